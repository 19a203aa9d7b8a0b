//! Synthesis over surfaces.
mod flat;
mod odd;
mod whole;
