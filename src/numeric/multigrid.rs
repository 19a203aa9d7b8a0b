//! A multigrid preconditioner, so that conjugate gradients take the same dozen iterations whatever the size.
//!
//! Based on: Vanek, Mandel, Brezina, "Algebraic multigrid by smoothed aggregation for second and fourth order elliptic
//! problems", Computing 56, 1996.
//!
//! 1. Group unknowns with their strongly coupled neighbours into aggregates.
//! 2. The prolongation is constant on each aggregate, smoothed by one damped Jacobi step.
//! 3. The coarse matrix is the Galerkin product; repeat until it is small, and factor that one densely.
//! 4. A V-cycle: one Gauss-Seidel sweep forward on the way down, one backward on the way up, so that the cycle is
//!    symmetric and may precondition conjugate gradients.
//!
//! Without it the iterations of a fit grow as the square root of the faces in a patch, and pasting as the 1.5th power.

use super::{Pair, Preconditioner, Sparse};

/// Unknowns i and j couple strongly if `|a_ij| > STRENGTH sqrt(a_ii a_jj)`. Larger values keep aggregates from
/// crossing weak couplings (needle triangles) but make them smaller; 0.05 to 0.1 differ little on real meshes.
const STRENGTH: f64 = 0.06;

/// Damping of the step that smooths the prolongation: 2/3 is right for a spectral radius of D^-1 A up to 2.
const SMOOTHING: f64 = 2.0 / 3.0;

/// A level of at most this many unknowns is factored densely: 64^3 / 6 operations are less than one more level costs.
const DENSE: usize = 64;

/// Levels at most; each shrinks the one before at least to [`SHRINK`] of its size.
const MAX_LEVELS: usize = 12;

/// A level that shrinks less than this (nothing couples strongly any more) is not worth having.
const SHRINK: f64 = 0.8;

/// Added to the dense factor's diagonal, relative to its largest entry: the coarsest matrix is singular along the
/// constants, and any large enough pivot there does, since residuals have no constant part.
const RIDGE: f64 = 1e-10;

#[derive(Debug, Clone)]
struct Level {
    /// Rows in the order that [`Sparse::split_rows`] brings them into.
    matrix: Sparse,
    middle: Vec<u32>,
    diagonal: Vec<f64>,
    /// From this level's unknowns (rows) to the next coarser one's (columns).
    prolong: Sparse,
    coarse_residual: Vec<Pair>,
    coarse: Vec<Pair>,
}

/// The hierarchy for one matrix.
#[derive(Debug, Clone)]
pub struct Multigrid {
    levels: Vec<Level>,
    coarsest: Coarsest,
}

#[derive(Debug, Clone)]
enum Coarsest {
    Dense(Cholesky),
    /// Too large to factor and nothing couples strongly: a symmetric Gauss-Seidel sweep.
    Sweep {
        matrix: Sparse,
        diagonal: Vec<f64>,
    },
}

impl Multigrid {
    /// Builds the hierarchy.
    #[must_use]
    pub fn new(matrix: &Sparse) -> Self {
        let mut levels = Vec::new();
        let mut matrix = matrix.clone();
        while matrix.rows() > DENSE && levels.len() < MAX_LEVELS {
            let diagonal = positive_diagonal(&matrix);
            let (aggregate, count) = aggregates(&matrix, &diagonal);
            if count as f64 > SHRINK * matrix.rows() as f64 {
                break;
            }
            let prolong = smoothed_prolongation(&matrix, &diagonal, &aggregate, count);
            let coarse = prolong.transposed().product(&matrix.product(&prolong));
            let middle = matrix.split_rows();
            levels.push(Level {
                matrix,
                middle,
                diagonal,
                prolong,
                coarse_residual: vec![[0.0; 2]; count],
                coarse: vec![[0.0; 2]; count],
            });
            matrix = coarse;
        }
        let coarsest = if matrix.rows() <= DENSE {
            Coarsest::Dense(Cholesky::new(&matrix))
        } else {
            Coarsest::Sweep { diagonal: positive_diagonal(&matrix), matrix }
        };
        Self { levels, coarsest }
    }
}

impl Preconditioner for Multigrid {
    fn apply(&mut self, residual: &[Pair], out: &mut [Pair]) {
        cycle(&mut self.levels, &self.coarsest, residual, out);
    }
}

fn cycle(levels: &mut [Level], coarsest: &Coarsest, rhs: &[Pair], x: &mut [Pair]) {
    let Some((level, coarser)) = levels.split_first_mut() else {
        match coarsest {
            Coarsest::Dense(factor) => factor.solve(rhs, x),
            Coarsest::Sweep { matrix, diagonal } => {
                x.fill([0.0; 2]);
                (0..matrix.rows()).for_each(|i| relax(matrix, diagonal, rhs, x, i));
                (0..matrix.rows()).rev().for_each(|i| relax(matrix, diagonal, rhs, x, i));
            }
        }
        return;
    };
    let Level { matrix, middle, diagonal, prolong, coarse_residual, coarse } = level;
    let n = matrix.rows();
    // Forward from zero: what stands past the diagonal does not count yet, ...
    x.fill([0.0; 2]);
    for i in 0..n {
        let sum = matrix.row_times_up_to(i, middle[i], x);
        x[i] = [(rhs[i][0] - sum[0]) / diagonal[i], (rhs[i][1] - sum[1]) / diagonal[i]];
    }
    // ... and is all that is left of the residual.
    coarse_residual.fill([0.0; 2]);
    for i in 0..n {
        let r = matrix.row_times_past(i, middle[i], x);
        for (c, w) in prolong.row(i) {
            coarse_residual[c][0] -= w * r[0];
            coarse_residual[c][1] -= w * r[1];
        }
    }
    cycle(coarser, coarsest, coarse_residual, coarse);
    for (i, x) in x.iter_mut().enumerate() {
        let step = prolong.row_times(i, coarse);
        x[0] += step[0];
        x[1] += step[1];
    }
    (0..n).rev().for_each(|i| relax(matrix, diagonal, rhs, x, i));
}

/// One Gauss-Seidel step.
#[inline]
fn relax(matrix: &Sparse, diagonal: &[f64], rhs: &[Pair], x: &mut [Pair], i: usize) {
    let sum = matrix.row_times(i, x);
    for k in 0..2 {
        x[i][k] += (rhs[i][k] - sum[k]) / diagonal[i];
    }
}

fn positive_diagonal(matrix: &Sparse) -> Vec<f64> {
    matrix.diagonal().into_iter().map(|d| if d > 0.0 { d } else { 1.0 }).collect()
}

/// True if unknowns i and j pull each other together. Entries of the other sign (obtuse angles) push them apart, and say
/// nothing of which unknowns move alike.
#[inline]
fn is_strong(diagonal: &[f64], i: usize, j: usize, v: f64) -> bool {
    j != i && v < 0.0 && v * v > STRENGTH * STRENGTH * diagonal[i] * diagonal[j]
}

/// Aggregate of each unknown, and how many there are.
fn aggregates(matrix: &Sparse, diagonal: &[f64]) -> (Vec<u32>, usize) {
    const FREE: u32 = u32::MAX;
    let n = matrix.rows();
    let strong = |i: usize| matrix.row(i).filter(move |&(j, v)| is_strong(diagonal, i, j, v)).map(|(j, _)| j);
    let mut of = vec![FREE; n];
    let mut count = 0_u32;
    // Whole neighbourhoods first.
    for i in 0..n {
        if of[i] == FREE && strong(i).all(|j| of[j] == FREE) && strong(i).next().is_some() {
            of[i] = count;
            strong(i).for_each(|j| of[j] = count);
            count += 1;
        }
    }
    // What is left joins a neighbour's aggregate of the first pass, ...
    let first_pass = of.clone();
    for i in 0..n {
        if of[i] == FREE
            && let Some(j) = strong(i).find(|&j| first_pass[j] != FREE)
        {
            of[i] = first_pass[j];
        }
    }
    // ... or stands with what is left around it.
    for i in 0..n {
        if of[i] == FREE {
            of[i] = count;
            for j in strong(i) {
                if of[j] == FREE {
                    of[j] = count;
                }
            }
            count += 1;
        }
    }
    (of, count as usize)
}

/// `(I - SMOOTHING D^-1 F) P0`, where `P0` is constant on each aggregate and `F` is the matrix without its weak entries,
/// which are added to the diagonal instead: rows still sum to what they did, and the coarse matrix stays sparse.
fn smoothed_prolongation(matrix: &Sparse, diagonal: &[f64], aggregate: &[u32], count: usize) -> Sparse {
    let mut out = Sparse::with_capacity(count, matrix.rows(), 3 * matrix.rows());
    let mut row: Vec<(u32, f64)> = Vec::new();
    for i in 0..matrix.rows() {
        row.clear();
        let (mut total, mut strong) = (0.0, 0.0);
        for (j, v) in matrix.row(i) {
            total += v;
            if is_strong(diagonal, i, j, v) {
                strong += v;
            }
        }
        // Of a row that sums to nothing the diagonal is what balances the strong entries.
        let own = total - strong;
        if !(own > 0.0) {
            out.push(aggregate[i], 1.0);
            out.end_row();
            continue;
        }
        row.push((aggregate[i], 1.0 - SMOOTHING));
        for (j, v) in matrix.row(i).filter(|&(j, v)| is_strong(diagonal, i, j, v)) {
            let weight = -SMOOTHING * v / own;
            match row.iter_mut().find(|(c, _)| *c == aggregate[j]) {
                Some(entry) => entry.1 += weight,
                None => row.push((aggregate[j], weight)),
            }
        }
        row.iter().for_each(|&(c, w)| out.push(c, w));
        out.end_row();
    }
    out
}

/// A dense Cholesky factor, lower triangle by rows.
#[derive(Debug, Clone)]
struct Cholesky {
    n: usize,
    lower: Vec<f64>,
}

impl Cholesky {
    fn new(matrix: &Sparse) -> Self {
        let n = matrix.rows();
        let mut lower = vec![0.0; n * n];
        for i in 0..n {
            for (j, v) in matrix.row(i) {
                lower[i * n + j] += v;
            }
        }
        let largest = (0..n).map(|i| lower[i * n + i]).fold(f64::MIN_POSITIVE, f64::max);
        let ridge = RIDGE * largest;
        for j in 0..n {
            let mut pivot = lower[j * n + j] + ridge;
            for k in 0..j {
                pivot -= lower[j * n + k] * lower[j * n + k];
            }
            let pivot = pivot.max(ridge).sqrt();
            lower[j * n + j] = pivot;
            for i in j + 1..n {
                let mut v = lower[i * n + j];
                for k in 0..j {
                    v -= lower[i * n + k] * lower[j * n + k];
                }
                lower[i * n + j] = v / pivot;
            }
        }
        Self { n, lower }
    }

    fn solve(&self, rhs: &[Pair], x: &mut [Pair]) {
        let (n, l) = (self.n, &self.lower);
        for i in 0..n {
            let mut v = rhs[i];
            for j in 0..i {
                v[0] -= l[i * n + j] * x[j][0];
                v[1] -= l[i * n + j] * x[j][1];
            }
            x[i] = [v[0] / l[i * n + i], v[1] / l[i * n + i]];
        }
        for i in (0..n).rev() {
            let mut v = x[i];
            for j in i + 1..n {
                v[0] -= l[j * n + i] * x[j][0];
                v[1] -= l[j * n + i] * x[j][1];
            }
            x[i] = [v[0] / l[i * n + i], v[1] / l[i * n + i]];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::{CgOptions, Jacobi, Stop, solve};
    use super::*;
    use crate::random::Random;

    /// The Laplacian of a w x w grid of squares, each of two right triangles: singular along the constants.
    fn grid(w: usize) -> Sparse {
        let mut elements = Vec::new();
        for y in 0..w - 1 {
            for x in 0..w - 1 {
                let v = |dx: usize, dy: usize| ((y + dy) * w + x + dx) as u32;
                elements.extend([[v(0, 0), v(1, 0), v(0, 1)], [v(1, 1), v(0, 1), v(1, 0)]]);
            }
        }
        // Gradient inner products of a right triangle whose first corner has the right angle.
        Sparse::assemble(w * w, &elements, |_| [[1.0, -0.5, -0.5], [-0.5, 0.5, 0.0], [-0.5, 0.0, 0.5]])
    }

    fn known_solution(n: usize) -> Vec<Pair> {
        let mut random = Random::new(3, 0);
        let mut x: Vec<Pair> = (0..n).map(|_| [random.range(-1.0, 1.0), random.range(-5.0, 5.0)]).collect();
        for k in 0..2 {
            let mean = x.iter().map(|v| v[k]).sum::<f64>() / n as f64;
            x.iter_mut().for_each(|v| v[k] -= mean);
        }
        x
    }

    fn iterations(w: usize, multigrid: bool) -> (usize, f64) {
        let a = grid(w);
        let truth = known_solution(a.rows());
        let mut rhs = vec![[0.0; 2]; a.rows()];
        a.times(&truth, &mut rhs);
        let mut x = vec![[0.0; 2]; a.rows()];
        let options = CgOptions { stop: Stop::Residual(1e-10), max_iterations: 4000, coupled: false };
        let product = |x: &[Pair], out: &mut [Pair]| a.times(x, out);
        let stats = if multigrid {
            solve(product, &rhs, &mut x, &mut Multigrid::new(&a), options)
        } else {
            solve(product, &rhs, &mut x, &mut Jacobi::new(&a), options)
        };
        let mut worst: f64 = 0.0;
        for k in 0..2 {
            let shift = x[0][k] - truth[0][k];
            worst = x.iter().zip(&truth).map(|(x, t)| (x[k] - t[k] - shift).abs()).fold(worst, f64::max);
        }
        (stats.iterations, worst)
    }

    #[test]
    fn both_preconditioners_find_the_known_solution_of_a_singular_system() {
        for multigrid in [false, true] {
            let (_, error) = iterations(40, multigrid);
            assert!(error < 1e-6, "multigrid {multigrid}: off by {error}");
        }
    }

    #[test]
    fn multigrid_iterations_do_not_grow_with_size() {
        let (small, large) = (iterations(24, true).0, iterations(128, true).0);
        assert!(large <= small + small / 2, "{small} iterations for 576 unknowns, {large} for 16,384");
        let plain = iterations(128, false).0;
        assert!(large * 6 < plain, "{large} iterations against {plain} of Jacobi");
    }
}
