//! Where a field turns: per edge, per face, and the vertices around which it makes a full turn.
//!
//! The turn over an edge is the angle between a face's direction, carried over the edge by parallel transport, and the next
//! face's own. Around a vertex these turns and the angle deficit sum to a whole number of full turns, the index (Ray, Vallet,
//! Li, Levy, "N-symmetry direction field design", 2008, sec. 3). On a closed mesh the indices sum to the Euler characteristic:
//! Poincare and Hopf's theorem, which holds here exactly, not only in the limit.

use super::nway::NWaySingularity;
use super::{Guide, TangentField};
use crate::mesh::transport::{across, angle};
use crate::mesh::{Mesh, NONE, prev};
use glam::Vec3;
use rayon::prelude::*;
use serde::Serialize;
use std::f64::consts::{PI, TAU};

/// A vertex around which the direction makes full turns.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct Singularity {
    /// The vertex.
    pub vertex: u32,
    /// How many full turns, counter-clockwise; 1 for a pole, -1 for a saddle.
    pub index: i32,
}

/// Turn over a half-edge in radians, -pi to pi, out of its face into the next; 0 on boundaries. Opposite half-edges have opposite
/// turns.
#[must_use]
pub fn turn(mesh: &Mesh, directions: &[Vec3], h: u32) -> f64 {
    let o = mesh.opposite[h as usize];
    if o == NONE {
        return 0.0;
    }
    // Computed one way only, so that the other is its exact negative even at half a turn.
    let low = h.min(o);
    let (from, to) = (low / 3, mesh.opposite[low as usize] / 3);
    let carried = across(mesh, low, directions[from as usize].as_dvec3()).unwrap_or_default();
    let turn = angle(carried, directions[to as usize].as_dvec3(), mesh.normal(to));
    if low == h { turn } else { -turn }
}

/// The singular vertices of a direction per face, in order. Vertices on a boundary have no index.
#[must_use]
pub fn singularities(mesh: &Mesh, directions: &[Vec3]) -> Vec<Singularity> {
    let first = mesh.vertex_half_edges();
    (0..mesh.vertex_count() as u32)
        .into_par_iter()
        .filter_map(|vertex| {
            let start = first[vertex as usize];
            if start == NONE || mesh.opposite[start as usize] == NONE {
                return None;
            }
            // The turns around the vertex, and the angle that is missing to a flat fan.
            let mut total = TAU;
            for h in mesh.ring(start) {
                total += turn(mesh, directions, prev(h)) - corner(mesh, h);
            }
            let index = (total / TAU).round() as i32;
            (index != 0).then_some(Singularity { vertex, index })
        })
        .collect()
}

/// The vertices around which a field turns, in n-th parts of a full turn where it means `ways` directions. Vertices on a boundary
/// have no index.
#[must_use]
pub fn turning_points(mesh: &Mesh, field: &TangentField) -> Vec<NWaySingularity> {
    if field.ways <= 1 {
        let parts = |s: Singularity| NWaySingularity { place: s.vertex, parts: s.index };
        return singularities(mesh, &field.up).into_iter().map(parts).collect();
    }
    let part = TAU / f64::from(field.ways);
    let first = mesh.vertex_half_edges();
    (0..mesh.vertex_count() as u32)
        .into_par_iter()
        .filter_map(|place| {
            let start = first[place as usize];
            if start == NONE || mesh.opposite[start as usize] == NONE {
                return None;
            }
            let mut total = TAU;
            for h in mesh.ring(start) {
                let turn = turn(mesh, &field.up, prev(h));
                // To the nearest of the next face's directions.
                total += turn - part * (turn / part).round() - corner(mesh, h);
            }
            let parts = (total / part).round() as i32;
            (parts != 0).then_some(NWaySingularity { place, parts })
        })
        .collect()
}

/// The angle of a face at the origin of a half-edge.
fn corner(mesh: &Mesh, h: u32) -> f64 {
    let at = mesh.point(mesh.origin(h));
    let [a, b] = [crate::mesh::next(h), prev(h)].map(|k| mesh.point(mesh.origin(k)) - at);
    a.cross(b).length().atan2(a.dot(b))
}

/// How abruptly the texture changes at each face: the largest turn (radians) or change of scale (natural logarithm) over its
/// edges. Faces of a smooth field on a fine mesh have nearly 0, discontinuities and singularities 1 and more.
#[must_use]
pub fn discontinuity(mesh: &Mesh, guide: &Guide) -> Vec<f32> {
    (0..mesh.face_count() as u32)
        .into_par_iter()
        .map(|f| {
            let mut worst = 0.0_f64;
            for h in 3 * f..3 * f + 3 {
                let o = mesh.opposite[h as usize];
                if o != NONE {
                    let scale = f64::from(guide.scale(o / 3) / guide.scale(f)).ln().abs();
                    let turn = guide.field().map_or(0.0, |field| {
                        let part = TAU / f64::from(field.ways);
                        let turn = turn(mesh, &field.up, h);
                        (turn - part * (turn / part).round()).abs()
                    });
                    worst = worst.max(scale).max(turn);
                }
            }
            worst.min(PI) as f32
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::{isotropic, up};
    use crate::mesh::{shapes, transport::projected};
    use glam::DVec3;

    fn total(mesh: &Mesh, directions: &[Vec3]) -> i64 {
        singularities(mesh, directions).iter().map(|s| i64::from(s.index)).sum()
    }

    #[test]
    fn indices_sum_to_the_euler_characteristic_for_any_field() {
        let mut random = crate::random::Random::new(1, 0);
        for mesh in [shapes::sphere(3), shapes::torus(20, 12, 1.0, 0.4), shapes::cube(4)] {
            for axis in [DVec3::Z, DVec3::new(0.3, 1.0, 0.2)] {
                let (field, _) = up(&mesh, axis, 1.0).expect("a field");
                assert_eq!(total(&mesh, &field.up), mesh.euler_characteristic(), "projected axis {axis}");
            }
            // Even noise turns by whole turns around each vertex.
            let noise: Vec<Vec3> = (0..mesh.face_count() as u32)
                .map(|f| {
                    let any = DVec3::new(random.unit() - 0.5, random.unit() - 0.5, random.unit() - 0.5);
                    projected(any, mesh.normal(f)).normalize().as_vec3()
                })
                .collect();
            assert_eq!(total(&mesh, &noise), mesh.euler_characteristic(), "noise");
        }
    }

    #[test]
    fn poles_have_index_one_and_saddles_minus_one() {
        let mesh = shapes::parametric(9, 9, |x, y| [x - 0.5, y - 0.5, 0.0]);
        let field = |of: fn(DVec3) -> DVec3| -> Vec<Vec3> {
            (0..mesh.face_count() as u32).map(|f| of(mesh.centroid(f) + DVec3::new(0.01, 0.02, 0.0)).as_vec3()).collect()
        };
        let index = |directions: &[Vec3]| singularities(&mesh, directions).iter().map(|s| s.index).collect::<Vec<_>>();
        assert_eq!(index(&field(|p| p)), [1], "pointing away from a middle");
        assert_eq!(index(&field(|p| DVec3::Z.cross(p))), [1], "going round it");
        assert_eq!(index(&field(|p| DVec3::new(p.x, -p.y, 0.0))), [-1], "a saddle");
        assert_eq!(index(&field(|_| DVec3::X)), [] as [i32; 0], "a constant field");
        let dipole = index(&field(|p| DVec3::new(p.x * p.x - p.y * p.y, 2.0 * p.x * p.y, 0.0)));
        assert_eq!(dipole.iter().sum::<i32>(), 2, "two turns around the middle, {dipole:?}");
    }

    #[test]
    fn discontinuity_tells_poles_and_jumps_from_smooth_parts() {
        let mesh = shapes::sphere(4);
        let (field, _) = up(&mesh, DVec3::Z, 1.0).expect("a field");
        let abrupt = discontinuity(&mesh, &Guide::Directed(field));
        for (f, &d) in abrupt.iter().enumerate() {
            let z = mesh.centroid(f as u32).z.abs();
            assert!(z > 0.9 || d < 0.3, "face {f} at height {z}: {d}");
        }
        let at_pole = (0..mesh.face_count()).filter(|&f| mesh.faces[f].contains(&2)).map(|f| abrupt[f]).fold(0.0, f32::max);
        assert!(at_pole > 1.0, "the pole is told: {at_pole}");
        let Ok(Guide::Isotropic { mut scale }) = isotropic(&mesh, 1.0) else { panic!("a scale") };
        scale[0] = 2.0;
        let abrupt = discontinuity(&mesh, &Guide::Isotropic { scale });
        assert!((abrupt[0] - 2.0_f32.ln()).abs() < 1e-6, "a jump of scale: {}", abrupt[0]);
        assert_eq!(abrupt.iter().filter(|&&d| d > 0.0).count(), 4, "the face and its three neighbours");
    }
}
