//! What a job is told.

use super::base::Base;
use crate::exemplar::symmetry::{Symmetry, exemplar_symmetry};
use crate::exemplar::{Exemplar, PatchOptions, PatchSpec};
use crate::field::{self, Constraints};
use crate::mesh::CleanOptions;
use crate::paste::PasteOptions;
use glam::DVec3;

/// How large the texture is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Scale {
    /// World length of one exemplar width.
    World(f64),
    /// So that the surface has this many times the first exemplar's area.
    Ratio(f64),
}

impl Default for Scale {
    fn default() -> Self {
        Self::Ratio(field::DEFAULT_RATIO)
    }
}

/// What steers the texture.
#[derive(Debug, Clone, PartialEq)]
pub enum Steer {
    /// An axis projected onto the surface.
    Up(DVec3),
    /// Constraints, with the axis they are measured against.
    Constraints(Constraints, DVec3),
    /// The smoothest field of so many ways, one of them at each face.
    Relaxed(u32),
    /// Along the direction in which the surface bends least.
    Curvature,
    /// No direction; constraints give the scale.
    Isotropic(Option<Constraints>),
    /// A field made for this model's mesh, as text.
    Field(String),
}

impl Default for Steer {
    fn default() -> Self {
        Self::Up(DVec3::Y)
    }
}

impl Steer {
    /// What an exemplar's own symmetry asks for, and the symmetry; the smoothest field where that cannot be told.
    #[must_use]
    pub fn by_exemplar(exemplar: &Exemplar) -> (Self, Option<Symmetry>) {
        let found = exemplar_symmetry(exemplar);
        (Self::by_symmetry(found.as_ref()), found)
    }

    /// What a symmetry asks for.
    #[must_use]
    pub fn by_symmetry(found: Option<&Symmetry>) -> Self {
        match found {
            None => Self::Relaxed(1),
            Some(found) if found.isotropic => Self::Isotropic(None),
            Some(found) => Self::Relaxed(found.n),
        }
    }
}

/// An exemplar and what to cut from it.
#[derive(Debug, Clone, PartialEq)]
pub struct ExemplarInput {
    /// The exemplar as read.
    pub exemplar: Exemplar,
    /// How often it is pasted, relative to the others.
    pub weight: f32,
    /// Shapes of its texture patches. Empty: its own transparency if it has any, else splotches.
    pub patches: Vec<PatchSpec>,
}

/// A job.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct PasteJob {
    /// How to clean the model.
    pub clean: CleanOptions,
    /// How large the texture is.
    pub scale: Scale,
    /// What steers it.
    pub steer: Steer,
    /// Leave large faces as they are.
    pub keep_faces: bool,
    /// Pixels over which alpha falls off at a patch's edge; `None` goes by each exemplar's size ([`default_feather`](super::patches::default_feather)).
    pub feather: Option<f32>,
    /// How else texture patches are cut; its feather is not used.
    pub patches: PatchOptions,
    /// Paste the detail of exemplars alone, over this; by [`paste_model`](super::paste_model) and
    /// [`paste_regions`](super::paste_regions). `None` pastes them as they are.
    pub base: Option<Base>,
    /// How to paste.
    pub paste: PasteOptions,
    /// Memory the job may take, bytes; one that is estimated to take more is refused. `None` sets no bound.
    pub memory: Option<f64>,
}
