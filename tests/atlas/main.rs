//! The atlas: charts, baking, and the files that come out.

mod bake;
mod charts;
mod checker;
mod corpus;
mod displace;
mod export;
#[path = "../common/folder.rs"]
mod folder;
mod layers;
mod mips;
#[path = "../common/turned.rs"]
mod turned;
