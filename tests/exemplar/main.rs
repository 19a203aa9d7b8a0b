//! Exemplars: patches cut from them, their hulls, and what coverage asks of their masks.

mod coverage_mask;
mod hull;
mod patches;
