//! Fidelity in numbers: pieces of the result against pieces of the exemplar.
//!
//! Pieces are cut from the surface at points spread by area, each in the texture's own direction and at the exemplar's own pixel
//! pitch, by walking straight from the point (`pieces`). All numbers are of colours encoded as sRGB.
//!
//! | measure | what it is | blind to |
//! |---|---|---|
//! | `swd` | sliced Wasserstein distance of 7x7 patches on three levels, 256 fixed projections, times 100 (Elnekave, Weiss, "Generating natural images with direct patch distributions matching", ECCV 2022; Heitz et al., "A sliced Wasserstein loss for neural texture synthesis", CVPR 2021) | where patches lie; blur, in part |
//! | `coherence` | from each result patch to the nearest patch of the exemplar, 11x11, root mean square over 32 principal components; its 99th hundredth is what an eye calls a seam (Simakov et al., "Summarizing visual data using bidirectional similarity", CVPR 2008) | a result that repeats one piece |
//! | `completeness` | the other way round (Simakov et al. 2008) | seams |
//! | `energy` | energy of the Laplacian over the exemplar's: 1 is right, less is blurred, more is noisy | everything else |
//! | `histogram` | how far colours must be moved to have the exemplar's distribution, steps of eight bits | where colours lie |
//! | `repetition` | the largest autocorrelation beyond 40 pixels | everything else |
//!
//! Borders have a measure of their own: [`seam_visibility`]. What colours cannot tell, the place that each pixel was copied from does:
//! [`mapping()`].
//!
//! None of them is a verdict. Each comes with its floor: the same between one half of the exemplar and the other, which a
//! perfect result cannot be expected to beat.

mod borders;
mod errors;
mod histogram;
mod mapping;
mod patches;
mod pieces;
mod reference;
mod sliced;
mod spectrum;

pub use borders::{Border, OwnSteps, SeamVisibility, chart_borders, seam_visibility, steps_across};
pub use errors::ErrorMap;
pub use histogram::{Histogram, histogram_distance};
pub use mapping::{Extreme, Extremes, Mapped, Mapping, breaks, mapping};
pub use patches::{Known, Spread, coherence};
pub use pieces::{ByArea, Pieces, Placed, around, of_image, of_surface, unrolls};
pub use reference::Reference;
pub use sliced::{Sliced, sliced_wasserstein};
pub use spectrum::{laplacian_energy, repetition};

use crate::exemplar::Exemplar;
use crate::mesh::walk::Walker;
use crate::mesh::{Mesh, SurfacePoint};
use crate::surface::SurfaceTexture;
use glam::DVec3;
use serde::Serialize;

/// The measures of one set of pieces against another.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct Measured {
    /// Sliced Wasserstein distance, times 100.
    pub swd: f64,
    /// Distances to the nearest patch of the exemplar.
    pub coherence: Spread,
    /// Distances of the exemplar's patches to the nearest of the result.
    pub completeness: Spread,
    /// Energy of the Laplacian over the exemplar's.
    pub energy: f64,
    /// The largest autocorrelation beyond 40 pixels; 0 if no piece is large enough.
    pub repetition: f64,
    /// Distance of the distributions of colours, steps of eight bits.
    pub histogram: f64,
}

/// A result against its exemplar, and the floor.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct Fidelity {
    /// The result.
    pub result: Measured,
    /// One half of the exemplar against the other.
    pub floor: Measured,
}

/// How much a texture on a surface looks like its exemplar. `right` gives the direction of texture right at a point, `pixel` is
/// the world length of a pixel of the exemplar.
#[must_use]
pub fn fidelity(
    mesh: &Mesh,
    texture: &dyn SurfaceTexture,
    right: &(dyn Fn(SurfacePoint) -> DVec3 + Sync),
    pixel: f64,
    exemplar: &Exemplar,
) -> Fidelity {
    let reference = Reference::new(exemplar);
    Fidelity { result: reference.measure(&Placed { on: &Walker::new(mesh), texture, right, pixel }, 1), floor: reference.floor }
}
