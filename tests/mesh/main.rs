//! The mesh core on hard shapes.

#[path = "../common/folder.rs"]
mod folder;
mod retile;
