//! Pictures by the reference renderer.

mod common;
mod picture;
mod raster;
mod styles;
