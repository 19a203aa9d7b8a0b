//! From a surface texture to a picture.
//!
//! The reference renderer runs on the CPU alone and needs no graphics driver. Whoever follows a picture walks one way:
//! [`View`] frames the mesh and gives a [`Camera`]; [`Visibility`] says which face lies under each sample;
//! [`draw`] shades what is seen there; a [`sheet()`] sets several views side by side, and a [`preview()`] does so in a
//! [`PreviewStyle`] that shows the method at work.

pub mod animation;
pub mod camera;
mod clip;
#[cfg(feature = "gpu")]
pub mod gpu;
pub mod ground;
mod lens;
pub mod normals;
pub mod occlusion;
pub mod picture;
pub mod raster;
pub mod reference;
pub mod shade;
pub mod sheet;
pub mod stroke;
pub mod style;
pub mod text;

pub use camera::{Camera, Projection, UpAxis, View};
pub use lens::{Grid, Hit};
pub use picture::Picture;
pub use raster::Visibility;
pub use reference::{Background, DrawOptions, Stage, draw};
pub use shade::Lighting;
pub use sheet::{SEPARATOR, SheetOptions, lay_out, sheet};
pub use style::{ChartColors, PreviewStyle, Subject, preview};

/// Why a picture cannot be made.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum RenderError {
    /// No pixels, or too many.
    #[error(
        "a picture of {width}x{height} pixels with {samples}x{samples} samples each cannot be drawn: use sides of 1 to {max_side} \
         samples and at most {max_samples} samples in all"
    )]
    Size {
        /// Pixels across.
        width: u32,
        /// Pixels down.
        height: u32,
        /// Samples along each side of a pixel.
        samples: u32,
        /// The most samples along one side of the picture.
        max_side: u32,
        /// The most samples in the whole picture.
        max_samples: u64,
    },
    /// A camera string that cannot be read.
    #[error("the camera {text:?}: {reason}; write for example `three-quarter,zoom=1.2` or `yaw=30,pitch=20`")]
    Camera {
        /// What was given.
        text: String,
        /// What is wrong with it.
        reason: String,
    },
    /// A style that does not exist.
    #[error("{text:?} is no preview style: there are texture, pastes, field, coverage, stretch and wireframe")]
    Style {
        /// What was given.
        text: String,
    },
    /// A style whose data is not there.
    #[error("the preview style {style} shows {what}, and there is none here: choose another style")]
    Missing {
        /// The style.
        style: &'static str,
        /// What it needs.
        what: &'static str,
    },
    /// The picture could not be encoded as a PNG file.
    #[error("the picture could not be encoded as PNG: {reason}")]
    Encode {
        /// What the encoder says.
        reason: String,
    },
}
