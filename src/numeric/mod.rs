//! Sparse least squares: matrices, conjugate gradients and their preconditioners. Knows no mesh.
