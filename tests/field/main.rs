//! Fields on real meshes.

mod corpus;
