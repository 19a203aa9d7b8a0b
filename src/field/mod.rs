//! Tangent fields: which way and how large the texture lies at each face (LT 3.2).
//!
//! Texture space is measured in exemplar widths: `s` runs right, `t` up along the image, and the vector T at a face maps
//! to the unit step up. So the length of T is the world length of one exemplar width there.
//!
//! * [`up()`] projects one axis onto every face.
//! * [`Constraints`] are what a user asks for at a few places; tied to a mesh they are [`Anchor`]s.
//! * [`constrained()`] spreads anchors over the surface.
//! * [`isotropic()`] and [`constrained_scale()`] give a scale alone, for exemplars that look the same every way.
//! * [`nway`] makes fields of n directions a place, as smooth as can be, along curvature or creases if asked to.
//! * [`stroke()`] makes constraints of combing over the surface; a [`Mirror`] repeats them on the other side of a plane.
//! * [`streamlines()`] shows how a field runs.
//! * [`singularities()`] are the vertices around which a field turns; [`refine_near_singularities()`] makes faces there finer.

pub mod constrained;
pub mod constraints;
pub mod error;
pub mod fill;
pub mod mirror;
pub mod nway;
pub mod refine;
pub mod singularities;
pub mod spread;
pub mod steady;
pub mod store;
pub mod streamlines;
pub mod stroke;
pub mod up;

pub use constrained::{ConstrainedStatistics, FieldOptions, constrained, constrained_on, constrained_scale, isotropic};
pub use constraints::{Anchor, Constraint, Constraints};
pub use error::{ConstraintProblem, FieldError};
pub use mirror::Mirror;
pub use nway::NWaySingularity;
pub use nway::{NWayField, NWayOptions, NWaySolver, NWayStatistics, comb};
pub use refine::{RefineOptions, RefineStatistics, Refined, refine_near_singularities};
pub use singularities::{Singularity, discontinuity, singularities, turning_points};
pub use spread::Carry;
pub use streamlines::{Streamline, StreamlineOptions, streamlines};
pub use stroke::{Comb, Dab, Wish, overrule, stroke};
pub use up::{UpStatistics, up, up_on};

use crate::mesh::Mesh;
use crate::mesh::subdivide::Subdivision;
use glam::{DVec3, Vec3};

/// A texture direction and scale per face.
#[derive(Debug, Clone, PartialEq)]
pub struct TangentField {
    /// T: texture up, in the face's plane; its length is the world length of one exemplar width.
    pub up: Vec<Vec3>,
    /// S: texture right, in the face's plane, where it is not simply T x N: a full tangential basis with shear and
    /// non-uniform stretch (LT 3.2).
    pub right: Option<Vec<Vec3>>,
    /// The texture looks the same turned by a full turn over this: within each patch every face takes that of so many directions
    /// which continues its neighbours'. 1 for a field that means just what it says.
    pub ways: u32,
}

impl TangentField {
    /// A field that means just what it says, with right as T x N.
    #[must_use]
    pub const fn along(up: Vec<Vec3>) -> Self {
        Self { up, right: None, ways: 1 }
    }

    /// The tangential basis (S, T) of a face.
    #[inline]
    #[must_use]
    pub fn basis(&self, mesh: &Mesh, face: u32) -> (DVec3, DVec3) {
        let t = self.up[face as usize].as_dvec3();
        let s = match &self.right {
            Some(right) => right[face as usize].as_dvec3(),
            None => t.cross(mesh.normal(face)),
        };
        (s, t)
    }

    /// The same field on a subdivision of its mesh.
    #[must_use]
    pub fn on(&self, fine: &Subdivision) -> Self {
        let spread = |vectors: &Vec<Vec3>| fine.parent.iter().map(|&f| vectors[f as usize]).collect();
        Self { up: spread(&self.up), right: self.right.as_ref().map(spread), ways: self.ways }
    }
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

impl Guide {
    /// World length of one exemplar width at a face.
    #[inline]
    #[must_use]
    pub fn scale(&self, face: u32) -> f32 {
        match self {
            // In f64: the square of a length that f32 holds may be more, or less, than f32 holds.
            Self::Directed(field) => field.up[face as usize].as_dvec3().length() as f32,
            Self::Isotropic { scale } => scale[face as usize],
        }
    }

    /// The tangent field, if there is one.
    #[must_use]
    pub const fn field(&self) -> Option<&TangentField> {
        match self {
            Self::Directed(field) => Some(field),
            Self::Isotropic { .. } => None,
        }
    }
}

/// Exemplar areas on the surface at the default scale.
pub const DEFAULT_RATIO: f64 = 40.0;

/// The scale (world length of one exemplar width) at which the surface has `ratio` times the exemplar's area; `aspect` is
/// the exemplar's width divided by its height.
#[must_use]
pub fn default_scale(mesh: &Mesh, ratio: f64, aspect: f64) -> f64 {
    (mesh.total_area() * aspect / ratio).sqrt()
}

/// The scale as it is stored, if it is a length at all.
pub(crate) fn usable_scale(scale: f64) -> Result<f32, FieldError> {
    let stored = scale as f32;
    if stored.is_normal() && stored > 0.0 { Ok(stored) } else { Err(FieldError::Scale(scale)) }
}
