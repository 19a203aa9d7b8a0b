//! Walking straight over the surface.
//!
//! A step is taken in the plane of the face; where it leaves the face it goes on in the next one as if the two were hinged
//! flat at their common edge (Polthier, Schmies, "Straightest geodesics on polyhedral surfaces", 1998). It ends at a boundary.
//!
//! The step is held as a change of barycentric coordinates, sum zero. A hinge says how such a change goes on beyond an edge,
//! in two numbers, so that a walk needs no positions on its way. [`walk`] finds hinges as it meets them; a [`Walker`] keeps those
//! of a whole mesh, for many walks.

use super::{Mesh, NONE, SurfacePoint};
use glam::DVec3;
use rayon::prelude::*;

/// Faces a step may cross. Steps are a few edges long; a walk that goes round and round a vertex through faces of no width
/// ends where it is.
const MOST_FACES: usize = 4096;

/// How a change of barycentric coordinates goes on in the face beyond a half-edge, the two faces hinged flat.
///
/// With the edge from `u` to `v`, both faces lie in a plane: `v` at `(l, 0)`, the third vertex of this face at `(x, y)`, that of
/// the other at `(s, t)`, `u` at the origin. A way `w` of this face is the vector `w_third (x, y) + w_v (l, 0)`, and the same
/// vector beyond is `w'_third (s, t) + w'_v (l, 0)`.
#[derive(Debug, Clone, Copy)]
struct Hinge {
    /// `w'_third` for each `w_third`: `y / t`, negative.
    third: f64,
    /// What `w'_v` has more than `w_v` for each `w_third`.
    shear: f64,
}

impl Hinge {
    /// The hinge at half-edge `h`. `None` at a boundary, and where the edge or the face beyond has no extent.
    fn new(mesh: &Mesh, h: u32) -> Option<Self> {
        let o = mesh.opposite[h as usize];
        if o == NONE {
            return None;
        }
        let corner = |h: u32, k: u32| mesh.point(mesh.faces[(h / 3) as usize][((h + k) % 3) as usize]);
        let (u, v) = (corner(h, 0), corner(h, 1));
        let length = u.distance(v);
        let along = (v - u) / length;
        let flat = |p: DVec3| {
            let x = (p - u).dot(along);
            [x, (p - u - along * x).length()]
        };
        let ([x, y], [s, t]) = (flat(corner(h, 2)), flat(corner(o, 2)));
        let third = -y / t;
        let shear = (x - third * s) / length;
        (third.is_finite() && shear.is_finite()).then_some(Self { third, shear })
    }
}

/// The hinges of a mesh.
#[derive(Debug, Clone)]
pub struct Walker<'a> {
    mesh: &'a Mesh,
    /// By half-edge.
    hinges: Vec<Option<Hinge>>,
}

impl<'a> Walker<'a> {
    /// Finds the hinges; linear in the faces, 72 bytes for each.
    #[must_use]
    pub fn new(mesh: &'a Mesh) -> Self {
        let hinges = (0..3 * mesh.face_count() as u32).into_par_iter().map(|h| Hinge::new(mesh, h)).collect();
        Self { mesh, hinges }
    }

    /// The mesh.
    #[must_use]
    pub const fn mesh(&self) -> &'a Mesh {
        self.mesh
    }

    /// As [`walk`].
    #[must_use]
    pub fn walk(&self, from: SurfacePoint, step: DVec3) -> SurfacePoint {
        go(self.mesh, from, step, |h| self.hinges[h as usize])
    }
}

/// Where a step of a vector in the plane of the face of `from` leads. The length of the way is the vector's length, less
/// what lies beyond a boundary.
#[must_use]
pub fn walk(mesh: &Mesh, from: SurfacePoint, step: DVec3) -> SurfacePoint {
    go(mesh, from, step, |h| Hinge::new(mesh, h))
}

fn go(mesh: &Mesh, from: SurfacePoint, step: DVec3, hinge: impl Fn(u32) -> Option<Hinge>) -> SurfacePoint {
    let (mut face, mut bary) = (from.face, from.bary.as_dvec3());
    let [a, b, c] = mesh.corners(face);
    let normal = (b - a).cross(c - a);
    let square = normal.length_squared();
    if !(square > 0.0) || !step.is_finite() {
        return from;
    }
    let y = step.cross(c - a).dot(normal) / square;
    let z = (b - a).cross(step).dot(normal) / square;
    let mut way = DVec3::new(-y - z, y, z);
    for _ in 0..MOST_FACES {
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
        // The edge runs from corner k + 1 to corner k + 2.
        let (from, to) = ((k + 1) % 3, (k + 2) % 3);
        let h = 3 * face + from as u32;
        let Some(Hinge { third, shear }) = hinge(h) else { break };
        let o = mesh.opposite[h as usize];
        // Beyond, the same edge runs the other way, from `to` to `from`.
        let [start, end, apex] = [0, 1, 2].map(|i| ((o + i) % 3) as usize);
        let (left, mut beyond, mut there) = (way * (1.0 - reached), DVec3::ZERO, DVec3::ZERO);
        beyond[start] = bary[to];
        beyond[end] = bary[from];
        there[apex] = third * left[k];
        there[start] = left[to] + shear * left[k];
        there[end] = -there[apex] - there[start];
        (face, bary, way) = (o / 3, beyond, there);
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
    fn kept_hinges_lead_where_hinges_found_on_the_way_lead() {
        let mesh = shapes::parametric(30, 30, |u, v| [3.0 * u, 3.0 * v, (5.0 * u).sin() * (7.0 * v).cos()]);
        let walker = Walker::new(&mesh);
        let mut random = Random::new(5, 0);
        for _ in 0..500 {
            let face = random.below(mesh.face_count() as u64) as u32;
            let from = SurfacePoint { face, bary: Vec3::new(0.2, 0.3, 0.5) };
            let step = mesh.normal(face).any_orthonormal_vector() * random.range(0.0, 2.0);
            assert_eq!(walker.walk(from, step), walk(&mesh, from, step));
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
