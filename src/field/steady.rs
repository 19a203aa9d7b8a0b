//! Evening out a tangent vector per face over a length.
//!
//! A direction projected onto noisy faces is noisy, and where the axis is nearly square to the surface (the base and the
//! back of a scan) it is nothing but noise; pastes grown along it fall to slivers. We look for the field z that stays
//! near the given vectors p and varies little over a length l: `z - l^2 Laplace(z) = p`, with the connection Laplacian
//! on the dual graph. Vectors keep their lengths, so that faces on which the projection is long speak louder.
//!
//! 1. A frame in each face; a rotation per half-edge carries the neighbour's vector over their common edge.
//! 2. Conjugate gradients on the Hermitian system, each unknown a complex number.

use crate::mesh::{Mesh, NONE};
use crate::numeric::{CgOptions, Pair, Preconditioner, solve};
use glam::{DVec2, DVec3};
use rayon::prelude::*;

/// The sum of differences to a triangle's three neighbours is this share of its area times the Laplacian, on a lattice
/// of equilateral triangles.
const DUAL_LAPLACIAN: f64 = 0.577;

/// A hundredth of the vectors' length is below what an eye or a fit can tell.
const TOLERANCE: f64 = 1e-2;

/// Iterations grow with l over the size of a face; 60 serve a million faces at ordinary scales.
const MAX_ITERATIONS: usize = 200;

/// Per face, in its own frame, the vectors evened out over `length` (world units).
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
    let carry: Vec<DVec2> = (0..mesh.opposite.len() as u32)
        .into_par_iter()
        .map(|h| match mesh.opposite[h as usize] {
            NONE => DVec2::ZERO,
            o => {
                let edge = mesh.point(mesh.origin(o)) - mesh.point(mesh.origin(h));
                let (here, there) = (local(h / 3, edge), local(o / 3, edge));
                // Here divided by there, as complex numbers of one length.
                DVec2::new(there.x, -there.y).rotate(here).normalize_or_zero()
            }
        })
        .collect();
    let keep: Vec<f64> = faces.clone().into_par_iter().map(|f| DUAL_LAPLACIAN * mesh.area(f) / (length * length)).collect();
    let row = |f: usize, z: &[Pair]| {
        let mut sum = keep[f] * DVec2::from(z[f]);
        for h in 3 * f..3 * f + 3 {
            let o = mesh.opposite[h];
            if o != NONE {
                sum += DVec2::from(z[f]) - carry[h].rotate(DVec2::from(z[o as usize / 3]));
            }
        }
        sum.to_array()
    };
    let product = |z: &[Pair], out: &mut [Pair]| out.par_iter_mut().enumerate().for_each(|(f, out)| *out = row(f, z));
    let mut z: Vec<Pair> = faces.clone().map(|f| local(f, vectors[f as usize]).to_array()).collect();
    let rhs: Vec<Pair> = z.iter().zip(&keep).map(|(z, k)| [z[0] * k, z[1] * k]).collect();
    let mut diagonal = Diagonal(
        faces
            .clone()
            .map(|f| {
                let beside = (0..3).filter(|&k| mesh.neighbour(f, k) != NONE).count();
                1.0 / (beside as f64 + keep[f as usize])
            })
            .collect(),
    );
    let options = CgOptions { tolerance: TOLERANCE, max_iterations: MAX_ITERATIONS, coupled: true };
    solve(product, &rhs, &mut z, &mut diagonal, options);
    faces.map(|f| frames[f as usize][0] * z[f as usize][0] + frames[f as usize][1] * z[f as usize][1]).collect()
}

/// Inverse diagonal.
struct Diagonal(Vec<f64>);

impl Preconditioner for Diagonal {
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
    fn a_wave_shrinks_as_the_screened_equation_says() {
        let mesh = square(64);
        let (length, wave) = (0.05, std::f64::consts::TAU * 2.0);
        let given: Vec<DVec3> = (0..mesh.face_count() as u32).map(|f| DVec3::Y * (wave * mesh.centroid(f).x).cos()).collect();
        let found = steady(&mesh, &given, length);
        let shrink = 1.0 / (1.0 + (length * wave).powi(2));
        // As a whole: the dual graph of right triangles is no lattice of equilateral ones, and the border reflects.
        let share =
            given.iter().zip(&found).map(|(g, f)| g.dot(*f)).sum::<f64>() / given.iter().map(|g| g.length_squared()).sum::<f64>();
        assert!((share - shrink).abs() < 0.15, "the wave keeps {share:.3} of its height, expected {shrink:.3}");
    }

    #[test]
    fn a_field_that_is_parallel_over_edges_stays_as_it_is() {
        let mesh = square(8);
        let given = vec![DVec3::new(0.3, 0.4, 0.0); mesh.face_count()];
        for (f, v) in steady(&mesh, &given, 0.3).iter().enumerate() {
            assert!((*v - given[f]).length() < 1e-9, "face {f}: {v}");
        }
    }

    #[test]
    fn evening_out_over_less_than_a_face_changes_nothing() {
        let mesh = cube(2);
        let given: Vec<DVec3> =
            (0..mesh.face_count() as u32).map(|f| DVec3::new(0.3, 1.0, 0.2).reject_from_normalized(mesh.normal(f))).collect();
        for (f, v) in steady(&mesh, &given, 1e-3).iter().enumerate() {
            assert!((*v - given[f]).length() < 1e-2, "face {f}: {v} for {}", given[f]);
        }
    }
}
