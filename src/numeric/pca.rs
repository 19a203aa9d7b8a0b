//! Principal components of rows, by subspace iteration: the directions in which they vary most.

use super::rows::Rows;
use crate::random::Random;
use pulp::Arch;
use rayon::prelude::*;

/// Rows that the covariance is taken of at most, evenly spread over all.
const LOOKED_AT: usize = 2048;
/// Iterations of the subspace; the components need to be good, not exact.
const ITERATIONS: usize = 12;
/// Rows of the covariance that one task sums.
const STRIP: usize = 16;

/// A projection on principal components.
#[derive(Debug, Clone)]
pub struct Pca {
    mean: Vec<f32>,
    /// For each number of a row its share of each component.
    shares: Vec<f32>,
    kept: usize,
}

impl Pca {
    /// The first `kept` components of some rows; fewer if the rows are shorter.
    #[must_use]
    pub fn new(rows: &Rows, kept: usize) -> Self {
        let dims = rows.dims();
        let kept = kept.clamp(1, dims);
        let step = rows.len().div_ceil(LOOKED_AT).max(1);
        let looked: Vec<&[f32]> = rows.iter().step_by(step).collect();
        let mut mean = vec![0.0_f64; dims];
        looked.iter().for_each(|r| mean.iter_mut().zip(*r).for_each(|(m, &x)| *m += f64::from(x)));
        let mean: Vec<f32> = mean.iter().map(|m| (m / looked.len().max(1) as f64) as f32).collect();
        let covariance = covariance(&looked, &mean);
        let shares = subspace(&covariance, dims, kept);
        Self { mean, shares, kept }
    }

    /// How many components.
    #[must_use]
    pub const fn kept(&self) -> usize {
        self.kept
    }

    /// A row's components.
    #[inline(always)]
    pub fn project(&self, row: &[f32], out: &mut [f32]) {
        out.fill(0.0);
        let out = &mut out[..self.kept];
        for ((&x, &m), shares) in row.iter().zip(&self.mean).zip(self.shares.chunks_exact(self.kept)) {
            let x = x - m;
            for (o, &s) in out.iter_mut().zip(shares) {
                *o += x * s;
            }
        }
    }

    /// All rows' components.
    #[must_use]
    pub fn project_all(&self, rows: &Rows) -> Rows {
        let mut out = Rows::zeros(rows.len(), self.kept);
        let work = out.data_mut().par_chunks_exact_mut(self.kept).enumerate();
        work.for_each(|(i, o)| Arch::new().dispatch(|| self.project(rows.row(i), o)));
        out
    }
}

/// The covariance of rows, up to a factor.
fn covariance(rows: &[&[f32]], mean: &[f32]) -> Vec<f32> {
    let dims = mean.len();
    let centred: Vec<f32> = rows.iter().flat_map(|r| r.iter().zip(mean).map(|(x, m)| x - m)).collect();
    let mut out = vec![0.0_f32; dims * dims];
    let strips = out.par_chunks_mut(STRIP * dims).enumerate();
    strips.for_each(|(strip, out)| {
        Arch::new().dispatch(|| {
            for row in centred.chunks_exact(dims) {
                for (i, line) in out.chunks_exact_mut(dims).enumerate() {
                    // The other half is its mirror image.
                    let from = strip * STRIP + i;
                    let x = row[from];
                    for (o, &y) in line[from..].iter_mut().zip(&row[from..]) {
                        *o += x * y;
                    }
                }
            }
        });
    });
    for i in 0..dims {
        for j in 0..i {
            out[i * dims + j] = out[j * dims + i];
        }
    }
    out
}

/// An orthonormal basis of the dominant subspace, `kept` columns, row by row.
fn subspace(matrix: &[f32], dims: usize, kept: usize) -> Vec<f32> {
    let mut random = Random::new(1, 0x9CA);
    let mut basis: Vec<f32> = (0..dims * kept).map(|_| random.range(-1.0, 1.0) as f32).collect();
    let scale = (0..dims).map(|i| matrix[i * dims + i]).fold(0.0, f32::max);
    for _ in 0..ITERATIONS {
        orthonormalise(&mut basis, kept);
        if !(scale > 0.0) {
            break;
        }
        let mut next = vec![0.0_f32; dims * kept];
        for (line, out) in matrix.chunks_exact(dims).zip(next.chunks_exact_mut(kept)) {
            for (&m, b) in line.iter().zip(basis.chunks_exact(kept)) {
                let m = m / scale;
                out.iter_mut().zip(b).for_each(|(o, &b)| *o += m * b);
            }
        }
        basis = next;
    }
    orthonormalise(&mut basis, kept);
    basis
}

/// Gram and Schmidt's method; columns that vanish stay zero.
fn orthonormalise(basis: &mut [f32], kept: usize) {
    for k in 0..kept {
        for j in 0..=k {
            let dot: f64 = basis.chunks_exact(kept).map(|b| f64::from(b[j]) * f64::from(b[k])).sum();
            if j < k {
                basis.chunks_exact_mut(kept).for_each(|b| b[k] -= dot as f32 * b[j]);
            } else {
                let factor = if dot > 1e-20 { 1.0 / dot.sqrt() } else { 0.0 };
                basis.chunks_exact_mut(kept).for_each(|b| b[k] = (f64::from(b[k]) * factor) as f32);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_in_a_plane_keep_their_distances_in_two_components() {
        let mut random = Random::new(3, 0);
        let (a, b): (Vec<f32>, Vec<f32>) = (0..30).map(|_| (random.unit() as f32, random.unit() as f32)).unzip();
        let mut rows = Rows::new(30);
        for _ in 0..200 {
            let (x, y) = (random.range(-3.0, 3.0) as f32, random.range(-1.0, 1.0) as f32);
            rows.push(&a.iter().zip(&b).map(|(a, b)| 0.5 + x * a + y * b).collect::<Vec<f32>>());
        }
        let flat = Pca::new(&rows, 2).project_all(&rows);
        for i in 1..rows.len() {
            let (whole, kept) = [&rows, &flat].map(|r| super::super::rows::distance_squared(r.row(0), r.row(i))).into();
            assert!((whole - kept).abs() < 1e-3 * whole.max(1.0), "row {i}: {whole} became {kept}");
        }
    }

    #[test]
    fn equal_rows_have_no_components() {
        let mut rows = Rows::new(4);
        (0..5).for_each(|_| rows.push(&[0.3, 0.1, 0.7, 0.2]));
        let flat = Pca::new(&rows, 3).project_all(&rows);
        assert!(flat.iter().flatten().all(|x| x.abs() < 1e-6), "{flat:?}");
    }
}
