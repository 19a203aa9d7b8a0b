//! The window in which a texture is seen, steered and changed live.
//!
//! Thin: it holds state and widgets; every deed is a call of the library.
//!
//! * [`App`] is all of it but the window: a [`Document`] that is edited, what is [`build`]t of it by a [`worker`] and shown in
//!   a [`viewport`], and panels around that. It is driven by a user interface alone, so that tests drive it without a window.
//! * [`window`] gives it a window of the system.
//!
//! A change goes one way: a panel edits the document; the document's revision is newer than what is shown; a job builds
//! that revision; its result is swapped in. Nothing that takes longer than a frame is done by the thread that draws.

pub mod action;
pub mod app;
pub mod build;
pub mod cut;
pub mod deeds;
pub mod document;
pub mod gallery;
pub mod graphics;
pub mod home;
mod labels;
pub mod library;
pub mod lines;
pub mod mode;
pub mod orbit;
mod panels;
mod rooms;
pub mod side;
pub mod steer;
pub mod synth;
pub mod theme;
pub mod trace;
pub mod viewport;
pub mod watch;
pub mod window;
mod work;
pub mod worker;

pub use action::Action;
pub use app::App;
pub use document::Document;
pub use graphics::Graphics;
pub use mode::Mode;

use crate::render::gpu::GpuError;
use std::path::PathBuf;

/// How to open the window.
#[derive(Debug, Clone, Default)]
pub struct ViewOptions {
    /// What to open: a mesh, a record, exemplars, a project.
    pub files: Vec<PathBuf>,
    /// The graphics adapter, as [`crate::render::gpu::GpuOptions::adapter`] has it.
    pub adapter: Option<String>,
    /// Size of the window, points; a usual one if absent.
    pub size: Option<[f32; 2]>,
    /// Where to write times of edits and frames when the window is closed.
    pub trace: Option<PathBuf>,
    /// Where settings and unsaved work are kept; the system's own place if absent.
    pub home: Option<PathBuf>,
    /// Ask for files by their names in the window, not in the system's dialogs.
    pub own_dialogs: bool,
}

/// Why there is no window.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ViewerError {
    /// There is no screen.
    #[error("there is no display to open a window on ({0}): run it in a desktop session, or draw pictures with `lapped render`")]
    Display(String),
    /// The system gives no window.
    #[error("the window cannot be opened: {0}: draw pictures with `lapped render` instead")]
    Window(String),
    /// The graphics adapter.
    #[error(transparent)]
    Gpu(#[from] GpuError),
}

/// Opens the window and stays until it is closed.
///
/// # Errors
/// If there is no display, no graphics adapter that can show a window, or the adapter fails for good.
pub fn run(options: ViewOptions) -> Result<(), ViewerError> {
    window::run(options)
}
