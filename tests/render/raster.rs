//! The rasterizer against ray casting by brute force, and what must hold for every closed or flat surface.

#![allow(clippy::unwrap_used, clippy::panic, reason = "helpers of tests fail as tests do")]

use crate::common::{corpus, flat, moved, round};
use glam::{DVec2, DVec3, Vec3};
use lapped::mesh::{Mesh, NONE};
use lapped::random::Random;
use lapped::render::{Camera, Grid, View, Visibility};
use proptest::prelude::*;

/// Separate random triangles in the unit cube.
fn soup(count: u32, seed: u64) -> Mesh {
    let mut r = Random::new(seed, 0);
    let mut positions = Vec::new();
    for _ in 0..count {
        let middle = DVec3::new(r.unit(), r.unit(), r.unit());
        for _ in 0..3 {
            positions.push((middle + 0.3 * DVec3::new(r.unit() - 0.5, r.unit() - 0.5, r.unit() - 0.5)).as_vec3());
        }
    }
    Mesh::new(positions, (0..count).map(|f| [3 * f, 3 * f + 1, 3 * f + 2]).collect()).unwrap()
}

/// The nearest face along the ray through a place on the grid, by testing all of them.
fn cast(mesh: &Mesh, camera: &Camera, grid: Grid, at: DVec2) -> (u32, f64) {
    let [across, down] = grid.size().map(|n| n as f64);
    let (start, direction) = camera.ray([(2.0 * at.x - across) / down, 1.0 - 2.0 * at.y / down]);
    let mut best = (NONE, f64::INFINITY);
    for face in 0..mesh.face_count() as u32 {
        let [a, b, c] = mesh.corners(face);
        let (u, v) = (b - a, c - a);
        let p = direction.cross(v);
        let scale = u.dot(p);
        let s = start - a;
        let q = s.cross(u);
        let (x, y, t) = (s.dot(p) / scale, direction.dot(q) / scale, v.dot(q) / scale);
        if x >= 0.0 && y >= 0.0 && x + y <= 1.0 && t >= camera.near && t < best.1 {
            best = (face, t);
        }
    }
    best
}

fn compare_with_casting(mesh: &Mesh, camera: &Camera) {
    let grid = Grid { width: 53, height: 41, samples: 2 };
    let seen = Visibility::new(mesh, camera, grid).unwrap();
    let [across, down] = grid.size();
    let mut hits = 0;
    for y in 0..down {
        for x in 0..across {
            let at = DVec2::new(x as f64 + 0.5, y as f64 + 0.5);
            let (face, depth) = cast(mesh, camera, grid, at);
            if seen.face(x, y) != face {
                // Only within the grid's snapping of an edge may the two differ.
                let around = [(1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0), (0.7, 0.7), (-0.7, -0.7), (0.7, -0.7), (-0.7, 0.7)];
                let same = around.iter().all(|&(dx, dy)| cast(mesh, camera, grid, at + DVec2::new(dx, dy) / 2048.0).0 == face);
                assert!(!same, "sample {x} {y} shows face {}, the ray meets {face}", seen.face(x, y));
            } else if let Some(hit) = seen.hit(mesh, x, y) {
                hits += 1;
                assert!((hit.depth - depth).abs() < 1e-9, "depth at {x} {y}: {} for {depth}", hit.depth);
                let (start, direction) = camera.ray([(2.0 * at.x - across as f64) / down as f64, 1.0 - 2.0 * at.y / down as f64]);
                let error = (mesh.position(hit.at) - (start + direction * depth)).length();
                assert!(error < 1e-6, "the barycentric coordinates at {x} {y} give the point met, off by {error}");
                assert!((hit.at.bary.element_sum() - 1.0).abs() < 1e-6 && hit.at.bary.min_element() >= 0.0, "weights");
            }
        }
    }
    assert!(hits > 300, "the picture shows something: {hits}");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]
    #[test]
    fn every_sample_shows_what_its_ray_meets_first(seed in 0_u64..1000, yaw in -180.0..180.0, pitch in -90.0..90.0, fov in prop::sample::select(vec![0.0, 30.0, 100.0])) {
        let view: View = format!("yaw={yaw},pitch={pitch},fov={fov},zoom=1.3").parse().unwrap();
        let mesh = soup(120, seed);
        compare_with_casting(&mesh, &view.frame(&mesh, 53.0 / 41.0));
    }

    #[test]
    fn faces_across_the_near_plane_are_clipped_exactly(seed in 0_u64..1000, yaw in -180.0..180.0, near in 1e-9..0.2) {
        let mesh = soup(200, seed);
        let mut camera = View::degrees(yaw, 10.0).frame(&mesh, 53.0 / 41.0);
        camera.eye = DVec3::splat(0.5);
        camera.near = near;
        camera.projection = lapped::render::Projection::Perspective(0.8);
        compare_with_casting(&mesh, &camera);
    }
}

/// How many layers of faces lie over each sample.
fn layers(mesh: &Mesh, seen: &Visibility) -> Vec<u32> {
    let mut count = vec![0; seen.faces().len()];
    let mut layer = seen.clone();
    for _ in 0..64 {
        if layer.is_empty() {
            return count;
        }
        for (n, &f) in count.iter_mut().zip(layer.faces()) {
            *n += u32::from(f != NONE);
        }
        layer = layer.behind(mesh);
    }
    panic!("the layers behind one another do not end");
}

#[test]
fn a_ray_enters_a_closed_surface_as_often_as_it_leaves() {
    enters_as_often_as_it_leaves([("sphere", round(33, 0.0)), ("torus", round(40, 0.35)), ("fine sphere", round(300, 0.0))]);
}

#[test]
fn a_ray_enters_corpus_meshes_as_often_as_it_leaves() {
    let names = ["cat.obj", "knot.obj", "fandisk.obj", "rocker-arm.obj"];
    enters_as_often_as_it_leaves(names.into_iter().filter_map(|name| Some((name, corpus(name)?))));
}

fn enters_as_often_as_it_leaves(meshes: impl IntoIterator<Item = (&'static str, Mesh)>) {
    for (name, mesh) in &meshes.into_iter().collect::<Vec<_>>() {
        // An odd grid and axis-aligned views put vertices and edges right on sample centres.
        for text in ["front", "top", "side", "three-quarter", "front,fov=0", "yaw=45,pitch=0,fov=0", "three-quarter,zoom=3"] {
            let view: View = text.parse().unwrap();
            let grid = Grid { width: 101, height: 101, samples: 1 };
            let seen = Visibility::new(mesh, &view.frame(mesh, 1.0), grid).unwrap();
            let layers = layers(mesh, &seen);
            assert!(layers.iter().any(|&n| n > 0), "{name} {text}: something is seen");
            let odd = layers.iter().position(|n| n % 2 == 1);
            assert_eq!(odd, None, "{name} {text}: a sample with an odd number of layers: a gap or a face drawn twice");
        }
    }
}

#[test]
fn neighbours_on_a_plane_leave_no_gap_and_do_not_overlap() {
    let mesh = flat(16);
    for text in ["front", "front,fov=0", "yaw=30,pitch=40", "front,zoom=3.7", "back,zoom=50"] {
        let view: View = text.parse().unwrap();
        // 16 quads over 128 samples of a parallel projection: edges and diagonals run through sample centres.
        let grid = Grid { width: 129, height: 129, samples: 1 };
        let seen = Visibility::new(&mesh, &view.frame(&mesh, 1.0), grid).unwrap();
        assert!(seen.behind(&mesh).is_empty(), "{text}: nothing lies behind a plane");
        for y in 0..129 {
            let row: Vec<usize> = (0..129).filter(|&x| seen.face(x, y) != NONE).collect();
            let gapless = row.windows(2).all(|w| w[1] == w[0] + 1);
            assert!(gapless, "{text}: row {y} has no gap");
        }
    }
}

#[test]
fn footprints_add_up_to_the_area_and_agree_with_neighbouring_points() {
    for text in ["front", "yaw=50,pitch=30", "yaw=60,pitch=-20,fov=90", "yaw=-40,pitch=10,fov=0"] {
        for size in [1e-6, 1.0, 1e6] {
            let mesh = moved(&flat(4), |p| p * size);
            let view: View = text.parse().unwrap();
            let grid = Grid { width: 160, height: 120, samples: 2 };
            let seen = Visibility::new(&mesh, &view.frame(&mesh, grid.aspect()), grid).unwrap();
            let [across, down] = grid.size();
            let hit = |x: usize, y: usize| seen.hit(&mesh, x, y);
            let mut area = 0.0;
            for y in 1..down - 1 {
                for x in 1..across - 1 {
                    let Some(here) = hit(x, y) else { continue };
                    area += here.footprint * here.footprint;
                    if let (Some(l), Some(r), Some(u), Some(d)) = (hit(x - 1, y), hit(x + 1, y), hit(x, y - 1), hit(x, y + 1)) {
                        let cell = 0.25 * (r.position - l.position).cross(d.position - u.position).length();
                        let ratio = here.footprint / cell.sqrt();
                        assert!((ratio - 1.0).abs() < 2e-3, "{text} {size}: footprint at {x} {y} is {ratio} of that measured");
                    }
                }
            }
            let ratio = area / (4.0 * size * size);
            assert!((ratio - 1.0).abs() < 0.02, "{text} {size}: footprints cover {ratio} of the plane");
        }
    }
}

#[test]
fn what_is_seen_depends_on_nothing_but_the_shape() {
    let mesh = round(60, 0.4);
    let grid = Grid { width: 150, height: 120, samples: 1 };
    let view = View::degrees(25.0, 35.0);
    let see = |mesh: &Mesh| Visibility::new(mesh, &view.frame(mesh, grid.aspect()), grid).unwrap();
    let seen = see(&mesh);

    for threads in [1, 5] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        assert_eq!(pool.install(|| see(&mesh)), seen, "{threads} threads");
    }

    // Vertices in another order.
    let n = mesh.vertex_count() as u32;
    let (there, back) = ((0..n).map(|v| (v * 7 + 3) % n), |v: u32| (v * 7 + 3) % n);
    let mut positions = vec![Vec3::ZERO; n as usize];
    for (from, to) in there.enumerate() {
        positions[to as usize] = mesh.positions[from];
    }
    assert_ne!(n % 7, 0, "7 permutes the vertices");
    let other = Mesh::new(positions, mesh.faces.iter().map(|f| f.map(back)).collect()).unwrap();
    assert_eq!(see(&other).faces(), seen.faces(), "vertex order");

    for (scale, shift) in [(2.0_f64.powi(-20), 0.0), (1e-6, 0.0), (1e6, 0.0), (1000.0, 1e5)] {
        let other = see(&moved(&mesh, |p| p * scale + DVec3::splat(shift)));
        let differ = other.faces().iter().zip(seen.faces()).filter(|(a, b)| a != b).count();
        // Rounding of moved positions turns a sample now and then; 1e5 away, positions are rounded to 1/128.
        let share = differ as f64 / seen.faces().len() as f64;
        assert!(share < if shift > 0.0 { 2e-3 } else { 2e-4 }, "size {scale} at {shift}: {differ} samples differ");
    }
}

#[test]
fn picking_finds_the_point_under_the_pixel() {
    let mesh = flat(8);
    let grid = Grid { width: 200, height: 100, samples: 3 };
    let view: View = "front,fov=0".parse().unwrap();
    let camera = view.frame(&mesh, grid.aspect());
    let seen = Visibility::new(&mesh, &camera, grid).unwrap();
    let lapped::render::Projection::Orthographic(half) = camera.projection else { panic!("fov=0 is a parallel projection") };
    for (x, y) in [(100.0, 50.0), (80.0, 30.0), (120.4, 77.3)] {
        let at = seen.pick(&mesh, DVec2::new(x, y)).unwrap();
        let expected = DVec3::new((x - 100.0) / 50.0 * half, (50.0 - y) / 50.0 * half, 0.0);
        let error = (mesh.position(at) - expected).length();
        assert!(error < half / 100.0, "{x} {y}: off by {error}");
    }
    for (x, y) in [(1.0, 50.0), (-3.0, 50.0), (1e9, 1.0), (f64::NAN, 2.0)] {
        assert_eq!(seen.pick(&mesh, DVec2::new(x, y)), None, "nothing at {x} {y}");
    }
}

#[test]
fn impossible_sizes_are_refused() {
    let mesh = flat(1);
    let camera = View::default().frame(&mesh, 1.0);
    for (width, height, samples) in [(0, 10, 1), (10, 10, 0), (40_000, 1, 1), (30_000, 30_000, 1), (u32::MAX, u32::MAX, u32::MAX)] {
        assert!(Visibility::new(&mesh, &camera, Grid { width, height, samples }).is_err(), "{width}x{height}x{samples}");
    }
}
