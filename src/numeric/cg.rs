//! Preconditioned conjugate gradients for two right-hand sides at once.
//!
//! The matrix may be singular along the constants (a fit is free up to a translation): the right-hand side must then sum
//! to zero, and the answer is one of the solutions.

use super::{Pair, Sparse};

/// Approximates the inverse of a symmetric matrix by a symmetric positive operator.
pub trait Preconditioner {
    /// Writes the approximate solution for `residual` to `out`.
    fn apply(&mut self, residual: &[Pair], out: &mut [Pair]);
}

/// Division by the diagonal.
#[derive(Debug, Clone)]
pub struct Jacobi(Vec<f64>);

impl Jacobi {
    /// From the matrix's diagonal; rows without one are left as they are.
    #[must_use]
    pub fn new(matrix: &Sparse) -> Self {
        Self::of(matrix.diagonal())
    }

    /// From a diagonal.
    #[must_use]
    pub fn of(mut diagonal: Vec<f64>) -> Self {
        diagonal.iter_mut().for_each(|d| *d = if *d > 0.0 { 1.0 / *d } else { 1.0 });
        Self(diagonal)
    }
}

impl Preconditioner for Jacobi {
    fn apply(&mut self, residual: &[Pair], out: &mut [Pair]) {
        for ((out, r), d) in out.iter_mut().zip(residual).zip(&self.0) {
            *out = [r[0] * d, r[1] * d];
        }
    }
}

/// When an answer is good enough.
#[derive(Debug, Clone, Copy)]
pub enum Stop {
    /// Once the residual is this small against the right-hand side.
    Residual(f64),
    /// Once hardly anything is left to gain in `x A x - 2 b x + constant`, the functional that the solution minimises.
    /// What is left is estimated by `r M r`, with `M` the preconditioner: exact for a perfect one, too small by the least
    /// eigenvalue of `M A` for another.
    Gain {
        /// The functional at the start.
        start: f64,
        /// Stop when less than this share of its present value is left to gain, ...
        share: f64,
        /// ... or less than this.
        floor: f64,
    },
}

/// When to stop, and what the matrix is.
#[derive(Debug, Clone, Copy)]
pub struct CgOptions {
    /// When an answer is good enough.
    pub stop: Stop,
    /// Iterations at most.
    pub max_iterations: usize,
    /// True if the matrix couples the two right-hand sides, which are then one system of twice the size.
    pub coupled: bool,
}

/// How it went.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct CgStats {
    /// Iterations done.
    pub iterations: usize,
    /// Residual relative to the right-hand side at the end, the larger of the two.
    pub residual: f64,
}

/// Inner products of the two systems, or of the one they form.
fn dot(a: &[Pair], b: &[Pair], coupled: bool) -> Pair {
    let mut sum = [0.0; 2];
    for (a, b) in a.iter().zip(b) {
        sum[0] += a[0] * b[0];
        sum[1] += a[1] * b[1];
    }
    if coupled { [sum[0] + sum[1]; 2] } else { sum }
}

/// Solves `matrix x = rhs` from the `x` given, for both right-hand sides in one pass. `matrix` writes the product of the
/// (symmetric, positive semi-definite) matrix with a vector.
pub fn solve(
    matrix: impl Fn(&[Pair], &mut [Pair]),
    rhs: &[Pair],
    x: &mut [Pair],
    preconditioner: &mut impl Preconditioner,
    options: CgOptions,
) -> CgStats {
    let (n, coupled) = (rhs.len(), options.coupled);
    let mut product = vec![[0.0; 2]; n];
    matrix(x, &mut product);
    let mut r: Vec<Pair> = rhs.iter().zip(&product).map(|(b, p)| [b[0] - p[0], b[1] - p[1]]).collect();
    let mut z = vec![[0.0; 2]; n];
    preconditioner.apply(&r, &mut z);
    let mut direction = z.clone();
    let mut rz = dot(&r, &z, coupled);
    let size = dot(rhs, rhs, false);
    // One scale for both: a coordinate whose own right-hand side is nearly zero need not be exact to its last bit.
    let size = (size[0] + size[1]).sqrt();
    let relative = |r: &[Pair]| {
        let rr = dot(r, r, false);
        if size > 0.0 { (rr[0] + rr[1]).sqrt() / size } else { 0.0 }
    };
    let mut value = if let Stop::Gain { start, .. } = options.stop { start } else { 0.0 };
    let mut stats = CgStats::default();
    loop {
        let left = if coupled { rz[0] } else { rz[0] + rz[1] };
        let done = match options.stop {
            Stop::Residual(tolerance) => relative(&r) <= tolerance,
            Stop::Gain { share, floor, .. } => left <= (share * value).max(floor),
        };
        if done || stats.iterations >= options.max_iterations {
            break;
        }
        matrix(&direction, &mut product);
        let curvature = dot(&direction, &product, coupled);
        let step = [0, 1].map(|i| if curvature[i] > 0.0 { rz[i] / curvature[i] } else { 0.0 });
        if step == [0.0; 2] {
            break;
        }
        value -= if coupled { step[0] * rz[0] } else { step[0] * rz[0] + step[1] * rz[1] };
        for i in 0..n {
            for k in 0..2 {
                x[i][k] += step[k] * direction[i][k];
                r[i][k] -= step[k] * product[i][k];
            }
        }
        preconditioner.apply(&r, &mut z);
        let new = dot(&r, &z, coupled);
        let beta = [0, 1].map(|i| if rz[i] > 0.0 { new[i] / rz[i] } else { 0.0 });
        for (d, z) in direction.iter_mut().zip(&z) {
            *d = [z[0] + beta[0] * d[0], z[1] + beta[1] * d[1]];
        }
        rz = new;
        stats.iterations += 1;
    }
    stats.residual = relative(&r);
    stats
}
