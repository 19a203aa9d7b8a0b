//! From wishes at a few places to a value everywhere: Gaussian radial basis functions over distance along the surface.
//!
//! Based on: Praun, Finkelstein, Hoppe 2000, sec. 3.2.
//!
//! 1. One search from all anchors at once gives every vertex its nearest anchor and with it a bound: that anchor's weight there.
//! 2. A search from each anchor visits the vertices where its own weight is not negligible beside that bound, and adds weight x
//!    value. So a hundred anchors cost a few searches of the whole surface, not a hundred.
//! 3. Sums are normalised. They are kept relative to the largest weight met so far, so that they never vanish: vertices far
//!    from all anchors take the nearest one's value.
//! 4. Faces take the mean of their corners; an anchor's own face takes the anchor's value.
//!
//! Where we differ:
//!
//! * The paper adds the anchors' vectors in space and projects the sum. A vector from the far side of a limb then arrives turned
//!   or standing square to the surface, and the sum shrinks. Here directions travel with the search by parallel transport and
//!   are added in the plane where they arrive ([`Carry::Transport`]); the paper's way is [`Carry::Project`]. On scanned and
//!   modelled creatures with 1 to 16 anchors transport leaves a half to a fifth of the turning energy and of the singular
//!   vertices.
//! * Normalised Gaussians that overlap do not meet their anchors: with eight anchors of the default extent, their faces come out
//!   12 degrees off on the mean. The weight here is 1 / (1/g - 1) for a Gaussian g: the Gaussian itself where that is small, but
//!   without bound at the anchor, so that every anchor is met.
//! * Scale is blended apart from direction, by its logarithm, so that opposing directions do not shrink the texture.

use super::constraints::Anchor;
use crate::mesh::geodesic::{Geodesic, Step, Via};
use crate::mesh::transport::{projected, turned};
use crate::mesh::{Mesh, SurfacePoint};
use glam::{DVec3, Vec3};
use rayon::prelude::*;

/// A weight this far (natural logarithm) below the largest at a vertex is not followed further: a hundredth. What is left of
/// it there is taken off all weights, so that they fade to nothing without a jump.
const NEGLIGIBLE: f64 = 4.6;

/// Anchors searched at the same time; bounds the memory for their searches.
const AT_ONCE: usize = 8;

/// Distances below this share of the extent count as this: bounds the weight at the anchor itself.
const NEAREST: f64 = 1e-6;

/// How directions come from their anchor to a face.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Carry {
    /// By parallel transport along the shortest way.
    #[default]
    Transport,
    /// Unchanged through space, then projected: the paper's way.
    Project,
}

/// What is blended: the values of those anchors that have one.
struct Channel {
    values: Vec<Option<DVec3>>,
    /// True if values are directions that travel.
    travels: bool,
    /// Step 1: logarithm of the largest weight, at each vertex.
    bounds: Vec<f32>,
    sums: Vec<Sum>,
}

/// Sums of weight x value and of weights, both divided by the largest weight so far.
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

    /// Logarithm of the whole weight, and the mean value.
    fn mean(&self) -> (f64, DVec3) {
        if self.weight > 0.0 {
            (self.ln_largest + self.weight.ln(), self.value / self.weight)
        } else {
            (f64::NEG_INFINITY, DVec3::ZERO)
        }
    }
}

/// What [`spread`] gives, per face.
pub(super) struct Spread {
    /// Directions in the faces' planes, if an anchor has one. Their length, 0 to 1, tells how far the anchors agree.
    pub(super) directions: Option<Vec<Vec3>>,
    /// Logarithm of the relative scale, if an anchor has one.
    pub(super) ln_scale: Option<Vec<f32>>,
    /// Logarithm of the stretch and the shear, if an anchor has one of them.
    pub(super) shape: Option<Vec<[f32; 2]>>,
}

/// The base field: the same weight everywhere, a direction per face, 0 for all numbers.
pub(super) struct Base<'a> {
    pub(super) weight: f64,
    pub(super) directions: &'a [Vec3],
}

/// Spreads everything the anchors say.
pub(super) fn spread(mesh: &Mesh, anchors: &[Anchor], base: &Base<'_>, carry: Carry) -> Spread {
    let numbers = |a: &Anchor| {
        (a.ln_stretch.is_some() || a.shear.is_some()).then(|| DVec3::new(a.ln_stretch.unwrap_or(0.0), a.shear.unwrap_or(0.0), 0.0))
    };
    let wishes: [(Vec<Option<DVec3>>, bool); 3] = [
        (anchors.iter().map(|a| a.direction).collect(), carry == Carry::Transport),
        (anchors.iter().map(|a| a.ln_scale.map(|x| DVec3::X * x)).collect(), false),
        (anchors.iter().map(numbers).collect(), false),
    ];
    let mut searches = Searches::new(mesh, anchors, base.weight);
    let mut channels: Vec<Option<Channel>> =
        wishes.into_iter().map(|(values, travels)| searches.channel(values, travels)).collect();
    let mut present: Vec<&mut Channel> = channels.iter_mut().flatten().collect();
    searches.add_all(&mut present);
    searches.out_of_reach(&mut present);
    let mut of = |k: usize| channels[k].take().map(|channel: Channel| searches.at_faces(&channel, base, k == 0));
    Spread {
        directions: of(0).map(|v| v.iter().map(|d| d.as_vec3()).collect()),
        ln_scale: of(1).map(|v| v.into_iter().map(|x| x.x as f32).collect()),
        shape: of(2).map(|v| v.into_iter().map(|x| [x.x as f32, x.y as f32]).collect()),
    }
}

/// Logarithm of an anchor's weight at a distance: of weight / (1/g - 1), with 1/g = e^x.
fn ln_weight(anchor: &Anchor, distance: f64) -> f64 {
    let share = (distance / anchor.extent).max(NEAREST);
    let x = 0.5 * share * share;
    anchor.weight.ln() - x - (-(-x).exp_m1()).ln()
}

/// Scratch of one search: the searcher and the directions that travel with it.
#[derive(Clone)]
struct Walker<'m> {
    geodesic: Geodesic<'m>,
    carried: Vec<Vec3>,
}

struct Searches<'a> {
    mesh: &'a Mesh,
    anchors: &'a [Anchor],
    base_weight: f64,
    normals: Vec<Vec3>,
    walkers: Vec<Walker<'a>>,
}

impl<'a> Searches<'a> {
    fn new(mesh: &'a Mesh, anchors: &'a [Anchor], base_weight: f64) -> Self {
        let (normals, walkers) = if anchors.is_empty() {
            (Vec::new(), Vec::new())
        } else {
            let walker = Walker { geodesic: Geodesic::new(mesh), carried: vec![Vec3::ZERO; mesh.vertex_count()] };
            let at_once = AT_ONCE.min(rayon::current_num_threads()).min(anchors.len());
            (mesh.vertex_normals(), vec![walker; at_once])
        };
        Self { mesh, anchors, base_weight, normals, walkers }
    }

    /// Step 1. `None` if no anchor has a value.
    fn channel(&mut self, values: Vec<Option<DVec3>>, travels: bool) -> Option<Channel> {
        let members: Vec<&Anchor> =
            self.anchors.iter().zip(&values).filter_map(|(a, value)| value.is_some().then_some(a)).collect();
        if members.is_empty() {
            return None;
        }
        let places: Vec<SurfacePoint> = members.iter().map(|a| a.at).collect();
        let geodesic = &mut self.walkers[0].geodesic;
        geodesic.search(&places, f64::INFINITY);
        let base = self.base_weight.ln();
        let bound = |v: u32| {
            let nearest = members.get(geodesic.vertex_source(v) as usize).map(|a| ln_weight(a, geodesic.vertex(v)));
            nearest.unwrap_or(f64::NEG_INFINITY).max(base) as f32
        };
        let bounds = (0..self.mesh.vertex_count() as u32).map(bound).collect();
        Some(Channel { values, travels, bounds, sums: vec![Sum::EMPTY; self.mesh.vertex_count()] })
    }

    /// Step 2.
    fn add_all(&mut self, channels: &mut [&mut Channel]) {
        let mut walkers = std::mem::take(&mut self.walkers);
        let useful = |a: &usize| channels.iter().any(|c| c.values[*a].is_some());
        let all: Vec<usize> = (0..self.anchors.len()).filter(useful).collect();
        for some in all.chunks(walkers.len().max(1)) {
            let shared: Vec<&Channel> = channels.iter().map(|c| &**c).collect();
            walkers.par_iter_mut().zip(some).for_each(|(walker, &a)| self.walk(walker, &shared, a));
            for (walker, &a) in walkers.iter().zip(some) {
                for channel in channels.iter_mut() {
                    self.add(walker, channel, a);
                }
            }
        }
        self.walkers = walkers;
    }

    /// The search from one anchor.
    fn walk(&self, walker: &mut Walker<'_>, channels: &[&Channel], index: usize) {
        let anchor = &self.anchors[index];
        let Walker { geodesic, carried } = walker;
        let mine: Vec<&Channel> = channels.iter().copied().filter(|c| c.values[index].is_some()).collect();
        let (ln_height, steepness) = (anchor.weight.ln(), 0.5 / (anchor.extent * anchor.extent));
        let admit = |v: u32, distance: f64| {
            // How far the weight can exceed its Gaussian: below one extent without bound, so that a visit is always worth it.
            let x = distance * distance * steepness;
            let excess = if x < 2.0 { 0.94 } else { 0.15 };
            x < 0.5 || mine.iter().any(|c| ln_height - x + excess >= f64::from(c.bounds[v as usize]) - NEGLIGIBLE)
        };
        match mine.iter().find(|c| c.travels).and_then(|c| c.values[index]) {
            None => geodesic.search_with(&[anchor.at], admit, |_| ()),
            Some(direction) => {
                let start = self.mesh.normal(anchor.at.face);
                geodesic.search_with(&[anchor.at], admit, |step| {
                    carried[step.to as usize] = arriving(step, &self.normals, carried, start, direction);
                });
            }
        }
    }

    /// Adds one search's result to a channel.
    fn add(&self, walker: &Walker<'_>, channel: &mut Channel, index: usize) {
        let Some(value) = channel.values[index] else { return };
        for &v in walker.geodesic.reached() {
            let full = ln_weight(&self.anchors[index], walker.geodesic.vertex(v));
            let rest = (f64::from(channel.bounds[v as usize]) - NEGLIGIBLE - full).exp();
            if rest < 1.0 {
                let value = if channel.travels { walker.carried[v as usize].as_dvec3() } else { value };
                channel.sums[v as usize].add(full + (-rest).ln_1p(), value);
            }
        }
    }

    /// Components without an anchor have no distance along the surface to one: there the straight distance counts, and values
    /// come unchanged.
    fn out_of_reach(&self, channels: &mut [&mut Channel]) {
        if self.base_weight > 0.0 {
            return;
        }
        let places: Vec<DVec3> = self.anchors.iter().map(|a| self.mesh.position(a.at)).collect();
        for channel in channels {
            let Channel { values, sums, .. } = &mut **channel;
            sums.par_iter_mut().enumerate().filter(|(_, sum)| sum.weight == 0.0).for_each(|(v, sum)| {
                let here = self.mesh.point(v as u32);
                for ((anchor, place), value) in self.anchors.iter().zip(&places).zip(values.iter()) {
                    if let Some(value) = *value {
                        sum.add(ln_weight(anchor, here.distance(*place)), value);
                    }
                }
            });
        }
    }

    /// Steps 3 and 4, with the base field.
    fn at_faces(&self, channel: &Channel, base: &Base<'_>, in_plane: bool) -> Vec<DVec3> {
        let ln_base = base.weight.ln();
        let mut values: Vec<DVec3> = (0..self.mesh.face_count() as u32)
            .into_par_iter()
            .map(|f| {
                let normal = self.mesh.normal(f);
                let (mut ln_weight, mut mean) = (0.0, DVec3::ZERO);
                for v in self.mesh.faces[f as usize] {
                    let (ln_corner, value) = channel.sums[v as usize].mean();
                    ln_weight += ln_corner / 3.0;
                    let at_vertex = self.normals[v as usize].as_dvec3();
                    mean += if channel.travels { turned(value, at_vertex, normal) } else { value } / 3.0;
                }
                if base.weight > 0.0 {
                    let share = 1.0 / (1.0 + (ln_base - ln_weight).exp());
                    let of_base = if in_plane { base.directions[f as usize].as_dvec3() } else { DVec3::ZERO };
                    mean = mean * share + of_base * (1.0 - share);
                }
                if in_plane { projected(mean, normal) } else { mean }
            })
            .collect();
        for (anchor, value) in self.anchors.iter().zip(&channel.values) {
            if let Some(value) = *value {
                values[anchor.at.face as usize] = value;
            }
        }
        values
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
