//! Both sides of each chart border made to agree.
//!
//! Based on: the least squares of Sylvan, "Fixing texture seams with linear least-squares", 2015, and Liu et al., "Seamless:
//! Seam erasure and seam-aware decoupling of shape from mesh resolution", SIGGRAPH Asia 2017.
//!
//! 1. Along each edge that is a chart border, points are taken every half texel of its longer image.
//! 2. At each point the bilinear samples on the two sides are to be equal; texels near borders are to stay what they are,
//!    those in gutters, which nobody sees but through such samples, much less so.
//! 3. Conjugate gradients on the normal equations, two components at a time, never assembled.
//!
//! Normals are left alone: the frames differ on the two sides, so equal normals are stored as different numbers.

use super::bake::Page;
use super::{Atlas, raster};
use crate::exemplar::{Channel, srgb};
use crate::mesh::{Mesh, next};
use crate::numeric::{CgOptions, Jacobi, Pair, Stop, solve};
use glam::DVec2;
use serde::Serialize;

/// Points a texel along a border.
const POINTS: f64 = 2.0;

/// Weight of a point's equation against a texel's wish to stay what it is. Seven times as much takes longer and gains nothing: what is
/// left is mostly the rounding to eight bits.
const EQUAL: f64 = 30.0;

/// Weight of that wish in a gutter.
const GUTTER: f64 = 0.02;

/// Residual, relative to the right-hand side, at which no texel is off by a step of eight bits any more.
const TOLERANCE: f64 = 1e-4;

/// Iterations at most.
const MAX_ITERATIONS: usize = 200;

/// How far colours of the two sides of chart borders lie apart, in steps of eight bits as displayed (sRGB), the largest of
/// the three components at each point, after rounding to eight bits.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct SeamStatistics {
    /// Length of all borders, world units.
    pub length: f64,
    /// Points compared.
    pub points: usize,
    /// Mean difference.
    pub mean: f64,
    /// 99 % of points differ by less.
    pub most: f64,
    /// The largest difference.
    pub greatest: f64,
}

/// A bilinear sample: four texels and their weights.
#[derive(Debug, Clone, Copy)]
struct Footprint {
    /// Texel numbers over all pages.
    texels: [u32; 4],
    weights: [f32; 4],
}

/// The points along all chart borders.
#[derive(Debug)]
pub struct Seams {
    points: Vec<[Footprint; 2]>,
    /// The texels in any footprint, rising; footprints hold places in this list.
    texels: Vec<u64>,
    page_texels: u64,
    length: f64,
}

impl Seams {
    /// Finds the borders.
    #[must_use]
    pub fn new(mesh: &Mesh, atlas: &Atlas) -> Self {
        let size = i64::from(atlas.size);
        let page_texels = (size * size) as u64;
        let mut raw: Vec<[([u64; 4], [f32; 4]); 2]> = Vec::new();
        let mut length = 0.0;
        for (h, o) in atlas.seams(mesh) {
            let ends = |h: u32| {
                let at = |h: u32| atlas.face_texels(h / 3)[(h % 3) as usize];
                (at(h), at(next(h)))
            };
            let (mine, theirs) = (ends(h), ends(o));
            let theirs = (theirs.1, theirs.0);
            // A face without area in the atlas shows one texel all over; there is nothing to match.
            if raster::Triangle::new(atlas.face_texels(h / 3)).is_none()
                || raster::Triangle::new(atlas.face_texels(o / 3)).is_none()
            {
                continue;
            }
            length += (mesh.point(mesh.origin(h)) - mesh.point(mesh.origin(next(h)))).length();
            let texels = (mine.0 - mine.1).length().max((theirs.0 - theirs.1).length());
            let count = (POINTS * texels).ceil().max(1.0) as usize;
            let pages = [atlas.page_of(h / 3), atlas.page_of(o / 3)].map(|p| u64::from(p) * page_texels);
            for k in 0..count {
                let t = (k as f64 + 0.5) / count as f64;
                raw.push([
                    footprint(mine.0.lerp(mine.1, t), size, pages[0]),
                    footprint(theirs.0.lerp(theirs.1, t), size, pages[1]),
                ]);
            }
        }
        let mut texels: Vec<u64> = raw.iter().flatten().flat_map(|(t, _)| *t).collect();
        texels.sort_unstable();
        texels.dedup();
        let place = |t: u64| texels.partition_point(|&other| other < t) as u32;
        let points = raw.iter().map(|sides| sides.map(|(t, weights)| Footprint { texels: t.map(place), weights })).collect();
        Self { points, texels, page_texels, length }
    }

    fn page(&self, texel: u64) -> (usize, usize) {
        ((texel / self.page_texels) as usize, (texel % self.page_texels) as usize)
    }

    /// Changes the texels near borders so that both sides agree.
    pub fn solve(&self, pages: &mut [Page]) {
        if self.points.is_empty() {
            return;
        }
        let keep: Vec<f64> = self
            .texels
            .iter()
            .map(|&t| {
                let (page, texel) = self.page(t);
                if pages[page].covered[texel] { 1.0 } else { GUTTER }
            })
            .collect();
        let mut diagonal = keep.clone();
        for point in &self.points {
            for (t, w) in difference(point) {
                diagonal[t] += EQUAL * w * w;
            }
        }
        let mut preconditioner = Jacobi::of(diagonal);
        // Components of all channels, two at a time.
        let components: Vec<(usize, usize)> = pages[0]
            .images
            .iter()
            .enumerate()
            .filter(|(_, (channel, _))| *channel != Channel::Normal)
            .flat_map(|(k, (channel, _))| (0..channel.components()).map(move |c| (k, c)))
            .collect();
        for pair in components.chunks(2) {
            let pair = [pair[0], *pair.last().unwrap_or(&pair[0])];
            let start: Vec<Pair> = self
                .texels
                .iter()
                .map(|&t| {
                    let (page, texel) = self.page(t);
                    pair.map(|(k, c)| {
                        let image = &pages[page].images[k].1;
                        f64::from(image.data()[texel * image.components() + c])
                    })
                })
                .collect();
            let rhs: Vec<Pair> = start.iter().zip(&keep).map(|(v, k)| v.map(|v| v * k)).collect();
            let mut x = start;
            let apply = |x: &[Pair], out: &mut [Pair]| {
                out.iter_mut().zip(x).zip(&keep).for_each(|((out, x), k)| *out = x.map(|x| x * k));
                for point in &self.points {
                    let mut sum = [0.0; 2];
                    for (t, w) in difference(point) {
                        (0..2).for_each(|c| sum[c] += w * x[t][c]);
                    }
                    for (t, w) in difference(point) {
                        (0..2).for_each(|c| out[t][c] += EQUAL * w * sum[c]);
                    }
                }
            };
            let options = CgOptions { stop: Stop::Residual(TOLERANCE), max_iterations: MAX_ITERATIONS, coupled: false };
            solve(apply, &rhs, &mut x, &mut preconditioner, options);
            for (&t, x) in self.texels.iter().zip(&x) {
                let (page, texel) = self.page(t);
                for ((k, c), x) in pair.into_iter().zip(x) {
                    let image = &mut pages[page].images[k].1;
                    let n = image.components();
                    image.data_mut()[texel * n + c] = x.clamp(0.0, 1.0) as f32;
                }
            }
        }
    }

    /// How far the colours of the two sides lie apart.
    #[must_use]
    pub fn measure(&self, pages: &[Page]) -> SeamStatistics {
        let rounded: Vec<[f32; 3]> = self
            .texels
            .iter()
            .map(|&t| {
                let (page, texel) = self.page(t);
                let colour =
                    pages[page].image(Channel::BaseColor).map_or([0.0; 3], |image| [0, 1, 2].map(|c| image.data()[3 * texel + c]));
                colour.map(|c| srgb::decode((srgb::encode(c) * 255.0).round() / 255.0))
            })
            .collect();
        let sample = |f: &Footprint| {
            let mut sum = [0.0; 3];
            for (&t, &w) in f.texels.iter().zip(&f.weights) {
                (0..3).for_each(|c| sum[c] += w * rounded[t as usize][c]);
            }
            sum.map(srgb::encode)
        };
        let mut apart: Vec<f32> = self
            .points
            .iter()
            .map(|[a, b]| {
                let (a, b) = (sample(a), sample(b));
                (0..3).map(|c| 255.0 * (a[c] - b[c]).abs()).fold(0.0, f32::max)
            })
            .collect();
        if apart.is_empty() {
            return SeamStatistics::default();
        }
        let mean = apart.iter().map(|&d| f64::from(d)).sum::<f64>() / apart.len() as f64;
        let high = (apart.len() - 1) * 99 / 100;
        let most = *apart.select_nth_unstable_by(high, f32::total_cmp).1;
        let greatest = apart.iter().copied().fold(0.0, f32::max);
        SeamStatistics {
            length: self.length,
            points: self.points.len(),
            mean,
            most: f64::from(most),
            greatest: f64::from(greatest),
        }
    }
}

/// The texels of a point's equation and their coefficients: one side less the other.
fn difference(point: &[Footprint; 2]) -> impl Iterator<Item = (usize, f64)> + '_ {
    let side = |f: &'_ Footprint, sign: f64| {
        let Footprint { texels, weights } = *f;
        (0..4).map(move |k| (texels[k] as usize, sign * f64::from(weights[k])))
    };
    side(&point[0], 1.0).chain(side(&point[1], -1.0))
}

/// The bilinear footprint of a point, texels, on the page whose texels begin at number `base`.
fn footprint(p: DVec2, size: i64, base: u64) -> ([u64; 4], [f32; 4]) {
    let q = p - 0.5;
    let low = q.floor();
    let (u, v) = ((q.x - low.x) as f32, (q.y - low.y) as f32);
    let at = |dx: i64, dy: i64| {
        let x = (low.x as i64 + dx).clamp(0, size - 1);
        let y = (low.y as i64 + dy).clamp(0, size - 1);
        base + (y * size + x) as u64
    };
    let texels = [at(0, 0), at(1, 0), at(0, 1), at(1, 1)];
    (texels, [(1.0 - u) * (1.0 - v), u * (1.0 - v), (1.0 - u) * v, u * v])
}
