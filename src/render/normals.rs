//! Smooth normals that respect creases.
//!
//! The faces around a vertex fall into runs between sharp edges, edges over which the surface turns by more than the
//! crease angle. The corners of one run share one normal: the mean of its faces' normals, weighted by their angle at the
//! vertex. A single sharp edge does not cut a closed fan in two, so a crease fades out where it ends.

use crate::mesh::{Mesh, NONE, prev};
use glam::{DVec3, Vec3};
use rayon::prelude::*;

/// The crease angle between [`LEAST_CREASE`] and [`MOST_CREASE`] that suits a mesh: three times the turn of its median edge,
/// since a coarse model of a smooth body turns at all its edges, a machine part only at its creases.
#[must_use]
pub fn crease_angle(mesh: &Mesh) -> f64 {
    let turn = |(h, &o): (usize, &u32)| {
        let (f, g) = (h as u32 / 3, o / 3);
        (o != NONE && f < g).then(|| mesh.normal(f).dot(mesh.normal(g)).clamp(-1.0, 1.0).acos())
    };
    let mut turns: Vec<f64> = mesh.opposite.par_iter().enumerate().filter_map(turn).collect();
    if turns.is_empty() {
        return LEAST_CREASE;
    }
    let middle = turns.len() / 2;
    let median = *turns.select_nth_unstable_by(middle, f64::total_cmp).1;
    (3.0 * median).clamp(LEAST_CREASE, MOST_CREASE)
}

/// Edges that turn less than 40 degrees are never creases.
pub const LEAST_CREASE: f64 = 40.0 * std::f64::consts::PI / 180.0;
/// Edges that turn more than 65 degrees always are.
pub const MOST_CREASE: f64 = 65.0 * std::f64::consts::PI / 180.0;

/// Unit normals at the three corners of each face. `crease` is the largest angle, in radians, that is smoothed over.
#[must_use]
pub fn corner_normals(mesh: &Mesh, crease: f64) -> Vec<[Vec3; 3]> {
    let flat: Vec<Vec3> = (0..mesh.face_count() as u32).into_par_iter().map(|f| mesh.normal(f).as_vec3()).collect();
    let mut normals: Vec<[Vec3; 3]> = flat.iter().map(|&n| [n; 3]).collect();
    let least_cosine = crease.clamp(0.0, std::f64::consts::PI).cos() as f32;
    let sharp = |h: u32, o: u32| flat[(h / 3) as usize].dot(flat[(o / 3) as usize]) < least_cosine;
    let mut ring: Vec<u32> = Vec::new();
    for start in mesh.vertex_half_edges() {
        ring.clear();
        ring.extend(mesh.ring(start));
        // Whether the edge between a corner and the one after it cuts.
        let cuts = |h: u32| {
            let edge = prev(h);
            let o = mesh.opposite[edge as usize];
            o == NONE || sharp(edge, o)
        };
        // Begin behind a cut, so that no run goes over the end.
        if let Some(last) = ring.iter().position(|&h| cuts(h)) {
            ring.rotate_left(last + 1);
        }
        for run in ring.chunk_by(|&h, _| !cuts(h)) {
            let sum: DVec3 = run.iter().map(|&h| weighted(mesh, h, flat[(h / 3) as usize])).sum();
            let mean = sum.normalize_or_zero().as_vec3();
            // Opposite faces may cancel out; then the flat normals stay.
            if mean != Vec3::ZERO {
                for &h in run {
                    normals[(h / 3) as usize][(h % 3) as usize] = mean;
                }
            }
        }
    }
    normals
}

/// A face's normal weighted by its angle at the corner where a half-edge starts.
fn weighted(mesh: &Mesh, h: u32, normal: Vec3) -> DVec3 {
    let corners = mesh.corners(h / 3);
    let k = (h % 3) as usize;
    let (a, b) = (corners[(k + 1) % 3] - corners[k], corners[(k + 2) % 3] - corners[k]);
    normal.as_dvec3() * a.cross(b).length().atan2(a.dot(b))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An octahedron-like fan: `n` faces around a tip, rising at `slope`, closed below by a second tip.
    fn double_cone(n: u32, slope: f32) -> Mesh {
        let mut positions = vec![Vec3::new(0.0, slope, 0.0), Vec3::new(0.0, -slope, 0.0)];
        let mut faces = Vec::new();
        for i in 0..n {
            let angle = std::f32::consts::TAU * i as f32 / n as f32;
            positions.push(Vec3::new(angle.sin(), 0.0, angle.cos()));
            let (a, b) = (2 + i, 2 + (i + 1) % n);
            faces.extend([[0, a, b], [1, b, a]]);
        }
        Mesh::new(positions, faces).unwrap()
    }

    #[test]
    fn a_crease_parts_normals_and_a_smooth_edge_joins_them() {
        // The rim turns by 2 atan(2) = 127 degrees, the cones themselves by little.
        let mesh = double_cone(24, 2.0);
        let normals = corner_normals(&mesh, 0.7);
        let (upper, lower) = (normals[0][1], normals[1][2]);
        assert_eq!(mesh.faces[0][1], mesh.faces[1][2], "both corners are at one rim vertex");
        assert!(upper.y > 0.3 && lower.y < -0.3, "the rim is sharp: {upper} {lower}");
        assert!((normals[0][2] - normals[2][1]).length() < 1e-6, "neighbours on the cone share their normal");
        let smooth = corner_normals(&mesh, 3.0);
        assert!(smooth[0][1].y.abs() < 1e-5, "smoothed over, the rim's normal is horizontal");
        assert_eq!(smooth[0][1], smooth[1][2], "and shared");
    }

    #[test]
    fn a_coarse_round_body_gets_a_wider_angle_than_a_box() {
        // Twelve sides turn by 30 degrees each; a fine cone hardly at all but at its rim.
        assert!(crease_angle(&double_cone(200, 2.0)) <= LEAST_CREASE, "fine");
        let coarse = double_cone(10, 4.0);
        assert!(crease_angle(&coarse) > LEAST_CREASE, "coarse: {}", crease_angle(&coarse).to_degrees());
    }

    #[test]
    fn every_normal_is_unit_and_without_creases_they_are_the_vertex_normals() {
        let mesh = double_cone(7, 0.4);
        let expected = mesh.vertex_normals();
        let smooth = corner_normals(&mesh, std::f64::consts::PI);
        for (f, corners) in mesh.faces.iter().enumerate() {
            for k in 0..3 {
                let difference = smooth[f][k] - expected[corners[k] as usize];
                assert!(difference.length() < 1e-5, "face {f} corner {k}");
            }
        }
        let flat = corner_normals(&mesh, 0.0);
        for (f, n) in flat.iter().enumerate() {
            assert!(n.iter().all(|n| (*n - mesh.normal(f as u32).as_vec3()).length() < 1e-5), "face {f} stays flat");
        }
    }
}
