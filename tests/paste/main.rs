//! Pasting as a whole: what a job promises, on meshes and exemplars as they are.

mod base;
#[path = "../common/mod.rs"]
mod common;
mod contrast;
mod corpus;
mod coverage;
mod cuts;
mod disc;
mod draft;
mod flat;
#[path = "../common/folder.rs"]
mod folder;
mod frames;
mod hard;
mod overlays;
mod prune;
mod repeat;
mod small;
#[path = "../common/turned.rs"]
mod turned;
mod turns;
mod ways;
mod windows;
