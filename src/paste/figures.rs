//! Figures of a run.

use super::grow::Stops;
use super::seam::{ContrastStatistics, CutStatistics};
use super::statistics::SpreadSummary;
use super::window::WindowStatistics;
use serde::Serialize;

/// Figures of a run.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct PasteStatistics {
    /// Pastes in the record.
    pub pastes: usize,
    /// Pastes laid; the difference was pruned or hidden completely.
    pub pastes_laid: usize,
    /// Faces of all surface patches together, as grown.
    pub grown_faces: u64,
    /// Draws per face before culling: mean over faces.
    pub draws_before_cull: f64,
    /// Draws per face in the record: mean over faces.
    pub draws_per_face: f64,
    /// The same, mean over the surface's area.
    pub draws_per_area: f64,
    /// Conjugate gradient iterations per fit.
    pub iterations_per_fit: f64,
    /// Share of pastes that grew again after a fit.
    pub regrowths_per_paste: f64,
    /// Seeds whose texture patch was too thin to cover a coverage cell.
    pub forced_seeds: u64,
    /// Coverage samples.
    pub coverage_samples: u64,
    /// Points of the final audit.
    pub audit_samples: u64,
    /// The least composite alpha it found.
    pub least_alpha: f32,
    /// Pastes laid for holes it found.
    pub repairs: usize,
    /// Pastes laid over hard edges that showed.
    pub overlays: usize,
    /// Smaller pastes laid over hard edges that still showed.
    pub small: usize,
    /// Pastes left out because the others cover all they did.
    pub pruned: usize,
    /// Pastes with a hard edge.
    pub pastes_with_hard_edges: u64,
    /// World length of all hard edges, weighted by alpha.
    pub hard_edge_length: f64,
    /// World length of hard edges that show, weighted by their alpha and by what lies over them.
    pub visible_hard_edge_length: f64,
    /// The same, divided by mean exemplar width, per exemplar area of surface.
    pub visible_hard_edges_per_exemplar: f64,
    /// Why growth stopped inside the hull, in edges.
    pub stops: Stops,
    /// How the fitted faces deviate from the field.
    pub deviation: SpreadSummary,
    /// Windows chosen, and how much better borders agree.
    pub windows: WindowStatistics,
    /// Pastes cut, and how much less borders show.
    pub cuts: CutStatistics,
    /// How far pastes agree with what lies below, if contrast is kept.
    pub contrast: ContrastStatistics,
    /// Seconds per stage.
    pub seconds: StageSeconds,
}

/// Seconds per stage. Growing, fitting and covering run on several threads: their seconds are summed over threads.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct StageSeconds {
    /// Masks, lattices, tables (wall).
    pub prepare: f64,
    /// Growing and fitting (all threads).
    pub lay: f64,
    /// Coverage and recording (all threads).
    pub cover: f64,
    /// The whole loop (wall).
    pub pasting: f64,
    /// The audit and its repairs (wall).
    pub audit: f64,
    /// Ordering and culling (wall).
    pub order_and_cull: f64,
    /// All of it (wall).
    pub total: f64,
}
