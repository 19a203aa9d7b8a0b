//! Walking straight over the surface.
//!
//! A step is taken in the plane of the face; where it leaves the face it goes on in the next one as if the two were hinged
//! flat at their common edge (Polthier, Schmies, "Straightest geodesics on polyhedral surfaces", 1998). It ends at a boundary.

use super::transport::across;
use super::{Mesh, NONE, SurfacePoint};
use glam::DVec3;

/// Faces a step may cross. Steps are a few edges long; a walk that goes round and round a vertex through faces of no width
/// ends where it is.
const MOST_FACES: usize = 4096;

/// Where a step of a vector in the plane of the face of `from` leads. The length of the way is the vector's length, less
/// what lies beyond a boundary.
#[must_use]
pub fn walk(mesh: &Mesh, from: SurfacePoint, step: DVec3) -> SurfacePoint {
    let (mut face, mut bary, mut step) = (from.face, from.bary.as_dvec3(), step);
    for _ in 0..MOST_FACES {
        let [a, b, c] = mesh.corners(face);
        let normal = (b - a).cross(c - a);
        let square = normal.length_squared();
        if !(square > 0.0) || !step.is_finite() {
            break;
        }
        let y = step.cross(c - a).dot(normal) / square;
        let z = (b - a).cross(step).dot(normal) / square;
        let way = DVec3::new(-y - z, y, z);
        // The first side that the step reaches: there a coordinate falls to zero.
        let (mut reached, mut side) = (1.0, None);
        for k in 0..3 {
            if way[k] < 0.0 && -bary[k] / way[k] < reached {
                reached = (-bary[k] / way[k]).max(0.0);
                side = Some(k);
            }
        }
        bary += way * reached;
        let Some(k) = side else { break };
        bary[k] = 0.0;
        let h = 3 * face + (k as u32 + 1) % 3;
        let o = mesh.opposite[h as usize];
        let Some(carried) = across(mesh, h, step * (1.0 - reached)) else { break };
        let mut beyond = DVec3::ZERO;
        beyond[(o % 3) as usize] = bary[(k + 2) % 3];
        beyond[((o + 1) % 3) as usize] = bary[(k + 1) % 3];
        (face, bary, step) = (o / 3, beyond, carried);
    }
    let bary = bary.max(DVec3::ZERO);
    SurfacePoint { face, bary: (bary / bary.element_sum()).as_vec3() }
}

/// The surface point at a vertex, from a half-edge that starts there.
#[must_use]
pub fn at_origin(h: u32) -> SurfacePoint {
    debug_assert_ne!(h, NONE, "a half-edge");
    let mut bary = glam::Vec3::ZERO;
    bary[(h % 3) as usize] = 1.0;
    SurfacePoint { face: h / 3, bary }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;
    use crate::random::Random;
    use glam::Vec3;

    #[test]
    fn on_a_plane_a_step_is_a_step() {
        let mesh = shapes::uneven_square(20);
        let mut random = Random::new(3, 0);
        for _ in 0..500 {
            let face = random.below(mesh.face_count() as u64) as u32;
            let from = SurfacePoint { face, bary: Vec3::splat(1.0 / 3.0) };
            let start = mesh.position(from);
            let goal = DVec3::new(random.range(0.01, 0.99), random.range(0.01, 0.99), 0.0);
            let there = mesh.position(walk(&mesh, from, goal - start));
            assert!(there.distance(goal) < 1e-6, "from {start} to {there} for {goal}");
        }
    }

    #[test]
    fn a_step_ends_at_the_boundary() {
        let mesh = shapes::uneven_square(10);
        let from = SurfacePoint { face: 87, bary: Vec3::splat(1.0 / 3.0) };
        let start = mesh.position(from);
        let there = mesh.position(walk(&mesh, from, DVec3::X * 5.0));
        assert!(there.distance(DVec3::new(1.0, start.y, 0.0)) < 1e-6, "{start} ended at {there}");
    }

    #[test]
    fn once_round_a_cylinder_leads_back() {
        let mesh = shapes::parametric(40, 20, |u, v| {
            let a = u * std::f64::consts::TAU;
            [a.cos(), a.sin(), 4.0 * v]
        });
        let round: f64 = 40.0 * 2.0 * (std::f64::consts::PI / 40.0).sin();
        for face in (0..mesh.face_count() as u32).step_by(53) {
            let from = SurfacePoint { face, bary: Vec3::new(0.5, 0.3, 0.2) };
            let along = DVec3::Z.cross(mesh.normal(face)) * -round;
            let there = mesh.position(walk(&mesh, from, along));
            assert!(there.distance(mesh.position(from)) < 1e-5, "face {face}: {there} for {}", mesh.position(from));
        }
    }
}
