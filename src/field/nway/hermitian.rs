//! Sparse Hermitian matrices over the nodes of a connection, and a multigrid preconditioner for them.
//!
//! Based on: Vanek, Mandel, Brezina, "Algebraic multigrid by smoothed aggregation", 1996, as in [`crate::numeric::multigrid`]; here
//! entries are complex, and what is constant on an aggregate is a direction carried out from its first node.
//!
//! Sweeps are those of Gauss and Seidel within blocks of a fixed number of rows, which know of each other what was there before
//! (Jacobi): several threads work, and the answer does not depend on how many. Down before the coarser level, up after it, so that a
//! cycle stays Hermitian.

use glam::DVec2;
use rayon::prelude::*;

/// Damping of the step that smooths the prolongation.
const SMOOTHING: f64 = 2.0 / 3.0;
/// The coarsest level is solved by as many sweeps.
const COARSEST: usize = 48;
/// Levels of fewer nodes than this need no coarser one.
const SMALL: usize = 40;
/// Rows of a block.
const BLOCK: usize = 4096;
/// A level that shrinks less than this is the last.
const SHRINK: f64 = 0.7;

/// Column and value.
type Entry = (u32, DVec2);

/// A sparse complex matrix in compressed rows.
#[derive(Debug, Clone)]
pub(super) struct Matrix {
    columns: usize,
    start: Vec<u32>,
    column: Vec<u32>,
    value: Vec<DVec2>,
}

pub(super) fn conjugate(a: DVec2) -> DVec2 {
    DVec2::new(a.x, -a.y)
}

/// The inner product, linear in the second.
pub(super) fn inner(a: &[DVec2], b: &[DVec2]) -> DVec2 {
    let of_block = |(a, b): (&[DVec2], &[DVec2])| -> DVec2 { a.iter().zip(b).map(|(&a, &b)| conjugate(a).rotate(b)).sum() };
    if a.len() <= BLOCK {
        return of_block((a, b));
    }
    let sums: Vec<DVec2> = a.par_chunks(BLOCK).zip(b.par_chunks(BLOCK)).map(of_block).collect();
    sums.into_iter().sum()
}

impl Matrix {
    /// From what `row` adds for each of so many rows, by several threads.
    pub(super) fn of_rows(columns: usize, rows: usize, row: impl Fn(u32, &mut Vec<Entry>) + Sync) -> Self {
        Self::of_rows_with(columns, rows, || (), |(), i, out| row(i, out))
    }

    /// The same with room of its own for each thread. What it adds must not depend on what the room holds from other rows.
    fn of_rows_with<T>(
        columns: usize,
        rows: usize,
        room: impl Fn() -> T + Sync,
        row: impl Fn(&mut T, u32, &mut Vec<Entry>) + Sync,
    ) -> Self {
        let all: Vec<u32> = (0..rows as u32).collect();
        let blocks = all.par_chunks(BLOCK).map_init(&room, |room, block| {
            let (mut ends, mut entries) = (Vec::with_capacity(block.len()), Vec::new());
            for &i in block {
                row(room, i, &mut entries);
                ends.push(entries.len() as u32);
            }
            (ends, entries)
        });
        let blocks: Vec<(Vec<u32>, Vec<Entry>)> = blocks.collect();
        let count = blocks.iter().map(|b| b.1.len()).sum();
        let mut out = Self { columns, start: vec![0], column: Vec::with_capacity(count), value: Vec::with_capacity(count) };
        for (ends, entries) in blocks {
            let before = out.column.len() as u32;
            out.start.extend(ends.into_iter().map(|end| before + end));
            out.column.extend(entries.iter().map(|e| e.0));
            out.value.extend(entries.iter().map(|e| e.1));
        }
        out
    }

    const fn rows(&self) -> usize {
        self.start.len() - 1
    }

    #[inline]
    fn row(&self, row: usize) -> impl Iterator<Item = (usize, DVec2)> + '_ {
        let range = self.start[row] as usize..self.start[row + 1] as usize;
        self.column[range.clone()].iter().map(|&c| c as usize).zip(self.value[range].iter().copied())
    }

    #[inline]
    fn row_times(&self, row: usize, x: &[DVec2]) -> DVec2 {
        self.row(row).map(|(c, v)| v.rotate(x[c])).sum()
    }

    pub(super) fn times(&self, x: &[DVec2]) -> Vec<DVec2> {
        let mut out = vec![DVec2::ZERO; self.rows()];
        blocks(&mut out, |first, block| block.iter_mut().zip(first..).for_each(|(o, r)| *o = self.row_times(r, x)));
        out
    }

    fn diagonal(&self) -> Vec<f64> {
        let of = |r: usize| self.row(r).find(|&(c, _)| c == r).map_or(0.0, |(_, v)| v.x);
        (0..self.rows()).map(of).map(|d| if d > 0.0 { d } else { 1.0 }).collect()
    }

    fn adjoint(&self) -> Self {
        let mut start = vec![0_u32; self.columns + 1];
        self.column.iter().for_each(|&c| start[c as usize + 1] += 1);
        (0..self.columns).for_each(|c| start[c + 1] += start[c]);
        let mut fill = start.clone();
        let (mut column, mut value) = (vec![0; self.column.len()], vec![DVec2::ZERO; self.value.len()]);
        for row in 0..self.rows() {
            for (c, v) in self.row(row) {
                let at = fill[c] as usize;
                fill[c] += 1;
                (column[at], value[at]) = (row as u32, conjugate(v));
            }
        }
        Self { columns: self.rows(), start, column, value }
    }

    fn product(&self, right: &Self) -> Self {
        let room = || vec![u32::MAX; right.columns];
        Self::of_rows_with(right.columns, self.rows(), room, |place, row, out| {
            let begin = out.len();
            for (k, a) in self.row(row as usize) {
                for (c, b) in right.row(k) {
                    // Where a column was written last; what lies there may be of a row before, or another column.
                    match out[begin..].get_mut((place[c] as usize).wrapping_sub(begin)).filter(|entry| entry.0 as usize == c) {
                        Some(entry) => entry.1 += a.rotate(b),
                        None => {
                            place[c] = out.len() as u32;
                            out.push((c as u32, a.rotate(b)));
                        }
                    }
                }
            }
        })
    }
}

/// One level: its matrix and the way to the next coarser one.
#[derive(Debug, Clone)]
struct Level {
    matrix: Matrix,
    diagonal: Vec<f64>,
    prolong: Option<Matrix>,
    restrict: Option<Matrix>,
}

/// The hierarchy for one matrix.
#[derive(Debug, Clone)]
pub(super) struct Multigrid {
    levels: Vec<Level>,
}

impl Multigrid {
    pub(super) fn new(matrix: Matrix) -> Self {
        let mut levels = Vec::new();
        let mut matrix = matrix;
        loop {
            let diagonal = matrix.diagonal();
            let prolong = (matrix.rows() > SMALL).then(|| prolongation(&matrix, &diagonal)).flatten();
            let Some(prolong) = prolong else {
                levels.push(Level { matrix, diagonal, prolong: None, restrict: None });
                return Self { levels };
            };
            let restrict = prolong.adjoint();
            let coarse = restrict.product(&matrix.product(&prolong));
            levels.push(Level { matrix, diagonal, prolong: Some(prolong), restrict: Some(restrict) });
            matrix = coarse;
        }
    }

    pub(super) fn matrix(&self) -> &Matrix {
        &self.levels[0].matrix
    }

    /// An approximate solution: one cycle.
    pub(super) fn apply(&self, rhs: &[DVec2]) -> Vec<DVec2> {
        cycle(&self.levels, rhs)
    }

    /// A vector that the matrix nearly maps to zero, found on the coarsest level and brought up.
    pub(super) fn smoothest(&self) -> Vec<DVec2> {
        let last = &self.levels[self.levels.len() - 1];
        let mut x: Vec<DVec2> = (0..last.matrix.rows()).map(|i| DVec2::from_angle(i as f64 * 2.4)).collect();
        for _ in 0..COARSEST {
            x = cycle(&self.levels[self.levels.len() - 1..], &x);
            scale(&mut x);
        }
        for k in (0..self.levels.len() - 1).rev() {
            if let Some(prolong) = &self.levels[k].prolong {
                x = prolong.times(&x);
            }
            for _ in 0..2 {
                scale(&mut x);
                x = cycle(&self.levels[k..], &x);
            }
            scale(&mut x);
        }
        x
    }
}

fn scale(x: &mut [DVec2]) {
    let length = inner(x, x).x.sqrt();
    if length > 0.0 {
        x.iter_mut().for_each(|v| *v /= length);
    }
}

/// Does a piece of work on each block of a vector: the number of its first entry and its entries.
fn blocks(x: &mut [DVec2], work: impl Fn(usize, &mut [DVec2]) + Sync) {
    if x.len() <= BLOCK {
        work(0, x);
    } else {
        x.par_chunks_mut(BLOCK).enumerate().for_each(|(k, block)| work(k * BLOCK, block));
    }
}

fn cycle(levels: &[Level], rhs: &[DVec2]) -> Vec<DVec2> {
    let Level { matrix, diagonal, prolong, restrict } = &levels[0];
    let n = matrix.rows();
    let mut x = vec![DVec2::ZERO; n];
    let (Some(prolong), Some(restrict)) = (prolong, restrict) else {
        let mut sweep = |i: usize| {
            let residual = rhs[i] - matrix.row_times(i, &x);
            x[i] += residual / diagonal[i];
        };
        for _ in 0..COARSEST {
            (0..n).for_each(&mut sweep);
            (0..n).rev().for_each(&mut sweep);
        }
        return x;
    };
    // Down, from nothing: rows further down and other blocks are still zero.
    blocks(&mut x, |first, block| {
        for i in 0..block.len() {
            let known = first..first + i;
            let done: DVec2 =
                matrix.row(first + i).filter(|(c, _)| known.contains(c)).map(|(c, v)| v.rotate(block[c - first])).sum();
            block[i] = (rhs[first + i] - done) / diagonal[first + i];
        }
    });
    let mut residual = vec![DVec2::ZERO; n];
    blocks(&mut residual, |first, block| {
        block.iter_mut().zip(first..).for_each(|(r, i)| *r = rhs[i] - matrix.row_times(i, &x));
    });
    let coarse = cycle(&levels[1..], &restrict.times(&residual));
    blocks(&mut x, |first, block| block.iter_mut().zip(first..).for_each(|(x, i)| *x += prolong.row_times(i, &coarse)));
    // Up.
    let before = x.clone();
    blocks(&mut x, |first, block| {
        let own = first..first + block.len();
        for i in (0..block.len()).rev() {
            let at = |c: usize| if own.contains(&c) { block[c - first] } else { before[c] };
            let known: DVec2 = matrix.row(first + i).map(|(c, v)| v.rotate(at(c))).sum();
            block[i] += (rhs[first + i] - known) / diagonal[first + i];
        }
    });
    x
}

/// From aggregates to nodes, smoothed; `None` if hardly any two nodes belong together.
fn prolongation(matrix: &Matrix, diagonal: &[f64]) -> Option<Matrix> {
    const FREE: u32 = u32::MAX;
    let n = matrix.rows();
    let mut of = vec![(FREE, DVec2::X); n];
    let mut count = 0;
    // An entry is minus a weight times the direction there seen from here.
    let carried = |v: DVec2| conjugate(-v).normalize_or(DVec2::X);
    for i in 0..n {
        if of[i].0 == FREE && matrix.row(i).all(|(j, _)| of[j].0 == FREE) {
            of[i] = (count, DVec2::X);
            matrix.row(i).filter(|&(j, _)| j != i).for_each(|(j, v)| of[j] = (count, carried(v)));
            count += 1;
        }
    }
    let first = of.clone();
    for i in 0..n {
        if of[i].0 == FREE {
            let strongest = matrix
                .row(i)
                .filter(|&(j, _)| j != i && first[j].0 != FREE)
                .max_by(|a, b| a.1.length_squared().total_cmp(&b.1.length_squared()));
            match strongest {
                Some((j, v)) => of[i] = (first[j].0, conjugate(carried(v)).rotate(first[j].1)),
                None => {
                    of[i] = (count, DVec2::X);
                    count += 1;
                }
            }
        }
    }
    if f64::from(count) > SHRINK * n as f64 {
        return None;
    }
    Some(Matrix::of_rows(count as usize, n, |i, out| {
        let begin = out.len();
        out.push(of[i as usize]);
        for (j, v) in matrix.row(i as usize) {
            let (aggregate, direction) = of[j];
            let add = v.rotate(direction) * (-SMOOTHING / diagonal[i as usize]);
            match out[begin..].iter_mut().find(|(c, _)| *c == aggregate) {
                Some(entry) => entry.1 += add,
                None => out.push((aggregate, add)),
            }
        }
    }))
}

/// Solves `(matrix + diagonal) x = rhs` from the `x` given by conjugate gradients; returns the iterations.
pub(super) fn solve(grid: &Multigrid, diagonal: &[f64], rhs: &[DVec2], x: &mut [DVec2], tolerance: f64, most: usize) -> usize {
    let times = |x: &[DVec2]| {
        let mut out = grid.matrix().times(x);
        blocks(&mut out, |first, block| {
            block.iter_mut().zip(&x[first..]).zip(&diagonal[first..]).for_each(|((o, &x), &d)| *o += x * d);
        });
        out
    };
    let product = times(x);
    let mut r: Vec<DVec2> = rhs.iter().zip(&product).map(|(&b, &p)| b - p).collect();
    let mut z = grid.apply(&r);
    let mut direction = z.clone();
    let mut rz = inner(&r, &z).x;
    let size = inner(rhs, rhs).x.sqrt();
    for iteration in 0..most {
        if inner(&r, &r).x.sqrt() <= tolerance * size {
            return iteration;
        }
        let product = times(&direction);
        let bent = inner(&direction, &product).x;
        if !(bent > 0.0) {
            return iteration;
        }
        let step = rz / bent;
        blocks(x, |first, block| block.iter_mut().zip(&direction[first..]).for_each(|(x, &d)| *x += d * step));
        blocks(&mut r, |first, block| block.iter_mut().zip(&product[first..]).for_each(|(r, &p)| *r -= p * step));
        z = grid.apply(&r);
        let new = inner(&r, &z).x;
        let share = if rz > 0.0 { new / rz } else { 0.0 };
        blocks(&mut direction, |first, block| block.iter_mut().zip(&z[first..]).for_each(|(d, &z)| *d = z + *d * share));
        rz = new;
    }
    most
}
