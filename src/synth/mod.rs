//! Texture synthesis over arbitrary surfaces: every vertex of a re-tiled mesh takes the place of the exemplar whose neighbourhood
//! looks most like its own.
//!
//! Based on: Wei, Levoy, "Texture synthesis over arbitrary manifold surfaces", SIGGRAPH 2001.
//!
//! The way through: [`Levels`] are meshes with texture frames, a [`Source`] the levels of the exemplar; [`synthesize`] matches one
//! against the other, and [`VertexTexture`] is the result as a [`crate::surface::SurfaceTexture`]. [`round`] does it on the user's own
//! vertices, after Chen and Dong 2008.

pub mod batch;
pub mod convolve;
mod fan;
mod flatten;
mod levels;
mod neighbourhood;
mod passes;
pub mod round;
mod search;
mod source;
mod texture;
mod window;

pub use fan::Frame;
pub use levels::{Level, Levels, combed_right, random_right, spacing};
pub use passes::{LevelDone, Synthesis, synthesize};
pub use search::SearchKind;
pub use source::{MeshSource, Place, Source};
pub use texture::{OnMesh, VertexTexture, image_of};
pub use window::{LONGEST, Window};

use serde::Serialize;

/// How to synthesise.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct SynthOptions {
    /// The neighbourhoods, from the coarsest level to the finest; the last stands for all finer ones.
    pub windows: Vec<Window>,
    /// Passes with the level's own neighbourhood, from the coarsest level to the finest; the last stands for all finer ones.
    pub passes: Vec<usize>,
    /// How to search.
    pub search: SearchKind,
    /// Whether the vertex itself is a part of its neighbourhood. The paper does not say; without it a vertex is free to change.
    pub middle: bool,
    /// Whether the exemplar's windows are made as soft as resampled neighbourhoods are.
    pub soften: bool,
    /// Batches in which the vertices of a pass are visited.
    pub batches: usize,
    /// Seed of all that is random.
    pub seed: u64,
}

impl Default for SynthOptions {
    fn default() -> Self {
        Self {
            windows: [(3, 1), (5, 2), (7, 2), (7, 2)].map(|(side, levels)| Window::new(side, levels)).into(),
            passes: vec![4, 4, 2, 1],
            search: SearchKind::default(),
            middle: false,
            soften: true,
            batches: 16,
            seed: 1,
        }
    }
}

impl SynthOptions {
    /// What the paper does: its neighbourhoods, one pass a level, and the vertex itself in its neighbourhood.
    #[must_use]
    pub fn paper() -> Self {
        Self {
            windows: [(1, 1), (3, 2), (5, 2), (7, 2)].map(|(side, levels)| Window::new(side, levels)).into(),
            passes: vec![1],
            middle: true,
            soften: false,
            ..Self::default()
        }
    }

    /// The window of a level, counted from the coarsest.
    #[must_use]
    pub fn window(&self, from_coarsest: usize) -> Window {
        self.windows.get(from_coarsest).or(self.windows.last()).copied().unwrap_or(Window::new(7, 2))
    }

    /// The passes of a level, counted from the coarsest.
    #[must_use]
    pub fn passes(&self, from_coarsest: usize) -> usize {
        self.passes.get(from_coarsest).or(self.passes.last()).copied().unwrap_or(1)
    }

    fn check(&self) -> Result<(), SynthError> {
        match self.windows.iter().find(|w| w.side > LONGEST || w.side.is_multiple_of(2) || w.levels == 0) {
            Some(window) => Err(SynthError::Window { window: *window }),
            None => Ok(()),
        }
    }
}

/// What was done on one level.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct LevelStatistics {
    /// Vertices.
    pub vertices: usize,
    /// Places of the exemplar there were to choose from.
    pub candidates: usize,
    /// The neighbourhood, as far as there are coarser levels.
    pub window: Window,
    /// Passes with the level's own neighbourhood.
    pub passes: usize,
    /// Faces left out of flattened patches because they flipped or were stretched.
    pub flipped_faces: u64,
    /// Template samples that no face covered.
    pub uncovered_samples: u64,
    /// Share of the vertices that continue a neighbour's place after the last pass.
    pub continued: f64,
    /// Time for flattening.
    pub flatten_seconds: f64,
    /// Time for making the search ready.
    pub build_seconds: f64,
    /// Time for matching, and everything else.
    pub match_seconds: f64,
}

/// What [`synthesize`] did, from the coarsest level to the finest.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct SynthStatistics {
    /// Its levels.
    pub levels: Vec<LevelStatistics>,
}

/// Why nothing can be synthesised.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SynthError {
    /// No levels.
    #[error("there is no surface or no exemplar to synthesise: give at least one level of both")]
    Nothing,
    /// A window that is none.
    #[error("the neighbourhood {window} cannot be used: sides are odd and at most {LONGEST}, levels at least 1")]
    Window {
        /// The window.
        window: Window,
    },
    /// The sink asked to stop.
    #[error("stopped")]
    Cancelled,
}
