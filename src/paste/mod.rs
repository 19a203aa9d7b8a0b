//! Lapped Textures: seed, grow, fit, cover, cull.
//!
//! Based on: Praun, Finkelstein, Hoppe, "Lapped Textures", SIGGRAPH 2000.

pub mod lapped;

pub use lapped::{LappedTexture, Paste};
