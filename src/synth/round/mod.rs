//! Synthesis with round neighbourhoods, on the user's own vertices, without a hierarchy of meshes.
//!
//! Based on: Chen, Dong, "Adaptive surface texture synthesis using round-shaped neighbourhoods", Computer Graphics Forum 27(8),
//! 2008.
//!
//! The way through: [`Marching`] finds the circles about every vertex, once for a mesh; [`synthesize_round`] reads their samples in
//! the directions it is given ([`Template`]) and matches level by level. A level is the same vertices with wider circles and a
//! coarser exemplar. [`synthesize_plane`] does the same on an image's pixels.

mod cache;
mod ground;
mod march;
mod marching;
mod metric;
mod order;
mod passes;
mod template;
mod windows;

pub use cache::{CacheError, mesh_key};
pub use marching::{Marching, MarchingStatistics};
pub use metric::Metric;
pub use template::{MOST_CIRCLES, Sample, Template};

use crate::exemplar::stack::Stack;
use crate::mesh::Mesh;
use crate::progress::Progress;
use crate::synth::{Frame, Place};
use ground::{Ground, Plane, Surface, plane_sizes};
use passes::Work;
use serde::Serialize;
use std::time::Instant;
use windows::Windows;

/// Levels at most: circles are twice as wide on each.
pub const MOST_LEVELS: usize = 5;

/// The circles to march: how far apart they are, how many a level has, and how many levels.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Grid {
    /// World length of a pixel of the finest level.
    pub pixel: f64,
    /// Circles of a level.
    pub circles: usize,
    /// Levels.
    pub levels: usize,
}

impl Grid {
    fn checked(self) -> Result<Self, RoundError> {
        let sound = self.pixel > 0.0
            && self.pixel.is_finite()
            && (1..=MOST_CIRCLES).contains(&self.circles)
            && (1..=MOST_LEVELS).contains(&self.levels);
        if sound { Ok(self) } else { Err(RoundError::Grid { grid: self }) }
    }
}

/// How to synthesise.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct RoundOptions {
    /// Circles of a neighbourhood, 1 to [`MOST_CIRCLES`].
    pub circles: usize,
    /// The metric of the coarsest level.
    pub metric: Metric,
    /// Pixels around the linked place that are candidates on finer levels: the paper's `dist_range`.
    pub range: u32,
    /// Passes over each finer level.
    pub passes: usize,
    /// Batches in which the vertices of a finer level's pass are visited.
    pub batches: usize,
    /// Seed of all that is random.
    pub seed: u64,
}

impl Default for RoundOptions {
    fn default() -> Self {
        Self { circles: 3, metric: Metric::default(), range: 2, passes: 1, batches: 16, seed: 1 }
    }
}

/// What was done on one level.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct RoundLevel {
    /// Vertices.
    pub vertices: usize,
    /// Samples of neighbourhoods that lie beyond boundaries, or on circles that are not there.
    pub missing_samples: u64,
    /// Parts of the surface that were begun with a vertex drawn at random; on the coarsest level.
    pub starts: usize,
    /// Vertices whose place was drawn, since nothing around them showed anything.
    pub drawn: u64,
    /// Vertices for which all pixels were searched, since no neighbour's place could be continued.
    pub searched: u64,
    /// Vertices with several candidates.
    pub compared: u64,
    /// Circles that counted for them, on the mean.
    pub circles: f64,
    /// Candidates of a vertex, on the mean.
    pub candidates: f64,
    /// Seconds for reading samples, for resampling the exemplar, and for matching.
    pub seconds: [f64; 3],
}

/// A place of the exemplar at each vertex.
#[derive(Debug, Clone, PartialEq)]
pub struct RoundSynthesis {
    /// Places on the finest level of the exemplar.
    pub places: Vec<Place>,
    /// What was done, from the coarsest level to the finest.
    pub levels: Vec<RoundLevel>,
}

/// Why nothing can be synthesised.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum RoundError {
    /// No exemplar, or no surface.
    #[error("there is no surface or no exemplar to synthesise: give at least one vertex and one level")]
    Nothing,
    /// Circles that are none.
    #[error(
        "{} circles on {} levels of pixels {} wide cannot be marched: give 1 to {MOST_CIRCLES} circles, 1 to {MOST_LEVELS} levels and a width above 0",
        grid.circles, grid.levels, grid.pixel
    )]
    Grid {
        /// What was asked for.
        grid: Grid,
    },
    /// Faces far smaller than pixels.
    #[error(
        "circles of pixels {pixel:.3e} wide cross too many of the edges of this mesh ({vertices} vertices, edges of {edge:.3e}): ask for more \
         vertices, or a smaller scale, so that a vertex is about a pixel; or for fewer circles or levels"
    )]
    TooFine {
        /// Vertices of the mesh.
        vertices: usize,
        /// World length of a pixel.
        pixel: f64,
        /// World length of an edge.
        edge: f64,
    },
    /// The marching is another mesh's, or of other circles.
    #[error("these circles were marched on another mesh or for other levels: march again")]
    Mismatch,
    /// The sink asked to stop.
    #[error("stopped")]
    Cancelled,
}

/// Synthesises on a mesh with a texture frame at each vertex; `stacks` are the exemplar's levels, the finest first.
///
/// # Errors
/// If there is nothing to synthesise, the marching does not fit, or `progress` cancels.
pub fn synthesize_round(
    mesh: &Mesh,
    frames: &[Frame],
    marching: &Marching,
    stacks: &[Stack],
    options: &RoundOptions,
    progress: &dyn Progress,
) -> Result<RoundSynthesis, RoundError> {
    let grid = Grid { pixel: marching.pixel(), circles: options.circles, levels: stacks.len() }.checked()?;
    if !marching.fits(grid) || frames.len() != mesh.vertex_count() || marching.key() != mesh_key(mesh) {
        return Err(RoundError::Mismatch);
    }
    let (template, first, normals) = (Template::new(options.circles), mesh.vertex_half_edges(), mesh.vertex_normals());
    let ground = |level: usize| {
        let surface = Surface::new(mesh, frames, &first, &normals, marching, level, &template);
        let missing = surface.missing();
        (surface, missing)
    };
    levels(ground, stacks, &template, options, progress)
}

/// Synthesises an image of `size` pixels.
///
/// # Errors
/// If there is nothing to synthesise, or `progress` cancels.
pub fn synthesize_plane(
    size: [usize; 2],
    stacks: &[Stack],
    options: &RoundOptions,
    progress: &dyn Progress,
) -> Result<RoundSynthesis, RoundError> {
    let grid = Grid { pixel: 1.0, circles: options.circles, levels: stacks.len() }.checked()?;
    let (template, sizes) = (Template::new(options.circles), plane_sizes(size, grid));
    let ground = |level: usize| (Plane::new(sizes[level], &template), 0);
    levels(ground, stacks, &template, options, progress)
}

/// Level by level, from the coarsest; `ground` makes each, and tells its missing samples.
fn levels<G: Ground>(
    ground: impl Fn(usize) -> (G, u64),
    stacks: &[Stack],
    template: &Template,
    options: &RoundOptions,
    progress: &dyn Progress,
) -> Result<RoundSynthesis, RoundError> {
    let mut out = RoundSynthesis { places: Vec::new(), levels: Vec::new() };
    let mut above: Vec<[f32; 2]> = Vec::new();
    let mut count = 0;
    progress.stage("synthesising", 0);
    for (level, stack) in stacks.iter().enumerate().rev() {
        let begin = Instant::now();
        let (ground, missing_samples) = ground(level);
        if ground.len() == 0 {
            return Err(RoundError::Nothing);
        }
        let read = begin.elapsed().as_secs_f64();
        let windows = Windows::new(stack.clone(), template);
        let resampled = begin.elapsed().as_secs_f64();
        let mut statistics = RoundLevel { vertices: ground.len(), missing_samples, ..RoundLevel::default() };
        let work = Work { ground: &ground, windows: &windows, template, options };
        let shown = if out.levels.is_empty() {
            let (order, starts) = order::order(&ground, windows.per, options.seed);
            statistics.starts = starts;
            work.coarsest(&order, &mut statistics, progress, &mut count)?
        } else {
            work.finer(&above, level, &mut statistics, progress, &mut count)?
        };
        statistics.seconds = [read, resampled - read, begin.elapsed().as_secs_f64() - resampled];
        above = shown.places;
        out.levels.push(statistics);
    }
    out.places = above.into_iter().map(Place::Pixel).collect();
    Ok(out)
}
