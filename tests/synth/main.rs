//! Synthesis over surfaces.
mod corpus;
mod flat;
mod odd;
mod round;
mod whole;
