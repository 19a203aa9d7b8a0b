//! Pictures by the reference renderer.

mod common;
#[path = "../common/folder.rs"]
mod folder;
mod picture;
mod raster;
mod styles;
