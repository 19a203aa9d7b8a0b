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
//! Renderers filter light in linear light, so the equations are linear there; but they are weighted by how much a difference
//! shows, the slope of the sRGB curve, or dark textures would be left apart. Texels that end up outside 0 to 1 are held at that
//! end and the others solved again.
//!
//! Normals are compared on the surface: the tangent frames of the two sides differ by a turn about the smooth normal they share,
//! so their first two components are one complex number with a turn as its coefficient on the far side. Where the smooth normals
//! differ, at a crease, there is nothing to match.

use super::bake::Page;
use super::{Atlas, Frames, raster};
use crate::exemplar::{Channel, srgb};
use crate::mesh::{Mesh, NONE, next};
use crate::numeric::{CgOptions, Pair, Preconditioner, Stop, solve};
use glam::{DVec2, Mat2, Vec2, Vec3};
use rayon::prelude::*;
use serde::Serialize;

/// Points a texel along a border.
const POINTS: f64 = 2.0;

/// Weight of a point's equation against a texel's wish to stay what it is: a border's difference shows as a line, a texel's not at
/// all.
const EQUAL: f64 = 300.0;

/// Weight of that wish in a gutter.
const GUTTER: f64 = 0.02;

/// Weight of that wish where a texel is held at the end of its range.
const HELD: f64 = 1e6;

/// Residual, relative to the first round's right-hand side, at which no texel is off by a step of eight bits any more: the right-hand side is
/// the difference itself.
const TOLERANCE: f64 = 1e-3;

/// Iterations at most.
const MAX_ITERATIONS: usize = 200;

/// Rounds of solving, each with the slopes and the held texels that the one before left.
const ROUNDS: usize = 3;

/// The darkest light at which the slope of the sRGB curve is taken: below, it is a straight line.
const DARKEST: f64 = 0.003;

/// Normals whose cosine is below this lie on both sides of a crease.
const SMOOTH: f32 = 0.9995;

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
    /// Mean angle between the normals of the two sides, degrees, away from creases.
    pub normals: f64,
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
    /// For each point how the second side's frame lies in the first's, zero at creases; empty without normals.
    turns: Vec<Mat2>,
    /// The texels in any footprint, in the order in which points meet them, so that what lies together along a border lies together
    /// in memory; footprints hold places in this list.
    texels: Vec<u64>,
    page_texels: u64,
    length: f64,
}

impl Seams {
    /// Finds the borders.
    #[must_use]
    pub fn new(mesh: &Mesh, atlas: &Atlas, frames: &Frames) -> Self {
        let size = i64::from(atlas.size);
        let page_texels = (size * size) as u64;
        let mut raw: Vec<[([u64; 4], [f32; 4]); 2]> = Vec::new();
        let mut turns = Vec::new();
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
                if !frames.tangents.is_empty() {
                    turns.push(turn(frames, [h, o], t as f32));
                }
            }
        }
        let mut rising: Vec<u64> = raw.iter().flatten().flat_map(|(t, _)| *t).collect();
        rising.sort_unstable();
        rising.dedup();
        let mut number = vec![NONE; rising.len()];
        let mut texels = Vec::with_capacity(rising.len());
        let mut place = |t: u64| {
            let number = &mut number[rising.partition_point(|&other| other < t)];
            if *number == NONE {
                *number = texels.len() as u32;
                texels.push(t);
            }
            *number
        };
        let points = raw.iter().map(|sides| sides.map(|(t, weights)| Footprint { texels: t.map(&mut place), weights })).collect();
        Self { points, turns, texels, page_texels, length }
    }

    fn page(&self, texel: u64) -> (usize, usize) {
        ((texel / self.page_texels) as usize, (texel % self.page_texels) as usize)
    }

    /// Changes the texels near borders so that both sides agree.
    pub fn solve(&self, pages: &mut [Page]) {
        if self.points.is_empty() {
            return;
        }
        let stay: Vec<f64> = self
            .texels
            .iter()
            .map(|&t| {
                let (page, texel) = self.page(t);
                if pages[page].covered[texel] { 1.0 } else { GUTTER }
            })
            .collect();
        // Components of all channels, two at a time; those of normals that are turned belong together.
        let channels: Vec<Channel> = pages[0].images.iter().map(|(channel, _)| *channel).collect();
        let (mut light, mut plain, mut turned) = (Vec::new(), Vec::new(), Vec::new());
        for (k, &channel) in channels.iter().enumerate() {
            let mine = (0..channel.components()).map(|c| (k, c));
            match channel {
                Channel::Normal if self.turns.is_empty() => {}
                Channel::Normal => turned.extend(mine),
                Channel::BaseColor | Channel::Emissive => light.extend(mine),
                _ => plain.extend(mine),
            }
        }
        let mut work = Vec::new();
        for (components, kind) in [(light, Kind::Light), (plain, Kind::Plain), (turned, Kind::Normal)] {
            for pair in components.chunks(2) {
                // The third component of a normal lies along the axis of the turn.
                let kind = if kind == Kind::Normal && pair.len() == 1 { Kind::Axis } else { kind };
                work.push(([pair[0], *pair.last().unwrap_or(&pair[0])], kind));
            }
        }
        let read = &*pages;
        let solved: Vec<Vec<Pair>> = work
            .par_iter()
            .map(|&(both, kind)| {
                let mut x = self.read(read, both);
                self.match_sides(&stay, &mut x, kind);
                x
            })
            .collect();
        for (&(both, _), x) in work.iter().zip(&solved) {
            self.write(pages, both, x);
        }
        for page in pages.iter_mut() {
            self.unit_normals(page);
        }
    }

    fn read(&self, pages: &[Page], pair: [(usize, usize); 2]) -> Vec<Pair> {
        let value = |&t: &u64| {
            let (page, texel) = self.page(t);
            pair.map(|(k, c)| {
                let image = &pages[page].images[k].1;
                f64::from(image.data()[texel * image.components() + c])
            })
        };
        self.texels.iter().map(value).collect()
    }

    fn write(&self, pages: &mut [Page], pair: [(usize, usize); 2], x: &[Pair]) {
        for (&t, x) in self.texels.iter().zip(x) {
            let (page, texel) = self.page(t);
            for ((k, c), &x) in pair.into_iter().zip(x) {
                let image = &mut pages[page].images[k].1;
                let n = image.components();
                image.data_mut()[texel * n + c] = x as f32;
            }
        }
    }

    fn unit_normals(&self, page: &mut Page) {
        for (_, image) in page.images.iter_mut().filter(|(channel, _)| *channel == Channel::Normal && !self.turns.is_empty()) {
            for normal in image.data_mut().as_chunks_mut::<3>().0 {
                *normal = Vec3::from_array(*normal).normalize_or(Vec3::Z).to_array();
            }
        }
    }

    /// Brings two components of all texels to agree.
    fn match_sides(&self, stay: &[f64], x: &mut [Pair], kind: Kind) {
        let mut wanted = x.to_vec();
        let mut held = vec![[false; 2]; x.len()];
        // What is still apart in later rounds is small; it need not be known more exactly than in the first.
        let mut first = 0.0_f64;
        for _ in 0..ROUNDS {
            let system = System::new(self, stay, &held, x, kind);
            let mut rhs = vec![[0.0; 2]; x.len()];
            system.apply_points(x, &mut rhs);
            for (i, rhs) in rhs.iter_mut().enumerate() {
                *rhs = [0, 1].map(|c| system.keep[i][c] * (wanted[i][c] - x[i][c]) - rhs[c]);
            }
            let size = rhs.iter().flatten().map(|r| r * r).sum::<f64>().sqrt();
            first = first.max(size);
            let tolerance = if size > 0.0 { TOLERANCE * first / size } else { TOLERANCE };
            let mut change = vec![[0.0; 2]; x.len()];
            let mut preconditioner = Diagonal(system.diagonal());
            let coupled = kind == Kind::Normal;
            let options = CgOptions { stop: Stop::Residual(tolerance), max_iterations: MAX_ITERATIONS, coupled };
            solve(|x, out| system.apply(x, out), &rhs, &mut change, &mut preconditioner, options);
            let mut beyond = false;
            for i in 0..x.len() {
                for c in 0..2 {
                    x[i][c] += change[i][c];
                    if !kind.signed() && !(0.0..=1.0).contains(&x[i][c]) {
                        x[i][c] = x[i][c].clamp(0.0, 1.0);
                        wanted[i][c] = x[i][c];
                        beyond |= !std::mem::replace(&mut held[i][c], true);
                    }
                }
            }
            if !beyond && kind != Kind::Light {
                break;
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
        let normals = self.normals_apart(pages);
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
            normals,
        }
    }

    /// Mean angle between the normals of both sides, degrees.
    fn normals_apart(&self, pages: &[Page]) -> f64 {
        let rounded = |v: f32| ((0.5 * v + 0.5) * 255.0).round() / 127.5 - 1.0;
        let normal = |t: u32| {
            let (page, texel) = self.page(self.texels[t as usize]);
            let image = pages[page].image(Channel::Normal);
            image.map_or(Vec3::ZERO, |image| Vec3::from_slice(&image.data()[3 * texel..]).map(rounded))
        };
        let sample = |f: &Footprint| (0..4).map(|k| normal(f.texels[k]) * f.weights[k]).sum::<Vec3>();
        let (mut sum, mut count) = (0.0, 0);
        for ([a, b], turn) in self.points.iter().zip(&self.turns).filter(|(_, turn)| **turn != Mat2::ZERO) {
            let (a, b) = (sample(a), sample(b));
            let b = (*turn * b.truncate()).extend(b.z);
            if a != Vec3::ZERO && b != Vec3::ZERO {
                sum += f64::from(a.angle_between(b));
                count += 1;
            }
        }
        if count > 0 { (sum / f64::from(count)).to_degrees() } else { 0.0 }
    }
}

/// What components are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    /// Linear light, displayed as sRGB.
    Light,
    /// Numbers shown as they are.
    Plain,
    /// The components of a normal across the axis of its frame.
    Normal,
    /// The one along it.
    Axis,
}

impl Kind {
    const fn signed(self) -> bool {
        matches!(self, Self::Normal | Self::Axis)
    }

    /// How much a difference shows.
    fn slope(self, value: f64) -> f64 {
        match self {
            Self::Light => 1.055 / 2.4 * value.clamp(DARKEST, 1.0).powf(1.0 / 2.4 - 1.0),
            _ => 1.0,
        }
    }
}

/// The normal equations of two components.
struct System<'a> {
    seams: &'a Seams,
    kind: Kind,
    /// Weights of texels' wishes and of points' equations.
    keep: Vec<Pair>,
    equal: Vec<Pair>,
}

impl<'a> System<'a> {
    fn new(seams: &'a Seams, stay: &[f64], held: &[[bool; 2]], x: &[Pair], kind: Kind) -> Self {
        let keep = |i: usize| [0, 1].map(|c| if held[i][c] { HELD } else { 1.0 } * stay[i] * kind.slope(x[i][c]).powi(2));
        let equal = |(i, [a, b]): (usize, &[Footprint; 2])| {
            let (a, b) = (sample(a, x), sample(b, x));
            let there = !kind.signed() || seams.turns[i] != Mat2::ZERO;
            [0, 1].map(|c| if there { EQUAL * kind.slope(0.5 * (a[c] + b[c])).powi(2) } else { 0.0 })
        };
        Self { seams, kind, keep: (0..x.len()).map(keep).collect(), equal: seams.points.iter().enumerate().map(equal).collect() }
    }

    /// How the second side's numbers count on the first.
    fn turn(&self, point: usize) -> [[f64; 2]; 2] {
        match self.kind {
            Kind::Normal => self.seams.turns[point].to_cols_array_2d().map(|column| column.map(f64::from)),
            _ => [[1.0, 0.0], [0.0, 1.0]],
        }
    }

    fn apply(&self, x: &[Pair], out: &mut [Pair]) {
        self.apply_points(x, out);
        out.iter_mut().zip(x).zip(&self.keep).for_each(|((out, x), k)| (0..2).for_each(|c| out[c] += k[c] * x[c]));
    }

    fn apply_points(&self, x: &[Pair], out: &mut [Pair]) {
        out.fill([0.0; 2]);
        for (i, ([near, far], equal)) in self.seams.points.iter().zip(&self.equal).enumerate() {
            let turn = self.turn(i);
            let (a, b) = (sample(near, x), sample(far, x));
            let apart = [0, 1].map(|c| equal[c] * (a[c] - turn[0][c] * b[0] - turn[1][c] * b[1]));
            let back = turn.map(|column| column[0] * apart[0] + column[1] * apart[1]);
            for k in 0..4 {
                let (w, v) = (f64::from(near.weights[k]), f64::from(far.weights[k]));
                (0..2).for_each(|c| out[near.texels[k] as usize][c] += w * apart[c]);
                (0..2).for_each(|c| out[far.texels[k] as usize][c] -= v * back[c]);
            }
        }
    }

    fn diagonal(&self) -> Vec<Pair> {
        let mut diagonal = self.keep.clone();
        for (footprints, equal) in self.seams.points.iter().zip(&self.equal) {
            for footprint in footprints {
                for k in 0..4 {
                    let w = f64::from(footprint.weights[k]).powi(2);
                    (0..2).for_each(|c| diagonal[footprint.texels[k] as usize][c] += w * equal[c]);
                }
            }
        }
        diagonal
    }
}

/// Division by a diagonal, a different one for each component.
struct Diagonal(Vec<Pair>);

impl Preconditioner for Diagonal {
    fn apply(&mut self, residual: &[Pair], out: &mut [Pair]) {
        for ((out, r), d) in out.iter_mut().zip(residual).zip(&self.0) {
            *out = [0, 1].map(|c| if d[c] > 0.0 { r[c] / d[c] } else { r[c] });
        }
    }
}

fn sample(footprint: &Footprint, x: &[Pair]) -> Pair {
    let mut sum = [0.0; 2];
    for k in 0..4 {
        let (value, weight) = (x[footprint.texels[k] as usize], f64::from(footprint.weights[k]));
        (0..2).for_each(|c| sum[c] += weight * value[c]);
    }
    sum
}

/// How the frame on the second of two half-edges lies in that on the first, `t` along the first; zero at a crease.
fn turn(frames: &Frames, [h, o]: [u32; 2], t: f32) -> Mat2 {
    let at = |h: u32, t: f32| {
        let mut bary = Vec3::ZERO;
        bary[(h % 3) as usize] = 1.0 - t;
        bary[(next(h) % 3) as usize] = t;
        let smooth = frames.normal(h / 3, bary, Vec3::Z);
        (frames.frame(h / 3, bary, smooth), smooth)
    };
    let ((near, n), (far, m)) = (at(h, t), at(o, 1.0 - t));
    if n.dot(m) < SMOOTH {
        return Mat2::ZERO;
    }
    let column = |axis: Vec3| Vec2::new(near.x_axis.dot(axis), near.y_axis.dot(axis)).normalize_or_zero();
    Mat2::from_cols(column(far.x_axis), column(far.y_axis))
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
