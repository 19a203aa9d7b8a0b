//! Whole jobs: what a command does between reading its files and writing its results, for the command line, the viewer
//! and whoever embeds the library.
//!
//! [`paste_model`] takes a model as its file holds it and exemplars, and returns a record of the same model with its
//! pastes. [`Bound`] leads back: from a record to the mesh and the lapped texture on it, ready to be shown.

pub mod bind;
pub mod paste;

pub use bind::Bound;
pub use paste::{ExemplarInput, JobError, JobReport, PasteJob, Pasted, Scale, Steer, paste_model};
