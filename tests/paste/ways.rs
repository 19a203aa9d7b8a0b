//! Fields of several ways: patches run straight on over the line where a choice of one way jumps.

#![allow(clippy::unwrap_used, reason = "a test may fail by panicking")]

use crate::common::{asset, meshed, patches, sheet};
use lapped::assets;
use lapped::exemplar::PatchSource;
use lapped::field::nway::relaxed;
use lapped::field::{Guide, TangentField, default_scale};
use lapped::paste::{PasteOptions, PasteStatistics, paste};
use lapped::progress::Silent;

#[test]
fn a_four_way_field_leaves_less_hard_edge_than_one_of_its_directions() {
    let mesh = asset("dragonling");
    let scale = default_scale(&mesh, 40.0, 1.0);
    let (field, met) = relaxed(&mesh, 4, scale, &Silent).unwrap();
    assert_eq!(field.ways, 4, "it says so");
    assert!(met.cut.edges > 20, "no line to run over: {:?}", met.cut);
    let pasted = |ways: u32, seed: u64| -> PasteStatistics {
        let guide = Guide::Directed(TangentField { ways, ..field.clone() });
        let exemplar = assets::exemplar("weave").unwrap();
        let options = PasteOptions { seed, ..PasteOptions::default() };
        paste(&mesh, &guide, vec![exemplar], patches("weave", PatchSource::Splotch), &[], &options, &Silent).unwrap().1
    };
    // One layout differs from the next by a tenth: the claim is about their mean.
    let seeds = 1..=4_u64;
    let mut means = [0.0_f64; 2];
    for seed in seeds.clone() {
        let free = pasted(4, seed);
        assert!(free.least_alpha >= 0.98, "covered: {}", free.least_alpha);
        means[0] += free.hard_edge_length;
        means[1] += pasted(1, seed).hard_edge_length;
    }
    let [free, fixed] = means.map(|sum| sum / seeds.clone().count() as f64);
    assert!(free < 0.92 * fixed, "{free} with four ways, {fixed} with one");
}

#[test]
fn turned_by_quarters_at_random_a_four_way_field_lays_patches_as_before() {
    // A flat grid whose field is one direction, given at each face by any of its four quarter turns.
    let mesh = meshed(&sheet(24, 1.0));
    let mut random = lapped::random::Random::new(9, 0);
    let quarter = [glam::Vec3::Y, glam::Vec3::X, glam::Vec3::NEG_Y, glam::Vec3::NEG_X];
    let up = (0..mesh.face_count()).map(|_| quarter[(random.unit() * 4.0) as usize % 4] * 0.4).collect();
    let guide = Guide::Directed(TangentField { up, right: None, ways: 4 });
    let exemplar = assets::exemplar("weave").unwrap();
    let patches = patches("weave", PatchSource::Splotch);
    let (_, statistics) = paste(&mesh, &guide, vec![exemplar], patches, &[], &PasteOptions::default(), &Silent).unwrap();
    assert!(statistics.deviation.direction_p95 < 0.1, "{:?}", statistics.deviation);
    assert!(statistics.hard_edge_length < 1e-6, "a plane has no hard edge: {}", statistics.hard_edge_length);
}
