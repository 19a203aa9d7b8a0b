//! Files in and out: every format, every flaw.

mod broken;
#[path = "../common/mod.rs"]
mod common;
mod corpus;
mod docs;
mod exemplars;
#[path = "../common/folder.rs"]
mod folder;
mod frames;
#[path = "../common/glb.rs"]
mod glb;
mod gltf;
mod motion;
mod obj;
mod ply_stl;
mod properties;
mod record;
mod relief;
