//! What source maps tell: exact where the map is known, worse the more a fault is planted, and the same however vertices are
//! numbered.

use glam::{DMat2, DVec2, DVec3, Vec3};
use lapped::compare::measures::{Mapped, Mapping, breaks, mapping};
use lapped::compare::source::{Origin, Plane, Sourced};
use lapped::exemplar::{Channel, ChannelSet};
use lapped::mesh::walk::Walker;
use lapped::mesh::{Mesh, SurfacePoint};
use lapped::random::Random;
use lapped::surface::{SurfaceTexture, Texel};

/// Side of the sheet, a pixel a unit.
const SIDE: f64 = 60_000.0;

/// Texture on a sheet in the plane z = 0, by the pixel at each place and the pixels of a step right and up.
struct Laid<'a, F> {
    mesh: &'a Mesh,
    place: F,
    alpha: fn(DVec2) -> f32,
}

impl<F: Fn(DVec2) -> (DVec2, DMat2) + Sync> SurfaceTexture for Laid<'_, F> {
    fn channels(&self) -> ChannelSet {
        ChannelSet::default().with(Channel::BaseColor)
    }

    fn texel(&self, at: SurfacePoint, _footprint: f32) -> Texel {
        Texel { alpha: (self.alpha)(self.mesh.position(at).truncate()), ..Texel::empty(Vec3::Z) }
    }
}

impl<F: Fn(DVec2) -> (DVec2, DMat2) + Sync> Sourced for Laid<'_, F> {
    fn origin(&self, at: SurfacePoint) -> Option<Origin> {
        let (pixel, map) = (self.place)(self.mesh.position(at).truncate());
        let back = map.inverse();
        let steps = [back.x_axis.extend(0.0), back.y_axis.extend(0.0)];
        Some(Origin { pixel, right: steps[0].normalize(), steps: Some(steps) })
    }
}

/// A square of `n` by `n` quads, its vertices and faces numbered in an order of their own.
fn sheet(n: u32, vertices: &[u32], faces: &[u32]) -> Mesh {
    let at = |i: u32, j: u32| vertices[(j * (n + 1) + i) as usize];
    let mut positions = vec![Vec3::ZERO; vertices.len()];
    let mut all = Vec::new();
    for j in 0..=n {
        for i in 0..=n {
            positions[at(i, j) as usize] = Vec3::new(i as f32, j as f32, 0.0) * (SIDE as f32 / n as f32);
            if i < n && j < n {
                all.extend([[at(i, j), at(i + 1, j), at(i + 1, j + 1)], [at(i, j), at(i + 1, j + 1), at(i, j + 1)]]);
            }
        }
    }
    Mesh::new(positions, faces.iter().map(|&f| all[f as usize]).collect()).expect("a sheet")
}

fn plain(n: u32) -> Mesh {
    sheet(n, &(0..(n + 1) * (n + 1)).collect::<Vec<_>>(), &(0..2 * n * n).collect::<Vec<_>>())
}

/// An exemplar that tiles, of so many pixels a side.
const fn tiling(side: f64) -> Plane {
    Plane { size: DVec2::splat(side), tiles: true, pixel: 1.0 }
}

fn measured(mesh: &Mesh, plane: Plane, ways: u32, place: impl Fn(DVec2) -> (DVec2, DMat2) + Sync) -> Mapping {
    let source = Laid { mesh, place, alpha: |_| 1.0 };
    mapping(&Mapped { on: &Walker::new(mesh), source: &source, plane, up: &|_| Some(DVec3::Y), ways }, 1).0
}

/// Right goes right, and up goes up in the exemplar, where pixels are counted downward.
const UPRIGHT: DMat2 = DMat2::from_cols_array(&[1.0, 0.0, 0.0, -1.0]);

fn by(map: DMat2) -> impl Fn(DVec2) -> (DVec2, DMat2) + Sync {
    move |p| (map * p, map)
}

/// Squares of `side` pixels, each from a random place.
fn scrambled(side: f64, seed: u64) -> impl Fn(DVec2) -> (DVec2, DMat2) + Sync {
    move |p| {
        let cell = (p / side).floor();
        let mut random = Random::new(seed, (cell.x as u64) << 32 | cell.y as u64);
        (UPRIGHT * p + 1000.0 * DVec2::new(random.unit(), random.unit()), UPRIGHT)
    }
}

#[test]
fn an_exemplar_laid_as_it_is_has_no_fault_but_that_it_repeats() {
    let mesh = plain(7);
    let m = measured(&mesh, tiling(100.0), 1, by(UPRIGHT));
    assert!(m.copied > 0.99 && m.copy_length == 64.0, "all is one copy: {m:?}");
    assert!((m.scale - 1.0).abs() < 1e-6 && (m.stretch_l2 - 1.0).abs() < 1e-6 && (m.stretch_linf - 1.0).abs() < 1e-6, "{m:?}");
    assert!(m.direction_rms.is_some_and(|d| d < 1e-4) && m.direction_p95.is_some_and(|d| d < 1e-4), "{m:?}");
    assert!(m.repeats > 0.95, "every 100 pixels: {m:?}");
    assert!(m.used > 0.95 && m.mapped == 1.0 && m.least_alpha == 1.0 && m.bare == 0.0, "{m:?}");
}

#[test]
fn size_stretch_and_direction_are_what_was_planted() {
    let mesh = plain(7);
    for factor in [0.5, 1.1, 1.5, 2.0] {
        let m = measured(&mesh, tiling(100.0), 1, by(UPRIGHT * (1.0 / factor)));
        assert!((m.scale - factor).abs() < 1e-6 && (m.stretch_l2 - 1.0).abs() < 1e-6, "{factor} times as large: {m:?}");
        let m = measured(&mesh, tiling(100.0), 1, by(UPRIGHT * DMat2::from_diagonal(DVec2::new(1.0 / factor, 1.0))));
        let l2 = ((factor * factor + 1.0) / 2.0 / factor).sqrt();
        assert!((m.stretch_l2 - l2).abs() < 1e-6, "{factor} times as wide: {m:?}, {l2}");
        assert!((m.stretch_linf - factor.max(1.0) / factor.sqrt()).abs() < 1e-6, "{factor} times as wide: {m:?}");
    }
    for degrees in [5.0_f64, 20.0, 80.0, 170.0] {
        let turned = by(UPRIGHT * DMat2::from_angle(degrees.to_radians()));
        let m = measured(&mesh, tiling(100.0), 1, &turned);
        assert!(m.direction_rms.is_some_and(|d| (d - degrees).abs() < 1e-3), "turned by {degrees}: {m:?}");
        let of_four = measured(&mesh, tiling(100.0), 4, &turned);
        let least = (degrees - (degrees / 90.0).round() * 90.0).abs();
        assert!(of_four.direction_rms.is_some_and(|d| (d - least).abs() < 1e-3), "of four ways: {of_four:?}");
    }
}

#[test]
fn smaller_pieces_are_copied_less_far_and_have_more_borders() {
    let mesh = plain(7);
    let plane = tiling(1000.0);
    let found: Vec<(Mapping, usize)> = [6.0, 20.0, 60.0, 200.0]
        .into_iter()
        .map(|side| {
            let source = Laid { mesh: &mesh, place: scrambled(side, 3), alpha: |_| 1.0 };
            let of = Mapped { on: &Walker::new(&mesh), source: &source, plane, up: &|_| None, ways: 1 };
            let places = breaks(&of, 1).len();
            // A step of random direction crosses a grid of lines 1/side apart in each way this often.
            let expected = 30_000.0 * (1.0 - (1.0 - 2.0 / std::f64::consts::PI / side).powi(2));
            let most = expected.min(4000.0);
            assert!((places as f64 - most).abs() < 0.1 * most + 20.0, "{places} of {expected} borders of squares of {side}");
            let m = mapping(&of, 1).0;
            assert!(m.direction_rms.is_none(), "no direction was asked for");
            assert!((m.stretch_l2 - 1.0).abs() < 1e-6, "each piece is as it should be");
            (m, places)
        })
        .collect();
    assert!(found.windows(2).all(|w| w[0].0.copied < w[1].0.copied && w[0].0.copy_length < w[1].0.copy_length), "{found:?}");
    assert!(found.windows(2).all(|w| w[0].1 >= w[1].1), "{found:?}");
    assert!(found.iter().all(|(m, _)| m.repeats < 0.1 && m.used > 0.95), "random places do not repeat: {found:?}");
}

#[test]
fn tiles_of_a_part_repeat_and_leave_the_rest_unused() {
    let mesh = plain(7);
    let window = |side: f64| move |p: DVec2| ((UPRIGHT * p).rem_euclid(DVec2::splat(side)), UPRIGHT);
    let plane = Plane { tiles: false, ..tiling(100.0) };
    let all: Vec<Mapping> = [50.0, 75.0, 100.0].into_iter().map(|side| measured(&mesh, plane, 1, window(side))).collect();
    for (m, share) in all.iter().zip([0.25, 0.5625, 1.0]) {
        assert!(m.repeats > 0.8, "tiles: {m:?}");
        assert!((m.used - share).abs() < 0.06, "{share} of it is used: {m:?}");
    }
}

#[test]
fn bare_places_are_found() {
    let mesh = plain(7);
    let source = Laid { mesh: &mesh, place: by(UPRIGHT), alpha: |p| if p.x < 0.1 * SIDE { 0.25 } else { 1.0 } };
    let of = Mapped { on: &Walker::new(&mesh), source: &source, plane: tiling(100.0), up: &|_| None, ways: 1 };
    let (m, worst) = mapping(&of, 1);
    assert!((m.bare - 0.1).abs() < 0.02 && m.least_alpha == 0.25, "a tenth: {m:?}");
    let at = worst.alpha.expect("a worst place");
    assert!(at.value == 0.25 && mesh.position(at.at).x <= 0.1 * SIDE, "{at:?}");
}

#[test]
fn the_numbers_of_vertices_mean_nothing_and_those_of_faces_hardly_anything() {
    let n = 12;
    let mut random = Random::new(8, 0);
    let (mut vertices, mut faces): (Vec<u32>, Vec<u32>) = ((0..(n + 1) * (n + 1)).collect(), (0..2 * n * n).collect());
    random.shuffle(&mut vertices);
    let bent = |p: DVec2| {
        let map = UPRIGHT * DMat2::from_angle(0.1 * p.x / SIDE) * (1.0 + 0.2 * p.y / SIDE);
        (scrambled(80.0, 5)(p).0, map)
    };
    let first = measured(&plain(n), tiling(1000.0), 1, bent);
    let same = measured(&sheet(n, &vertices, &faces), tiling(1000.0), 1, bent);
    let near = |a: f64, b: f64, by: f64| (a - b).abs() <= by * a.abs().max(b.abs()) + 1e-12;
    let all = |m: &Mapping| [m.copied, m.copy_length, m.used, m.scale, m.stretch_l2, m.direction_rms.unwrap_or(0.0)];
    assert!(all(&first).into_iter().zip(all(&same)).all(|(a, b)| near(a, b, 1e-6)), "{first:?}\n{same:?}");
    random.shuffle(&mut faces);
    let others = measured(&sheet(n, &vertices, &faces), tiling(1000.0), 1, bent);
    assert!(all(&first).into_iter().zip(all(&others)).all(|(a, b)| near(a, b, 0.06)), "{first:?}\n{others:?}");
}
