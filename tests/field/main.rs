//! Fields on real meshes.

mod corpus;
#[path = "../common/folder.rs"]
mod folder;
mod nway;
