//! Fields on real meshes.

mod corpus;
mod nway;
