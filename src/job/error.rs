//! Why a job ends without a result.

use super::estimate::in_words;
use crate::exemplar::ExemplarError;
use crate::field::FieldError;
use crate::mesh::MeshError;
use crate::paste::PasteError;

/// Why a job ended without a result.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum JobError {
    /// The model.
    #[error(transparent)]
    Mesh(#[from] MeshError),
    /// An exemplar.
    #[error("{source}")]
    Exemplar {
        /// Its place among the exemplars given.
        index: usize,
        /// What is wrong.
        source: ExemplarError,
    },
    /// A scale that no number of the mesh's precision can hold.
    #[error("a scale of {0:e} (world length of one exemplar width) cannot be used: give a finite length above zero, like 0.5")]
    Scale(f64),
    /// A feather wider than the exemplar.
    #[error("a feather of {feather:e} pixels leaves nothing of an exemplar of {} x {}: give at most {most:.0}", size[0], size[1])]
    Feather {
        /// Pixels asked for.
        feather: f32,
        /// The exemplar's size.
        size: [u32; 2],
        /// Pixels that would do.
        most: f32,
    },
    /// A base that the model does not have.
    #[error("the mesh has no vertex colours for detail to lie over: export it with them, or give --base own or a colour")]
    NoBase,
    /// The field.
    #[error(transparent)]
    Field(#[from] FieldError),
    /// Pasting.
    #[error(transparent)]
    Paste(#[from] PasteError),
    /// Where a region lies.
    #[error(transparent)]
    Area(#[from] super::area::AreaError),
    /// One of several regions.
    #[error("region {} ({name:?}): {source}", index + 1)]
    Region {
        /// Its place, from 0.
        index: usize,
        /// Its name.
        name: String,
        /// What is wrong.
        source: Box<JobError>,
    },
    /// More than the machine has.
    #[error(
        "this job takes about {} of memory ({faces} faces, {pastes:.0} pastes), but {} may be used: use a larger scale or a smaller \
         exemplar, split the mesh, or allow more with --memory", in_words(*needed), in_words(*limit)
    )]
    Memory {
        /// Estimated bytes.
        needed: f64,
        /// Bytes allowed.
        limit: f64,
        /// Faces of the mesh.
        faces: usize,
        /// Estimated pastes.
        pastes: f64,
    },
}
