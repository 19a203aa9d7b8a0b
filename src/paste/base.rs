//! A base of the surface's own: what exemplars are where they are slow, smooth across pastes.
//!
//! Detail is pasted without what is slow in it ([`take_detail`](crate::exemplar::take_detail)). Laid as pastes lie, that part changes
//! where they end; spread over a patch it is smooth, and still lighter where the exemplars are.
//!
//! Based on: diffusion of a surface signal by one implicit step (Desbrun et al., "Implicit Fairing of Irregular Meshes using Diffusion
//! and Curvature Flow", SIGGRAPH 1999, section 2), with cotangent weights.
//!
//! 1. At each vertex the mean of what the slow parts show there on the faces around it.
//! 2. `(M + t K) base = M shown`: `M` areas, `K` the stiffness matrix, `t` so that a point spreads by [`SPREAD`].

use super::composite::Composite;
use super::lapped::{BaseColor, LappedTexture, base_color};
use crate::exemplar::{Exemplar, Image};
use crate::field::Guide;
use crate::mesh::{Mesh, SurfacePoint};
use crate::numeric::{CgOptions, Jacobi, Pair, Sparse, Stop, solve};
use crate::surface::SurfaceTexture;
use glam::Vec3;
use rayon::prelude::*;

/// Standard deviation of what one point becomes, in exemplar widths: as wide as what counts as slow.
const SPREAD: f64 = 0.25;
/// A residual far below a step of eight bits.
const TOLERANCE: f64 = 1e-4;
/// Steps of a spread wider than this many thousand edges are not worth waiting for.
const ITERATIONS: usize = 2000;
/// Faces thinner than this, as area over the square of their longest edge, conduct nothing.
const THIN: f64 = 1e-9;

/// A base at the corners of each face. `slow` has the slow part of each exemplar, as large as it is.
#[must_use]
pub fn own_base(mesh: &Mesh, guide: &Guide, lapped: &LappedTexture, slow: Vec<Image>) -> Vec<[BaseColor; 3]> {
    let exemplars = lapped.exemplars.iter().zip(slow).map(|(exemplar, slow)| {
        let mut shown = Exemplar::new(exemplar.name.clone(), slow);
        shown.wrap = exemplar.wrap;
        shown
    });
    let composite = Composite::new(mesh, lapped).showing(exemplars.collect());
    let corner = |face: u32, k: usize| {
        let mut bary = Vec3::ZERO;
        bary[k] = 1.0;
        let texel = composite.texel(SurfacePoint { face, bary }, 0.0);
        (texel.alpha > 0.0).then_some(texel.base_color)
    };
    let at_corners: Vec<[Option<Vec3>; 3]> =
        (0..mesh.face_count() as u32).into_par_iter().map(|face| [0, 1, 2].map(|k| corner(face, k))).collect();
    let mut colors = vec![Vec3::ZERO; mesh.positions.len()];
    let mut mass = vec![0.0; mesh.positions.len()];
    for (face, (vertices, found)) in mesh.faces.iter().zip(&at_corners).enumerate() {
        for (&v, color) in vertices.iter().zip(found) {
            if let Some(color) = color {
                let area = mesh.area(face as u32) / 3.0;
                colors[v as usize] += *color * area as f32;
                mass[v as usize] += area;
            }
        }
    }
    let smooth = spread(mesh, guide, &colors, &mass);
    mesh.faces.iter().map(|corners| corners.map(|v| base_color(smooth[v as usize]))).collect()
}

/// Solves for the base; `sums` are colours times `mass`.
fn spread(mesh: &Mesh, guide: &Guide, sums: &[Vec3], mass: &[f64]) -> Vec<Vec3> {
    let stiffness = Sparse::assemble(mesh.positions.len(), &mesh.faces, |face| {
        let [a, b, c] = mesh.corners(face as u32);
        let edges = [c - b, a - c, b - a];
        let area = mesh.area(face as u32);
        let longest = edges.iter().map(|e| e.length_squared()).fold(0.0, f64::max);
        if area <= THIN * longest {
            return [[0.0; 3]; 3];
        }
        let sigma = SPREAD * f64::from(guide.scale(face as u32));
        let factor = 0.5 * sigma * sigma / (4.0 * area);
        edges.map(|e| edges.map(|f| factor * e.dot(f)))
    });
    let diagonal: Vec<f64> = stiffness.diagonal().iter().zip(mass).map(|(k, m)| k + m).collect();
    let product = |x: &[Pair], out: &mut [Pair]| {
        stiffness.times(x, out);
        for ((out, x), m) in out.iter_mut().zip(x).zip(mass) {
            *out = [out[0] + m * x[0], out[1] + m * x[1]];
        }
    };
    let solved = |one: usize, other: usize| {
        let rhs: Vec<Pair> = sums.iter().map(|s| [f64::from(s[one]), f64::from(s[other])]).collect();
        let start = |(r, m): (&Pair, &f64)| if *m > 0.0 { r.map(|r| r / m) } else { [0.0; 2] };
        let mut x: Vec<Pair> = rhs.iter().zip(mass).map(start).collect();
        let options = CgOptions { stop: Stop::Residual(TOLERANCE), max_iterations: ITERATIONS, coupled: false };
        solve(product, &rhs, &mut x, &mut Jacobi::of(diagonal.clone()), options);
        x
    };
    let (first, last) = (solved(0, 1), solved(2, 2));
    first.iter().zip(&last).map(|(rg, b)| Vec3::new(rg[0] as f32, rg[1] as f32, b[0] as f32)).collect()
}
