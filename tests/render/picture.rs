//! The reference picture: colours that survive, light that is neither won nor lost, and independence of everything that
//! must not matter.

#![allow(clippy::unwrap_used, clippy::panic, reason = "helpers of tests fail as tests do")]

use crate::common::{Painted, checks, flat, moved, plain, round};
use glam::{DVec3, Vec3};
use lapped::exemplar::{Channel, ChannelSet};
use lapped::mesh::{Mesh, SurfacePoint};
use lapped::render::{Background, DrawOptions, Grid, Lighting, Picture, SheetOptions, View, draw, sheet};
use lapped::surface::{SurfaceTexture, Texel};

const GRID: Grid = Grid { width: 96, height: 96, samples: 2 };

fn picture(mesh: &Mesh, texture: &dyn SurfaceTexture, view: &str, options: &DrawOptions) -> Picture {
    let view: View = view.parse().unwrap();
    draw(mesh, texture, &view.frame(mesh, GRID.aspect()), GRID, options).unwrap()
}

fn srgb(linear: f32) -> f32 {
    255.0 * lapped::exemplar::srgb::encode(linear)
}

#[test]
fn a_base_colour_seen_from_the_front_is_shown_as_it_is() {
    let mesh = flat(2);
    for colour in [Vec3::splat(0.2158), Vec3::new(0.6, 0.2, 0.05), Vec3::new(0.05, 0.1, 0.4), Vec3::splat(0.03)] {
        let shown = picture(&mesh, &plain(&mesh, colour), "front", &DrawOptions::default()).pixel(48, 48);
        for k in 0..3 {
            let difference = f32::from(shown[k]) - srgb(colour[k]);
            assert!(difference.abs() < 9.0, "{colour} is shown as {shown:?}");
        }
    }
}

#[test]
fn in_a_white_furnace_a_white_body_cannot_be_told_from_the_light() {
    let mesh = round(40, 0.4);
    let options = DrawOptions {
        lighting: Lighting::furnace(),
        background: Background::Plain(Vec3::ONE),
        occlusion: false,
        ..DrawOptions::default()
    };
    let shown = picture(&mesh, &plain(&mesh, Vec3::ONE), "three-quarter", &options);
    // The tone curve shows light 1 as this.
    let white = srgb(lapped::render::shade::tone(Vec3::ONE).x);
    let inside: Vec<_> = shown.rgba.as_chunks::<4>().0.iter().filter(|p| p[0] < 255).collect();
    assert!(inside.len() > 1000, "the body is seen");
    for p in inside {
        assert!(f32::from(p[0]) > white - 3.0, "a pixel of {p:?} is darker than {white}");
    }
}

#[test]
fn outside_the_silhouette_a_transparent_picture_is_empty_and_inside_opaque() {
    let mesh = round(40, 0.0);
    let options = DrawOptions { background: Background::Transparent, ..DrawOptions::default() };
    let shown = picture(&mesh, &plain(&mesh, Vec3::splat(0.3)), "front", &options);
    let opaque = shown.rgba.as_chunks::<4>().0.iter().map(|p| f64::from(p[3]) / 255.0).sum::<f64>();
    // A sphere framed with a margin of 0.07 on each side.
    let expected = std::f64::consts::PI * (48.0 * 0.93_f64).powi(2);
    assert!((opaque / expected - 1.0).abs() < 0.01, "coverage {opaque}, disc {expected}");
    assert_eq!([shown.pixel(48, 48)[3], shown.pixel(2, 2)[3]], [255, 0], "middle and corner");
}

#[test]
fn relief_along_the_flat_normal_changes_nothing_on_a_smooth_body() {
    let mesh = round(24, 0.4);
    let flat = plain(&mesh, Vec3::splat(0.4));
    let relief = Painted { channels: flat.channels.with(Channel::Normal), paint: |at, footprint| (flat.paint)(at, footprint) };
    let options = DrawOptions::default();
    let (a, b) = (picture(&mesh, &flat, "three-quarter", &options), picture(&mesh, &relief, "three-quarter", &options));
    let most = a.rgba.iter().zip(&b.rgba).map(|(x, y)| x.abs_diff(*y)).max().unwrap();
    assert!(most <= 1, "pictures differ by {most}");
}

#[test]
fn one_sees_through_what_is_not_opaque_in_the_right_order() {
    // Two sheets: half-opaque black before opaque white; the emission makes colours exact.
    let front = moved(&flat(2), |p| p + DVec3::Z * 0.1);
    let back = flat(2);
    let half = back.vertex_count() as u32;
    let positions = back.positions.iter().chain(&front.positions).copied().collect();
    let faces = back.faces.iter().copied().chain(front.faces.iter().map(|f| f.map(|v| v + half))).collect();
    let mesh = Mesh::new(positions, faces).unwrap();
    let first_front = back.face_count() as u32;
    let texture = Painted {
        channels: ChannelSet::default().with(Channel::Opacity).with(Channel::Emissive),
        paint: |at: SurfacePoint, _| {
            let near = at.face >= first_front;
            let (emissive, opacity) = if near { (Vec3::new(0.5, 0.0, 0.0), 0.5) } else { (Vec3::new(0.0, 0.5, 0.0), 1.0) };
            Texel { emissive, opacity, alpha: 1.0, ..Texel::empty(Vec3::Z) }
        },
    };
    let dark = Lighting { sky: Vec3::ZERO, ground: Vec3::ZERO, ..Lighting::furnace() };
    let options = DrawOptions { lighting: dark, ..DrawOptions::default() };
    let from_front = picture(&mesh, &texture, "front", &options).pixel(48, 48);
    assert_eq!(from_front[..3], [srgb(0.25).round() as u8, srgb(0.25).round() as u8, 0], "half of each from the front");
    let from_back = picture(&mesh, &texture, "back", &options).pixel(48, 48);
    assert_eq!(from_back[..3], [0, srgb(0.5).round() as u8, 0], "only the opaque one from the back");
}

#[test]
fn pictures_do_not_depend_on_threads_vertex_order_size_or_place() {
    let mesh = round(48, 0.4);
    let look = |mesh: &Mesh| picture(mesh, &checks(mesh, 9.0), "three-quarter", &DrawOptions::default());
    let expected = look(&mesh);
    for threads in [1, 3] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        assert_eq!(pool.install(|| look(&mesh)), expected, "{threads} threads");
    }
    let n = mesh.vertex_count() as u32;
    let positions = (0..n).map(|v| mesh.positions[(n - 1 - v) as usize]).collect();
    let reversed = Mesh::new(positions, mesh.faces.iter().map(|f| f.map(|v| n - 1 - v)).collect()).unwrap();
    assert_eq!(look(&reversed), expected, "vertex order");

    for (scale, shift) in [(0.5, 0.0), (1e-6, 0.0), (1e6, 0.0), (1000.0, 1e5)] {
        let other = look(&moved(&mesh, |p| p * scale + DVec3::splat(shift)));
        let differences = other.rgba.iter().zip(&expected.rgba).map(|(a, b)| f64::from(a.abs_diff(*b)));
        let mean = differences.sum::<f64>() / expected.rgba.len() as f64;
        assert!(mean < if shift > 0.0 { 0.1 } else { 0.02 }, "size {scale} at {shift}: mean difference {mean} of 255");
    }
}

#[test]
fn a_sheet_shows_every_view_once_in_its_place() {
    let mesh = round(30, 0.4);
    let texture = plain(&mesh, Vec3::splat(0.4));
    let mut options = SheetOptions { size: [64, 48], samples: 1, ..SheetOptions::default() };
    for view in &mut options.views {
        view.0.clear();
    }
    let whole = sheet(&mesh, &texture, &options).unwrap();
    assert_eq!([whole.width, whole.height], [130, 98], "two by two with separators");
    for (i, (_, view)) in options.views.iter().enumerate() {
        let grid = Grid { width: 64, height: 48, samples: 1 };
        let alone = draw(&mesh, &texture, &view.frame(&mesh, grid.aspect()), grid, &options.draw).unwrap();
        let (left, top) = ((i as u32 % 2) * 66, (i as u32 / 2) * 50);
        let same = (0..48).all(|y| (0..64).all(|x| whole.pixel(left + x, top + y) == alone.pixel(x, y)));
        assert!(same, "view {i} is in its cell");
    }
    options.views.clear();
    assert!(sheet(&mesh, &texture, &options).is_err(), "no views, no sheet");
}
