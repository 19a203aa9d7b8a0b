//! The program as its users meet it: arguments in, files and exit codes out.

mod channels;
mod commands;
#[path = "../common/mod.rs"]
mod common;
mod errors;
mod flaws;
#[path = "../common/glb.rs"]
mod glb;
mod inspect;
mod moving;
mod program;
mod regions;
