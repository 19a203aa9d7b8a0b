//! Where a result does not look like its exemplar: the error of coherence, point by point.

use super::patches::{Known, PATCH};
use super::pieces::{ByArea, Placed, around};
use crate::mesh::{Mesh, SurfacePoint};
use crate::numeric::kd::KdTree;
use crate::numeric::rows::Rows;
use glam::DVec3;

/// Points at which the error is known.
const POINTS: usize = 5000;
/// Leaves of the tree over these that are looked at; a few are as good as all.
const LEAVES: usize = 6;
/// The points with the largest errors: one in so many.
const WORST: usize = 50;

/// The error at points spread over a surface.
#[derive(Debug, Clone)]
pub struct ErrorMap {
    /// The points.
    pub points: Vec<SurfacePoint>,
    /// At each the distance from the patch around it to the nearest of the exemplar, colour steps (root mean square; 0 to 1).
    pub errors: Vec<f64>,
    tree: KdTree,
    /// The middle of the mesh and its size, which bring positions to about 1.
    middle: DVec3,
    size: f64,
}

impl ErrorMap {
    /// Measures a texture.
    #[must_use]
    pub fn new(at: &Placed, known: &Known, seed: u64) -> Self {
        let points = ByArea::new(at.on.mesh()).points(POINTS, seed);
        let errors = known.distances(&around(at, PATCH, &points).middles(PATCH));
        let (low, high) = at.on.mesh().bounds();
        let middle = (low.as_dvec3() + high.as_dvec3()) * 0.5;
        let size = (high.as_dvec3() - low.as_dvec3()).max_element().max(f64::MIN_POSITIVE);
        let mut rows = Rows::new(3);
        for &p in &points {
            rows.push(&((at.on.mesh().position(p) - middle) / size).as_vec3().to_array());
        }
        Self { points, errors, tree: KdTree::new(&rows), middle, size }
    }

    /// The error at the nearest point that was measured.
    #[must_use]
    pub fn near(&self, position: DVec3) -> Option<f64> {
        let query = ((position - self.middle) / self.size).as_vec3().to_array();
        let (found, _) = self.tree.finder().nearest(&query, LEAVES, f32::INFINITY)?;
        self.errors.get(found as usize).copied()
    }

    /// The point with the largest error: of the largest hundredths the one
    /// with most of the others `within` a distance of it, so that a single odd patch is not the worst.
    #[must_use]
    pub fn worst(&self, mesh: &Mesh, within: f64) -> Option<super::Extreme> {
        let mut order: Vec<usize> = (0..self.errors.len()).collect();
        order.sort_by(|&a, &b| self.errors[b].total_cmp(&self.errors[a]).then(a.cmp(&b)));
        let worst: Vec<(usize, DVec3)> =
            order.into_iter().take(self.errors.len().div_ceil(WORST)).map(|i| (i, mesh.position(self.points[i]))).collect();
        let around = |&(_, p): &(usize, DVec3)| -> f64 {
            worst.iter().filter(|(_, q)| p.distance(*q) <= within).map(|(j, _)| self.errors[*j]).sum()
        };
        let sums: Vec<f64> = worst.iter().map(around).collect();
        let most = (0..sums.len()).fold(None, |most: Option<usize>, i| match most {
            Some(m) if sums[m] >= sums[i] => most,
            _ => Some(i),
        })?;
        let (i, _) = worst[most];
        Some(super::Extreme { at: self.points[i], value: self.errors[i] })
    }
}
