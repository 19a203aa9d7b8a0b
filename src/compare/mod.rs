//! Judging results: how much a texture on a surface looks like the exemplar it was made from, and what it has to stand beside.

pub mod baselines;
pub mod measures;

pub use measures::{Fidelity, Measured, Spread, fidelity};
