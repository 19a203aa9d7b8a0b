//! Judging results: how much a texture on a surface looks like the exemplar it was made from, and what it has to stand beside.
//!
//! [`compare()`] takes a mesh and an exemplar through every [`Method`] and measures all in the same way; [`report`] writes what was
//! found, and [`many`] does that for many meshes and exemplars. [`measures`] and [`baselines`] are of use alone.

pub mod baselines;
pub mod blind;
pub mod cell;
pub mod make;
pub mod many;
pub mod measures;
pub mod method;
pub mod report;
pub mod setting;
pub mod shown;
pub mod source;

pub use cell::{CompareJob, Comparison, Figures, MethodReport, Named, compare};
pub use measures::{Fidelity, Measured, Spread, fidelity};
pub use method::Method;
pub use setting::{Setting, SettingOptions};

use crate::atlas::AtlasError;
use crate::exemplar::ExemplarError;
use crate::field::FieldError;
use crate::job::{JobError, RoundJobError, SynthJobError};
use crate::mesh::MeshError;
use crate::paste::PasteError;
use crate::render::RenderError;

/// Why there is no comparison, or not of one method.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum CompareError {
    /// The model.
    #[error(transparent)]
    Mesh(#[from] MeshError),
    /// The exemplar.
    #[error(transparent)]
    Exemplar(#[from] ExemplarError),
    /// The field.
    #[error(transparent)]
    Field(#[from] FieldError),
    /// What all methods share, or the patches.
    #[error(transparent)]
    Job(#[from] JobError),
    /// Pasting.
    #[error(transparent)]
    Paste(#[from] PasteError),
    /// Charts or baking.
    #[error(transparent)]
    Atlas(#[from] AtlasError),
    /// Synthesis after Wei and Levoy.
    #[error(transparent)]
    Synth(#[from] SynthJobError),
    /// Synthesis after Chen and Dong.
    #[error(transparent)]
    Round(#[from] RoundJobError),
    /// Pictures.
    #[error(transparent)]
    Render(#[from] RenderError),
    /// Asked to stop.
    #[error("cancelled")]
    Cancelled,
}
