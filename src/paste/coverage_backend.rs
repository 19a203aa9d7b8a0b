//! Coverage drawn by something else than the processor's own loops, such as a graphics adapter.
//!
//! The loop of pasting asks for a batch of faces at a time: what was transparent of each sample, and the texture patches laid
//! over the face one after the other. The answer is what `Tile::cover` gives for each sample. All lengths are in units of the
//! face's longest edge, so that single precision serves at every scale.

use super::coverage::{Image, Lattice, RUN};
use crate::exemplar::{CoverageMask, ERODED_RADII};
use glam::{DVec2, Vec2};
use std::fmt;
use std::sync::Arc;

/// Something that draws coverage.
pub trait CoverageBackend: fmt::Debug + Send + Sync {
    /// Makes it ready for the masks of a job.
    ///
    /// # Errors
    /// If it cannot hold them: a sentence.
    fn prepare(&self, masks: &[CoverageMask]) -> Result<Box<dyn CoverageDrawer>, String>;
}

/// Draws coverage with the masks of one job.
pub trait CoverageDrawer: Send + Sync {
    /// Lays patches over faces; returns the transparency of each face's samples, of 255.
    ///
    /// # Errors
    /// If it fails: a sentence.
    fn cover(&self, faces: &[CoveredFace]) -> Result<Vec<Box<[u8]>>, String>;
}

/// A face to be covered.
#[derive(Debug, Clone)]
pub struct CoveredFace {
    /// Transparency of its samples so far, of 255.
    pub samples: Vec<u8>,
    /// Cells in each row of its lattice, the first over the longest edge.
    pub rows: Vec<u32>,
    /// The corner opposite the longest edge, which runs from (0, 0) to (1, 0).
    pub apex: Vec2,
    /// What is laid over it, one after the other.
    pub over: Vec<Overlay>,
}

/// A texture patch over a face: mask pixels are `origin + along x + up y`.
#[derive(Debug, Clone, Copy)]
pub struct Overlay {
    /// Which mask.
    pub mask: u32,
    /// See above.
    pub origin: Vec2,
    /// See above.
    pub along: Vec2,
    /// See above.
    pub up: Vec2,
    /// A sample counts the least alpha this near, mask pixels.
    pub radius: f32,
    /// Which of the masks' eroded alphas that is; as many as there are: none.
    pub level: u32,
}

/// Where coverage is drawn: on the processor, or by a back-end.
#[derive(Debug, Clone, Default)]
pub struct Coverage(pub Option<Arc<dyn CoverageBackend>>);

impl PartialEq for Coverage {
    fn eq(&self, other: &Self) -> bool {
        match (&self.0, &other.0) {
            (None, None) => true,
            (Some(a), Some(b)) => Arc::ptr_eq(a, b),
            _ => false,
        }
    }
}

impl CoveredFace {
    /// A face with nothing laid over it yet.
    #[must_use]
    pub fn new(lattice: &Lattice, samples: Vec<u8>) -> Self {
        Self { samples, rows: lattice.rows(), apex: lattice.apex().as_vec2(), over: Vec::new() }
    }

    /// Lays a patch over it whose mask pixels at the face's corners are these.
    pub fn lay(&mut self, lattice: &Lattice, mask: u32, pixel: [DVec2; 3]) {
        let image = Image::new(lattice, pixel);
        let radius = image.radius(lattice.half_cell());
        let level = ERODED_RADII.iter().filter(|&&r| r < radius).count() as u32;
        let [origin, along, up] = image.in_edges(lattice);
        self.over.push(Overlay { mask, origin, along, up, radius, level });
    }

    /// Runs of up to [`RUN`] cells of a row: the row, its first cell, and how many.
    pub fn runs(&self) -> impl Iterator<Item = (u32, u32, u32)> + '_ {
        let of_row = |(row, &cells): (usize, &u32)| {
            (0..cells).step_by(RUN as usize).map(move |first| (row as u32, first, RUN.min(cells - first)))
        };
        self.rows.iter().enumerate().flat_map(of_row)
    }
}
