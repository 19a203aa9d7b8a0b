//! What a record takes on the device, against an atlas with the exemplar's pixels all over the surface.

#![allow(clippy::print_stdout, clippy::unwrap_used, reason = "the table is shown when asked for; helpers fail as tests do")]

use crate::common::{pasted, renderers};
use lapped::exemplar::{Channel, Exemplar};
use lapped::render::{DrawOptions, Stage};

/// What charts commonly leave of an atlas.
const ATLAS_FILL: f64 = 0.7;

/// Bytes of an atlas in which the surface has `ratio` areas of the finest exemplar, with mip levels: four bytes for each group
/// of channels that any exemplar has.
fn atlas_bytes(exemplars: &[Exemplar], ratio: f64) -> f64 {
    let pixels = exemplars.iter().map(|e| e.size().map(f64::from).iter().product::<f64>()).fold(0.0, f64::max);
    let normals = exemplars.iter().any(|e| e.channels().has(Channel::Normal));
    pixels * ratio / ATLAS_FILL * 4.0 / 3.0 * 4.0 * if normals { 2.0 } else { 1.0 }
}

#[test]
#[ignore = "needs graphics adapters, software will do: cargo test --test gpu -- --include-ignored"]
fn the_demos_take_a_tenth_of_an_atlas_of_their_sampling_density() {
    let shows: [(&str, &[&str], f64, bool); 8] = [
        ("dragonling_25k", &["scales"], 60.0, true),
        ("dragonling", &["fur"], 40.0, true),
        ("dragonling", &["moss", "stone"], 40.0, false),
        ("knot", &["weave"], 60.0, true),
        ("knot", &["pebbles"], 30.0, false),
        ("gear", &["rust"], 30.0, false),
        ("vase", &["bricks"], 30.0, true),
        ("terrain", &["leaves"], 60.0, false),
    ];
    for (mesh, exemplars, ratio, up) in shows {
        let done = pasted(mesh, exemplars, ratio, up);
        let stage = Stage::new(&done.mesh, &DrawOptions::default());
        let subject = renderers()[0].load(&stage, &done.lapped).unwrap();
        let [positions, lists, textures] = subject.bytes();
        let atlas = atlas_bytes(&done.lapped.exemplars, ratio);
        let times = atlas / (lists + textures) as f64;
        let mib = |bytes: f64| bytes / f64::from(1 << 20);
        println!(
            "| {mesh} {exemplars:?} | {} | {:.2} | {:.2} | {:.2} | {:.1} | {times:.1} |",
            done.mesh.face_count(),
            mib(positions as f64),
            mib(lists as f64),
            mib(textures as f64),
            mib(atlas)
        );
        assert!(times > 10.0, "{mesh} {exemplars:?}: {times:.1} times less");
    }
}
