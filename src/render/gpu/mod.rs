//! Pictures and frames drawn by a graphics adapter (LT 4, "Runtime pasting of lapped textures").
//!
//! The reference renderer's twin: the same studio, the same filtering, the same light, many times faster where there is
//! hardware. Whoever follows a picture walks one way: [`Gpu`] opens a device; a [`Renderer`] prepares it;
//! [`Renderer::load`] brings a lapped texture there as a [`Subject`]; [`Renderer::draw`] makes a picture of it. A program with
//! a device and a window of its own draws a subject into its own pass with a [`Forward`], or has frames of it drawn onto any
//! texture, several samples a pixel, by a [`Screen`]; a [`Window`] gives the textures of a surface.
//!
//! All that touches wgpu is in this folder; the shaders are in `shaders/`.

mod canvas;
mod composite;
mod context;
mod coverage;
mod error;
mod forward;
mod frame;
mod lists;
mod packing;
mod patches;
mod pipelines;
mod renderer;
mod screen;
mod shape;
mod studio;
mod subject;
mod target;
mod texture;
mod window;

pub use canvas::Canvas;
pub use composite::GpuComposite;
pub use context::{AdapterSummary, Gpu, GpuOptions, adapters, has_hardware};
pub use coverage::GpuCoverage;
pub use error::GpuError;
pub use forward::{Forward, Seen};
pub use patches::PatchTextures;
pub use pipelines::shaders;
pub use renderer::{Filter, Path, Renderer, RendererOptions};
pub use screen::Screen;
pub use subject::Subject;
pub use target::read_pixels;
pub use wgpu;
pub use window::{Step, SurfaceStatus, Window};
