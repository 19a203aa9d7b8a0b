//! Unwrapping: every face in one chart, no charts on top of each other, little stretch, nothing left to chance.

#![allow(clippy::unwrap_used, reason = "a test may fail by panicking")]

use crate::checker::Shown;
use glam::Vec2;
use lapped::atlas::{Atlas, AtlasError, ChartMethod, UnwrapOptions, keep, measure, stretch, unwrap};
use lapped::mesh::{CleanOptions, Mesh, clean};
use lapped::progress::Silent;

const MESHES: [&str; 4] = ["knot", "gear", "vase", "dragonling"];

pub(crate) fn asset(name: &str) -> Mesh {
    let model = lapped::assets::mesh(name).unwrap();
    clean(&model.positions, &model.faces, &CleanOptions::default()).unwrap().mesh
}

fn options(method: ChartMethod) -> UnwrapOptions {
    UnwrapOptions { size: 1024, method, ..UnwrapOptions::default() }
}

/// What every atlas must be, whoever made its charts.
fn check(mesh: &Mesh, atlas: &Atlas, name: &str) {
    assert_eq!(atlas.corners.len(), mesh.face_count(), "{name}: every face has corners");
    for (f, (corners, &chart)) in atlas.corners.iter().zip(&atlas.chart).enumerate() {
        assert!((chart as usize) < atlas.chart_count(), "{name}: face {f} lies in a chart");
        assert_eq!(corners.map(|v| atlas.vertices[v as usize]), mesh.faces[f], "{name}: face {f} keeps its vertices");
    }
    assert!(atlas.uv.iter().all(|p| p.cmpge(Vec2::ZERO).all() && p.cmple(Vec2::ONE).all()), "{name}: within the page");
    let found = measure::overlap(mesh, atlas, 2048);
    assert_eq!((found.shared_texels, found.doubled_texels), (0, 0), "{name}: no texel is owned twice");
    assert_eq!(found.flipped_faces, 0, "{name}: no face lies upside down");
}

#[test]
fn charts_cover_every_face_once_and_do_not_overlap() {
    for name in MESHES {
        let mesh = asset(name);
        for (method, most) in [(ChartMethod::Auto, 1.05), (ChartMethod::Grow, 1.12)] {
            let atlas = unwrap(&mesh, &options(method), &Silent).unwrap();
            check(&mesh, &atlas, &format!("{name}, {method:?}"));
            let found = stretch(&mesh, &atlas);
            assert!(found.l2 < most, "{name}, {method:?}: the stretch is {}", found.l2);
            assert!(atlas.efficiency() > 0.35, "{name}, {method:?}: {} of the page is filled", atlas.efficiency());
        }
    }
}

#[test]
fn gutters_are_as_wide_as_the_mips_need() {
    let mesh = asset("knot");
    for mips in [0, 2, 4] {
        let atlas = unwrap(&mesh, &UnwrapOptions { mips, ..options(ChartMethod::Auto) }, &Silent).unwrap();
        // No two charts come nearer than twice the margin: texels that charts touch, looked at in squares of that size.
        let n = atlas.size as usize;
        let reach = 2 * atlas.margin as usize;
        let mut owner = vec![u32::MAX; n * n];
        for f in 0..mesh.face_count() as u32 {
            let Some(t) = measure_triangle(&atlas, f) else { continue };
            t.touched(0..n as i64, |x, y| owner[y as usize * n + x as usize] = atlas.chart[f as usize]);
        }
        for y in (0..n).step_by(3) {
            for x in 0..n - reach {
                let (a, b) = (owner[y * n + x], &owner[y * n + x..y * n + x + reach]);
                let alone = a == u32::MAX || b.iter().all(|&o| o == u32::MAX || o == a);
                assert!(alone, "{mips} mips: two charts within {reach} texels at {x}, {y}");
            }
        }
    }
}

fn measure_triangle(atlas: &Atlas, face: u32) -> Option<lapped::atlas::raster::Triangle> {
    lapped::atlas::raster::Triangle::new(atlas.face_texels(face))
}

#[test]
fn the_size_of_the_model_changes_nothing() {
    let mesh = asset("gear");
    let start = unwrap(&mesh, &options(ChartMethod::Auto), &Silent).unwrap();
    for scale in [1e-6_f32, 1e6] {
        let mut other = mesh.clone();
        other.positions.iter_mut().for_each(|p| *p *= scale);
        for method in [ChartMethod::Auto, ChartMethod::Grow] {
            check(&other, &unwrap(&other, &options(method), &Silent).unwrap(), &format!("scale {scale:e}, {method:?}"));
        }
        let atlas = unwrap(&other, &options(ChartMethod::Auto), &Silent).unwrap();
        let same = atlas.chart_count().abs_diff(start.chart_count());
        assert!(same * 10 <= start.chart_count(), "scale {scale:e}: {} charts", atlas.chart_count());
    }
}

#[test]
fn any_number_of_threads_makes_the_same_atlas() {
    let mesh = asset("dragonling");
    for method in [ChartMethod::Auto, ChartMethod::Grow] {
        let on = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| unwrap(&mesh, &options(method), &Silent).unwrap())
        };
        assert_eq!(on(1), on(3), "{method:?}");
    }
}

#[test]
fn several_pages_are_filled_at_one_density() {
    let mesh = asset("dragonling");
    let one = unwrap(&mesh, &UnwrapOptions { size: 512, ..UnwrapOptions::default() }, &Silent).unwrap();
    let four = unwrap(&mesh, &UnwrapOptions { size: 512, pages: 4, ..UnwrapOptions::default() }, &Silent).unwrap();
    assert!((2..=4).contains(&four.pages), "{} pages", four.pages);
    check(&mesh, &four, "four pages");
    assert!(four.density(&mesh) > 1.5 * one.density(&mesh), "finer: {} and {}", four.density(&mesh), one.density(&mesh));
    for page in 0..four.pages {
        assert!((0..mesh.face_count() as u32).any(|f| four.page_of(f) == page), "page {page} is used");
    }
}

#[test]
fn what_does_not_fit_is_refused_with_a_remedy() {
    let mesh = asset("dragonling");
    for (options, word) in [
        (UnwrapOptions { size: 8, ..UnwrapOptions::default() }, "16"),
        (UnwrapOptions { size: 32, mips: 6, ..UnwrapOptions::default() }, "--mips"),
    ] {
        let error = unwrap(&mesh, &options, &Silent).unwrap_err().to_string();
        assert!(error.contains(word), "{error}");
    }
}

#[test]
fn own_coordinates_are_kept_or_refused_with_the_place() {
    let mesh = asset("gear");
    let made = unwrap(&mesh, &options(ChartMethod::Auto), &Silent).unwrap();
    let uv: Vec<[Vec2; 3]> = (0..mesh.face_count() as u32).map(|f| made.face_uv(f)).collect();
    let kept = keep(&mesh, &uv, 1024, 2).unwrap();
    check(&mesh, &kept, "kept");
    for f in 0..mesh.face_count() as u32 {
        assert_eq!(kept.face_uv(f), made.face_uv(f), "face {f} stays where it was");
    }
    let mut doubled = uv.clone();
    // Two large faces on one place.
    let largest = (0..uv.len()).max_by(|&a, &b| mesh.area(a as u32).total_cmp(&mesh.area(b as u32))).unwrap();
    doubled[(largest + 1) % uv.len()] = uv[largest];
    match keep(&mesh, &doubled, 1024, 2) {
        Err(AtlasError::Keep(text)) => assert!(text.contains("faces") && text.contains("at ("), "{text}"),
        other => panic!("two faces on one place: {:?}", other.map(|a| a.chart_count())),
    }
    let mut outside = uv;
    outside[0][0].x = 1.5;
    assert!(keep(&mesh, &outside, 1024, 2).unwrap_err().to_string().contains("outside 0 to 1"), "tiled coordinates");
}

/// For the tests of files: charts seen in the file are those that were made, or parts of them.
pub(crate) fn charts_in(shown: &Shown) -> usize {
    let mut all = shown.charts();
    all.sort_unstable();
    all.dedup();
    all.len()
}
