//! Evening out a tangent vector per face over a length.
//!
//! A direction projected onto noisy faces is noisy, and where the axis is nearly square to the surface (the base and the
//! back of a scan) it is nothing but noise; pastes grown along it fall to slivers. Given directions d and how sure each is,
//! c from 0 to 1, we look for the field z that minimises the integral of `c^2 |z - d|^2 + l^2 |grad z|^2`: where directions
//! are sure it keeps them but for what is smaller than l, and where they are not it continues the smoothest way from where
//! they are.
//!
//! 1. A frame in each face; a rotation per half-edge carries the neighbour's vector over their common edge.
//! 2. Finite volumes on the faces: the flow over an edge is its length over the distance of the two faces' centroids from it.
//! 3. Conjugate gradients on the Hermitian system, each unknown a complex number.

use crate::mesh::{Mesh, NONE};
use crate::numeric::{CgOptions, Pair, Preconditioner, Stop, solve};
use glam::{DVec2, DVec3};
use rayon::prelude::*;

/// The least sureness that counts, so that the system stays regular where nothing is sure at all.
const LEAST_SURE: f64 = 0.01;

/// Residual against the right-hand side. The right-hand side is small where directions are not sure, and with it what
/// this leaves: a hundredth of the vectors' length is below what an eye or a fit can tell.
const TOLERANCE: f64 = 1e-3;

/// Iterations grow with l over the size of a face. News travels one face in each: where nothing is sure over more faces than
/// this, their middle keeps what it had, evened out over as many.
const MAX_ITERATIONS: usize = 80;

/// Per face, in its own plane, the vectors evened out over `length` (world units). A given vector's direction is the one
/// wanted, its length (at most 1) how sure that is. Vectors found are near 1 long where directions around agree, and short
/// where they cancel.
#[must_use]
pub fn steady(mesh: &Mesh, vectors: &[DVec3], length: f64) -> Vec<DVec3> {
    let faces = 0..mesh.face_count() as u32;
    let frames: Vec<[DVec3; 2]> = faces
        .clone()
        .into_par_iter()
        .map(|f| {
            let [a, b, _] = mesh.corners(f);
            let x = (b - a).normalize_or_zero();
            [x, mesh.normal(f).cross(x)]
        })
        .collect();
    let local = |f: u32, v: DVec3| DVec2::new(frames[f as usize][0].dot(v), frames[f as usize][1].dot(v));
    // The vector beyond half-edge h counts as `flow[h]` times it, a rotation and a weight in one.
    let flow: Vec<DVec2> = (0..mesh.opposite.len() as u32)
        .into_par_iter()
        .map(|h| match mesh.opposite[h as usize] {
            NONE => DVec2::ZERO,
            o => {
                let edge = mesh.point(mesh.origin(o)) - mesh.point(mesh.origin(h));
                let (here, there) = (local(h / 3, edge), local(o / 3, edge));
                // A centroid lies a third of the height over the edge, which is 2/3 of the area over the edge's length.
                let weight = 1.5 * edge.length_squared() / (mesh.area(h / 3) + mesh.area(o / 3));
                // Here divided by there, as complex numbers of one length.
                weight * DVec2::new(there.x, -there.y).rotate(here).normalize_or_zero()
            }
        })
        .collect();
    let sure = |f: u32| vectors[f as usize].length().clamp(LEAST_SURE, 1.0);
    let keep: Vec<f64> = faces.clone().into_par_iter().map(|f| sure(f) * sure(f) * mesh.area(f) / (length * length)).collect();
    let diagonal: Vec<f64> =
        (0..mesh.face_count()).map(|f| keep[f] + flow[3 * f..3 * f + 3].iter().map(|w| w.length()).sum::<f64>()).collect();
    let row = |f: usize, z: &[Pair]| {
        let mut sum = diagonal[f] * DVec2::from(z[f]);
        for h in 3 * f..3 * f + 3 {
            let o = mesh.opposite[h];
            if o != NONE {
                sum -= flow[h].rotate(DVec2::from(z[o as usize / 3]));
            }
        }
        sum.to_array()
    };
    let product = |z: &[Pair], out: &mut [Pair]| out.par_iter_mut().enumerate().for_each(|(f, out)| *out = row(f, z));
    let mut z: Vec<Pair> = faces.clone().map(|f| (local(f, vectors[f as usize]) / sure(f)).to_array()).collect();
    let rhs: Vec<Pair> = z.iter().zip(&keep).map(|(z, k)| [z[0] * k, z[1] * k]).collect();
    let mut inverse = Inverse(diagonal.iter().map(|d| 1.0 / d).collect());
    let options = CgOptions { stop: Stop::Residual(TOLERANCE), max_iterations: MAX_ITERATIONS, coupled: true };
    solve(product, &rhs, &mut z, &mut inverse, options);
    faces.map(|f| frames[f as usize][0] * z[f as usize][0] + frames[f as usize][1] * z[f as usize][1]).collect()
}

/// Inverse diagonal.
struct Inverse(Vec<f64>);

impl Preconditioner for Inverse {
    fn apply(&mut self, residual: &[Pair], out: &mut [Pair]) {
        for ((out, r), d) in out.iter_mut().zip(residual).zip(&self.0) {
            *out = [r[0] * d, r[1] * d];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes::cube;
    use glam::Vec3;

    /// A square of 2 n^2 triangles over [0, 1]^2.
    fn square(n: usize) -> Mesh {
        let p = (0..=n).flat_map(|y| (0..=n).map(move |x| Vec3::new(x as f32, y as f32, 0.0) / n as f32)).collect();
        let v = |x: usize, y: usize| (y * (n + 1) + x) as u32;
        let faces = (0..n)
            .flat_map(|y| (0..n).map(move |x| (x, y)))
            .flat_map(|(x, y)| [[v(x, y), v(x + 1, y), v(x, y + 1)], [v(x + 1, y + 1), v(x, y + 1), v(x + 1, y)]])
            .collect();
        Mesh::new(p, faces).expect("a square")
    }

    #[test]
    fn a_turning_field_keeps_its_directions_and_shrinks_as_the_screened_equation_says() {
        let mesh = square(64);
        let (length, turns) = (0.05, std::f64::consts::TAU * 2.0);
        let given: Vec<DVec3> = (0..mesh.face_count() as u32)
            .map(|f| {
                let (sin, cos) = (turns * mesh.centroid(f).x).sin_cos();
                DVec3::new(cos, sin, 0.0)
            })
            .collect();
        let found = steady(&mesh, &given, length);
        let shrink = 1.0 / (1.0 + (length * turns).powi(2));
        for f in 0..mesh.face_count() as u32 {
            // Nothing flows over the border, where a turning field would have it otherwise; five lengths inside that is over.
            let inside = |at: f64| (0.25..0.75).contains(&at);
            if inside(mesh.centroid(f).x) && inside(mesh.centroid(f).y) {
                let (given, found) = (given[f as usize], found[f as usize]);
                assert!(given.angle_between(found) < 0.05, "face {f} turned by {}", given.angle_between(found));
                // Finite volumes on right triangles flow an eighth less than they should.
                assert!((found.length() - shrink).abs() < 0.05, "face {f} keeps {}, expected {shrink}", found.length());
            }
        }
    }

    #[test]
    fn what_is_not_sure_continues_what_is() {
        let mesh = square(32);
        // The middle third says nothing or nonsense, as on top of a hill.
        let middle = |f: u32| (0.33..0.66).contains(&mesh.centroid(f).x);
        let given: Vec<DVec3> = (0..mesh.face_count() as u32)
            .map(|f| match (middle(f), f % 2) {
                (false, _) => DVec3::new(0.6, 0.8, 0.0),
                (true, 0) => DVec3::new(0.0, -0.02, 0.0),
                (true, _) => DVec3::ZERO,
            })
            .collect();
        for (f, v) in steady(&mesh, &given, 0.1).iter().enumerate() {
            assert!(v.angle_between(DVec3::new(0.6, 0.8, 0.0)) < 0.02 && v.length() > 0.9, "face {f}: {v}");
        }
    }

    #[test]
    fn a_field_that_is_parallel_over_edges_stays_as_it_is() {
        let mesh = square(8);
        let given = vec![DVec3::new(0.6, 0.8, 0.0); mesh.face_count()];
        for (f, v) in steady(&mesh, &given, 0.3).iter().enumerate() {
            assert!((*v - given[f]).length() < 1e-9, "face {f}: {v}");
        }
    }

    #[test]
    fn evening_out_over_less_than_a_face_changes_nothing() {
        let mesh = cube(2);
        let given: Vec<DVec3> = (0..mesh.face_count() as u32)
            .map(|f| DVec3::new(0.3, 1.0, 0.2).reject_from_normalized(mesh.normal(f)).normalize())
            .collect();
        for (f, v) in steady(&mesh, &given, 1e-3).iter().enumerate() {
            assert!((*v - given[f]).length() < 1e-2, "face {f}: {v} for {}", given[f]);
        }
    }
}
