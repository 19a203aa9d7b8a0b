//! How even a mesh is.

use crate::mesh::{Mesh, NONE, next};
use glam::DVec3;
use serde::Serialize;

/// A face whose area is below this share of its longest edge squared has no width.
const NO_WIDTH: f64 = 1e-6;

/// Edges, angles and valences of a mesh.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct Evenness {
    /// Mean edge length, world units.
    pub mean_edge: f64,
    /// Standard deviation of the edge lengths over their mean.
    pub edge_variation: f64,
    /// Smallest angle, degrees.
    pub least_angle: f64,
    /// The angle below which one face in twenty has its smallest, degrees.
    pub low_angle: f64,
    /// Mean of the faces' smallest angles, degrees.
    pub mean_least_angle: f64,
    /// Inner vertices by their number of neighbours: fewer than 5, 5, 6, 7, more than 7.
    pub valence: [usize; 5],
    /// Faces without width.
    pub degenerate_faces: usize,
    /// Edges over which the surface folds back upon itself (by more than 150 degrees).
    pub folded_edges: usize,
}

/// Measures a mesh.
#[must_use]
pub fn evenness(mesh: &Mesh) -> Evenness {
    let mut out = Evenness::default();
    let (mut sum, mut squares, mut edges) = (0.0, 0.0, 0.0);
    let mut valence = vec![0_u32; mesh.vertex_count()];
    let mut inner = vec![true; mesh.vertex_count()];
    for h in 0..mesh.opposite.len() as u32 {
        let (a, b) = (mesh.origin(h), mesh.origin(next(h)));
        valence[a as usize] += 1;
        let o = mesh.opposite[h as usize];
        if o == NONE {
            inner[a as usize] = false;
            inner[b as usize] = false;
        } else if o < h {
            continue;
        } else if mesh.normal(h / 3).dot(mesh.normal(o / 3)) < -(3_f64.sqrt()) / 2.0 {
            out.folded_edges += 1;
        }
        let length = mesh.point(a).distance(mesh.point(b));
        sum += length;
        squares += length * length;
        edges += 1.0;
    }
    out.mean_edge = sum / edges;
    out.edge_variation = (squares / edges - out.mean_edge * out.mean_edge).max(0.0).sqrt() / out.mean_edge;
    for (v, &n) in valence.iter().enumerate().filter(|&(v, &n)| inner[v] && n > 0) {
        debug_assert!(inner[v], "an inner vertex");
        out.valence[(n.clamp(4, 8) - 4) as usize] += 1;
    }
    let mut least: Vec<f64> = Vec::with_capacity(mesh.face_count());
    for f in 0..mesh.face_count() as u32 {
        let p = mesh.corners(f);
        let longest = (0..3).map(|k| p[k].distance_squared(p[(k + 1) % 3])).fold(0.0, f64::max);
        out.degenerate_faces += usize::from(!(2.0 * mesh.area(f) > NO_WIDTH * longest));
        let angle = |k: usize| {
            let (a, b): (DVec3, DVec3) = (p[(k + 1) % 3] - p[k], p[(k + 2) % 3] - p[k]);
            a.cross(b).length().atan2(a.dot(b)).to_degrees()
        };
        least.push(angle(0).min(angle(1)).min(angle(2)));
    }
    out.mean_least_angle = least.iter().sum::<f64>() / least.len() as f64;
    least.sort_unstable_by(f64::total_cmp);
    out.least_angle = least[0];
    out.low_angle = least[least.len() / 20];
    out
}
