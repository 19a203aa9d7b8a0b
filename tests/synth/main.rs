//! Synthesis over surfaces.
mod corpus;
mod flat;
#[path = "../common/folder.rs"]
mod folder;
mod odd;
mod round;
mod whole;
