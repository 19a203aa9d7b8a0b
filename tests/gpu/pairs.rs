//! All demo meshes, each under several of the demo exemplars and each exemplar on two, and meshes of the corpus, in all three ways of drawing.

#![allow(clippy::unwrap_used, reason = "helpers of tests fail as tests do")]

use crate::agree::agree;
use crate::common::{pasted, pasted_model};
use lapped::format::{ExemplarOptions, read_exemplar, read_model};
use lapped::render::{DrawOptions, Grid};

/// Few exemplar areas: what is compared is drawing, and each pair is pasted first.
const RATIO: f64 = 8.0;
/// One pair in so many is drawn.
const EVERY: usize = 3;
const GRID: Grid = Grid { width: 90, height: 80, samples: 2 };

#[test]
#[ignore = "needs graphics adapters, software will do: cargo test --test gpu -- --include-ignored"]
fn every_demo_mesh_and_every_demo_exemplar_look_the_same_in_all_modes() {
    for (i, mesh) in lapped::assets::mesh_names().enumerate() {
        for (j, exemplar) in lapped::assets::exemplar_names().enumerate().filter(|(j, _)| (i + j) % EVERY == 0) {
            let pasted = pasted(mesh, &[exemplar], RATIO, (i + j) % 2 == 0);
            agree(&format!("{mesh} {exemplar}"), &pasted.mesh, &pasted.lapped, &DrawOptions::default(), "three-quarter", GRID);
        }
    }
}

#[test]
#[ignore = "needs graphics adapters, software will do: cargo test --test gpu -- --include-ignored"]
fn meshes_of_the_corpus_look_the_same_in_all_modes() {
    let Some(corpus) = crate::folder::corpus() else { return };
    let pairs = [
        ("spot.obj", "grass.png", "three-quarter"),
        ("duck.glb", "bricks-pbr", "yaw=-60,pitch=25"),
        ("fandisk.obj", "cheese", "front,fov=0"),
        ("teapot.obj", "leaves-alpha.png", "top"),
        ("rocker-arm.obj", "bark", "yaw=120,pitch=-10"),
    ];
    for (mesh, exemplar, view) in pairs {
        let model = read_model(&corpus.join("meshes").join(mesh)).unwrap();
        let (exemplar, _) = read_exemplar(&corpus.join("textures").join(exemplar), &ExemplarOptions::default()).unwrap();
        let pasted = pasted_model(&model, vec![exemplar], RATIO, true);
        agree(mesh, &pasted.mesh, &pasted.lapped, &DrawOptions::default(), view, GRID);
    }
}
