//! Flattening the surface around a point, far enough for a square neighbourhood.
//!
//! Based on: Wei, Levoy 2001, sec. 3.3: the patch around a vertex grows until it covers the template, and every template sample
//! is interpolated from the flattened triangle that contains it.
//!
//! We differ in how a new vertex finds its place. The paper averages triangles similar to those in space, which lets errors grow
//! from triangle to triangle. Here a vertex is placed by all its neighbours placed already: each knows where it lies in its own
//! tangent plane (the discrete exponential map of Schmidt, Grimm, Wyvill, "Interactive decal compositing with discrete
//! exponential maps", SIGGRAPH 2006), and their mean is taken (of three at most). Lengths along the way are true, nothing runs away, and a vertex costs a
//! few dozen operations. On a regular grid both are exact.
//!
//! 1. Start with the point's own vertex, or with the corners of its parent face projected along its normal (sec. 3.3).
//! 2. Ring by ring, place the neighbours of all vertices that lie within the template or close to it.
//! 3. Put each face into the plane: of those that flip, or are stretched because the patch has closed around a thin limb, the
//!    samples stay uncovered.

use super::fan::Fans;
use glam::Vec2;

/// Vertices this far outside the template are still grown from, in units of the spacing: enough on even meshes,
const MARGIN: f32 = 0.3;
/// and, where samples stay uncovered then, enough on all others.
const WIDE: f32 = 1.2;

/// A neighbour that would place a vertex farther than this from where the first one does lies on the other side of a limb.
const APART: f32 = 0.6;

/// Faces with an edge this many times shorter or longer than in space do not count.
const STRETCH: f32 = 2.0;

/// Vertices of a patch at most; a template of the longest side covers about a thousand.
const MOST: u32 = 1 << 13;

/// Neighbours that place a vertex at most; more hardly change their mean.
const ASKED: f32 = 3.0;

/// A sample this near to a vertex, as a share of the face, takes the vertex's value alone: rounding must not blend in others.
const SNAP: f32 = 1e-4;

/// Samples on an edge may lie outside the face by rounding.
const EDGE: f32 = 1e-5;

/// Where a vertex lies in the plane, and how its frame is turned there.
#[derive(Debug, Clone, Copy)]
pub(super) struct Placed {
    pub(super) vertex: u32,
    pub(super) at: Vec2,
    pub(super) turn: Vec2,
}

/// Three vertices and their shares.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Blend {
    pub(super) vertices: [u32; 3],
    pub(super) shares: [f32; 3],
}

/// Room for flattening on one mesh, used again and again.
#[derive(Debug)]
pub(super) struct Flattener<'a> {
    fans: &'a Fans,
    /// For each vertex the round in which it was placed last, and its place in that round, in the low bits.
    marks: Vec<u32>,
    round: u32,
    placed: Vec<Placed>,
    /// Faces that flipped or were stretched, and samples no face covered, so far.
    pub(super) flipped: u64,
    pub(super) uncovered: u64,
}

impl<'a> Flattener<'a> {
    pub(super) fn new(fans: &'a Fans) -> Self {
        Self { fans, marks: vec![0; fans.len()], round: 0, placed: Vec::new(), flipped: 0, uncovered: 0 }
    }

    #[inline]
    fn index(&self, vertex: u32) -> Option<usize> {
        let index = self.marks[vertex as usize].wrapping_sub(self.round);
        (index < MOST).then_some(index as usize)
    }

    fn place(&mut self, placed: Placed) {
        self.marks[placed.vertex as usize] = self.round + self.placed.len() as u32;
        self.placed.push(placed);
    }

    /// Samples the square of `2 radius + 1` samples a side, a spacing apart, rows from the top; `None` where nothing covers one.
    pub(super) fn square(&mut self, seeds: &[Placed], radius: i32, out: &mut [Option<Blend>]) {
        let mut missing = 0;
        for margin in [MARGIN, WIDE] {
            self.grow(seeds, radius as f32 + margin);
            out.fill(None);
            missing = out.len();
            let mut flipped = 0;
            for i in 0..self.placed.len() {
                missing -= self.faces(i, radius, out, &mut flipped);
                if missing == 0 {
                    return;
                }
            }
            if margin == WIDE {
                self.flipped += flipped;
            }
        }
        self.uncovered += missing as u64;
    }

    fn grow(&mut self, seeds: &[Placed], reach: f32) {
        // Rounds are so far apart that a mark of one is never taken for another's.
        self.round = self.round.checked_add(MOST).unwrap_or_else(|| {
            self.marks.fill(0);
            MOST
        });
        self.placed.clear();
        for &seed in seeds {
            if self.index(seed.vertex).is_none() {
                self.place(seed);
            }
        }
        let fans = self.fans;
        let mut at = 0;
        while at < self.placed.len() {
            let from = self.placed[at];
            at += 1;
            // The seeds themselves may lie outside a small template.
            if from.at.abs().max_element() > reach && at > seeds.len() {
                continue;
            }
            for spoke in fans.of(from.vertex) {
                if self.index(spoke.to).is_none() && self.placed.len() < MOST as usize {
                    let first = from.at + from.turn.rotate(spoke.out);
                    let placed = self.averaged(spoke.to, first);
                    self.place(placed);
                }
            }
        }
    }

    /// Where a vertex lies by all its neighbours that have a place.
    fn averaged(&self, vertex: u32, first: Vec2) -> Placed {
        let (mut sum, mut turn, mut count) = (Vec2::ZERO, Vec2::ZERO, 0.0);
        for spoke in self.fans.of(vertex) {
            let Some(index) = self.index(spoke.to) else { continue };
            let from = self.placed[index];
            let here = from.at + from.turn.rotate(spoke.back);
            if here.distance_squared(first) <= APART * APART {
                sum += here;
                turn += from.turn.rotate(Vec2::new(spoke.turn.x, -spoke.turn.y));
                count += 1.0;
                if count == ASKED {
                    break;
                }
            }
        }
        let at = if count > 0.0 { sum / count } else { first };
        Placed { vertex, at, turn: turn.try_normalize().unwrap_or(Vec2::X) }
    }

    /// Takes the samples in the faces whose first corner, by order of placing, is vertex `i`; returns how many were new.
    fn faces(&self, i: usize, radius: i32, out: &mut [Option<Blend>], flipped: &mut u64) -> usize {
        let fans = self.fans;
        let a = self.placed[i];
        let fan = fans.of(a.vertex);
        let mut covered = 0;
        let following = fan.iter().skip(1).chain(fan.first());
        for (spoke, following) in fan.iter().zip(following) {
            let Some(j) = self.index(spoke.to).filter(|&j| j > i && spoke.face) else { continue };
            let Some(l) = self.index(following.to).filter(|&l| l > i) else { continue };
            let (b, c) = (self.placed[j], self.placed[l]);
            let (ab, ac) = (b.at - a.at, c.at - a.at);
            let area = ab.perp_dot(ac);
            let sound = |flat: Vec2, there: Vec2| {
                let (flat, length) = (flat.length_squared(), there.length_squared());
                flat <= STRETCH * STRETCH * length && flat * (STRETCH * STRETCH) >= length
            };
            if !(area > 0.0 && sound(ab, spoke.out) && sound(ac, following.out)) {
                *flipped += 1;
                continue;
            }
            covered += Self::scan([a, b, c], area, radius, out);
        }
        covered
    }

    fn scan([a, b, c]: [Placed; 3], area: f32, radius: i32, out: &mut [Option<Blend>]) -> usize {
        let low = a.at.min(b.at).min(c.at) - EDGE;
        let high = a.at.max(b.at).max(c.at) + EDGE;
        // Casts round towards 0, and numbers are never far below -radius - 4. (`f32::floor` is a call on plain x86-64.)
        let shift = radius + 8;
        let whole = |x: f32| (x + shift as f32) as i32 - shift;
        let from = [low.x, low.y].map(|x| (-whole(-x)).max(-radius));
        let to = [high.x, high.y].map(|x| whole(x).min(radius));
        let side = 2 * radius + 1;
        let mut covered = 0;
        let inverse = 1.0 / area;
        for y in from[1]..=to[1] {
            for x in from[0]..=to[0] {
                let slot = &mut out[((radius - y) * side + radius + x) as usize];
                if slot.is_some() {
                    continue;
                }
                let p = Vec2::new(x as f32, y as f32);
                let shares = [(b.at - p).perp_dot(c.at - p), (c.at - p).perp_dot(a.at - p), (a.at - p).perp_dot(b.at - p)];
                let shares = shares.map(|s| s * inverse);
                if shares.iter().all(|&s| s >= -EDGE) {
                    *slot = Some(Blend { vertices: [a.vertex, b.vertex, c.vertex], shares: snapped(shares) });
                    covered += 1;
                }
            }
        }
        covered
    }
}

/// Shares that are hardly there go to the largest.
fn snapped(shares: [f32; 3]) -> [f32; 3] {
    let kept = shares.map(|s| if s < SNAP { 0.0 } else { s });
    let inverse = 1.0 / kept.iter().sum::<f32>();
    kept.map(|s| s * inverse)
}
