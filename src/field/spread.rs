//! From wishes at a few places to a value everywhere: Gaussian radial basis functions over distance along the surface.
//!
//! Based on: Praun, Finkelstein, Hoppe 2000, sec. 3.2.
//!
//! 1. One search from all anchors at once gives every vertex its nearest anchor and a bound: the logarithm of that anchor's
//!    Gaussian there.
//! 2. A search from each anchor visits what lies where its own Gaussian is not negligible beside that bound, and adds weight x
//!    value to the faces. So a hundred anchors cost a few searches of the whole surface, not a hundred.
//! 3. Sums are normalised. They are kept relative to the largest Gaussian met so far, so that they never vanish: faces far
//!    from all anchors take the nearest one's value.
//!
//! Where we differ: the paper adds the anchors' vectors in space and projects the sum. A vector from the far side of a limb then
//! arrives turned or standing square to the surface and the sum shrinks. Here directions travel with the search by parallel
//! transport and are added in the plane where they arrive ([`Carry::Transport`]); the paper's way is [`Carry::Project`].
//! Scale is blended apart from direction, by its logarithm, so that opposing directions do not shrink the texture.

use super::constraints::Anchor;
use crate::mesh::geodesic::{Geodesic, Step, Via};
use crate::mesh::transport::{projected, turned};
use crate::mesh::{Mesh, NONE, SurfacePoint};
use glam::{DVec3, Vec3};
use rayon::prelude::*;

/// A Gaussian this far (natural logarithm) below the largest one at a vertex is not followed further: a thousandth, which
/// turns a direction by less than 0.06 degrees.
const NEGLIGIBLE: f64 = 7.0;

/// Anchors searched at the same time; bounds the memory for their answers.
const AT_ONCE: usize = 4;

/// How directions come from their anchor to a face.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Carry {
    /// By parallel transport along the shortest way.
    #[default]
    Transport,
    /// Unchanged through space, then projected: the paper's way.
    Project,
}

/// One blended quantity: at the faces, the sum of weight x value and of weights, both divided by the largest weight so far.
#[derive(Debug, Clone, Copy)]
struct Sum {
    ln_largest: f64,
    weight: f64,
    value: DVec3,
}

impl Sum {
    const EMPTY: Self = Self { ln_largest: f64::NEG_INFINITY, weight: 0.0, value: DVec3::ZERO };

    fn add(&mut self, ln_weight: f64, value: DVec3) {
        if ln_weight > self.ln_largest {
            let shrink = (self.ln_largest - ln_weight).exp();
            self.weight *= shrink;
            self.value *= shrink;
            self.ln_largest = ln_weight;
        }
        let weight = (ln_weight - self.ln_largest).exp();
        self.weight += weight;
        self.value += value * weight;
    }
}

/// What each anchor gives, and the value of the base field with its weight (0 for none).
struct Blend<'a> {
    mesh: &'a Mesh,
    anchors: &'a [&'a Anchor],
    values: &'a [DVec3],
    base_weight: f64,
    /// Vertex normals if values are directions to be transported.
    normals: Option<Vec<Vec3>>,
}

/// Blended directions: the sum of the carried unit vectors in each face's plane, divided by the sum of weights. Its length, 0
/// to 1, tells how far the anchors agree.
pub(super) fn directions(mesh: &Mesh, anchors: &[Anchor], base: Option<(Vec<Vec3>, f64)>, carry: Carry) -> Vec<Vec3> {
    let (anchors, values): (Vec<&Anchor>, Vec<DVec3>) = anchors.iter().filter_map(|a| a.direction.map(|d| (a, d))).unzip();
    let normals = (carry == Carry::Transport).then(|| mesh.vertex_normals());
    let base_weight = base.as_ref().map_or(0.0, |b| b.1);
    let mut sums = Blend { mesh, anchors: &anchors, values: &values, base_weight, normals }.sums();
    if let Some((directions, weight)) = base.filter(|b| b.1 > 0.0) {
        for (sum, direction) in sums.iter_mut().zip(directions) {
            sum.add(weight.ln(), direction.as_dvec3());
        }
    }
    let in_plane = |(f, sum): (usize, &Sum)| (projected(sum.value, mesh.normal(f as u32)) / sum.weight).as_vec3();
    sums.iter().enumerate().map(in_plane).collect()
}

/// A blended number; the base field's is 0.
pub(super) fn numbers(mesh: &Mesh, anchors: &[Anchor], base_weight: f64, of: impl Fn(&Anchor) -> Option<f64>) -> Vec<f32> {
    let (anchors, values): (Vec<&Anchor>, Vec<DVec3>) = anchors.iter().filter_map(|a| of(a).map(|x| (a, DVec3::X * x))).unzip();
    if anchors.is_empty() {
        return vec![0.0; mesh.face_count()];
    }
    let mut sums = Blend { mesh, anchors: &anchors, values: &values, base_weight, normals: None }.sums();
    if base_weight > 0.0 {
        sums.iter_mut().for_each(|sum| sum.add(base_weight.ln(), DVec3::ZERO));
    }
    sums.iter().map(|sum| (sum.value.x / sum.weight) as f32).collect()
}

/// Logarithm of an anchor's Gaussian at a distance.
fn ln_gaussian(anchor: &Anchor, distance: f64) -> f64 {
    let share = distance / anchor.extent;
    anchor.weight.ln() - 0.5 * share * share
}

/// Scratch of one search: the searcher and the directions that travel with it.
struct Walker<'m> {
    geodesic: Geodesic<'m>,
    carried: Vec<Vec3>,
}

impl Blend<'_> {
    fn sums(&self) -> Vec<Sum> {
        let mut sums = vec![Sum::EMPTY; self.mesh.face_count()];
        if self.anchors.is_empty() {
            return sums;
        }
        let places: Vec<SurfacePoint> = self.anchors.iter().map(|a| a.at).collect();
        let carried = if self.normals.is_some() { self.mesh.vertex_count() } else { 0 };
        let walker = Walker { geodesic: Geodesic::new(self.mesh), carried: vec![Vec3::ZERO; carried] };
        let mut walkers = vec![walker];
        walkers[0].geodesic.search(&places, f64::INFINITY);
        let bounds: Vec<f64> = (0..self.mesh.vertex_count() as u32)
            .map(|v| {
                let (geodesic, base) = (&walkers[0].geodesic, self.base_weight.ln());
                let source = geodesic.vertex_source(v);
                let nearest = self.anchors.get(source as usize).map(|a| ln_gaussian(a, geodesic.vertex(v)));
                nearest.unwrap_or(f64::NEG_INFINITY).max(base)
            })
            .collect();
        let at_once = AT_ONCE.min(rayon::current_num_threads()).min(self.anchors.len());
        while walkers.len() < at_once {
            walkers.push(Walker { geodesic: walkers[0].geodesic.clone(), carried: walkers[0].carried.clone() });
        }
        let all: Vec<usize> = (0..self.anchors.len()).collect();
        for some in all.chunks(at_once) {
            let found: Vec<Vec<(u32, f64, DVec3)>> =
                walkers.par_iter_mut().zip(some).map(|(walker, &a)| self.influence(walker, &bounds, a)).collect();
            for (face, ln_weight, value) in found.into_iter().flatten() {
                sums[face as usize].add(ln_weight, value);
            }
        }
        self.out_of_reach(&mut sums);
        sums
    }

    /// Step 2 for one anchor: faces, logarithms of its weight there, values as they arrive.
    fn influence(&self, walker: &mut Walker<'_>, bounds: &[f64], index: usize) -> Vec<(u32, f64, DVec3)> {
        let (anchor, value) = (self.anchors[index], self.values[index]);
        let Walker { geodesic, carried } = walker;
        let admit = |v: u32, distance: f64| ln_gaussian(anchor, distance) >= bounds[v as usize] - NEGLIGIBLE;
        match &self.normals {
            None => geodesic.search_with(&[anchor.at], admit, |_| ()),
            Some(normals) => {
                let start = self.mesh.normal(anchor.at.face);
                geodesic.search_with(&[anchor.at], admit, |step| {
                    carried[step.to as usize] = arriving(step, normals, carried, start, value);
                });
            }
        }
        let mut found = Vec::new();
        geodesic.for_each_reached_face(|face| {
            let at_face = match &self.normals {
                Some(normals) if face != anchor.at.face => self.gathered(face, normals, geodesic, carried),
                _ => value,
            };
            found.push((face, ln_gaussian(anchor, geodesic.face(face)), at_face));
        });
        found
    }

    /// The direction at a face: the mean of what its corners got.
    fn gathered(&self, face: u32, normals: &[Vec3], geodesic: &Geodesic<'_>, carried: &[Vec3]) -> DVec3 {
        let normal = self.mesh.normal(face);
        let reached = self.mesh.faces[face as usize].into_iter().filter(|&v| geodesic.vertex_source(v) != NONE);
        let sum: DVec3 = reached.map(|v| turned(carried[v as usize].as_dvec3(), normals[v as usize].as_dvec3(), normal)).sum();
        projected(sum, normal).normalize_or_zero()
    }

    /// Components without an anchor have no distance along the surface to one: there the straight distance counts, and values
    /// come unchanged.
    fn out_of_reach(&self, sums: &mut [Sum]) {
        if self.base_weight > 0.0 {
            return;
        }
        let places: Vec<DVec3> = self.anchors.iter().map(|a| self.mesh.position(a.at)).collect();
        sums.par_iter_mut().enumerate().filter(|(_, sum)| sum.weight == 0.0).for_each(|(f, sum)| {
            let here = self.mesh.centroid(f as u32);
            for ((anchor, place), &value) in self.anchors.iter().zip(&places).zip(self.values) {
                sum.add(ln_gaussian(anchor, here.distance(*place)), value);
            }
        });
    }
}

/// The direction as it arrives at a vertex, turned from normal to normal along the way the front took.
fn arriving(step: &Step, normals: &[Vec3], carried: &[Vec3], start: DVec3, value: DVec3) -> Vec3 {
    let to = normals[step.to as usize].as_dvec3();
    let from = |v: u32| turned(carried[v as usize].as_dvec3(), normals[v as usize].as_dvec3(), to);
    let direction = match step.via {
        Via::Source => turned(value, start, to),
        Via::Edge(v) => from(v),
        Via::Across([a, b], share) => from(a) * (1.0 - share) + from(b) * share,
    };
    projected(direction, to).normalize_or_zero().as_vec3()
}
