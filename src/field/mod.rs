//! Tangent fields: which way and how large the texture lies at each face (LT 3.2).
//!
//! Texture space is measured in exemplar widths: `s` runs right, `t` up along the image, and the vector T at a face maps
//! to the unit step up. So the length of T is the world length of one exemplar width there.

use glam::Vec3;

/// A texture direction and scale per face.
#[derive(Debug, Clone, PartialEq)]
pub struct TangentField {
    /// T: texture up, in the face's plane; its length is the world length of one exemplar width.
    pub up: Vec<Vec3>,
    /// S: texture right, in the face's plane, where it is not simply T x N: a full tangential basis with shear and
    /// non-uniform stretch (LT 3.2).
    pub right: Option<Vec<Vec3>>,
}

/// What steers the texture over the surface.
#[derive(Debug, Clone, PartialEq)]
pub enum Guide {
    /// Direction and scale everywhere.
    Directed(TangentField),
    /// Scale only: the direction is arbitrary at each paste's seed and propagated during growth (LT 3.2).
    Isotropic {
        /// Per face, world length of one exemplar width.
        scale: Vec<f32>,
    },
}
