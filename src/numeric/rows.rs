//! Vectors of equal length as rows of one array, and the nearest of them to others, by looking at all.
//!
//! The nearest row has the smallest |c|^2 / 2 - q . c, so that the work is a product of matrices: candidates lie in panels of
//! sixteen columns and queries are taken four at a time, which keeps all sums in registers where those hold eight numbers.
//! Rounding could swap rows that are nearly equally near; those within its bound are compared again, directly and in double
//! precision. Of equally near rows the first counts.
//!
//! The inner loops are compiled for several widths of registers, and the widest that the processor has is taken. Sums are in a
//! fixed order, so that all of them have the same result.

use pulp::Arch;

/// Candidates of a panel.
const PANEL: usize = 16;
/// Queries taken at once.
const TAKEN: usize = 4;
/// Sums that a scalar product is taken in side by side.
const LANES: usize = 16;
/// Bound of the rounding of a sum of products, as a share of the squared lengths in it.
const ROUNDING: f32 = 4e-6;

/// Rows of equal length.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Rows {
    dims: usize,
    data: Vec<f32>,
}

impl Rows {
    /// No rows yet, of `dims` numbers each (at least one).
    #[must_use]
    pub fn new(dims: usize) -> Self {
        Self { dims: dims.max(1), data: Vec::new() }
    }

    /// `count` rows of zeros.
    #[must_use]
    pub fn zeros(count: usize, dims: usize) -> Self {
        let dims = dims.max(1);
        Self { dims, data: vec![0.0; count * dims] }
    }

    /// Numbers a row.
    #[must_use]
    pub const fn dims(&self) -> usize {
        self.dims
    }

    /// How many rows.
    #[must_use]
    pub const fn len(&self) -> usize {
        self.data.len() / self.dims
    }

    /// True if there are none.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.data.is_empty()
    }

    /// A row.
    #[inline]
    #[must_use]
    pub fn row(&self, index: usize) -> &[f32] {
        &self.data[index * self.dims..][..self.dims]
    }

    /// A row, to change.
    #[inline]
    pub fn row_mut(&mut self, index: usize) -> &mut [f32] {
        &mut self.data[index * self.dims..][..self.dims]
    }

    /// All rows one after another.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = &[f32]> {
        self.data.chunks_exact(self.dims)
    }

    /// All numbers, to change row by row.
    pub fn data_mut(&mut self) -> &mut [f32] {
        &mut self.data
    }

    /// Adds a row; what it lacks is zero, what it has too much is dropped.
    pub fn push(&mut self, row: &[f32]) {
        let end = self.data.len() + self.dims;
        self.data.extend(row.iter().take(self.dims));
        self.data.resize(end, 0.0);
    }

    /// Makes it `count` rows, new ones of zeros.
    pub fn resize(&mut self, count: usize) {
        self.data.resize(count * self.dims, 0.0);
    }

    /// Some of the rows.
    #[must_use]
    pub fn select(&self, indices: &[u32]) -> Self {
        Self { dims: self.dims, data: indices.iter().flat_map(|&i| self.row(i as usize)).copied().collect() }
    }
}

/// The squared distance of two vectors.
#[inline(always)]
#[must_use]
pub fn distance_squared(a: &[f32], b: &[f32]) -> f32 {
    // Four sums side by side, which the compiler turns into one of vectors.
    let mut sums = [0.0_f32; 4];
    let (a4, a1) = a.as_chunks::<4>();
    let (b4, b1) = b.as_chunks::<4>();
    for (a, b) in a4.iter().zip(b4) {
        for k in 0..4 {
            let d = a[k] - b[k];
            sums[k] += d * d;
        }
    }
    let rest: f32 = a1.iter().zip(b1).map(|(a, b)| (a - b) * (a - b)).sum();
    (sums[0] + sums[1]) + (sums[2] + sums[3]) + rest
}

/// The scalar product of two vectors.
#[inline(always)]
#[must_use]
pub fn dot(a: &[f32], b: &[f32]) -> f32 {
    let mut sums = [0.0_f32; LANES];
    let (many_a, rest_a) = a.as_chunks::<LANES>();
    let (many_b, rest_b) = b.as_chunks::<LANES>();
    for (a, b) in many_a.iter().zip(many_b) {
        for k in 0..LANES {
            sums[k] += a[k] * b[k];
        }
    }
    let rest: f32 = rest_a.iter().zip(rest_b).map(|(a, b)| a * b).sum();
    sums.iter().sum::<f32>() + rest
}

fn exact(a: &[f32], b: &[f32]) -> f64 {
    a.iter().zip(b).map(|(&a, &b)| (f64::from(a) - f64::from(b)).powi(2)).sum()
}

/// A found row.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Near {
    /// Its index.
    pub row: u32,
    /// The squared distance.
    pub squared: f64,
}

/// Rows made ready to be searched whole.
#[derive(Debug, Clone)]
pub struct Exhaustive {
    rows: Rows,
    panels: Vec<[f32; PANEL]>,
    half_squares: Vec<f32>,
    longest: f32,
}

impl Exhaustive {
    /// Lays the rows out for searching.
    #[must_use]
    pub fn new(rows: Rows) -> Self {
        let (count, dims) = (rows.len(), rows.dims());
        let mut panels = vec![[0.0; PANEL]; count.div_ceil(PANEL) * dims];
        for (i, row) in rows.iter().enumerate() {
            for (k, &x) in row.iter().enumerate() {
                panels[i / PANEL * dims + k][i % PANEL] = x;
            }
        }
        let mut half_squares: Vec<f32> = rows.iter().map(|r| r.iter().map(|x| x * x).sum::<f32>() / 2.0).collect();
        let longest = half_squares.iter().copied().fold(0.0, f32::max);
        half_squares.resize(count.div_ceil(PANEL) * PANEL, f32::INFINITY);
        Self { rows, panels, half_squares, longest }
    }

    /// The rows.
    #[must_use]
    pub const fn rows(&self) -> &Rows {
        &self.rows
    }

    /// The nearest row to each query; queries have the rows' length. Nothing if there are no rows.
    #[must_use]
    pub fn nearest(&self, queries: &Rows) -> Vec<Near> {
        let dims = self.rows.dims();
        if self.rows.is_empty() || queries.dims() != dims {
            return Vec::new();
        }
        let arch = Arch::new();
        let mut scores = vec![[0.0_f32; PANEL]; self.panels.len() / dims * TAKEN];
        let mut out = Vec::with_capacity(queries.len());
        for first in (0..queries.len()).step_by(TAKEN) {
            // Beyond the last query its row is taken again.
            let taken = std::array::from_fn(|q| queries.row((first + q).min(queries.len() - 1)));
            arch.dispatch(|| self.score(&taken, &mut scores));
            for (q, query) in taken.iter().enumerate().take(queries.len() - first) {
                out.push(arch.dispatch(|| self.refined(query, q, &scores)));
            }
        }
        out
    }

    #[inline(always)]
    fn score(&self, taken: &[&[f32]; TAKEN], scores: &mut [[f32; PANEL]]) {
        let dims = self.rows.dims();
        let [q0, q1, q2, q3] = taken.map(|q| &q[..dims]);
        for (p, panel) in self.panels.chunks_exact(dims).enumerate() {
            let mut sums = [[0.0_f32; PANEL]; TAKEN];
            for ((((column, &a), &b), &c), &d) in panel.iter().zip(q0).zip(q1).zip(q2).zip(q3) {
                for k in 0..PANEL {
                    sums[0][k] += a * column[k];
                    sums[1][k] += b * column[k];
                    sums[2][k] += c * column[k];
                    sums[3][k] += d * column[k];
                }
            }
            let half = &self.half_squares[p * PANEL..][..PANEL];
            for (q, sum) in sums.iter().enumerate() {
                let out = &mut scores[p * TAKEN + q];
                for k in 0..PANEL {
                    out[k] = half[k] - sum[k];
                }
            }
        }
    }

    #[inline(always)]
    fn refined(&self, query: &[f32], q: usize, scores: &[[f32; PANEL]]) -> Near {
        let own = || scores.iter().skip(q).step_by(TAKEN);
        let mut least = [f32::INFINITY; PANEL];
        for panel in own() {
            for k in 0..PANEL {
                least[k] = least[k].min(panel[k]);
            }
        }
        let length: f32 = query.iter().map(|x| x * x).sum();
        let bound = least.iter().copied().fold(f32::INFINITY, f32::min) + ROUNDING * (length + 2.0 * self.longest);
        let mut best = Near { row: 0, squared: f64::INFINITY };
        for (p, panel) in own().enumerate() {
            for (k, _) in panel.iter().enumerate().filter(|(_, s)| **s <= bound) {
                let row = p * PANEL + k;
                let squared = exact(query, self.rows.row(row));
                if squared < best.squared {
                    best = Near { row: row as u32, squared };
                }
            }
        }
        best
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;

    fn noise(count: usize, dims: usize, seed: u64) -> Rows {
        let mut random = Random::new(seed, 0);
        let mut rows = Rows::zeros(count, dims);
        rows.data_mut().iter_mut().for_each(|x| *x = random.unit() as f32);
        rows
    }

    #[test]
    fn the_blocked_search_finds_what_a_plain_one_finds() {
        for (count, dims, asked) in [(1, 1, 1), (7, 3, 5), (8, 4, 4), (300, 21, 33), (1000, 75, 6)] {
            let (rows, queries) = (noise(count, dims, 1), noise(asked, dims, 2));
            let found = Exhaustive::new(rows.clone()).nearest(&queries);
            for (q, near) in queries.iter().zip(&found) {
                let all: Vec<f64> = rows.iter().map(|r| exact(q, r)).collect();
                let least = all.iter().copied().fold(f64::INFINITY, f64::min);
                assert_eq!(near.squared, least, "{count} rows of {dims}");
                assert_eq!(near.row as usize, all.iter().position(|&d| d == least).expect("one is least"), "{count} of {dims}");
            }
        }
    }

    #[test]
    fn of_equal_rows_the_first_counts_and_no_rows_have_no_nearest() {
        let mut rows = Rows::new(3);
        (0..40).for_each(|i| rows.push(&[if i < 9 { 1.0 } else { 0.25 }; 3]));
        let mut query = Rows::new(3);
        query.push(&[0.3; 3]);
        assert_eq!(Exhaustive::new(rows).nearest(&query)[0].row, 9, "rows 9 to 39 are the same");
        assert!(Exhaustive::new(Rows::new(3)).nearest(&query).is_empty(), "there is nothing to find");
    }
}
