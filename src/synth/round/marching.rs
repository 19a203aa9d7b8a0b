//! What marching found about all vertices of a mesh, kept small, and the samples of any texture direction read from it.
//!
//! Based on: Chen, Dong 2008, sec. 4.2 and 4.3: a sample is a circle and a share of its length, counted from where the texture
//! direction meets the circle. So marching knows nothing of directions, and a new direction only reads.
//!
//! A crossing takes four bytes: its angle, its way along the curve, and by which edge the curve leaves the face that begins there. The
//! half-edges themselves follow from the first one. An open curve, which a boundary cuts short, has no length to take shares of:
//! its samples lie at the angles of the plane, as far as it goes.

use super::cache::mesh_key;
use super::march::{Axis, Curve, Marcher, difference, turned};
use super::template::{MOST_CIRCLES, Template};
use super::{Grid, RoundError};
use crate::mesh::{Mesh, NONE, SurfacePoint, next};
use crate::progress::Progress;
use glam::{DVec2, DVec3};
use rayon::prelude::*;
use serde::Serialize;
use std::f64::consts::TAU;
use std::sync::atomic::{AtomicU64, Ordering};

/// Vertices that one task marches about.
const CHUNK: usize = 512;

/// Steps of angles and of ways: an angle is off by a fifth of a thousandth at most, a way by as little of the whole.
const STEPS: u32 = 1 << 15;

/// Angles that differ by less are equal but for rounding.
const ROUNDING: f64 = 1e-9;

/// Crossings kept at most; with more, faces are far smaller than pixels.
const MOST_CROSSINGS: f64 = (1_u64 << 31) as f64;

/// Mean crossings of a circle for each of its radius in mean edges: 2 pi times the edges that a line of one edge's length meets.
const EXPECTED: f64 = 12.0;

/// A curve as it is kept.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Arc {
    pub(super) half_edge: u32,
    /// Its first crossing.
    pub(super) first: u32,
    /// World length; negative if the curve is open.
    pub(super) length: f32,
}

/// What marching met.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct MarchingStatistics {
    /// Circles that go around their vertex.
    pub closed: u64,
    /// Circles of which boundaries leave only parts.
    pub open: u64,
    /// Circles that are not there: about spikes, and where a limb is thinner than the circle.
    pub missing: u64,
    /// Vertices one of whose circles is not closed.
    pub incomplete: u64,
    /// Places where circles meet edges.
    pub crossings: u64,
}

/// The circles about every vertex of a mesh.
#[derive(Debug, Clone, PartialEq)]
pub struct Marching {
    /// Of which mesh.
    pub(super) key: u64,
    /// World length of a pixel of the finest level.
    pub(super) pixel: f64,
    /// Radii, pixels of the finest level, rising.
    pub(super) radii: Vec<u32>,
    /// The first arc of each circle of each vertex, and one past the last.
    pub(super) starts: Vec<u32>,
    pub(super) arcs: Vec<Arc>,
    pub(super) crossings: Vec<u32>,
    pub(super) statistics: MarchingStatistics,
}

/// A sample on a face: weights of its first two corners in 65,535ths.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Packed {
    pub(super) face: u32,
    weights: [u16; 2],
}

impl Default for Packed {
    /// No sample.
    fn default() -> Self {
        Self { face: NONE, weights: [0; 2] }
    }
}

impl Packed {
    fn new(face: u32, weights: [f64; 3]) -> Self {
        let positive = weights.map(|w| if w > 0.0 { w } else { 0.0 });
        let sum: f64 = positive.iter().sum();
        let whole = |w: f64| if sum > 0.0 { (w / sum * 65535.0).round() as u16 } else { 21845 };
        let first = whole(positive[0]);
        Self { face, weights: [first, whole(positive[1]).min(65535 - first)] }
    }

    /// Weights of the face's corners.
    #[inline]
    pub(super) fn shares(self) -> [f32; 3] {
        let [a, b] = self.weights.map(i32::from);
        [a, b, 65535 - a - b].map(|w| w as f32 / 65535.0)
    }
}

/// Radii of all levels' circles, pixels of the finest level: each level's circles are twice as wide as those of the one before
/// (sec. 6.2), so that many are the same.
pub(super) fn radii(circles: usize, levels: usize) -> Vec<u32> {
    let mut out: Vec<u32> = (0..levels).flat_map(|l| (1..=circles as u32).map(move |m| m << l)).collect();
    out.sort_unstable();
    out.dedup();
    out
}

impl Marching {
    /// Marches about every vertex of a mesh.
    ///
    /// # Errors
    /// If circles would cross too many faces to be kept, or `progress` cancels.
    pub fn new(mesh: &Mesh, grid: Grid, progress: &dyn Progress) -> Result<Self, RoundError> {
        let grid = grid.checked()?;
        let radii = radii(grid.circles, grid.levels);
        let (first, normals) = (mesh.vertex_half_edges(), mesh.vertex_normals());
        let edge = crate::synth::spacing(mesh);
        let vertices = mesh.vertex_count();
        let expected: f64 = radii.iter().map(|&r| EXPECTED * f64::from(r) * grid.pixel / edge * vertices as f64).sum();
        if !(expected < MOST_CROSSINGS) {
            return Err(RoundError::TooFine { vertices, pixel: grid.pixel, edge });
        }
        progress.stage("marching", vertices as u64);
        let done = AtomicU64::new(0);
        let chunk = |c: usize| -> Self {
            let range = c * CHUNK..((c + 1) * CHUNK).min(vertices);
            let mut out = Self::empty();
            if progress.cancelled() {
                return out;
            }
            let (mut marcher, mut curves) = (Marcher::new(mesh, &first), Vec::new());
            for v in range.clone() {
                let axis = Axis::new(mesh.point(v as u32), normals[v].as_dvec3());
                let before = out.statistics.closed;
                for &radius in &radii {
                    marcher.curves(v as u32, axis, f64::from(radius) * grid.pixel, &mut curves);
                    out.starts.push(out.arcs.len() as u32);
                    out.add(mesh, &curves);
                }
                out.statistics.incomplete += u64::from(out.statistics.closed - before < radii.len() as u64);
            }
            progress.done(done.fetch_add(range.len() as u64, Ordering::Relaxed) + range.len() as u64);
            out
        };
        let chunks: Vec<Self> = (0..vertices.div_ceil(CHUNK)).into_par_iter().map(chunk).collect();
        if progress.cancelled() {
            return Err(RoundError::Cancelled);
        }
        let mut all = Self { key: mesh_key(mesh), pixel: grid.pixel, radii: radii.clone(), ..Self::empty() };
        all.starts.reserve_exact(vertices * radii.len() + 1);
        all.arcs.reserve_exact(chunks.iter().map(|c| c.arcs.len()).sum());
        all.crossings.reserve_exact(chunks.iter().map(|c| c.crossings.len()).sum());
        for chunk in chunks {
            let (arcs, crossings) = (all.arcs.len() as u32, all.crossings.len() as u32);
            all.starts.extend(chunk.starts.iter().map(|s| s + arcs));
            all.arcs.extend(chunk.arcs.iter().map(|a| Arc { first: a.first + crossings, ..*a }));
            all.crossings.extend_from_slice(&chunk.crossings);
            let (sum, s) = (&mut all.statistics, chunk.statistics);
            sum.closed += s.closed;
            sum.open += s.open;
            sum.missing += s.missing;
            sum.incomplete += s.incomplete;
            sum.crossings += s.crossings;
        }
        all.starts.push(all.arcs.len() as u32);
        Ok(all)
    }

    const fn empty() -> Self {
        let statistics = MarchingStatistics { closed: 0, open: 0, missing: 0, incomplete: 0, crossings: 0 };
        Self { key: 0, pixel: 0.0, radii: Vec::new(), starts: Vec::new(), arcs: Vec::new(), crossings: Vec::new(), statistics }
    }

    /// What marching met.
    #[must_use]
    pub const fn statistics(&self) -> MarchingStatistics {
        self.statistics
    }

    /// World length of a pixel of the finest level.
    #[must_use]
    pub const fn pixel(&self) -> f64 {
        self.pixel
    }

    /// The [`mesh_key`] of its mesh.
    #[must_use]
    pub const fn key(&self) -> u64 {
        self.key
    }

    /// Bytes it takes.
    #[must_use]
    pub const fn bytes(&self) -> usize {
        4 * self.starts.len() + size_of::<Arc>() * self.arcs.len() + 4 * self.crossings.len()
    }

    /// True if it was made for these circles and levels.
    #[must_use]
    pub fn fits(&self, grid: Grid) -> bool {
        self.pixel == grid.pixel && self.radii == radii(grid.circles.clamp(1, MOST_CIRCLES), grid.levels)
    }

    /// The length of a vertex's closed circle, world units, if it has one; circles are counted over all levels by rising radius.
    #[must_use]
    pub fn length(&self, vertex: u32, circle: usize) -> Option<f64> {
        match self.arcs_of(vertex, circle) {
            [arc] if arc.length > 0.0 => Some(f64::from(arc.length)),
            _ => None,
        }
    }

    /// The samples of a level of the neighbourhoods of some vertices, each in a texture direction of its own, in the template's order.
    /// `mesh` is the one that was marched about; for another one, and for vertices that it does not have, there are none.
    #[must_use]
    pub fn places(&self, mesh: &Mesh, of: &[(u32, DVec3)], level: usize, template: &Template) -> Vec<Vec<Option<SurfacePoint>>> {
        let (same, normals) = (mesh_key(mesh) == self.key, mesh.vertex_normals());
        let mut reader = Reader::new(mesh, &normals);
        let mut one = |&(vertex, right): &(u32, DVec3)| {
            let mut out = vec![Packed::default(); template.samples().len()];
            if same && (vertex as usize) < mesh.vertex_count() {
                self.samples(&mut reader, vertex, level, right, template, &mut out);
            }
            let point = |p: &Packed| (p.face != NONE).then(|| SurfacePoint { face: p.face, bary: p.shares().into() });
            out.iter().map(point).collect()
        };
        of.iter().map(&mut one).collect()
    }

    fn arcs_of(&self, vertex: u32, circle: usize) -> &[Arc] {
        let at = vertex as usize * self.radii.len() + circle;
        &self.arcs[self.starts[at] as usize..self.starts[at + 1] as usize]
    }

    fn add(&mut self, mesh: &Mesh, curves: &[Curve]) {
        match curves {
            [] => self.statistics.missing += 1,
            [one] if one.closed => self.statistics.closed += 1,
            _ => self.statistics.open += 1,
        }
        for curve in curves {
            let c = &curve.crossings;
            let (first, sign) = (self.crossings.len() as u32, if curve.closed { 1.0 } else { -1.0 });
            self.arcs.push(Arc {
                half_edge: c[0].half_edge,
                first,
                length: sign * curve.length.max(f64::from(f32::MIN_POSITIVE)) as f32,
            });
            self.statistics.crossings += c.len() as u64;
            for (i, crossing) in c.iter().enumerate() {
                let out = match c.get(i + 1) {
                    // The last half-edge of an open curve is on the last face itself.
                    Some(last) if !curve.closed && i + 2 == c.len() => last.half_edge,
                    Some(after) => mesh.opposite[after.half_edge as usize],
                    None if curve.closed => mesh.opposite[c[0].half_edge as usize],
                    None => crossing.half_edge,
                };
                let turn = match out {
                    h if h == crossing.half_edge => 0,
                    h if h == next(crossing.half_edge) => 1,
                    _ => 2,
                };
                let angle = (crossing.angle / TAU * f64::from(STEPS)).round() as i64 as u32 & (STEPS - 1);
                let way = (crossing.way / curve.length.max(f64::MIN_POSITIVE) * f64::from(STEPS - 1)).round() as u32;
                self.crossings.push(angle << 17 | way.min(STEPS - 1) << 2 | turn);
            }
        }
    }

    /// The samples of a level's circles in a texture direction, in the template's order; [`Packed::default`] where there is nothing.
    pub(super) fn samples(
        &self,
        reader: &mut Reader,
        vertex: u32,
        level: usize,
        right: DVec3,
        template: &Template,
        out: &mut [Packed],
    ) {
        out.fill(Packed::default());
        let axis = Axis::new(reader.mesh.point(vertex), reader.normals[vertex as usize].as_dvec3());
        let start = axis.angle(right);
        for circle in 0..template.circles() {
            let radius = (circle as u32 + 1) << level;
            let Ok(index) = self.radii.binary_search(&radius) else { continue };
            let range = template.range(circle);
            let samples = template.samples()[range.clone()].iter().map(|s| s.share);
            let out = &mut out[range];
            for arc in self.arcs_of(vertex, index) {
                reader.decode(arc, &self.crossings[arc.first as usize..]);
                let radius = f64::from(radius) * self.pixel;
                if arc.length > 0.0 {
                    reader.closed(&axis, radius, start, samples.clone(), out);
                } else {
                    reader.open(&axis, radius, start, samples.clone(), out);
                }
            }
        }
    }
}

/// A piece of a curve, on one face.
#[derive(Debug, Clone, Copy)]
struct Piece {
    face: u32,
    /// Where it begins, radians, and how far it turns.
    angle: f64,
    turn: f64,
    /// Where it ends, as a share of the curve's length.
    end: f64,
}

/// Room for reading curves, used again and again.
pub(super) struct Reader<'a> {
    mesh: &'a Mesh,
    normals: &'a [glam::Vec3],
    pieces: Vec<Piece>,
}

impl<'a> Reader<'a> {
    pub(super) const fn new(mesh: &'a Mesh, normals: &'a [glam::Vec3]) -> Self {
        Self { mesh, normals, pieces: Vec::new() }
    }

    /// Unfolds a curve. Its end is where it closes, or where its way is complete.
    fn decode(&mut self, arc: &Arc, crossings: &[u32]) {
        self.pieces.clear();
        let angle_of = |c: u32| f64::from(c >> 17) / f64::from(STEPS) * TAU;
        let way_of = |c: u32| f64::from(c >> 2 & (STEPS - 1)) / f64::from(STEPS - 1);
        let mut half_edge = arc.half_edge;
        for (i, &c) in crossings.iter().enumerate() {
            let out = turned(half_edge, c & 3);
            let over = self.mesh.opposite[out as usize];
            let closes = arc.length > 0.0 && over == arc.half_edge;
            let after = if closes { crossings[0] } else { crossings.get(i + 1).copied().unwrap_or(c) };
            let angle = angle_of(c);
            let end = if closes { 1.0 } else { way_of(after) };
            self.pieces.push(Piece { face: half_edge / 3, angle, turn: difference(angle, angle_of(after)), end });
            if closes || over == NONE {
                break;
            }
            half_edge = over;
        }
    }

    /// Samples of a closed curve at shares of its length from where the texture direction meets it.
    fn closed(&self, axis: &Axis, radius: f64, start: f64, shares: impl Iterator<Item = f64>, out: &mut [Packed]) {
        let n = self.pieces.len();
        let begin = |i: usize| if i == 0 { 0.0 } else { self.pieces[i - 1].end };
        // Where it has gone over that direction.
        let met = self.pieces.iter().position(|p| {
            let far = difference(p.angle, start);
            let (low, high) = if p.turn >= 0.0 { (0.0, p.turn) } else { (p.turn, 0.0) };
            (low - ROUNDING..=high + ROUNDING).contains(&far)
        });
        let Some(met) = met else { return };
        let piece = self.pieces[met];
        let part = if piece.turn == 0.0 { 0.0 } else { (difference(piece.angle, start) / piece.turn).clamp(0.0, 1.0) };
        let from = begin(met) + part * (piece.end - begin(met));
        let (mut i, mut rounds) = (met, 0.0);
        for (share, out) in shares.zip(out) {
            let to = from + share;
            while self.pieces[i].end + rounds < to && rounds < 2.0 {
                i += 1;
                if i == n {
                    (i, rounds) = (0, rounds + 1.0);
                }
            }
            let (p, low) = (self.pieces[i], begin(i));
            let part = if p.end > low { ((to - rounds - low) / (p.end - low)).clamp(0.0, 1.0) } else { 0.0 };
            *out = self.packed(axis, radius, p.face, p.angle + part * p.turn);
        }
    }

    /// Samples of an open curve at the angles of the plane, where it goes over them.
    fn open(&self, axis: &Axis, radius: f64, start: f64, shares: impl Iterator<Item = f64>, out: &mut [Packed]) {
        for (share, out) in shares.zip(out) {
            let angle = start + share * TAU;
            // Boundaries along the grid's own lines lie at the angles of samples: they count as on the surface.
            let slack = 2.0 * TAU / f64::from(STEPS);
            let over = |p: &&Piece| p.turn > 0.0 && (-slack..=p.turn + slack).contains(&difference(p.angle, angle));
            if let Some(piece) = self.pieces.iter().find(over) {
                *out = self.packed(axis, radius, piece.face, angle);
            }
        }
    }

    /// The point of a face at an angle on the circle.
    fn packed(&self, axis: &Axis, radius: f64, face: u32, angle: f64) -> Packed {
        let p = DVec2::from_angle(angle) * radius;
        let [a, b, c] = self.mesh.corners(face).map(|c| axis.seen(c).flat);
        let area = (b - a).perp_dot(c - a);
        let shares = [(b - p).perp_dot(c - p), (c - p).perp_dot(a - p), (a - p).perp_dot(b - p)];
        // Faces seen edge on have no place in the plane; Packed takes their middle then.
        Packed::new(face, shares.map(|s| s / area))
    }
}
