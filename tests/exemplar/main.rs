//! Exemplars: patches cut from them, those they choose themselves, their hulls, what coverage asks of their masks, and how they look when
//! turned.

mod auto;
mod coverage_mask;
#[path = "../common/folder.rs"]
mod folder;
mod hull;
mod patches;
mod symmetry;
