//! Whole jobs: what a command does between reading its files and writing its results, for the command line, the viewer
//! and whoever embeds the library.
//!
//! [`paste_model`] takes a model as its file holds it and exemplars, and returns a record of the same model with its
//! pastes; [`paste_regions`] does so with several textures, each on its part of the surface. [`Bound`] leads back: from a record
//! to the mesh and the lapped texture on it, ready to be shown; [`Moving`] plays its animations.

pub mod area;
pub mod auto;
pub mod bake;
mod base;
pub mod beside;
pub mod bind;
pub mod directions;
pub mod displace;
mod error;
pub mod estimate;
pub mod guide;
mod input;
pub mod moving;
pub mod painted;
pub mod paste;
pub mod patches;
pub mod project;
pub mod regions;
mod report;
pub mod round;
pub mod synth;

pub use area::{Area, AreaError, Where};
pub use bake::{BakeJob, BakeReport, BakedModel, Coordinates, bake_model, bake_record, bake_record_sized};
pub use base::{Base, split};
pub use beside::{Beside, Synthesis};
pub use bind::Bound;
pub use directions::Direction;
pub use displace::{Displace, displace_mesh};
pub use error::JobError;
pub use estimate::{Estimate, Work, available_memory};
pub use guide::{Guided, guided};
pub use input::{ExemplarInput, PasteJob, Scale, Steer};
pub use moving::Moving;
pub use painted::Painted;
pub use paste::{Draft, Drafts, Laid, Pasted, lay, lay_with_draft, paste_model};
pub use patches::cut_patches;
pub use project::{Link, Project, ProjectError, ProjectExemplar};
pub use regions::{Region, paste_regions};
pub use report::{JobReport, RegionReport};
pub use round::{
    Marched, Refined, RoundJob, RoundJobError, RoundReport, Rounded, march, synthesize_marched, synthesize_plane_image,
};
pub use synth::{Density, ScaleError, SynthJob, SynthJobError, SynthReport, Synthesized, synthesize_on, transfer};
