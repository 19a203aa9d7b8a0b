//! `lapped` puts any example texture on any triangle mesh: no UVs, no cuts, no painting.

pub mod assets;
pub mod cli;
pub mod exemplar;
pub mod field;
pub mod format;
pub mod job;
pub mod mesh;
pub mod numeric;
pub mod paste;
pub mod progress;
pub mod random;
pub mod render;
pub mod surface;
