//! Why pasting ends without a result.

/// Why pasting ended without a result.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PasteError {
    /// Nothing to paste.
    #[error("there is no texture patch to paste: give at least one exemplar")]
    NoPatches,
    /// More patches than a record can name.
    #[error("there are {0} texture patches; a record can name {max}", max = u16::MAX)]
    TooManyPatches(usize),
    /// The guide belongs to another mesh.
    #[error("the field has {found} faces, the mesh {expected}: it was made for another mesh")]
    GuideSize {
        /// Faces of the guide.
        found: usize,
        /// Faces of the mesh.
        expected: usize,
    },
    /// The field has no usable basis at a face.
    #[error("the tangent field vanishes or turns inside out at face {face}: give it a direction there")]
    NoBasis {
        /// The face.
        face: u32,
    },
    /// The job is far too large for its scale.
    #[error(
        "at a scale of {scale:.3e} (world length of one exemplar width) this surface takes about {pastes:.1e} pastes and \
         {cells:.1e} coverage samples: use a scale of at least {usable:.3e}"
    )]
    ScaleTooSmall {
        /// Mean scale.
        scale: f64,
        /// Pastes estimated.
        pastes: f64,
        /// Samples estimated.
        cells: f64,
        /// A scale that would do.
        usable: f64,
    },
    /// The scale dwarfs the mesh.
    #[error(
        "a scale of {scale:.3e} (world length of one exemplar width) is {times:.0e} times the size of the mesh, which would \
         show a single texel: use one below {usable:.3e}"
    )]
    ScaleTooLarge {
        /// Mean scale.
        scale: f64,
        /// Relative to the mesh.
        times: f64,
        /// A scale that would do.
        usable: f64,
    },
    /// The distortion bound is no bound.
    #[error("the distortion bound is {0}: give a number above zero (1 is usual)")]
    Distortion(f64),
    /// Something else was to draw coverage, and cannot.
    #[error("{0}: or let the processor draw coverage (--coverage cpu)")]
    Coverage(String),
    /// The progress sink asked to stop.
    #[error("pasting was cancelled")]
    Cancelled,
}
