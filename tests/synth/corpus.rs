//! Real surfaces with everything that is wrong with them. Takes the folder of meshes and textures from the environment variable
//! `LAPPED_CORPUS` and does nothing without it.

use lapped::format::{ExemplarOptions, read_exemplar, read_model};
use lapped::job::{Density, Direction, Steer, SynthJob, synthesize_on};
use lapped::mesh::{CleanOptions, clean};
use lapped::progress::Silent;

#[test]
fn every_surface_gets_a_texture_and_hardly_a_sample_stays_uncovered() {
    let Some(folder) = crate::folder::corpus() else { return };
    let options = ExemplarOptions { alone: true, ..ExemplarOptions::default() };
    let (exemplar, _) = read_exemplar(&folder.join("textures/stones-128.png"), &options).expect("a texture");
    // Thin limbs, sharp edges, high genus, open borders, needles.
    for name in ["cat.obj", "knot.obj", "mechpart.obj", "horse.ply", "mannequin.obj", "fandisk.obj", "range-scan.ply", "blade.obj"]
    {
        let model = read_model(&folder.join("meshes").join(name)).expect("a mesh");
        let cleaned = clean(&model.positions, &model.faces, &CleanOptions::default()).expect("a surface");
        let direction = Direction::Steered(Steer::Relaxed(2));
        let job = SynthJob { density: Density::Vertices(6000), side: Some(64), direction, ..SynthJob::default() };
        let made = synthesize_on(&cleaned, &exemplar, &job, &Silent, &mut |_, _, _| ()).unwrap_or_else(|e| panic!("{name}: {e}"));
        let levels = &made.report.synth.levels;
        let finest = levels.last().expect("a level");
        let asked = (finest.vertices * (finest.window.side * finest.window.side) as usize) as f64;
        let share = finest.uncovered_samples as f64 / asked;
        let open = cleaned.mesh.boundary_edge_count() > 0;
        assert!(share < if open { 0.25 } else { 0.03 }, "{name}: {share} of the finest level's samples are uncovered");
        let values = made.texture.all().iter().flat_map(|(_, v)| v);
        assert!(values.clone().all(|x| (0.0..=1.0).contains(x)), "{name}: colours within 0 and 1");
    }
}
