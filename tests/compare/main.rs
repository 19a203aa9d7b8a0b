//! Judging results.
mod baselines;
mod measures;
