//! What people do today, as surface textures: beside these a pasted or a synthesized texture has to stand.
//!
//! | baseline | what it is | known to fail |
//! |---|---|---|
//! | [`Triplanar`], plain | the exemplar projected along the three axes and blended by the normal | ghosts on slopes, no direction, repetition |
//! | [`Triplanar`], hexagons | the same, each plane tiled by hexagons of random places of the exemplar ([`hex`]) | ghosts on slopes, no direction, broken structure |
//! | [`Tiling`] | the exemplar repeated over automatic charts, flat on each | seams at every chart border, no direction, repetition |
//!
//! All show the exemplar at the same scale as the methods they are compared with, filtered by the same rule.

pub mod hex;
mod tile;
mod tiling;
mod triplanar;

pub use hex::HexOptions;
pub use tile::Tile;
pub use tiling::Tiling;
pub use triplanar::{Sheet, Triplanar, TriplanarOptions};
