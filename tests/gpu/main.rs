//! The GPU renderer on real adapters, Vulkan and OpenGL; software ones will do: on Debian
//! `apt-get install mesa-vulkan-drivers libegl1 libgl1-mesa-dri`, then `cargo test --test gpu -- --include-ignored`.
#![cfg(feature = "gpu")]

mod agree;
mod bake;
mod common;
mod coverage;
#[path = "../common/folder.rs"]
mod folder;
#[path = "../common/glb.rs"]
mod glb;
mod limits;
mod memory;
mod pairs;
mod screen;
