//! Sparse matrices in compressed rows.

use super::Pair;

/// A sparse matrix in compressed rows. Columns within a row are in the order of first use, each at most once.
#[derive(Debug, Clone, PartialEq)]
pub struct Sparse {
    columns: usize,
    start: Vec<u32>,
    column: Vec<u32>,
    value: Vec<f64>,
}

impl Sparse {
    /// A matrix from its rows of (column, value) with `columns` columns.
    #[must_use]
    pub fn from_rows(columns: usize, rows: &[Vec<(u32, f64)>]) -> Self {
        let mut out = Self::with_capacity(columns, rows.len(), rows.iter().map(Vec::len).sum());
        for row in rows {
            row.iter().for_each(|&(c, v)| out.push(c, v));
            out.end_row();
        }
        out
    }

    /// Assembles a symmetric matrix of triangle elements: `matrix(e)` is added at rows and columns `elements[e]`.
    #[must_use]
    pub fn assemble(unknowns: usize, elements: &[[u32; 3]], mut matrix: impl FnMut(usize) -> [[f64; 3]; 3]) -> Self {
        // Room for a row: itself and two neighbours an element; what is shared is squeezed out at the end.
        let mut start = vec![0_u32; unknowns + 1];
        for &v in elements.as_flattened() {
            start[v as usize + 1] += 2;
        }
        for v in 0..unknowns {
            start[v + 1] += start[v] + 1;
        }
        let mut length = vec![1_u32; unknowns];
        let mut column = vec![0_u32; start[unknowns] as usize];
        let mut value = vec![0.0; start[unknowns] as usize];
        for v in 0..unknowns {
            column[start[v] as usize] = v as u32;
        }
        for (e, corners) in elements.iter().enumerate() {
            let m = matrix(e);
            for i in 0..3 {
                let row = corners[i] as usize;
                let first = start[row] as usize;
                for j in 0..3 {
                    let used = length[row] as usize;
                    let k = column[first..first + used].iter().position(|&c| c == corners[j]).unwrap_or_else(|| {
                        column[first + used] = corners[j];
                        length[row] += 1;
                        used
                    });
                    value[first + k] += m[i][j];
                }
            }
        }
        let mut out = Self::with_capacity(unknowns, unknowns, length.iter().map(|&l| l as usize).sum());
        for v in 0..unknowns {
            let range = start[v] as usize..(start[v] + length[v]) as usize;
            out.column.extend_from_slice(&column[range.clone()]);
            out.value.extend_from_slice(&value[range]);
            out.end_row();
        }
        out
    }

    pub(super) fn with_capacity(columns: usize, rows: usize, entries: usize) -> Self {
        let mut start = Vec::with_capacity(rows + 1);
        start.push(0);
        Self { columns, start, column: Vec::with_capacity(entries), value: Vec::with_capacity(entries) }
    }

    pub(super) fn push(&mut self, column: u32, value: f64) {
        self.column.push(column);
        self.value.push(value);
    }

    pub(super) fn end_row(&mut self) {
        self.start.push(self.column.len() as u32);
    }

    /// Number of rows.
    #[must_use]
    pub const fn rows(&self) -> usize {
        self.start.len() - 1
    }

    /// Number of stored entries.
    #[must_use]
    pub const fn entries(&self) -> usize {
        self.column.len()
    }

    /// The (column, value) entries of a row.
    #[inline]
    pub fn row(&self, row: usize) -> impl Iterator<Item = (usize, f64)> + '_ {
        let range = self.start[row] as usize..self.start[row + 1] as usize;
        self.column[range.clone()].iter().map(|&c| c as usize).zip(self.value[range].iter().copied())
    }

    /// The diagonal.
    #[must_use]
    pub fn diagonal(&self) -> Vec<f64> {
        (0..self.rows()).map(|r| self.row(r).filter(|&(c, _)| c == r).map(|(_, v)| v).sum()).collect()
    }

    /// One row times two vectors.
    #[inline]
    #[must_use]
    pub fn row_times(&self, row: usize, x: &[Pair]) -> Pair {
        self.range_times(self.start[row] as usize..self.start[row + 1] as usize, x)
    }

    /// The matrix times two vectors.
    pub fn times(&self, x: &[Pair], out: &mut [Pair]) {
        for (row, out) in out.iter_mut().enumerate() {
            *out = self.row_times(row, x);
        }
    }

    /// Brings each row of a square matrix into the order: columns below the diagonal, the diagonal, columns above it. Returns
    /// for each row where, among all entries, the columns above begin; `self.row` is in the new order from then on.
    pub(super) fn split_rows(&mut self) -> Vec<u32> {
        let mut above: Vec<(u32, f64)> = Vec::new();
        (0..self.rows())
            .map(|row| {
                let range = self.start[row] as usize..self.start[row + 1] as usize;
                above.clear();
                let (mut put, mut own) = (range.start, None);
                for k in range.clone() {
                    let entry = (self.column[k], self.value[k]);
                    match (entry.0 as usize).cmp(&row) {
                        std::cmp::Ordering::Less => {
                            (self.column[put], self.value[put]) = entry;
                            put += 1;
                        }
                        std::cmp::Ordering::Equal => own = Some(entry),
                        std::cmp::Ordering::Greater => above.push(entry),
                    }
                }
                if let Some(entry) = own {
                    (self.column[put], self.value[put]) = entry;
                    put += 1;
                }
                for (k, &entry) in (put..range.end).zip(&above) {
                    (self.column[k], self.value[k]) = entry;
                }
                put as u32
            })
            .collect()
    }

    /// The part of a row's product up to the diagonal, `middle` being what [`Self::split_rows`] returned for the row.
    #[inline]
    pub(super) fn row_times_up_to(&self, row: usize, middle: u32, x: &[Pair]) -> Pair {
        self.range_times(self.start[row] as usize..middle as usize, x)
    }

    /// The part of a row's product past the diagonal.
    #[inline]
    pub(super) fn row_times_past(&self, row: usize, middle: u32, x: &[Pair]) -> Pair {
        self.range_times(middle as usize..self.start[row + 1] as usize, x)
    }

    #[inline]
    fn range_times(&self, range: std::ops::Range<usize>, x: &[Pair]) -> Pair {
        let mut sum = [0.0; 2];
        for (&c, v) in self.column[range.clone()].iter().zip(&self.value[range]) {
            let x = x[c as usize];
            sum[0] += v * x[0];
            sum[1] += v * x[1];
        }
        sum
    }

    /// The transposed matrix.
    #[must_use]
    pub fn transposed(&self) -> Self {
        let mut start = vec![0_u32; self.columns + 1];
        for &c in &self.column {
            start[c as usize + 1] += 1;
        }
        for c in 0..self.columns {
            start[c + 1] += start[c];
        }
        let mut fill = start.clone();
        let mut column = vec![0; self.entries()];
        let mut value = vec![0.0; self.entries()];
        for row in 0..self.rows() {
            for (c, v) in self.row(row) {
                let at = fill[c] as usize;
                fill[c] += 1;
                column[at] = row as u32;
                value[at] = v;
            }
        }
        Self { columns: self.rows(), start, column, value }
    }

    /// The product of two matrices.
    #[must_use]
    pub fn product(&self, right: &Self) -> Self {
        let mut out = Self::with_capacity(right.columns, self.rows(), self.entries());
        // Where each column stands in the row being built; entries before `begin` belong to earlier rows.
        let mut place = vec![u32::MAX; right.columns];
        for row in 0..self.rows() {
            let begin = out.column.len();
            for (k, a) in self.row(row) {
                for (c, b) in right.row(k) {
                    let p = place[c] as usize;
                    if p >= begin && p < out.column.len() && out.column[p] as usize == c {
                        out.value[p] += a * b;
                    } else {
                        place[c] = out.column.len() as u32;
                        out.push(c as u32, a * b);
                    }
                }
            }
            out.end_row();
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn dense(m: &Sparse, columns: usize) -> Vec<Vec<f64>> {
        (0..m.rows())
            .map(|r| {
                let mut row = vec![0.0; columns];
                m.row(r).for_each(|(c, v)| row[c] += v);
                row
            })
            .collect()
    }

    #[test]
    fn assembled_elements_sum_to_the_dense_matrix() {
        let elements = [[0, 1, 2], [2, 1, 3]];
        let m = Sparse::assemble(4, &elements, |e| [[2.0, -1.0, -1.0], [-1.0, 3.0, -2.0], [-1.0, -2.0, 3.0 + e as f64]]);
        let expected =
            vec![vec![2.0, -1.0, -1.0, 0.0], vec![-1.0, 6.0, -3.0, -2.0], vec![-1.0, -3.0, 5.0, -1.0], vec![0.0, -2.0, -1.0, 4.0]];
        assert_eq!(dense(&m, 4), expected, "sums of the two elements");
        assert_eq!(m.entries(), 14, "no entry twice");
    }

    #[test]
    fn products_and_transposes_agree_with_dense_arithmetic() {
        let a = Sparse::from_rows(3, &[vec![(0, 1.0), (2, 2.0)], vec![(1, -1.0)]]);
        let b = Sparse::from_rows(2, &[vec![(1, 4.0)], vec![(0, 3.0)], vec![(0, 5.0), (1, 1.0)]]);
        assert_eq!(dense(&a.product(&b), 2), vec![vec![10.0, 6.0], vec![-3.0, 0.0]], "product");
        assert_eq!(dense(&a.transposed(), 2), vec![vec![1.0, 0.0], vec![0.0, -1.0], vec![2.0, 0.0]], "transpose");
    }
}
