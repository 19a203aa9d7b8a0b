//! Judging results.
mod measures;
