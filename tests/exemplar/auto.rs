//! Patches that exemplars choose: outlines run along lines that close, and nowhere else.

use glam::{Vec2, Vec3};
use lapped::exemplar::auto::Choice;
use lapped::exemplar::{Exemplar, Image, PatchOptions, Wrap, make_patches};
use lapped::job::patches::default_feather;
use lapped::random::Random;

const SIDE: u32 = 128;

fn exemplar(width: u32, height: u32, of: impl Fn(u32, u32) -> f32) -> Exemplar {
    Exemplar::new("made", Image::from_fn(width, height, |x, y| Vec3::splat(of(x, y).clamp(0.0, 1.0))))
}

/// Noise of one pixel that tiles.
fn noise(width: u32, height: u32, seed: u64) -> Vec<f32> {
    let mut random = Random::new(seed, 9);
    (0..width * height).map(|_| random.unit() as f32).collect()
}

/// Cells around random points, each of its own grey, with dark gaps between them; it tiles. And how far each pixel lies from a gap.
fn cells(side: u32, count: usize, seed: u64) -> (Exemplar, Vec<f32>) {
    let mut random = Random::new(seed, 3);
    let period = side as f32;
    // A jittered grid: no cell is much larger than others.
    let rows = (count as f32).sqrt() as usize;
    let points: Vec<(Vec2, f32)> = (0..rows * rows)
        .map(|i| {
            let jitter = Vec2::new(random.unit() as f32, random.unit() as f32) * 0.7;
            let at = (Vec2::new((i % rows) as f32, (i / rows) as f32) + jitter) * (period / rows as f32);
            (at, random.range(0.3, 0.9) as f32)
        })
        .collect();
    let grain = noise(side, side, seed);
    let look = |x: u32, y: u32| {
        let p = Vec2::new(x as f32 + 0.5, y as f32 + 0.5);
        let mut near: Vec<(f32, f32)> = points
            .iter()
            .map(|&(q, grey)| {
                let d = (p - q).abs();
                (d.min(Vec2::splat(period) - d).length(), grey)
            })
            .collect();
        near.sort_by(|a, b| a.0.total_cmp(&b.0));
        (0.5 * (near[1].0 - near[0].0), near[0].1)
    };
    let off: Vec<f32> = (0..side * side).map(|i| look(i % side, i / side).0).collect();
    let image = exemplar(side, side, |x, y| {
        let (away, grey) = look(x, y);
        let gap = (1.0 - away / 2.5).clamp(0.0, 1.0);
        (grey + 0.1 * grain[(y * side + x) as usize]) * (1.0 - gap) + 0.05 * gap
    });
    (image, off)
}

/// Points along an outline, a pixel apart.
fn along(points: &[Vec2]) -> Vec<Vec2> {
    let side = |i: usize| {
        let (a, b) = (points[i], points[(i + 1) % points.len()]);
        let steps = a.distance(b).ceil().max(1.0);
        (0..steps as u32).map(move |k| a.lerp(b, k as f32 / steps))
    };
    (0..points.len()).flat_map(side).collect()
}

#[test]
fn outlines_run_in_the_gaps_between_cells() {
    for (seed, count) in [(1, 36), (2, 49), (3, 64)] {
        let (exemplar, off) = cells(SIDE, count, seed);
        // No feather: outlines lie on the lines themselves.
        let choice = Choice::of(&exemplar, 0.0);
        assert!((2..=4).contains(&choice.outlines.len()), "{count} cells: {:?}", choice.reasons);
        assert!(choice.tiles && choice.used > 0.9, "{count} cells: they use most of what tiles: {}", choice.used);
        let spacing = 1.0 / (count as f32).sqrt();
        assert!(
            (0.5..2.0).contains(&(choice.feature / spacing)),
            "{count} cells are {spacing} apart, {} was found",
            choice.feature
        );
        for (i, outline) in choice.outlines.iter().enumerate() {
            let places = along(&outline.points);
            let wrapped = |p: f32| (p.floor() as i64).rem_euclid(i64::from(SIDE)) as usize;
            let away: Vec<f32> = places.iter().map(|p| off[wrapped(p.y) * SIDE as usize + wrapped(p.x)]).collect();
            let inside = away.iter().filter(|&&a| a < 2.5).count() as f32 / away.len() as f32;
            assert!(inside > 0.85, "{count} cells, outline {i}: {inside} of it in the gaps");
        }
    }
}

#[test]
fn outlines_are_simple_different_and_the_same_for_any_number_of_threads() {
    for seed in 4..6 {
        let side = 48 + 16 * seed as u32;
        let (mut exemplar, _) = cells(side, 49, seed);
        exemplar.wrap = Wrap::Repeat;
        let choice = Choice::of(&exemplar, 3.0);
        for threads in [1, 3] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
            assert_eq!(pool.install(|| Choice::of(&exemplar, 3.0)), choice, "{threads} threads");
        }
        let (patches, warnings) = make_patches(&exemplar, 0, &choice.specs(), &PatchOptions::default()).expect("patches");
        assert_eq!((patches.len(), warnings), (choice.outlines.len(), Vec::new()), "one each, whole");
        for (patch, outline) in patches.iter().zip(&choice.outlines) {
            assert_eq!(outline.check([side; 2]), Ok(()), "simple, and meets the exemplar");
            let [w, h] = patch.mask.size();
            assert!(w <= side && h <= side, "no larger than the exemplar: {w} x {h} of {side}");
            assert!(patch.hull.contains(patch.centre), "hull and centre move together");
            let middle = patch.centre - Vec2::from(patch.origin.map(|o| o as f32));
            assert!(patch.mask.finest().bilinear(middle).x > 0.99, "the centre is opaque");
            let area = patch.mask.finest().data().iter().filter(|&&a| a > 0.5).count() as f32 / (side * side) as f32;
            assert!((0.35..0.95).contains(&area), "about as large as a splotch: {area}");
            assert!(!patch.slides, "what lies under it stays there");
        }
        assert!((0..patches.len()).all(|i| (0..i).all(|j| patches[i].mask != patches[j].mask)), "they differ");
    }
}

#[test]
fn an_outline_over_the_edges_of_what_tiles_is_the_outline_moved() {
    let (mut exemplar, _) = cells(96, 36, 11);
    exemplar.wrap = Wrap::Repeat;
    let square = |x: f32, y: f32| {
        let corners = [[0.0, 0.0], [50.0, 0.0], [50.0, 40.0], [0.0, 40.0]];
        let points = corners.map(|[a, b]| Vec2::new(a + x, b + y)).to_vec();
        let source = lapped::exemplar::PatchSource::Outlines {
            name: "square".to_owned(),
            outlines: vec![lapped::exemplar::Outline { points }],
        };
        let spec = lapped::exemplar::PatchSpec { source, weight: 1.0 };
        make_patches(&exemplar, 0, &[spec], &PatchOptions::default()).expect("patches").0.remove(0)
    };
    let (inside, over) = (square(20.0, 30.0), square(-30.0, 80.0));
    let both = over.mask.finest().data().iter().zip(inside.mask.finest().data());
    assert!(over.mask.size() == inside.mask.size() && both.into_iter().all(|(a, b)| (a - b).abs() < 0.01), "the same mask");
    assert_eq!(over.origin, [inside.origin[0] - 50, inside.origin[1] + 50], "moved");
    assert_eq!(over.centre, inside.centre + Vec2::new(-50.0, 50.0), "and its centre");
    assert!(over.hull.contains(over.centre), "and its hull");
}

#[test]
fn what_has_no_lines_gets_splotches() {
    let grain = noise(SIDE, SIDE, 5);
    let at = |x: u32, y: u32| grain[(y % SIDE * SIDE + x % SIDE) as usize];
    let soft = |x: u32, y: u32| (0..49).map(|k| at(x + k % 7, y + k / 7)).sum::<f32>() / 49.0;
    let stripes = |x: u32, _: u32| if x % 32 < 4 { 0.1 } else { 0.6 };
    for (what, made) in [
        ("noise", exemplar(SIDE, SIDE, at)),
        ("soft noise", exemplar(SIDE, SIDE, |x, y| 4.0 * soft(x, y) - 1.5)),
        ("stripes", exemplar(SIDE, SIDE, |x, y| stripes(x, y) + 0.1 * at(x, y))),
    ] {
        let choice = Choice::of(&made, 3.0);
        assert!(choice.outlines.is_empty() && choice.specs().is_empty(), "{what}: {:?}", choice.reasons);
        assert!(choice.reasons[0].starts_with("splotches"), "{what}: {:?}", choice.reasons);
    }
}

#[test]
fn the_tiniest_and_the_evenest_have_an_answer() {
    for (w, h) in [(1, 1), (2, 1), (7, 9), (23, 400), (24, 24), (400, 25)] {
        for even in [true, false] {
            let grain = noise(w, h, 2);
            let choice = Choice::of(&exemplar(w, h, |x, y| if even { 0.4 } else { grain[(y * w + x) as usize] }), 3.0);
            assert!(!choice.reasons.is_empty(), "{w} x {h}: says why");
            assert!(!even || choice.outlines.is_empty(), "{w} x {h}, one colour: {:?}", choice.reasons);
        }
    }
}

#[test]
fn own_exemplars_choose_as_a_hand_would() {
    let mut outlined: Vec<&str> = lapped::assets::exemplar_names()
        .filter(|name| {
            let exemplar = lapped::assets::exemplar(name).expect("a demo exemplar");
            !Choice::of(&exemplar, default_feather(exemplar.size())).outlines.is_empty()
        })
        .collect();
    outlined.sort_unstable();
    // The others have no lines (moss, rust), or none that close (bark, fur, stripes, wood).
    assert_eq!(outlined, ["bricks", "leaves", "pebbles", "scales", "stone", "weave"], "those with grout, gaps or borders");
}
