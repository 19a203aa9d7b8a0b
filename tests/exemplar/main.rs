//! Exemplars: patches cut from them, their hulls, what coverage asks of their masks, and how they look when turned.

mod coverage_mask;
#[path = "../common/folder.rs"]
mod folder;
mod hull;
mod patches;
mod symmetry;
