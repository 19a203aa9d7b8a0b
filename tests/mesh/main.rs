//! The mesh core on hard shapes.

mod retile;
