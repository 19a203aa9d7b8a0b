//! Judging results.
mod baselines;
mod cell;
mod mapping;
mod measures;
