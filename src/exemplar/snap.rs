//! Live wire: an outline that snaps to the exemplar's edges while it is drawn.
//!
//! Based on: Mortensen, Barrett, "Intelligent scissors for image composition" (1995).
//!
//! 1. Every pixel gets a cost, low on edges ([`Edges`]): how weak its gradient is, and whether the gradient is strongest there
//!    across the edge; and a direction, along the edge.
//! 2. From an anchor the cheapest ways over neighbouring pixels grow outward ([`Wire`], Dijkstra). A step costs what the pixel it
//!    leads to costs, and how far it turns off the edges at its two ends.
//! 3. The way to the pixel under the pointer is read off as soon as it is settled; moving the pointer further goes on from there.
//!
//! Where we differ: zero crossings of the Laplacian are everywhere in a photograph's noise; a pixel counts instead if its gradient
//! is no weaker than those of its two neighbours across the edge. The gradient is that of the channel where it is strongest, of
//! encoded values, as the eye sees them. And all of a step's cost is multiplied by its length, so that ways do not prefer diagonals.

use super::Image;
use super::srgb::to_byte;
use glam::{IVec2, Vec2};
use rayon::prelude::*;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// Shares of a step's cost: off the crest of an edge, a weak gradient, turned off the edge.
const CREST: f32 = 0.43;
const WEAK: f32 = 0.27;
const TURNED: f32 = 0.3;

/// This share of all gradients counts as strongest: a few extreme ones would make all others look weak.
const STRONGEST: f32 = 0.98;

/// A gradient weaker than this share of the strongest has no crest worth a name.
const FAINT: f32 = 0.08;

/// Cost of the dearest straight step.
const FULL: f32 = 100.0;

/// What every step costs at least, so that ways along perfect edges are short ones too.
const LEAST: f32 = 3.0;

/// Widths of the window around an anchor that ways stay in, pixels from the anchor to its side.
pub const REACH: u32 = 384;

/// The edges of an exemplar: what a wire goes by.
#[derive(Debug, Clone)]
pub struct Edges {
    size: IVec2,
    /// Per pixel, 0 on the crest of a strong edge, up to [`CREST`] + [`WEAK`].
    cost: Vec<f32>,
    /// Per pixel, along the edge, as long as the gradient is strong: at most 1.
    along: Vec<Vec2>,
}

impl Edges {
    /// Finds the edges of an image of linear light. Linear.
    #[must_use]
    pub fn new(image: &Image) -> Self {
        let [w, h] = image.size().map(|n| n as usize);
        let components = image.components();
        let mut strongest = vec![Vec2::ZERO; w * h];
        for channel in 0..components {
            let seen: Vec<f32> =
                image.data().par_iter().skip(channel).step_by(components).map(|&v| f32::from(to_byte(v))).collect();
            let smooth = blurred(&seen, w, h);
            strongest.par_iter_mut().enumerate().for_each(|(i, best)| {
                let found = gradient(&smooth, w, h, i % w, i / w);
                if found.length_squared() > best.length_squared() {
                    *best = found;
                }
            });
        }
        let mut sorted: Vec<f32> = strongest.par_iter().map(|g| g.length()).collect();
        let rank = ((sorted.len() - 1) as f32 * STRONGEST) as usize;
        let full = sorted.select_nth_unstable_by(rank, f32::total_cmp).1.max(f32::MIN_POSITIVE);
        let strength = |x: i64, y: i64| {
            let (x, y) = (x.clamp(0, w as i64 - 1) as usize, y.clamp(0, h as i64 - 1) as usize);
            strongest[y * w + x].length() / full
        };
        let of = |i: usize| {
            let (x, y) = ((i % w) as i64, (i / w) as i64);
            let own = strength(x, y);
            let across = strongest[i].normalize_or_zero();
            let (dx, dy) = (across.x.round() as i64, across.y.round() as i64);
            let crest = own > FAINT && own >= strength(x + dx, y + dy) && own >= strength(x - dx, y - dy);
            let shown = own.min(1.0);
            let cost = WEAK * (1.0 - shown) + if crest { 0.0 } else { CREST };
            (cost, across.perp() * shown)
        };
        let (cost, along) = (0..w * h).into_par_iter().map(of).unzip();
        Self { size: IVec2::new(w as i32, h as i32), cost, along }
    }

    /// Width and height in pixels.
    #[must_use]
    pub fn size(&self) -> [u32; 2] {
        self.size.to_array().map(|n| n as u32)
    }

    /// The middle of the pixel with the clearest edge within `reach` pixels; of equally clear ones the nearest.
    #[must_use]
    pub fn snap(&self, at: Vec2, reach: f32) -> Vec2 {
        let middle = self.pixel(at);
        let r = reach.clamp(0.0, 64.0).ceil() as i32;
        let mut best = (self.cost[self.index(middle)], 0.0, middle);
        for dy in -r..=r {
            for dx in -r..=r {
                let p = middle + IVec2::new(dx, dy);
                let far = ((dx * dx + dy * dy) as f32).sqrt();
                if far > reach || p != self.inside(p) {
                    continue;
                }
                let cost = self.cost[self.index(p)];
                if (cost, far) < (best.0, best.1) {
                    best = (cost, far, p);
                }
            }
        }
        centre(best.2)
    }

    fn inside(&self, p: IVec2) -> IVec2 {
        p.clamp(IVec2::ZERO, self.size - 1)
    }

    /// The pixel at a place; that nearest to a place outside.
    fn pixel(&self, at: Vec2) -> IVec2 {
        self.inside(at.floor().as_ivec2())
    }

    fn index(&self, p: IVec2) -> usize {
        (p.y * self.size.x + p.x) as usize
    }

    /// What the step from a pixel to its neighbour costs.
    fn step(&self, from: usize, to: usize, step: IVec2) -> u32 {
        let way = step.as_vec2();
        let length = way.length();
        let way = way / length;
        let off = |i: usize| 1.0 - self.along[i].dot(way).abs();
        let turned = 0.5 * TURNED * (off(from) + off(to));
        ((LEAST + FULL * (self.cost[to] + turned)) * length) as u32
    }
}

fn centre(p: IVec2) -> Vec2 {
    p.as_vec2() + 0.5
}

/// Blurred by the binomial 1 4 6 4 1 along both axes: noise of single pixels is no edge.
fn blurred(values: &[f32], w: usize, h: usize) -> Vec<f32> {
    const KERNEL: [f32; 5] = [1.0 / 16.0, 4.0 / 16.0, 6.0 / 16.0, 4.0 / 16.0, 1.0 / 16.0];
    let along = |values: &[f32], at: &(dyn Fn(usize, i64) -> usize + Sync)| -> Vec<f32> {
        let of = |i: usize| (0..5).map(|k| KERNEL[k] * values[at(i, k as i64 - 2)]).sum();
        (0..values.len()).into_par_iter().map(of).collect()
    };
    let moved = |x: usize, by: i64, n: usize| (x as i64 + by).clamp(0, n as i64 - 1) as usize;
    let rows = along(values, &|i, by| i - i % w + moved(i % w, by, w));
    along(&rows, &|i, by| moved(i / w, by, h) * w + i % w)
}

/// Sobel's gradient.
fn gradient(values: &[f32], w: usize, h: usize, x: usize, y: usize) -> Vec2 {
    let (left, right) = (x.saturating_sub(1), (x + 1).min(w - 1));
    let (top, bottom) = (y.saturating_sub(1), (y + 1).min(h - 1));
    let at = |x: usize, y: usize| values[y * w + x];
    let dx = at(right, top) + 2.0 * at(right, y) + at(right, bottom) - at(left, top) - 2.0 * at(left, y) - at(left, bottom);
    let dy = at(left, bottom) + 2.0 * at(x, bottom) + at(right, bottom) - at(left, top) - 2.0 * at(x, top) - at(right, top);
    Vec2::new(dx, dy)
}

const STEPS: [IVec2; 8] = [
    IVec2::new(1, 0),
    IVec2::new(0, 1),
    IVec2::new(-1, 0),
    IVec2::new(0, -1),
    IVec2::new(1, 1),
    IVec2::new(-1, 1),
    IVec2::new(-1, -1),
    IVec2::new(1, -1),
];

const FAR: u32 = u32::MAX;
const NO_STEP: u8 = u8::MAX;

/// The cheapest ways from an anchor, as far as they were looked for.
#[derive(Debug, Clone)]
pub struct Wire {
    from: IVec2,
    /// The window's first pixel and its size.
    low: IVec2,
    size: IVec2,
    cost: Vec<u32>,
    /// Which of [`STEPS`] led to each pixel.
    by: Vec<u8>,
    settled: Vec<bool>,
    front: BinaryHeap<Reverse<(u32, u32)>>,
}

impl Wire {
    /// From an anchor, in a window of [`REACH`] pixels around it.
    #[must_use]
    pub fn new(edges: &Edges, from: Vec2) -> Self {
        let from = edges.pixel(from);
        let reach = IVec2::splat(REACH as i32);
        let low = edges.inside(from - reach);
        let size = edges.inside(from + reach) - low + 1;
        let count = (size.x * size.y) as usize;
        let mut wire = Self {
            from,
            low,
            size,
            cost: vec![FAR; count],
            by: vec![NO_STEP; count],
            settled: vec![false; count],
            front: BinaryHeap::new(),
        };
        let start = wire.index(from);
        wire.cost[start] = 0;
        wire.front.push(Reverse((0, start as u32)));
        wire
    }

    /// The anchor: the middle of its pixel.
    #[must_use]
    pub fn from(&self) -> Vec2 {
        centre(self.from)
    }

    /// The cheapest way from the anchor to a place, pixel by pixel, both ends included; beyond the window it goes on straight.
    /// `None` if it takes settling more than `most` further pixels to know: ask again, or make do with a straight line.
    pub fn to(&mut self, edges: &Edges, at: Vec2, most: usize) -> Option<Vec<Vec2>> {
        let goal = edges.pixel(at);
        let seen = goal.clamp(self.low, self.low + self.size - 1);
        let end = self.index(seen);
        let mut left = most;
        while !self.settled[end] {
            left = left.checked_sub(1)?;
            self.settle(edges)?;
        }
        let mut way = Vec::new();
        if seen != goal {
            way.push(centre(goal));
        }
        let mut p = seen;
        loop {
            way.push(centre(p));
            match self.by[self.index(p)] {
                NO_STEP => break,
                by => p -= STEPS[usize::from(by)],
            }
        }
        way.reverse();
        Some(way)
    }

    fn index(&self, p: IVec2) -> usize {
        let q = p - self.low;
        (q.y * self.size.x + q.x) as usize
    }

    /// Settles the cheapest pixel of the front. `None` if there is none.
    fn settle(&mut self, edges: &Edges) -> Option<()> {
        let (cost, i) = loop {
            let Reverse((cost, i)) = self.front.pop()?;
            if !self.settled[i as usize] {
                break (cost, i as i32);
            }
        };
        self.settled[i as usize] = true;
        let p = self.low + IVec2::new(i % self.size.x, i / self.size.x);
        for (k, &step) in STEPS.iter().enumerate() {
            let q = p + step;
            if q.clamp(self.low, self.low + self.size - 1) != q {
                continue;
            }
            let j = self.index(q);
            let through = cost.saturating_add(edges.step(edges.index(p), edges.index(q), step));
            if !self.settled[j] && through < self.cost[j] {
                self.cost[j] = through;
                self.by[j] = k as u8;
                self.front.push(Reverse((through, j as u32)));
            }
        }
        Some(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;
    use glam::Vec3;

    const MIDDLE: Vec2 = Vec2::new(97.0, 103.0);
    const RADIUS: f32 = 60.0;

    /// A disc that is redder than its ground, both with noise, its edge a pixel soft.
    fn disc() -> Image {
        let mut random = Random::new(7, 7);
        Image::from_fn(200, 200, |x, y| {
            let inside = (RADIUS - Vec2::new(x as f32 + 0.5, y as f32 + 0.5).distance(MIDDLE) + 0.5).clamp(0.0, 1.0);
            let noise = random.range(-0.02, 0.02) as f32;
            Vec3::new(0.3 + 0.25 * inside, 0.3, 0.25) + noise
        })
    }

    fn on_circle(angle: f32, radius: f32) -> Vec2 {
        MIDDLE + Vec2::from_angle(angle) * radius
    }

    #[test]
    fn a_wire_runs_on_the_edge_of_a_disc() {
        let edges = Edges::new(&disc());
        for (from, to) in [(0.3, 1.8), (4.0, 2.5), (5.5, 7.2)] {
            // The pointer is a few pixels off the edge; the anchors snap to it.
            let [a, b] = [on_circle(from, RADIUS + 3.0), on_circle(to, RADIUS - 3.0)].map(|p| edges.snap(p, 6.0));
            let way = Wire::new(&edges, a).to(&edges, b, usize::MAX).expect("unbounded");
            assert_eq!((way[0], way[way.len() - 1]), (a, b), "from anchor to anchor");
            let off = way.iter().map(|p| (p.distance(MIDDLE) - RADIUS).abs()).fold(0.0, f32::max);
            assert!(off <= 1.0, "{off} pixels off the edge between {from} and {to}");
            let arc = RADIUS * (to - from).abs();
            assert!((way.len() as f32) < 1.2 * arc, "{} pixels for an arc of {arc}", way.len());
            assert!(way.windows(2).all(|w| w[0].distance(w[1]) < 1.5), "pixel by pixel");
        }
    }

    #[test]
    fn moving_the_pointer_on_gives_what_a_new_wire_gives() {
        let edges = Edges::new(&disc());
        let start = edges.snap(on_circle(0.0, RADIUS), 4.0);
        let mut live = Wire::new(&edges, start);
        for angle in [0.2, 0.9, 0.5, 1.4] {
            let at = on_circle(angle, RADIUS - 2.0);
            let fresh = Wire::new(&edges, start).to(&edges, at, usize::MAX);
            assert_eq!(live.to(&edges, at, usize::MAX), fresh, "to {angle}");
        }
        let far = on_circle(3.0, RADIUS);
        assert_eq!(live.to(&edges, far, 50), None, "not found with so little work");
        while live.to(&edges, far, 50).is_none() {}
        assert_eq!(live.to(&edges, far, 0), Wire::new(&edges, start).to(&edges, far, usize::MAX), "asked again and again");
    }

    #[test]
    fn beyond_the_window_and_the_image_a_wire_still_ends_where_it_can() {
        let wide = Image::grey_from_fn(1200, 8, |x, _| if x % 50 < 25 { 0.2 } else { 0.6 });
        let edges = Edges::new(&wide);
        let way = Wire::new(&edges, Vec2::new(-5.0, 4.0)).to(&edges, Vec2::new(5000.0, 4.0), usize::MAX).expect("unbounded");
        assert_eq!(way[0], Vec2::new(0.5, 4.5), "from the nearest pixel");
        assert_eq!(way[way.len() - 1], Vec2::new(1199.5, 4.5), "to the nearest pixel");
        let tiny = Edges::new(&Image::grey_from_fn(1, 1, |_, _| 0.5));
        assert_eq!(tiny.snap(Vec2::new(9.0, 9.0), 3.0), Vec2::splat(0.5), "one pixel");
        assert_eq!(Wire::new(&tiny, Vec2::ZERO).to(&tiny, Vec2::ONE, 10), Some(vec![Vec2::splat(0.5)]), "one pixel");
    }
}
