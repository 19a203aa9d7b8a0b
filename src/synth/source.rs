//! What is synthesised from: the levels of an example image, or of a coloured mesh (the transfer that WL sec. 5 leaves to the
//! future: the image pyramid and its neighbourhoods are replaced by a mesh pyramid and its own).

use super::levels::Levels;
use super::neighbourhood::{Neighbourhoods, Values};
use super::search::Between;
use super::window::Window;
use crate::exemplar::Wrap;
use crate::exemplar::stack::Stack;
use glam::Vec2;
use rayon::prelude::*;

/// Windows that reach over the edge of an exemplar that does not tile are left out; but at least the middle half of each side is
/// kept, or small levels would have nothing left to choose from.
const KEPT: usize = 4;

/// A place of the exemplar.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Place {
    /// Pixel coordinates on the level's image; (0.5, 0.5) is the middle of the first pixel.
    Pixel([f32; 2]),
    /// A vertex of the level's mesh.
    Vertex(u32),
}

/// The exemplar.
#[derive(Debug, Clone)]
pub enum Source {
    /// Levels of an image, the finest first.
    Image(Vec<Stack>),
    /// A mesh with numbers at its vertices.
    Mesh(Box<MeshSource>),
}

/// A mesh pyramid with numbers at the vertices of each level.
#[derive(Debug, Clone)]
pub struct MeshSource {
    pub(super) levels: Levels,
    pub(super) values: Vec<Values>,
}

impl Source {
    /// The levels of an image.
    #[must_use]
    pub fn image(stack: &Stack, levels: usize) -> Self {
        Self::Image(stack.pyramid(levels))
    }

    /// A mesh pyramid with `components` numbers at each vertex of its finest level; coarser levels are filtered from it.
    #[must_use]
    pub fn mesh(levels: Levels, components: usize, values: &[f32]) -> Self {
        let values = super::convolve::pyramid(&levels, components.max(1), values);
        Self::Mesh(Box::new(MeshSource { levels, values }))
    }

    /// How many levels.
    #[must_use]
    pub const fn len(&self) -> usize {
        match self {
            Self::Image(stacks) => stacks.len(),
            Self::Mesh(source) => source.levels.len(),
        }
    }

    /// True if there are none.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Numbers at each place.
    #[must_use]
    pub fn components(&self) -> usize {
        match self {
            Self::Image(stacks) => stacks.first().map_or(1, |s| s.components),
            Self::Mesh(source) => source.values.first().map_or(1, |v| v.components),
        }
    }

    /// Places on a level.
    #[must_use]
    pub fn places(&self, level: usize) -> usize {
        match self {
            Self::Image(stacks) => stacks[level].size[0] * stacks[level].size[1],
            Self::Mesh(source) => source.levels.levels()[level].mesh.vertex_count(),
        }
    }

    /// The mean over a level, which stands for what nothing covers (WL 3.3).
    pub(super) fn mean(&self, level: usize) -> Vec<f32> {
        match self {
            Self::Image(stacks) => stacks[level].mean(),
            Self::Mesh(source) => {
                let values = &source.values[level];
                let count = values.data.len() / values.components;
                values.of(count as u32 - 1).to_vec()
            }
        }
    }

    /// The numbers at a place of a level.
    pub(super) fn value(&self, level: usize, place: Place, out: &mut [f32]) {
        match (self, place) {
            (Self::Image(stacks), Place::Pixel(at)) => {
                out.fill(0.0);
                stacks[level].sample(at, out);
            }
            (Self::Mesh(source), Place::Vertex(v)) => out.copy_from_slice(source.values[level].of(v)),
            // A place of the other kind is never made.
            _ => out.fill(0.0),
        }
    }
}

/// The places of one level that may be chosen, with their neighbourhoods.
pub(super) struct Candidates<'a> {
    source: &'a Source,
    level: usize,
    window: Window,
    middle: bool,
    /// Numbers of all chosen places: pixel or vertex.
    ids: Vec<u32>,
    /// For each pixel or vertex its row, or `u32::MAX`.
    rows: Vec<u32>,
    /// What windows are read from.
    kind: Kind<'a>,
}

enum Kind<'a> {
    Image { own: Stack, coarser: &'a [Stack] },
    Mesh { around: Neighbourhoods, values: &'a [Values] },
}

impl<'a> Candidates<'a> {
    /// The candidates of a level. With `soft`, windows of images are as soft as resampled ones.
    pub(super) fn new(source: &'a Source, level: usize, window: Window, middle: bool, soft: bool) -> Self {
        let window = Window { levels: window.levels.min((source.len() - level) as u32), ..window };
        let all = source.places(level);
        let (ids, kind): (Vec<u32>, Kind) = match source {
            Source::Image(stacks) => {
                let stack = &stacks[level];
                let own = if soft { stack.softened() } else { stack.clone() };
                let margin = |n: usize| match stack.wrap {
                    Wrap::Repeat => 0,
                    Wrap::Clamp => (window.radius() as usize).min((n - 1) / KEPT),
                };
                let [w, h] = stack.size;
                let inside = |i: &u32| {
                    let (x, y) = (*i as usize % w, *i as usize / w);
                    let within = |x: usize, n: usize| x >= margin(n) && x < n - margin(n);
                    within(x, w) && within(y, h)
                };
                ((0..all as u32).filter(inside).collect(), Kind::Image { own, coarser: &stacks[level + 1..] })
            }
            Source::Mesh(source) => {
                let around = source.levels.neighbourhoods(level, window, middle);
                ((0..all as u32).collect(), Kind::Mesh { around, values: &source.values[level..] })
            }
        };
        let mut rows = vec![u32::MAX; all];
        ids.iter().enumerate().for_each(|(row, &id)| rows[id as usize] = row as u32);
        Self { source, level, window, middle, ids, rows, kind }
    }

    pub(super) const fn len(&self) -> usize {
        self.ids.len()
    }

    /// The neighbourhood of a candidate: samples of its own level, unless `up_only`, then those of coarser levels.
    pub(super) fn row(&self, index: usize, up_only: bool, out: &mut Vec<f32>) {
        let id = self.ids[index];
        match &self.kind {
            Kind::Image { own, coarser } => {
                let (x, y) = (i64::from(id) % own.size[0] as i64, i64::from(id) / own.size[0] as i64);
                if !up_only {
                    let radius = i64::from(self.window.radius());
                    for dy in -radius..=radius {
                        for dx in -radius..=radius {
                            if self.middle || (dx, dy) != (0, 0) {
                                out.extend_from_slice(own.pixel(x + dx, y + dy));
                            }
                        }
                    }
                }
                let mut at = [x as f32 + 0.5, y as f32 + 0.5];
                for (stack, radius) in coarser.iter().zip(self.window.coarser()) {
                    at = at.map(|a| a / 2.0);
                    for dy in -radius..=radius {
                        for dx in -radius..=radius {
                            let start = out.len();
                            out.resize(start + stack.components, 0.0);
                            stack.sample([at[0] + dx as f32, at[1] + dy as f32], &mut out[start..]);
                        }
                    }
                }
            }
            Kind::Mesh { around, values } => {
                if !up_only {
                    around.own.gather(id, &values[0], out);
                }
                around.coarser.iter().zip(&values[1..]).for_each(|(samples, values)| samples.gather(id, values, out));
            }
        }
    }

    /// All rows.
    pub(super) fn matrix(&self, up_only: bool) -> crate::numeric::rows::Rows {
        let rows: Vec<Vec<f32>> = (0..self.len()).into_par_iter().with_min_len(64).map(|i| self.one(i, up_only)).collect();
        let mut out = crate::numeric::rows::Rows::new(rows.first().map_or(1, Vec::len));
        rows.iter().for_each(|r| out.push(r));
        out
    }

    /// One row of its own.
    pub(super) fn one(&self, index: usize, up_only: bool) -> Vec<f32> {
        let mut out = Vec::new();
        self.row(index, up_only, &mut out);
        out
    }

    /// The place of a row.
    pub(super) fn place(&self, row: u32) -> Place {
        let id = self.ids[row as usize];
        match self.source {
            Source::Image(stacks) => {
                let w = stacks[self.level].size[0] as u32;
                Place::Pixel([(id % w) as f32 + 0.5, (id / w) as f32 + 0.5])
            }
            Source::Mesh(_) => Place::Vertex(id),
        }
    }

    /// The place `offset` away (right and up, in samples) from another, and what it blends.
    pub(super) fn shifted(&self, from: Place, offset: Vec2) -> Option<(Place, Between)> {
        match (&self.kind, from) {
            (Kind::Image { own, .. }, Place::Pixel([x, y])) => self.pixel([x + offset.x, y - offset.y], own),
            (Kind::Mesh { around, .. }, Place::Vertex(v)) => {
                let radius = self.window.radius();
                let [dx, dy] = offset.to_array().map(|o| o.round() as i32);
                if (dx, dy) == (0, 0) || dx.abs() > radius || dy.abs() > radius {
                    return ((dx, dy) == (0, 0)).then_some((from, Between::at(self.rows[v as usize])));
                }
                let side = 2 * radius + 1;
                let index = (radius - dy) * side + radius + dx;
                let before_middle = self.middle || index < side * side / 2;
                let blend = around.own.of(v)[index as usize - usize::from(!before_middle)];
                let best = (0..3).max_by(|&a, &b| blend.shares[a].total_cmp(&blend.shares[b]))?;
                let to = blend.vertices[best];
                ((to as usize) < self.rows.len()).then(|| (Place::Vertex(to), Between::at(self.rows[to as usize])))
            }
            _ => None,
        }
    }

    /// The place on this level that a place of the next coarser one, `offset` away (in that level's samples), stands for.
    pub(super) fn finer(&self, from: Place, offset: Vec2) -> Option<(Place, Between)> {
        match (&self.kind, from) {
            (Kind::Image { own, .. }, Place::Pixel([x, y])) => self.pixel([2.0 * (x + offset.x), 2.0 * (y - offset.y)], own),
            _ => None,
        }
    }

    fn pixel(&self, at: [f32; 2], own: &Stack) -> Option<(Place, Between)> {
        let mut at = at;
        for (a, n) in at.iter_mut().zip(own.size) {
            let n = n as f32;
            if own.wrap == Wrap::Repeat {
                *a = a.rem_euclid(n);
                // Just below zero the remainder rounds up to the whole.
                *a = if *a >= n { 0.0 } else { *a };
            }
            if !(0.0..n).contains(a) {
                return None;
            }
        }
        let [w, h] = own.size.map(|n| n as i64);
        let row = |x: i64, y: i64| {
            let (x, y) = match own.wrap {
                Wrap::Repeat => (x.rem_euclid(w), y.rem_euclid(h)),
                Wrap::Clamp => (x.clamp(0, w - 1), y.clamp(0, h - 1)),
            };
            self.rows[(y * w + x) as usize]
        };
        let here = row(at[0] as i64, at[1] as i64);
        if here == u32::MAX {
            return None;
        }
        let low = at.map(|a| (a - 0.5).floor());
        let ([u, v], [x, y]) = ([at[0] - 0.5 - low[0], at[1] - 0.5 - low[1]], low.map(|l| l as i64));
        let rows = [row(x, y), row(x + 1, y), row(x, y + 1), row(x + 1, y + 1)].map(|r| if r == u32::MAX { here } else { r });
        let shares = [(1.0 - u) * (1.0 - v), u * (1.0 - v), (1.0 - u) * v, u * v];
        Some((Place::Pixel(at), Between { rows, shares }))
    }
}
