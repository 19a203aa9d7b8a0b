//! Why a graphics adapter cannot draw.

use crate::render::RenderError;

/// Why a graphics adapter cannot draw.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum GpuError {
    /// The machine has none.
    #[error(
        "there is no graphics adapter here, not even one in software: install a graphics driver, or draw with the mode reference"
    )]
    NoAdapter,
    /// None is called so.
    #[error("no graphics adapter is called {wanted:?}; there are {there}")]
    NoSuchAdapter {
        /// What was asked for.
        wanted: String,
        /// The ones there are.
        there: String,
    },
    /// The adapter gives no device.
    #[error("the graphics adapter {adapter} cannot be used: {reason}: choose another one, or draw with the mode reference")]
    Device {
        /// The adapter.
        adapter: String,
        /// What the driver says.
        reason: String,
    },
    /// More than the adapter can hold.
    #[error("{what}: {needs}, and this graphics adapter takes {has}: {remedy}")]
    Limit {
        /// What is too large.
        what: String,
        /// How large it is.
        needs: u64,
        /// What fits.
        has: u64,
        /// What to do.
        remedy: &'static str,
    },
    /// The device is gone: the driver was reset or updated, or the adapter unplugged.
    #[error("the graphics device was lost ({reason}): start again, or draw with the mode reference")]
    Lost {
        /// What the driver says.
        reason: String,
    },
    /// The driver or its validation refused a command.
    #[error("the graphics driver refused a command: {reason}: draw with the mode reference")]
    Refused {
        /// What it says.
        reason: String,
    },
    /// New positions for another mesh.
    #[error("{found} positions were given for a mesh of {expected} vertices: give one for each vertex, in their order")]
    Positions {
        /// How many were given.
        found: usize,
        /// How many there are.
        expected: usize,
    },
    /// Another mesh than the one that was loaded.
    #[error("a mesh of {found} faces cannot stand in for one of {expected}: only positions may change")]
    Faces {
        /// How many it has.
        found: usize,
        /// How many are needed.
        expected: usize,
    },
    /// Colours of faces' own, and other faces.
    #[error("{found} faces have colours of their own on a mesh of {expected}: give every face three")]
    Tints {
        /// How many have.
        found: usize,
        /// How many there are.
        expected: usize,
    },
    /// The adapter cannot show a window.
    #[error("the graphics adapter {adapter} cannot show this window: open the device on an adapter that can")]
    Surface {
        /// The adapter.
        adapter: String,
    },
    /// A window's surface is gone.
    #[error("the window's surface was lost: make a new one of the window")]
    SurfaceLost,
    /// The picture cannot be drawn by any renderer.
    #[error(transparent)]
    Picture(#[from] RenderError),
}
