//! The atlas: charts, baking, and the files that come out.

mod bake;
mod charts;
mod checker;
mod corpus;
mod displace;
mod export;
mod layers;
mod mips;
