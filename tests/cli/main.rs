//! The program as its users meet it: arguments in, files and exit codes out.

mod channels;
mod commands;
#[path = "../common/mod.rs"]
mod common;
mod compare;
mod errors;
mod flaws;
#[path = "../common/folder.rs"]
mod folder;
#[path = "../common/glb.rs"]
mod glb;
mod inspect;
mod moving;
mod program;
mod regions;
