//! n-way fields: at each place n directions, a full turn over n apart, as smooth over the surface as can be.
//!
//! Based on: Wei, Levoy 2001, sec. 3.1 (relaxation); Knoppel, Crane, Pinkall, Schroder, "Globally optimal direction fields",
//! SIGGRAPH 2013 (the smooth start and the alignment).
//!
//! The n directions at a node are stored as the n-th power of any of them, a unit complex number in the node's frame.
//!
//! 1. Start: the eigenvector of the connection Laplacian with the smallest eigenvalue; with wishes, the solution of the
//!    linear system that weighs smoothness against them; or at random, as the paper does.
//! 2. Relax the smooth error, then, if asked for, the paper's own (`relax`).
//!
//! The paper starts at random on the coarsest of several meshes ([`on_pyramid`]); the eigenvector needs no coarser
//! mesh and ends lower, with fewer singularities.

pub mod align;
mod comb;
pub mod connection;
mod hermitian;
mod index;
mod levels;
pub mod relax;
mod steer;

pub use comb::{Combed, Cut, comb};
pub use connection::{Connection, Over};
pub use index::NWaySingularity;
pub use levels::{LevelFields, on_pyramid};
pub use relax::{Measure, energy};
pub use steer::{SteerStatistics, along_curvature, relaxed};

use crate::mesh::Mesh;
use crate::progress::Progress;
use crate::random::Random;
use connection::unit;
use glam::{DVec2, DVec3};
use hermitian::{Matrix, Multigrid, inner, solve};
use rayon::prelude::*;
use serde::Serialize;
use std::f64::consts::TAU;
use std::sync::OnceLock;

/// Most directions a place may have.
pub const MOST_WAYS: u32 = 12;

/// Added to the Laplacian's diagonal, as a share of its mean: on flat surfaces its smallest eigenvalue is zero.
const RIDGE: f64 = 1e-9;

/// Inverse iterations for the eigenvector at most, and the change of the eigenvalue that ends them.
const INVERSE: usize = 12;
const EIGENVALUE: f64 = 1e-3;

/// Diffusions of the eigenvector brought to unit length (Viertel, Osting 2019), the first over this share of the time in which the
/// smoothest field fades, each of the others over half the time of the one before.
const DIFFUSIONS: usize = 3;
const DIFFUSION: f64 = 0.5;

/// Residuals at which the eigenvector's systems, and that of the wishes, are solved well enough; relaxation does the rest.
const LOOSE: f64 = 3e-2;
const TIGHT: f64 = 1e-4;
const ITERATIONS: usize = 100;

/// Where relaxation starts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Start {
    /// The smoothest field there is.
    #[default]
    Smooth,
    /// A random direction at each node.
    Random,
}

/// How to make a field.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct NWayOptions {
    /// Where to start.
    pub start: Start,
    /// Relax the smooth error. Without it an answer comes several times sooner, as somebody wants it who steers by hand.
    pub smooth: bool,
    /// Then relax the paper's own.
    pub nearest: bool,
    /// Seed of a random start.
    pub seed: u64,
}

impl Default for NWayOptions {
    fn default() -> Self {
        Self { start: Start::Smooth, smooth: true, nearest: false, seed: 1 }
    }
}

/// n directions at each vertex or face.
#[derive(Debug, Clone, PartialEq)]
pub struct NWayField {
    /// How many.
    pub n: u32,
    /// Where.
    pub over: Over,
    /// The n-th power of the directions as unit complex numbers, in the frames of the connection over the same mesh.
    pub powers: Vec<DVec2>,
}

/// What [`NWaySolver::solve`] did.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct NWayStatistics {
    /// Iterations of conjugate gradients for the start.
    pub iterations: usize,
    /// The smooth error before relaxation and after each sweep; it never rises.
    pub smooth_errors: Vec<f64>,
    /// The paper's error before its relaxation and after each sweep; it never rises. Only the last value, if it was not relaxed.
    pub nearest_errors: Vec<f64>,
    /// Singularities.
    pub singularities: usize,
    /// The sum of their indices, in n-th parts of a full turn.
    pub index_sum: i64,
}

/// A connection with its Laplacian: made once for a mesh and n, it solves for any wishes.
#[derive(Debug)]
pub struct NWaySolver<'m> {
    mesh: &'m Mesh,
    n: u32,
    /// The nodes.
    pub table: Connection,
    /// The Laplacian and its coarser levels, once somebody starts smooth.
    grid: OnceLock<Multigrid>,
    component: Vec<u32>,
    components: usize,
}

impl<'m> NWaySolver<'m> {
    /// Prepares a solver; `n` is brought into 1 to [`MOST_WAYS`].
    #[must_use]
    pub fn new(mesh: &'m Mesh, over: Over, n: u32) -> Self {
        let n = n.clamp(1, MOST_WAYS);
        let table = Connection::new(mesh, over);
        let (component, components) = components(&table);
        Self { mesh, n, table, grid: OnceLock::new(), component, components }
    }

    fn grid(&self) -> &Multigrid {
        self.grid.get_or_init(|| {
            let table = &self.table;
            let sums: Vec<f64> = (0..table.len() as u32).map(|i| table.neighbours(i).map(|t| t.weight).sum()).collect();
            let ridge = RIDGE * (sums.iter().sum::<f64>() / sums.len().max(1) as f64).max(f64::MIN_POSITIVE);
            Multigrid::new(Matrix::of_rows(table.len(), table.len(), |i, row| {
                row.push((i, DVec2::new(if sums[i as usize] > 0.0 { sums[i as usize] + ridge } else { 1.0 }, 0.0)));
                row.extend(table.neighbours(i).map(|t| (t.node, -unit(f64::from(self.n) * t.turn) * t.weight)));
            }))
        })
    }

    /// The field for some wishes (empty for none).
    #[must_use]
    pub fn solve(&self, wishes: &[DVec2], options: &NWayOptions, progress: &dyn Progress) -> (NWayField, NWayStatistics) {
        let mut statistics = NWayStatistics::default();
        progress.stage("smoothing directions", 0);
        let mut powers = match options.start {
            Start::Smooth => self.smooth_start(wishes, &mut statistics.iterations),
            Start::Random => random(self.table.len(), options.seed),
        };
        self.relax(&mut powers, wishes, options, &mut statistics);
        if options.start == Start::Smooth && self.n > 1 && wishes.is_empty() && self.mesh.euler_characteristic() == 0 {
            self.try_single(&mut powers, options, &mut statistics, progress);
        }
        let field = NWayField { n: self.n, over: self.table.over, powers };
        let found = self.singularities(&field);
        statistics.singularities = found.len();
        statistics.index_sum = found.iter().map(|s| i64::from(s.parts)).sum();
        (field, statistics)
    }

    /// A field of single directions is one of n ways too. Where the topology asks for no singularity, it may be lower than
    /// what n ways by themselves come to; the lower one is kept.
    fn try_single(&self, powers: &mut Vec<DVec2>, options: &NWayOptions, statistics: &mut NWayStatistics, progress: &dyn Progress) {
        let (single, found) = NWaySolver::new(self.mesh, self.table.over, 1).solve(&[], options, progress);
        let mut other: Vec<DVec2> = single.powers.iter().map(|p| unit(f64::from(self.n) * p.to_angle())).collect();
        let mut attempt = NWayStatistics { iterations: statistics.iterations + found.iterations, ..NWayStatistics::default() };
        self.relax(&mut other, &[], options, &mut attempt);
        let error = |powers: &[DVec2]| energy(&self.table, self.n, powers, &[], Measure::Smooth);
        if error(&other) < error(powers) {
            *powers = other;
            *statistics = attempt;
        }
    }

    fn relax(&self, powers: &mut [DVec2], wishes: &[DVec2], options: &NWayOptions, statistics: &mut NWayStatistics) {
        if options.smooth {
            statistics.smooth_errors = relax::relax(&self.table, self.n, powers, wishes, Measure::Smooth);
        }
        statistics.nearest_errors = if options.nearest {
            relax::relax(&self.table, self.n, powers, wishes, Measure::Nearest)
        } else {
            vec![energy(&self.table, self.n, powers, wishes, Measure::Nearest)]
        };
    }

    /// The singularities of a field over this solver's nodes.
    #[must_use]
    pub fn singularities(&self, field: &NWayField) -> Vec<NWaySingularity> {
        index::singularities(self.mesh, &self.table, self.n, &field.powers)
    }

    /// One of the directions at each node.
    #[must_use]
    pub fn directions(&self, field: &NWayField) -> Vec<DVec3> {
        let one = |(i, p): (usize, &DVec2)| self.table.direction(i as u32, p.to_angle() / f64::from(self.n));
        field.powers.par_iter().enumerate().map(one).collect()
    }

    fn smooth_start(&self, wishes: &[DVec2], iterations: &mut usize) -> Vec<DVec2> {
        let mut wished = vec![false; self.components];
        for (i, wish) in wishes.iter().enumerate() {
            wished[self.component[i] as usize] |= *wish != DVec2::ZERO;
        }
        let mut x = if wished.iter().all(|&w| w) && !wished.is_empty() {
            vec![DVec2::ZERO; self.table.len()]
        } else {
            self.smoothest(iterations)
        };
        if wished.iter().any(|&w| w) {
            let strength: Vec<f64> = wishes.iter().map(|w| w.length()).collect();
            let mut guided = vec![DVec2::ZERO; self.table.len()];
            *iterations += solve(self.grid(), &strength, wishes, &mut guided, TIGHT, ITERATIONS);
            for (i, guided) in guided.into_iter().enumerate() {
                if wished[self.component[i] as usize] {
                    x[i] = guided;
                }
            }
        }
        x.into_iter().map(|p| p.normalize_or(DVec2::X)).collect()
    }

    /// The eigenvector of the smallest eigenvalue, of each component its own, and then fields of unit length everywhere that
    /// diffuse for shorter and shorter times: where the eigenvector fades it leaves pairs of singularities that nothing
    /// needs, and these meet and go.
    fn smoothest(&self, iterations: &mut usize) -> Vec<DVec2> {
        let mean = self.table.area.iter().sum::<f64>() / self.table.len().max(1) as f64;
        let mass: Vec<f64> = self.table.area.iter().map(|a| (a / mean).max(1e-6)).collect();
        let none = vec![0.0; mass.len()];
        let mut x = self.grid().smoothest();
        let mut last = f64::INFINITY;
        for _ in 0..INVERSE {
            self.balance(&mut x, &mass);
            let rhs: Vec<DVec2> = x.iter().zip(&mass).map(|(&x, &m)| x * m).collect();
            let value = inner(&x, &self.grid().matrix().times(&x)).x / inner(&x, &rhs).x;
            if (last - value).abs() <= EIGENVALUE * value {
                break;
            }
            last = value;
            // The answer is about the vector over its eigenvalue.
            x.iter_mut().for_each(|x| *x /= value.max(f64::MIN_POSITIVE));
            *iterations += solve(self.grid(), &none, &rhs, &mut x, LOOSE, ITERATIONS);
        }
        let mut time = DIFFUSION / last.max(1e-9);
        for _ in 0..DIFFUSIONS {
            let hold: Vec<f64> = mass.iter().map(|m| m / time).collect();
            let rhs: Vec<DVec2> = x.iter().zip(&hold).map(|(x, &h)| x.normalize_or(DVec2::X) * h).collect();
            *iterations += solve(self.grid(), &hold, &rhs, &mut x, LOOSE, ITERATIONS);
            time /= 2.0;
        }
        x
    }

    /// Gives every component the same mean length, so that none is lost beside the smoothest.
    fn balance(&self, x: &mut [DVec2], mass: &[f64]) {
        let mut sums = vec![(0.0, 0.0); self.components];
        for (i, x) in x.iter().enumerate() {
            let sum = &mut sums[self.component[i] as usize];
            *sum = (sum.0 + mass[i] * x.length_squared(), sum.1 + mass[i]);
        }
        for (i, x) in x.iter_mut().enumerate() {
            let (squares, weight) = sums[self.component[i] as usize];
            *x = if squares > 0.0 { *x * (weight / squares).sqrt() } else { DVec2::X };
        }
    }
}

/// A random direction at each node.
fn random(nodes: usize, seed: u64) -> Vec<DVec2> {
    let mut random = Random::new(seed, 0xF1E1D);
    (0..nodes).map(|_| unit(random.range(0.0, TAU))).collect()
}

fn components(table: &Connection) -> (Vec<u32>, usize) {
    let mut of = vec![u32::MAX; table.len()];
    let (mut count, mut stack) = (0, Vec::new());
    for seed in 0..table.len() as u32 {
        if of[seed as usize] != u32::MAX {
            continue;
        }
        of[seed as usize] = count;
        stack.push(seed);
        while let Some(i) = stack.pop() {
            for t in table.neighbours(i) {
                if of[t.node as usize] == u32::MAX {
                    of[t.node as usize] = count;
                    stack.push(t.node);
                }
            }
        }
        count += 1;
    }
    (of, count as usize)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;
    use crate::progress::Silent;

    fn falls(errors: &[f64]) -> bool {
        errors.windows(2).all(|w| w[1] <= w[0] * (1.0 + 1e-12) + 1e-20)
    }

    #[test]
    fn indices_sum_to_the_euler_characteristic_and_errors_never_rise() {
        for mesh in [shapes::sphere(3), shapes::torus(24, 14, 1.0, 0.4), shapes::cube(4)] {
            for over in [Over::Vertices, Over::Faces] {
                for n in [1, 2, 3, 4, 6] {
                    let solver = NWaySolver::new(&mesh, over, n);
                    for start in [Start::Smooth, Start::Random] {
                        let options = NWayOptions { start, nearest: true, ..NWayOptions::default() };
                        let (_, s) = solver.solve(&[], &options, &Silent);
                        assert_eq!(s.index_sum, i64::from(n) * mesh.euler_characteristic(), "{over:?} n {n} {start:?}");
                        assert!(falls(&s.smooth_errors) && falls(&s.nearest_errors), "{over:?} n {n} {start:?}: {s:?}");
                    }
                    let (_, noise) =
                        solver.solve(&[], &NWayOptions { start: Start::Random, smooth: false, ..Default::default() }, &Silent);
                    assert_eq!(noise.index_sum, i64::from(n) * mesh.euler_characteristic(), "noise, {over:?} n {n}");
                }
            }
        }
    }

    #[test]
    fn a_torus_has_no_singularity_and_a_sphere_no_more_than_it_must() {
        let (torus, sphere) = (shapes::torus(48, 16, 1.0, 0.25), shapes::sphere(4));
        for over in [Over::Vertices, Over::Faces] {
            for n in [1, 2, 4, 6] {
                let (_, s) = NWaySolver::new(&torus, over, n).solve(&[], &NWayOptions::default(), &Silent);
                assert_eq!(s.singularities, 0, "torus, {over:?}, n {n}");
                let (_, s) = NWaySolver::new(&sphere, over, n).solve(&[], &NWayOptions::default(), &Silent);
                assert_eq!(s.singularities, 2 * n as usize, "sphere, {over:?}, n {n}");
            }
        }
    }

    #[test]
    fn indices_of_faces_agree_with_those_of_plain_fields() {
        let mesh = shapes::sphere(3);
        let solver = NWaySolver::new(&mesh, Over::Faces, 1);
        let (field, _) = solver.solve(&[], &NWayOptions { start: Start::Random, smooth: false, ..Default::default() }, &Silent);
        let up: Vec<glam::Vec3> = solver.directions(&field).iter().map(|d| d.as_vec3()).collect();
        let plain: Vec<(u32, i32)> = crate::field::singularities(&mesh, &up).iter().map(|s| (s.vertex, s.index)).collect();
        let found: Vec<(u32, i32)> = solver.singularities(&field).iter().map(|s| (s.place, s.parts)).collect();
        assert_eq!(found, plain, "noise has many of both signs");
    }

    #[test]
    fn the_smooth_start_is_about_as_low_as_where_relaxation_from_noise_ends_and_relaxed_no_higher() {
        let mesh = shapes::torus(40, 24, 1.0, 0.5);
        for n in [1, 2, 4] {
            let solver = NWaySolver::new(&mesh, Over::Vertices, n);
            let (smooth, _) = solver.solve(&[], &NWayOptions { smooth: false, ..Default::default() }, &Silent);
            let (relaxed, _) = solver.solve(&[], &NWayOptions::default(), &Silent);
            let (noise, _) = solver.solve(&[], &NWayOptions { start: Start::Random, ..Default::default() }, &Silent);
            let error = |f: &NWayField| energy(&solver.table, n, &f.powers, &[], Measure::Smooth);
            let errors = [&smooth, &relaxed, &noise].map(error);
            assert!(errors[0] <= 1.1 * errors[2] && errors[1] <= 1.01 * errors[2], "n {n}: {errors:?}");
        }
    }
}
