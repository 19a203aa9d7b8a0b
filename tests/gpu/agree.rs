//! Both ways of drawing on a graphics adapter give the reference renderer's picture.

#![allow(
    clippy::print_stdout,
    clippy::unwrap_used,
    reason = "helpers of tests fail as tests do, and figures are shown when asked for"
)]

use crate::common::{checks, compare, flat, pasted, pasted_with, renderers, round_patch, scattered};
use glam::{DVec3, Vec3, Vec4};
use lapped::exemplar::stack::resized;
use lapped::exemplar::{Channel, ChannelSet, Exemplar, FramesBy, Image, TexturePatch};
use lapped::job::{ExemplarInput, PasteJob, Scale, paste_model};
use lapped::mesh::{Mesh, SurfacePoint};
use lapped::paste::{Composite, LappedTexture, Layer, Paste, TURNS, Turn, base_color};
use lapped::progress::Silent;
use lapped::render::gpu::{Filter, Forward, GpuError, Path, Renderer, RendererOptions};
use lapped::render::{Background, DrawOptions, Grid, Picture, Stage, View, Visibility};
use lapped::surface::{SurfaceTexture, Texel};
use std::sync::Arc;

/// Mean difference away from outlines, and at them, in steps of 1/255.
const INSIDE: f64 = 0.6;
const OUTLINE: f64 = 2.0;

fn reference(stage: &Stage<'_>, lapped: &LappedTexture, camera: &lapped::render::Camera, grid: Grid) -> Picture {
    stage.draw(&Composite::new(stage.mesh, lapped), &Visibility::new(stage.mesh, camera, grid).unwrap())
}

/// Draws with every adapter and both ways and holds each against the reference.
pub(crate) fn agree(name: &str, mesh: &Mesh, lapped: &LappedTexture, options: &DrawOptions, view: &str, grid: Grid) {
    let shown = Shown { texture: &Composite::new(mesh, lapped), lapped, tints: None };
    agree_on(name, mesh, &shown, options, view, grid);
}

/// A texture, and what is loaded for it.
struct Shown<'a> {
    texture: &'a dyn SurfaceTexture,
    lapped: &'a LappedTexture,
    tints: Option<&'a [[Vec4; 3]]>,
}

fn agree_on(name: &str, mesh: &Mesh, shown: &Shown<'_>, options: &DrawOptions, view: &str, grid: Grid) {
    let stage = Stage::new(mesh, options);
    let camera = view.parse::<View>().unwrap().frame(mesh, grid.aspect());
    let expected = stage.draw(shown.texture, &Visibility::new(mesh, &camera, grid).unwrap());
    for renderer in renderers() {
        let subject = renderer.load_tinted(&stage, shown.lapped, shown.tints).unwrap();
        for path in [Path::Single, Path::Layered] {
            let drawn = renderer.draw(&subject, &stage, &camera, grid, path).unwrap();
            let found = compare(mesh, &camera, grid, &expected, &drawn);
            let adapter = renderer.gpu().adapter();
            println!("{name} {view} {path:?} on {adapter}: {found:?}");
            assert!(found.inside < INSIDE, "{name} {view} {path:?} on {adapter}: {found:?} away from outlines");
            assert!(found.outline < OUTLINE, "{name} {view} {path:?} on {adapter}: {found:?} at outlines");
            assert!(found.outside < 0.1, "{name} {view} {path:?} on {adapter}: {found:?} behind the mesh");
        }
        assert_eq!(renderer.gpu().check(), Ok(()), "{name}: the driver and its validation refuse nothing");
    }
}

#[test]
#[ignore = "needs graphics adapters, software will do: cargo test --test gpu -- --include-ignored"]
fn the_demos_look_the_same_in_all_modes() {
    let shows: [(&str, &[&str], f64, bool); 6] = [
        ("dragonling", &["fur"], 40.0, true),
        ("dragonling", &["moss", "stone"], 40.0, false),
        ("knot", &["weave"], 60.0, true),
        ("gear", &["rust"], 30.0, false),
        ("vase", &["bricks"], 30.0, true),
        ("terrain", &["leaves"], 60.0, false),
    ];
    for (mesh, exemplars, ratio, up) in shows {
        let pasted = pasted(mesh, exemplars, ratio, up);
        let name = format!("{mesh} {exemplars:?}");
        let grid = Grid { width: 260, height: 220, samples: 3 };
        agree(&name, &pasted.mesh, &pasted.lapped, &DrawOptions::default(), "three-quarter", grid);
        let grid = Grid { width: 150, height: 190, samples: 2 };
        let options = DrawOptions { background: Background::Transparent, ..DrawOptions::default() };
        agree(&name, &pasted.mesh, &pasted.lapped, &options, "yaw=200,pitch=-20,fov=0", grid);
    }
}

#[test]
#[ignore = "needs graphics adapters, software will do: cargo test --test gpu -- --include-ignored"]
fn transitions_that_keep_contrast_look_the_same_in_all_modes() {
    let inputs = ["stone", "moss"].map(|name| ExemplarInput {
        exemplar: lapped::assets::exemplar(name).unwrap(),
        weight: 1.0,
        patches: Vec::new(),
    });
    let job = PasteJob { scale: Scale::Ratio(30.0), feather: Some(40.0), ..PasteJob::default() };
    let mut pasted = paste_model(&lapped::assets::mesh("vase").unwrap(), inputs.into(), &job, &Silent).unwrap();
    pasted.lapped.pastes.iter_mut().zip((0..200).cycle().step_by(23)).for_each(|(paste, agreement)| paste.agreement = agreement);
    let grid = Grid { width: 260, height: 220, samples: 2 };
    agree("contrast", &pasted.mesh, &pasted.lapped, &DrawOptions::default(), "three-quarter", grid);
}

#[test]
#[ignore = "needs graphics adapters, software will do: cargo test --test gpu -- --include-ignored"]
fn turned_pastes_look_the_same_in_all_modes() {
    let mut pasted = pasted("vase", &["scales", "stone"], 30.0, true);
    let plain = pasted.lapped.clone();
    pasted.lapped.pastes.iter_mut().zip((0..TURNS).cycle().step_by(37)).for_each(|(paste, parts)| paste.turn = Turn::new(parts));
    let grid = Grid { width: 260, height: 220, samples: 2 };
    let stage = Stage::new(&pasted.mesh, &DrawOptions::default());
    let camera = View::default().frame(&pasted.mesh, grid.aspect());
    let [before, after] = [&plain, &pasted.lapped].map(|lapped| reference(&stage, lapped, &camera, grid));
    assert!(compare(&pasted.mesh, &camera, grid, &before, &after).inside > 4.0, "the turn is seen");
    agree("turned", &pasted.mesh, &pasted.lapped, &DrawOptions::default(), "three-quarter", grid);
}

#[test]
#[ignore = "needs graphics adapters, software will do: cargo test --test gpu -- --include-ignored"]
fn as_many_square_exemplars_as_a_cube_has_sides_look_the_same_in_all_modes() {
    let mesh = flat(6);
    let patches = (0..6).map(|k| TexturePatch { exemplar: k, ..round_patch(32, [4, 7]) }).collect();
    let mut lapped = scattered(&mesh, patches, checks(64), 400);
    lapped.exemplars = [Vec3::X, Vec3::Y, Vec3::Z, Vec3::ONE, Vec3::ZERO, Vec3::splat(0.5)]
        .map(|tint| Exemplar::new("tint", Image::from_fn(64, 64, |x, _| tint * (0.5 + x as f32 / 128.0))))
        .to_vec();
    agree("six exemplars", &mesh, &lapped, &DrawOptions::default(), "front", Grid { width: 160, height: 160, samples: 2 });
}

#[test]
#[ignore = "needs graphics adapters, software will do: cargo test --test gpu -- --include-ignored"]
fn exemplars_that_change_with_view_or_light_look_the_same_in_all_modes() {
    let named = |name: &str| lapped::assets::exemplar(name).unwrap();
    for by in [FramesBy::View, FramesBy::Light] {
        // Of one size: frames keep to the first's.
        let [mut first, second, third] = ["moss", "stone", "rust"].map(|name| resized(&named(name), [64, 64]).into_owned());
        let own = |e: &Exemplar| {
            let mut plain = e.clone();
            Channel::ALL.into_iter().for_each(|c| plain.remove(c));
            plain
        };
        first = own(&first);
        first.set_frames(by, vec![own(&second), own(&third)], Vec::new()).unwrap();
        let pasted = pasted_with("vase", vec![first, named("stone")], 30.0, false);
        let still: Vec<Exemplar> = pasted
            .lapped
            .exemplars
            .iter()
            .map(|e| {
                let mut still = e.clone();
                still.remove_frames();
                still
            })
            .collect();
        let grid = Grid { width: 220, height: 200, samples: 2 };
        let stage = Stage::new(&pasted.mesh, &DrawOptions::default());
        let camera = View::default().frame(&pasted.mesh, grid.aspect());
        let first = reference(&stage, &LappedTexture { exemplars: still, ..pasted.lapped.clone() }, &camera, grid);
        let mixed = reference(&stage, &pasted.lapped, &camera, grid);
        assert!(compare(&pasted.mesh, &camera, grid, &first, &mixed).inside > 4.0, "{by:?}: frames are seen");
        agree(&format!("{by:?}"), &pasted.mesh, &pasted.lapped, &DrawOptions::default(), "three-quarter", grid);
    }
}

#[test]
#[ignore = "needs graphics adapters, software will do: cargo test --test gpu -- --include-ignored"]
fn every_channel_of_a_material_is_drawn_alike_and_translucent_ones_in_exact_order() {
    let mut exemplar = lapped::assets::exemplar("scales").unwrap();
    let [w, h] = exemplar.size();
    let wave = |k: f32| move |x: u32, y: u32| 0.5 + 0.5 * (k * x as f32).sin() * (k * y as f32).cos();
    exemplar.set(Channel::Roughness, Image::grey_from_fn(w, h, wave(0.1))).unwrap();
    exemplar.set(Channel::Metallic, Image::grey_from_fn(w, h, wave(0.05))).unwrap();
    exemplar.set(Channel::Occlusion, Image::grey_from_fn(w, h, wave(0.2))).unwrap();
    exemplar.set(Channel::Emissive, Image::from_fn(w, h, |x, y| Vec3::new(0.3, 0.1, 0.0) * wave(0.07)(x, y))).unwrap();
    let grid = Grid { width: 200, height: 200, samples: 2 };
    let opaque = pasted_with("knot", vec![exemplar.clone()], 40.0, true);
    agree("all channels", &opaque.mesh, &opaque.lapped, &DrawOptions::default(), "three-quarter", grid);
    let mut glassy = opaque.lapped.clone();
    glassy.exemplars[0].set(Channel::Opacity, Image::grey_from_fn(w, h, |x, y| 0.3 + 0.6 * wave(0.04)(x, y))).unwrap();
    // Five groups of material are more than many adapters blend at once; without emission they are four.
    glassy.exemplars[0].remove(Channel::Emissive);
    agree("translucent", &opaque.mesh, &glassy, &DrawOptions::default(), "three-quarter", grid);
}

#[test]
#[ignore = "needs graphics adapters, software will do: cargo test --test gpu -- --include-ignored"]
fn layers_mixed_by_weights_and_over_bases_look_the_same_in_all_modes() {
    let [below, above] = ["stone", "rust"].map(|name| pasted("vase", &[name], 30.0, false));
    assert_eq!(below.mesh.faces, above.mesh.faces, "on the same faces");
    let mesh = &below.mesh;
    let (low, high) = mesh.bounds();
    // Weights from 0 to 1 and back, by height; and a layer of one weight everywhere on top.
    let wave = |k: f32| {
        move |v: &u32| {
            let height = (mesh.positions[*v as usize].y - low.y) / (high.y - low.y);
            (0.5 + 0.7 * (k * height).sin()).clamp(0.0, 1.0)
        }
    };
    let by = |k: f32| mesh.faces.iter().map(|f| f.each_ref().map(wave(k))).collect::<Vec<_>>();
    let mut lapped = below.lapped.clone();
    let layer = |pastes: &[Paste], weights| Layer { pastes: pastes.len() as u32, weights, ..Layer::default() };
    lapped.layers = vec![
        layer(&below.lapped.pastes, Vec::new()),
        layer(&above.lapped.pastes, by(7.0)),
        layer(&below.lapped.pastes, vec![[0.3; 3]; mesh.face_count()]),
    ];
    let [patches, exemplars] = [lapped.patches.len() as u16, lapped.exemplars.len() as u16];
    lapped.exemplars.extend(above.lapped.exemplars.clone());
    lapped.patches.extend(above.lapped.patches.iter().cloned().map(|p| TexturePatch { exemplar: p.exemplar + exemplars, ..p }));
    lapped.pastes.extend(above.lapped.pastes.iter().cloned().map(|p| Paste { patch: p.patch + patches, ..p }));
    lapped.pastes.extend(below.lapped.pastes.clone());
    let (options, grid) = (DrawOptions::default(), Grid { width: 220, height: 260, samples: 2 });
    agree("three layers", mesh, &lapped, &options, "three-quarter", grid);
    let stage = Stage::new(mesh, &options);
    let camera = View::default().frame(mesh, grid.aspect());
    let mixed = reference(&stage, &lapped, &camera, grid);
    let plain = reference(&stage, &below.lapped, &camera, grid);
    assert!(compare(mesh, &camera, grid, &mixed, &plain).inside > 3.0, "the upper layers show");

    // Dark where a weight is low, and beyond 1 where it is high.
    let hue = |w: f32| base_color(Vec3::new(0.05, 0.25, 0.9) * w + Vec3::new(0.1, 0.0, 0.05));
    lapped.layers[0].base = by(5.0).iter().map(|corners| corners.map(hue)).collect();
    lapped.layers[2].base = vec![[base_color(Vec3::new(0.6, 0.3, 0.1)); 3]; mesh.face_count()];
    let based = reference(&stage, &lapped, &camera, grid);
    assert!(compare(mesh, &camera, grid, &mixed, &based).inside > 3.0, "bases are seen");
    agree("three layers over two bases", mesh, &lapped, &options, "three-quarter", grid);
    lapped.layers = vec![Layer { pastes: lapped.pastes.len() as u32, base: lapped.layers[0].base.clone(), ..Layer::default() }];
    agree("one base", mesh, &lapped, &options, "three-quarter", grid);
}

/// Some faces in colours of their own, the others as they are pasted.
struct Tinted<'a> {
    mesh: &'a Mesh,
    pasted: Composite<'a>,
    tints: &'a [[Vec4; 3]],
}

impl SurfaceTexture for Tinted<'_> {
    fn channels(&self) -> ChannelSet {
        self.pasted.channels()
    }

    fn texel(&self, at: SurfacePoint, footprint: f32) -> Texel {
        let below = self.pasted.texel(at, footprint);
        let own: Vec4 = (0..3).map(|k| self.tints[at.face as usize][k] * at.bary[k]).sum();
        if own.w < 0.5 {
            return below;
        }
        Texel { base_color: own.truncate(), alpha: 1.0, ..Texel::empty(self.mesh.normal(at.face).as_vec3()) }
    }
}

#[test]
#[ignore = "needs graphics adapters, software will do: cargo test --test gpu -- --include-ignored"]
fn colours_of_faces_own_lie_over_pastes_and_over_nothing() {
    let pasted = pasted("vase", &["stone"], 30.0, false);
    let mesh = &pasted.mesh;
    let (low, high) = mesh.bounds();
    let color = |v: u32| ((mesh.positions[v as usize] - low) / (high - low)).extend(1.0);
    let every = |keep: u32| -> Vec<[Vec4; 3]> {
        let of = |f: u32| mesh.faces[f as usize].map(color).map(|c| if f.is_multiple_of(keep) { c } else { Vec4::ZERO });
        (0..mesh.face_count() as u32).map(of).collect()
    };
    let nothing = LappedTexture::default();
    let (options, grid) = (DrawOptions::default(), Grid { width: 220, height: 260, samples: 2 });
    for (name, lapped, tints) in [("vertex colours", &nothing, every(1)), ("every third face", &pasted.lapped, every(3))] {
        let texture = Tinted { mesh, pasted: Composite::new(mesh, lapped), tints: &tints };
        agree_on(name, mesh, &Shown { texture: &texture, lapped, tints: Some(&tints) }, &options, "three-quarter", grid);
    }
    let refused = renderers().first().unwrap().load_tinted(&Stage::new(mesh, &options), &nothing, Some(&every(1)[1..]));
    assert!(matches!(refused, Err(GpuError::Tints { .. })), "one face short is refused");
}

#[test]
#[ignore = "needs graphics adapters, software will do: cargo test --test gpu -- --include-ignored"]
fn a_model_that_is_played_looks_as_the_reference_has_it() {
    use crate::glb::{bending, bulging};
    use lapped::job::Bound;
    for (name, (gltf, rest)) in [("bending", bending(20, 40)), ("bulging", bulging(20, 40))] {
        let model = lapped::format::read_model_bytes(std::path::Path::new("a.glb"), &gltf.glb(rest)).unwrap();
        let exemplar = lapped::assets::exemplar("scales").unwrap();
        let record = crate::common::pasted_model(&model, vec![exemplar], 30.0, true).record;
        let bound = Bound::new(record).unwrap();
        let moving = bound.moving.as_ref().unwrap();
        let options = DrawOptions { crease: Some(1.0), ..DrawOptions::default() };
        let grid = Grid { width: 200, height: 200, samples: 2 };
        for renderer in renderers() {
            let rest = moving.at(Some(0), 0.0).unwrap();
            let mut subject = renderer.load(&Stage::new(&rest, &options), &bound.lapped).unwrap();
            for time in [0.5, 1.0, 1.6] {
                let mesh = moving.at(Some(0), time).unwrap();
                let stage = Stage::new(&mesh, &options);
                renderer.follow(&mut subject, &stage).unwrap();
                let camera = View::default().frame(&mesh, 1.0);
                let expected = reference(&stage, &bound.lapped, &camera, grid);
                for path in [Path::Single, Path::Layered] {
                    let drawn = renderer.draw(&subject, &stage, &camera, grid, path).unwrap();
                    let found = compare(&mesh, &camera, grid, &expected, &drawn);
                    println!("{name} {time} {path:?}: {found:?}");
                    assert!(found.inside < INSIDE && found.outline < OUTLINE, "{name} at {time} s, {path:?}: {found:?}");
                }
            }
        }
    }
}

#[test]
#[ignore = "needs graphics adapters, software will do: cargo test --test gpu -- --include-ignored"]
fn far_and_near_and_bare_meshes_agree_too() {
    let pasted = pasted("vase", &["stone"], 20.0, false);
    let options = DrawOptions { background: Background::Plain(Vec3::new(0.1, 0.2, 0.3)), ..DrawOptions::default() };
    let grid = Grid { width: 160, height: 120, samples: 2 };
    for view in ["front,zoom=0.1", "front,zoom=6", "top", "bottom,fov=100"] {
        agree("vase stone", &pasted.mesh, &pasted.lapped, &options, view, grid);
    }
    agree("bare", &pasted.mesh, &LappedTexture::default(), &options, "front", grid);
    // Far from the origin and of another size.
    let place = |p: &Vec3| (p.as_dvec3() * 1e-4 + DVec3::new(3.0, -2.0, 1.0)).as_vec3();
    let moved = Mesh::new(pasted.mesh.positions.iter().map(place).collect(), pasted.mesh.faces.clone()).unwrap();
    agree("small and far away", &moved, &pasted.lapped, &options, "three-quarter", grid);
}

#[test]
#[ignore = "needs graphics adapters, software will do: cargo test --test gpu -- --include-ignored"]
fn other_exemplars_stand_under_the_same_pastes_without_pasting_again() {
    let stone = pasted("knot", &["stone"], 30.0, false);
    let mut rust = stone.lapped.clone();
    rust.exemplars = vec![lapped::assets::exemplar("rust").unwrap()];
    let (options, grid) = (DrawOptions::default(), Grid { width: 160, height: 160, samples: 2 });
    let stage = Stage::new(&stone.mesh, &options);
    let camera = View::default().frame(&stone.mesh, 1.0);
    for renderer in renderers() {
        let mut subject = renderer.load(&stage, &stone.lapped).unwrap();
        let before = renderer.draw(&subject, &stage, &camera, grid, Path::Single).unwrap();
        let old = Arc::clone(subject.patches());
        let new = Arc::new(renderer.load_patches(&rust.exemplars, &rust.patches).unwrap());
        subject.set_patches(new).unwrap();
        let switched = renderer.draw(&subject, &stage, &camera, grid, Path::Single).unwrap();
        let loaded = renderer.draw(&renderer.load(&stage, &rust).unwrap(), &stage, &camera, grid, Path::Single).unwrap();
        assert_eq!(switched, loaded, "as if it had been loaded so");
        assert!(compare(&stone.mesh, &camera, grid, &before, &switched).inside > 8.0, "and another texture than before");
        subject.set_patches(old).unwrap();
        assert_eq!(renderer.draw(&subject, &stage, &camera, grid, Path::Single).unwrap(), before, "and back");
        assert!(subject.set_patches(Arc::new(renderer.load_patches(&[], &[]).unwrap())).is_err(), "too few patches are refused");
    }
}

#[test]
#[ignore = "needs graphics adapters, software will do: cargo test --test gpu -- --include-ignored"]
fn exemplars_that_go_by_time_show_each_frame_for_its_while() {
    let color = |name: &str| {
        let mut exemplar = resized(&lapped::assets::exemplar(name).unwrap(), [64, 64]).into_owned();
        Channel::ALL.into_iter().for_each(|c| exemplar.remove(c));
        exemplar
    };
    let mut first = color("moss");
    first.set_frames(FramesBy::Time, vec![color("rust"), color("stone")], vec![0.5, 0.25, 1.0]).unwrap();
    // A second exemplar, so that frames stand between the two.
    let pasted = pasted_with("vase", vec![first, color("wood")], 30.0, false);
    let (options, grid) = (DrawOptions::default(), Grid { width: 160, height: 160, samples: 2 });
    let stage = Stage::new(&pasted.mesh, &options);
    let camera = View::default().frame(&pasted.mesh, 1.0);
    for renderer in renderers() {
        let subject = renderer.load(&stage, &pasted.lapped).unwrap();
        let mut seen = Vec::new();
        for (seconds, left) in [(0.1, 0.4), (0.6, 0.15), (1.0, 0.75), (1.85, 0.4)] {
            assert!((renderer.set_time(subject.patches(), seconds) - left).abs() < 1e-9, "at {seconds} s it holds for {left}");
            let played = renderer.draw(&subject, &stage, &camera, grid, Path::Single).unwrap();
            let still = LappedTexture {
                exemplars: pasted.lapped.exemplars.iter().map(|e| e.at(seconds)).collect(),
                ..pasted.lapped.clone()
            };
            let loaded = renderer.draw(&renderer.load(&stage, &still).unwrap(), &stage, &camera, grid, Path::Single).unwrap();
            assert_eq!(played, loaded, "at {seconds} s as if that frame had been loaded alone");
            seen.push(played);
        }
        assert_eq!(seen[0], seen[3], "they come round");
        assert!(seen[0] != seen[1] && seen[1] != seen[2], "and differ");
        let still =
            renderer.load(&stage, &LappedTexture { exemplars: vec![color("moss"), color("wood")], ..pasted.lapped.clone() });
        assert_eq!(renderer.set_time(still.unwrap().patches(), 3.0), f64::INFINITY, "what does not change holds without end");
    }
}

#[test]
#[ignore = "needs graphics adapters, software will do: cargo test --test gpu -- --include-ignored"]
fn the_texture_stays_in_place_on_a_mesh_that_moves() {
    let pasted = pasted("dragonling", &["fur"], 40.0, true);
    let options = DrawOptions { occlusion: false, ..DrawOptions::default() };
    let grid = Grid { width: 180, height: 180, samples: 2 };
    let bent = |amount: f64| {
        let bend = |p: &Vec3| {
            let p = p.as_dvec3();
            glam::DQuat::from_rotation_y(amount * p.y).mul_vec3(p).as_vec3()
        };
        Mesh::new(pasted.mesh.positions.iter().map(bend).collect(), pasted.mesh.faces.clone()).unwrap()
    };
    let still = Stage::new(&pasted.mesh, &options);
    for renderer in renderers() {
        let mut subject = renderer.load(&still, &pasted.lapped).unwrap();
        for amount in [0.3, 0.8] {
            let mesh = bent(amount);
            let stage = Stage::new(&mesh, &options);
            renderer.follow(&mut subject, &stage).unwrap();
            let camera = View::default().frame(&mesh, 1.0);
            let expected = reference(&stage, &pasted.lapped, &camera, grid);
            let found =
                compare(&mesh, &camera, grid, &expected, &renderer.draw(&subject, &stage, &camera, grid, Path::Single).unwrap());
            assert!(found.inside < INSIDE && found.outline < OUTLINE, "bent by {amount}: {found:?}");
        }
        let other = flat(3);
        assert!(renderer.follow(&mut subject, &Stage::new(&other, &options)).is_err(), "another mesh is refused");
    }
}

#[test]
#[ignore = "needs graphics adapters, software will do: cargo test --test gpu -- --include-ignored"]
fn a_subject_drawn_into_somebody_elses_pass_looks_like_its_picture() {
    let pasted = pasted("vase", &["bricks"], 30.0, true);
    let colour = Vec3::new(0.1, 0.2, 0.3);
    let options = DrawOptions { occlusion: false, background: Background::Plain(colour), ..DrawOptions::default() };
    let stage = Stage::new(&pasted.mesh, &options);
    let grid = Grid { width: 128, height: 128, samples: 1 };
    let camera = View::default().frame(&pasted.mesh, 1.0);
    for renderer in renderers() {
        let device = &renderer.gpu().device;
        let subject = renderer.load(&stage, &pasted.lapped).unwrap();
        let expected = renderer.draw(&subject, &stage, &camera, grid, Path::Single).unwrap();
        // Light is encoded by the format, or by the shader where the format keeps what it is given.
        for color in [wgpu::TextureFormat::Rgba8UnormSrgb, wgpu::TextureFormat::Rgba8Unorm] {
            let target = |format, usage| {
                device.create_texture(&wgpu::TextureDescriptor {
                    label: None,
                    size: wgpu::Extent3d { width: 128, height: 128, depth_or_array_layers: 1 },
                    mip_level_count: 1,
                    sample_count: 1,
                    dimension: wgpu::TextureDimension::D2,
                    format,
                    usage: wgpu::TextureUsages::RENDER_ATTACHMENT | usage,
                    view_formats: &[],
                })
            };
            let frame = target(color, wgpu::TextureUsages::COPY_SRC);
            let depth = target(wgpu::TextureFormat::Depth32Float, wgpu::TextureUsages::empty());
            let forward = Forward::new(renderer, color, wgpu::TextureFormat::Depth32Float, 1).unwrap();
            let seen = renderer.see(&subject, &camera, [128, 128], &options, Some([0.01, 1000.0]));
            let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            let shown = if color.is_srgb() { colour } else { Vec3::from(colour.to_array().map(lapped::exemplar::srgb::encode)) };
            let [r, g, b] = shown.to_array().map(f64::from);
            {
                let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                    color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                        view: &frame.create_view(&wgpu::TextureViewDescriptor::default()),
                        depth_slice: None,
                        resolve_target: None,
                        ops: wgpu::Operations {
                            load: wgpu::LoadOp::Clear(wgpu::Color { r, g, b, a: 1.0 }),
                            store: wgpu::StoreOp::Store,
                        },
                    })],
                    depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                        view: &depth.create_view(&wgpu::TextureViewDescriptor::default()),
                        depth_ops: Some(wgpu::Operations { load: wgpu::LoadOp::Clear(1.0), store: wgpu::StoreOp::Discard }),
                        stencil_ops: None,
                    }),
                    ..Default::default()
                });
                forward.draw(&mut pass, &subject, &seen);
            }
            renderer.gpu().queue.submit([encoder.finish()]);
            let rgba = lapped::render::gpu::read_pixels(renderer.gpu(), &frame).unwrap();
            let drawn = Picture { width: 128, height: 128, rgba };
            let found = compare(&pasted.mesh, &camera, grid, &expected, &drawn);
            assert!(found.inside < 0.5 && found.outline < 1.0 && found.outside < 0.5, "{color:?}: {found:?}");
        }
    }
}

#[test]
#[ignore = "needs graphics adapters, software will do: cargo test --test gpu -- --include-ignored"]
fn gradients_and_relief_change_only_what_they_should() {
    let pasted = pasted("knot", &["scales"], 30.0, true);
    let options = DrawOptions { occlusion: false, ..DrawOptions::default() };
    let stage = Stage::new(&pasted.mesh, &options);
    let grid = Grid { width: 150, height: 150, samples: 1 };
    let camera = View::default().frame(&pasted.mesh, 1.0);
    for (name, plain) in ["vulkan", "gl"].into_iter().zip(renderers()) {
        let draw = |renderer: &Renderer| {
            let subject = renderer.load(&stage, &pasted.lapped).unwrap();
            renderer.draw(&subject, &stage, &camera, grid, Path::Single).unwrap()
        };
        let with = |options| Renderer::new(plain.gpu().clone(), options).unwrap();
        let expected = draw(plain);
        let sharper = draw(&with(RendererOptions { filter: Filter::Anisotropic, ..RendererOptions::default() }));
        let deeper = draw(&with(RendererOptions { parallax: 0.05, ..RendererOptions::default() }));
        let [sharper, deeper] = [sharper, deeper].map(|drawn| compare(&pasted.mesh, &camera, grid, &expected, &drawn));
        println!("{name}: anisotropic {sharper:?}, parallax {deeper:?}");
        assert!(sharper.inside > 0.1 && sharper.inside < 12.0 && sharper.outside < 0.1, "anisotropic on {name}: {sharper:?}");
        assert!(deeper.inside > 0.5 && deeper.inside < 30.0 && deeper.outside < 0.1, "parallax on {name}: {deeper:?}");
    }
}

#[test]
#[ignore = "needs graphics adapters, software will do: cargo test --test gpu -- --include-ignored"]
fn relief_is_shifted_as_the_reference_shifts_it() {
    let mut pasted = pasted("vase", &["bricks"], 20.0, true);
    // Slopes turn with what is turned.
    pasted.lapped.pastes.iter_mut().step_by(3).for_each(|paste| paste.turn = Turn::new(TURNS / 7));
    let options = DrawOptions::default();
    let stage = Stage::new(&pasted.mesh, &options);
    let grid = Grid { width: 200, height: 200, samples: 2 };
    for view in ["front", "yaw=40,pitch=50"] {
        let camera = view.parse::<View>().unwrap().frame(&pasted.mesh, 1.0);
        let seen = Visibility::new(&pasted.mesh, &camera, grid).unwrap();
        for depth in [0.02, 0.06] {
            let plain = stage.draw(&Composite::new(&pasted.mesh, &pasted.lapped), &seen);
            let expected = stage.draw(&Composite::new(&pasted.mesh, &pasted.lapped).with_parallax(depth), &seen);
            assert!(compare(&pasted.mesh, &camera, grid, &plain, &expected).inside > 1.0, "relief is seen");
            for renderer in renderers() {
                let renderer =
                    Renderer::new(renderer.gpu().clone(), RendererOptions { parallax: depth, ..RendererOptions::default() });
                let renderer = renderer.unwrap();
                let subject = renderer.load(&stage, &pasted.lapped).unwrap();
                for path in [Path::Single, Path::Layered] {
                    let drawn = renderer.draw(&subject, &stage, &camera, grid, path).unwrap();
                    let found = compare(&pasted.mesh, &camera, grid, &expected, &drawn);
                    println!("relief {depth} {view} {path:?} on {}: {found:?}", renderer.gpu().adapter());
                    assert!(found.inside < 1.0 && found.outline < OUTLINE, "{depth} {view} {path:?}: {found:?}");
                }
            }
        }
    }
}
