//! A synthesis beside pastes: of one of their exemplars, as large on the surface and lying the same way, so that the two can be
//! compared.

use super::directions::Direction;
use super::project::Project;
use super::round::RoundJob;
use super::synth::{Density, SynthJob};
use crate::exemplar::Exemplar;
use crate::mesh::Mesh;
use serde::{Deserialize, Serialize};

/// Vertices unless more or fewer are asked for: a few seconds of work.
pub const VERTICES: u32 = 60_000;

/// The exemplar's longer side, pixels, at least and at most.
const SIDES: [f64; 2] = [8.0, 256.0];

/// What is chosen for a synthesis.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase", deny_unknown_fields, default)]
pub struct Synthesis {
    /// Which of the exemplars, from 0.
    pub exemplar: usize,
    /// Vertices, about. Each stands for a pixel: with more of them the exemplar has more pixels, until it has all of its own.
    pub vertices: u32,
    /// Seed of all random choices.
    pub seed: u64,
}

impl Default for Synthesis {
    fn default() -> Self {
        Self { exemplar: 0, vertices: VERTICES, seed: 1 }
    }
}

/// The same synthesis by both methods.
#[derive(Debug, Clone)]
pub struct Beside {
    /// Wei and Levoy.
    pub levels: SynthJob,
    /// Chen and Dong.
    pub round: RoundJob,
}

impl Beside {
    /// The synthesis that a project asks for beside its pastes on a mesh, `scale` being the world length of one exemplar width.
    #[must_use]
    pub fn new(project: &Project, mesh: &Mesh, exemplar: &Exemplar, scale: f64) -> Self {
        let chosen = project.synthesis;
        let [width, height] = exemplar.size().map(f64::from);
        let longer = width.max(height);
        // So many pixels to one exemplar width give as many vertices as are asked for.
        let pixels = scale * (f64::from(chosen.vertices) / mesh.total_area()).sqrt();
        let side = (pixels * longer / width).clamp(SIDES[0], SIDES[1]).min(longer).round();
        let side = Some(if side.is_finite() { side as u32 } else { longer as u32 });
        let (density, direction) = (Density::Scale(scale), Direction::Steered(project.job(Some(exemplar)).steer));
        let mut levels = SynthJob { density, side, direction: direction.clone(), ..SynthJob::default() };
        let mut round = RoundJob { density, side, direction, ..RoundJob::default() };
        (levels.options.seed, round.options.seed) = (chosen.seed, chosen.seed);
        Self { levels, round }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::exemplar::Image;
    use crate::job::synth::prepared;
    use crate::mesh::shapes;
    use glam::Vec3;

    #[test]
    fn as_many_vertices_as_asked_for_until_the_exemplar_has_all_its_pixels() {
        let mesh = shapes::sphere(3);
        let wide = Exemplar::new("wide".to_owned(), Image::from_fn(200, 100, |_, _| Vec3::ONE));
        let vertices = |asked: u32| {
            let project = Project { synthesis: Synthesis { vertices: asked, ..Synthesis::default() }, ..Project::default() };
            let job = Beside::new(&project, &mesh, &wide, 1.0).levels;
            let width = prepared(&wide, job.side, job.tiles).size()[0];
            (job.density.vertices(&mesh, width).expect("a usable scale"), width)
        };
        for asked in [5_000, 60_000, 200_000] {
            let (made, width) = vertices(asked);
            let share = made as f64 / f64::from(asked);
            assert!((0.9..1.1).contains(&share), "{asked} vertices became {made}, with an exemplar {width} pixels wide");
        }
        assert_eq!(vertices(10_000_000).1, 200, "no more pixels than it has");
    }
}
