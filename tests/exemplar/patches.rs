//! Texture patches: every shape gives a mask with a feathered edge, a hull around it and an opaque centre.

use glam::{Vec2, Vec3};
use lapped::exemplar::mask::{OPAQUE, feather_alpha};
use lapped::exemplar::{
    Channel, Exemplar, ExemplarError, Image, Outline, PatchOptions, PatchShape, PatchSource, PatchSpec, TexturePatch, make_patches,
    patch::opacity_is_outline,
};

fn exemplar(width: u32, height: u32) -> Exemplar {
    Exemplar::new("test", Image::from_fn(width, height, |_, _| Vec3::ONE))
}

fn with_opacity(width: u32, height: u32, opacity: impl FnMut(u32, u32) -> f32) -> Exemplar {
    let mut exemplar = exemplar(width, height);
    exemplar.set(Channel::Opacity, Image::grey_from_fn(width, height, opacity)).expect("same size");
    exemplar
}

fn make(exemplar: &Exemplar, source: PatchSource, options: &PatchOptions) -> (Vec<TexturePatch>, Vec<String>) {
    make_patches(exemplar, 3, &[PatchSpec { source, weight: 2.0 }], options).expect("a good patch")
}

fn alpha_at(patch: &TexturePatch, at: Vec2) -> f32 {
    let [x, y] = patch.origin.map(|o| o as f32);
    let p = at - Vec2::new(x, y);
    let [w, h] = patch.mask.size().map(|n| n as f32);
    if p.cmplt(Vec2::ZERO).any() || p.x > w || p.y > h { 0.0 } else { patch.mask.finest().bilinear(p).x }
}

/// What holds for every patch whatever its shape.
fn check(patch: &TexturePatch, what: &str) {
    let mask = patch.mask.finest();
    let [w, h] = mask.size();
    for y in 0..h {
        for x in 0..w {
            let alpha = mask.grey(x.into(), y.into());
            assert_eq!(alpha, (alpha * 255.0).round() / 255.0, "{what}: alpha at {x}, {y} is a step of 8 bits");
            if x == 0 || y == 0 || x + 1 == w || y + 1 == h {
                assert_eq!(alpha, 0.0, "{what}: border at {x}, {y}");
            }
            let at = Vec2::new((x as i32 + patch.origin[0]) as f32, (y as i32 + patch.origin[1]) as f32) + 0.5;
            assert!(alpha == 0.0 || patch.hull.contains(at), "{what}: alpha {alpha} at {at} outside the hull");
        }
    }
    for dx in [-0.9, 0.0, 0.9] {
        for dy in [-0.9, 0.0, 0.9] {
            let alpha = alpha_at(patch, patch.centre + Vec2::new(dx, dy));
            assert!(alpha >= OPAQUE - 1e-6, "{what}: alpha {alpha} beside the centre {}", patch.centre);
        }
    }
    assert_eq!(patch.exemplar, 3, "{what}: its exemplar");
}

fn opaque_share(patch: &TexturePatch, exemplar: &Exemplar) -> f32 {
    let opaque = patch.mask.finest().data().iter().filter(|&&a| a >= OPAQUE).count();
    opaque as f32 / exemplar.size().iter().product::<u32>() as f32
}

#[test]
fn circle_and_whole_follow_exact_depth() {
    for ([w, h], feather) in [([64, 64], 3.0), ([97, 50], 6.0), ([200, 31], 1.0), ([40, 40], 0.0)] {
        let exemplar = exemplar(w, h);
        let options = PatchOptions { feather, ..PatchOptions::default() };
        let size = Vec2::new(w as f32, h as f32);
        let border = |p: Vec2| (p - 0.5).min(size - p - 0.5).min_element();
        let disc = |p: Vec2| (size.min_element() - 1.0) / 2.0 - p.distance(size / 2.0);
        let shapes: [(PatchSource, &dyn Fn(Vec2) -> f32); 2] = [(PatchSource::Whole, &border), (PatchSource::Circle, &disc)];
        for (source, depth) in shapes {
            let what = format!("{source:?} of {size}, feather {feather}");
            let (patches, warnings) = make(&exemplar, source, &options);
            assert_eq!((patches.len(), warnings.len()), (1, 0), "{what}: one patch, no warning");
            check(&patches[0], &what);
            assert_eq!(patches[0].weight, 2.0, "{what}: weight");
            for i in 0..w * h {
                let p = Vec2::new((i % w) as f32, (i / w) as f32) + 0.5;
                let expected = feather_alpha(depth(p), feather.max(1.0));
                let found = alpha_at(&patches[0], p);
                assert!((found - expected).abs() < 0.6 / 255.0, "{what}: {found} at {p}, by depth {expected}");
            }
        }
    }
}

#[test]
fn splotches_are_large_irregular_and_repeatable() {
    for [w, h] in [[256, 256], [300, 128], [64, 64]] {
        let exemplar = exemplar(w, h);
        let options = PatchOptions { seed: 11, splotches: 5, ..PatchOptions::default() };
        let (patches, warnings) = make(&exemplar, PatchSource::Splotch, &options);
        assert!(warnings.is_empty(), "{w} x {h}: a splotch is one piece: {warnings:?}");
        assert_eq!(patches.len(), 5, "{w} x {h}: as many as asked for");
        for (i, patch) in patches.iter().enumerate() {
            check(patch, &format!("splotch {i} of {w} x {h}"));
            let share = opaque_share(patch, &exemplar);
            assert!((0.55..0.70).contains(&share), "splotch {i} of {w} x {h}: {share} opaque");
            assert_eq!(patch.mask.size(), [w, h], "splotch {i} of {w} x {h}: it reaches all four sides");
            assert_eq!(patch.weight, 2.0 / 5.0, "the weight is shared");
            assert!(patches[..i].iter().all(|p| p.mask != patch.mask), "splotch {i} is like an earlier one");
        }
        let (full, _) = make(&exemplar, PatchSource::Splotch, &PatchOptions { full: true, ..options.clone() });
        for (i, patch) in full.iter().enumerate() {
            check(patch, &format!("full splotch {i} of {w} x {h}"));
            let share = opaque_share(patch, &exemplar);
            assert!((0.70..0.85).contains(&share), "full splotch {i} of {w} x {h}: {share} opaque");
            assert!(full[..i].iter().all(|p| p.mask != patch.mask), "full splotch {i} is like an earlier one");
        }
        assert_eq!(make(&exemplar, PatchSource::Splotch, &options).0, patches, "the same seed, the same splotches");
        let other = make(&exemplar, PatchSource::Splotch, &PatchOptions { seed: 12, ..options }).0;
        assert_ne!(other, patches, "another seed, others");
    }
}

#[test]
fn a_hard_mask_image_is_feathered_and_a_soft_one_stays_soft() {
    let exemplar = exemplar(80, 60);
    let options = PatchOptions { feather: 4.0, ..PatchOptions::default() };
    let mask = |image: Image| PatchSource::Mask { name: "m.png".to_owned(), image };
    // Hard: right of x = 30, so the first opaque pixel centre lies at 30.5 and the outline a pixel before it.
    let hard = Image::grey_from_fn(80, 60, |x, _| if x >= 30 { 1.0 } else { 0.0 });
    let (patches, _) = make(&exemplar, mask(hard.clone()), &options);
    check(&patches[0], "hard mask");
    for x in 28..40 {
        let at = Vec2::new(x as f32 + 0.5, 30.5);
        let expected = feather_alpha(at.x - 29.5, 4.0);
        assert!((alpha_at(&patches[0], at) - expected).abs() < 0.01, "hard mask at {at}: {}", alpha_at(&patches[0], at));
    }
    let (sharp, _) = make(&exemplar, mask(hard), &PatchOptions { feather: 0.0, ..options });
    assert_eq!(alpha_at(&sharp[0], Vec2::new(30.5, 30.5)), 1.0, "no feather leaves a hard mask hard");
    // Soft: a ramp over 30 pixels remains one.
    let soft = Image::grey_from_fn(80, 60, |x, _| ((x as f32 - 20.0) / 30.0).clamp(0.0, 1.0));
    let (patches, _) = make(&exemplar, mask(soft), &options);
    check(&patches[0], "soft mask");
    for x in 26..50 {
        let (found, own) = (alpha_at(&patches[0], Vec2::new(x as f32 + 0.5, 30.5)), (x as f32 - 20.0) / 30.0);
        assert!((found - own).abs() < 0.03, "soft mask at {x}: {found}, its own {own}");
    }
}

#[test]
fn a_mask_of_another_size_is_fitted_and_bad_proportions_told() {
    let exemplar = exemplar(64, 32);
    let disc = |size: [u32; 2]| {
        let s = Vec2::new(size[0] as f32, size[1] as f32);
        Image::grey_from_fn(size[0], size[1], |x, y| {
            let p = (Vec2::new(x as f32, y as f32) + 0.5) / s - 0.5;
            if p.length() < 0.4 { 1.0 } else { 0.0 }
        })
    };
    let source = |size| PatchSource::Mask { name: "m.png".to_owned(), image: disc(size) };
    let options = PatchOptions { feather: 2.0, ..PatchOptions::default() };
    let (same, _) = make(&exemplar, source([64, 32]), &options);
    for (size, warned) in [([256, 128], false), ([32, 16], false), ([100, 100], true)] {
        let (patches, warnings) = make(&exemplar, source(size), &options);
        check(&patches[0], "fitted mask");
        assert_eq!(warnings.len(), usize::from(warned), "{size:?}: {warnings:?}");
        let ratio = opaque_share(&patches[0], &exemplar) / opaque_share(&same[0], &exemplar);
        assert!((0.85..1.15).contains(&ratio), "{size:?} covers {ratio} of what the fitting one covers");
    }
}

#[test]
fn of_several_pieces_the_largest_is_used_and_told() {
    let image = Image::grey_from_fn(80, 40, |x, _| if (4..30).contains(&x) || (40..76).contains(&x) { 1.0 } else { 0.0 });
    let (patches, warnings) =
        make(&exemplar(80, 40), PatchSource::Mask { name: "two.png".to_owned(), image }, &PatchOptions::default());
    check(&patches[0], "two bars");
    assert_eq!(alpha_at(&patches[0], Vec2::new(15.0, 20.0)), 0.0, "the smaller bar is gone");
    assert_eq!(alpha_at(&patches[0], Vec2::new(58.0, 20.0)), 1.0, "the larger stays");
    assert!(warnings.len() == 1 && warnings[0].contains("two.png"), "it is told: {warnings:?}");
}

#[test]
fn outlines_in_pixels_and_fractions_agree() {
    let json = "[[[8, 4], [56, 4], [56, 28], [32, 16], [8, 28]], [[0.1, 0.1], [0.9, 0.1], [0.5, 0.9]]]";
    let outlines = Outline::from_json(json, "o.json").expect("good outlines");
    let fractions = Outline::from_json("[[0.125, 0.125], [0.875, 0.125], [0.875, 0.875], [0.5, 0.5], [0.125, 0.875]]", "f.json");
    let exemplar = exemplar(64, 32);
    let options = PatchOptions { feather: 2.0, ..PatchOptions::default() };
    let source = |outlines| PatchSource::Outlines { name: "o.json".to_owned(), outlines };
    let (patches, _) = make(&exemplar, source(outlines), &options);
    assert_eq!(patches.len(), 2, "a patch for each outline");
    for patch in &patches {
        check(patch, "outline");
        assert_eq!(patch.weight, 1.0, "the weight is shared");
    }
    assert_eq!(alpha_at(&patches[0], Vec2::new(32.0, 25.0)), 0.0, "in the notch");
    assert_eq!(alpha_at(&patches[0], Vec2::new(32.0, 10.0)), 1.0, "inside");
    let (same, _) = make(&exemplar, source(fractions.expect("good outline")), &options);
    assert_eq!(same[0].mask, patches[0].mask, "fractions of the size are the same outline");
}

#[test]
fn bad_outlines_are_refused() {
    let exemplar = exemplar(64, 64);
    for (json, reason) in [
        ("[[4, 4], [60, 60], [60, 4], [4, 60]]", "crosses"),
        ("[[4, 4], [60, 4], [60, 60], [30, 4], [4, 60]]", "touches"),
        ("[[4, 4], [60, 4], [30, 4], [30, 60]]", "crosses"),
        ("[[4, 4], [60, 60]]", "at least 3"),
        ("[[10, 10], [12, 10], [12, 12]]", "too small"),
        ("[[100, 100], [200, 100], [200, 200]]", "outside"),
        ("[[0, 0], [1e30, 0], [0, 1e30]]", "far"),
    ] {
        let outlines = Outline::from_json(json, "bad.json").expect("well formed");
        let spec = PatchSpec { source: PatchSource::Outlines { name: "bad.json".to_owned(), outlines }, weight: 1.0 };
        let error = make_patches(&exemplar, 0, &[spec], &PatchOptions::default()).expect_err(json);
        assert!(matches!(error, ExemplarError::BadOutline { .. }), "{json}: {error}");
        assert!(error.to_string().contains(reason) && error.to_string().contains("bad.json"), "{json}: {error}");
    }
    for json in ["", "{}", "[]", "[[1, 2, 3]]", "[1, 2]", "[[\"a\", 1]]", "[[]]"] {
        let error = Outline::from_json(json, "bad.json").expect_err(json);
        assert!(error.to_string().contains("bad.json"), "{json}: {error}");
    }
}

#[test]
fn transparent_parts_of_the_exemplar_bound_its_patches() {
    // A hole on the left, so that the largest disc lies on the right.
    let hole = |x: u32, y: u32| if Vec2::new(x as f32, y as f32).distance(Vec2::new(30.0, 50.0)) < 20.0 { 0.0 } else { 1.0 };
    let exemplar = with_opacity(160, 100, hole);
    assert!(opacity_is_outline(&exemplar, 3.0), "it has a hole");
    for source in [PatchSource::Whole, PatchSource::Circle, PatchSource::Splotch] {
        let what = format!("{source:?}");
        for patch in make(&exemplar, source, &PatchOptions::default()).0 {
            check(&patch, &what);
            for i in 0..160 * 100 {
                let (x, y) = (i % 160, i / 160);
                let alpha = alpha_at(&patch, Vec2::new(x as f32, y as f32) + 0.5);
                assert!(alpha == 0.0 || hole(x, y) > 0.0, "{what}: alpha {alpha} in the hole at {x}, {y}");
            }
        }
    }
    let circle = &make(&exemplar, PatchSource::Circle, &PatchOptions::default()).0[0];
    // Between the hole's right end at 50 and the border at 160 the disc is as large as the height allows.
    assert!(circle.centre.x > 95.0 && opaque_share(circle, &exemplar) > 0.38, "centre {}", circle.centre);
}

#[test]
fn thin_opacity_stays_material_and_is_told() {
    let exemplar = with_opacity(64, 64, |x, _| if x % 4 < 2 { 1.0 } else { 0.0 });
    assert!(!opacity_is_outline(&exemplar, 3.0), "stripes of two pixels hold nothing");
    let (patches, warnings) = make(&exemplar, PatchSource::Circle, &PatchOptions::default());
    check(&patches[0], "circle over stripes");
    assert!(opaque_share(&patches[0], &exemplar) > 0.6, "the stripes do not cut it");
    assert!(warnings.len() == 1 && warnings[0].contains("opacity"), "it is told: {warnings:?}");
    let glass = with_opacity(64, 64, |_, _| 0.6);
    let (patches, warnings) = make(&glass, PatchSource::Whole, &PatchOptions::default());
    assert!(opaque_share(&patches[0], &glass) > 0.8 && warnings.is_empty(), "a clear material has no transparent parts");
}

#[test]
fn patches_without_opaque_part_and_absurd_settings_are_errors() {
    let bad = |exemplar: &Exemplar, source: PatchSource, weight: f32, options: PatchOptions| {
        make_patches(exemplar, 0, &[PatchSpec { source, weight }], &options).expect_err("this cannot be made")
    };
    let options = PatchOptions::default;
    for (w, h) in [(1, 1), (2, 200), (8, 8)] {
        for source in [PatchSource::Whole, PatchSource::Circle, PatchSource::Splotch] {
            let error = bad(&exemplar(w, h), source, 1.0, options());
            assert!(matches!(error, ExemplarError::NothingOpaque { .. }), "{w} x {h}: {error}");
        }
    }
    let black = PatchSource::Mask { name: "black.png".to_owned(), image: Image::grey_from_fn(64, 64, |_, _| 0.0) };
    let error = bad(&exemplar(64, 64), black, 1.0, options());
    assert!(error.to_string().contains("black.png"), "it names the mask: {error}");
    for (weight, changed) in [
        (0.0, options()),
        (f32::NAN, options()),
        (1.0, PatchOptions { feather: -1.0, ..options() }),
        (1.0, PatchOptions { feather: f32::INFINITY, ..options() }),
        (1.0, PatchOptions { splotches: 0, ..options() }),
    ] {
        let error = bad(&exemplar(64, 64), PatchSource::Splotch, weight, changed);
        assert!(matches!(error, ExemplarError::BadPatch { .. }), "{error}");
    }
    let wide = bad(&exemplar(64, 64), PatchSource::Circle, 1.0, PatchOptions { feather: 1e9, ..options() });
    assert!(matches!(wide, ExemplarError::NothingOpaque { .. }), "a feather wider than the exemplar: {wide}");
}

#[test]
fn shapes_are_named_as_at_the_command_line() {
    let parse = |text: &str| text.parse::<PatchShape>();
    assert_eq!(parse("whole"), Ok(PatchShape::Whole), "whole");
    assert_eq!(parse("circle"), Ok(PatchShape::Circle), "circle");
    assert_eq!(parse("splotch"), Ok(PatchShape::Splotch), "splotch");
    assert_eq!(parse("a/leaf.PNG"), Ok(PatchShape::Mask("a/leaf.PNG".into())), "an image");
    assert_eq!(parse("leaf.json"), Ok(PatchShape::Outline("leaf.json".into())), "an outline");
    for text in ["", "disc", "leaf.obj", "json"] {
        assert!(parse(text).is_err_and(|e| e.to_string().contains("splotch")), "'{text}' is told what there is");
    }
}
