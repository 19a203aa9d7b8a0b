//! Sparse least squares: matrices, conjugate gradients and a multigrid preconditioner; and rows of numbers, their principal
//! components and the nearest among them. Knows no mesh.
//!
//! Systems are symmetric and positive (semi-)definite with two right-hand sides that are solved in one pass, since the
//! two texture coordinates of a fit share their matrix (LT 3.4).

pub mod cg;
pub mod kd;
pub mod multigrid;
pub mod pca;
pub mod rows;
pub mod sparse;

pub use cg::{CgOptions, CgStats, Jacobi, Preconditioner, Stop, solve};
pub use multigrid::Multigrid;
pub use sparse::Sparse;

/// One value per unknown for each of the two right-hand sides.
pub type Pair = [f64; 2];
