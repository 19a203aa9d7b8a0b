//! The hull of a texture patch: a polygon of few vertices around all that its mask can show, which decides where a
//! surface patch still has to grow.
//!
//! Based on: Praun, Finkelstein, Hoppe, "Lapped Textures" (2000), section 3.3 and figure 4, after the progressive hulls
//! of Sander et al., "Silhouette Clipping" (2000).
//!
//! 1. The contour of the mask's bilinear support: the unit squares between four neighbouring pixel centres of which at
//!    least one has alpha. Holes are ignored; squares that meet in a corner only are bridged, so that the contour is simple.
//! 2. Edge collapses that only add area (`collapse.rs`), down to a budget of vertices and of area.

use super::Image;
use super::collapse::{segment_distance, signed_area, simplify};
use glam::{DVec2, IVec2, Vec2};

/// Vertices the hull is reduced to, as long as that costs less than [`HULL_EXTRA_AREA`]. Growth tests each edge of a
/// front against all of them; a circle in 32 tangents is 0.3 % too large.
pub const HULL_VERTICES: usize = 32;
/// Area the hull may add for the sake of fewer vertices, relative to the contour's. Faces in it are grown for nothing.
pub const HULL_EXTRA_AREA: f64 = 0.03;
/// Vertices that even a spiky hull is reduced to, whatever the area: beyond it the hull test costs more than the faces it
/// saves.
pub const HULL_MOST_VERTICES: usize = 96;

/// A simple polygon, and the questions growth asks of it.
#[derive(Debug, Clone, PartialEq)]
pub struct Hull {
    points: Vec<Vec2>,
    low: Vec2,
    high: Vec2,
    /// A circle inside the polygon, for a quick yes.
    core: Vec2,
    core_radius: f32,
}

impl Hull {
    /// A hull from the corners of a simple polygon in pixel coordinates, in either sense of rotation.
    #[must_use]
    pub fn new(mut points: Vec<Vec2>) -> Self {
        let doubles: Vec<DVec2> = points.iter().map(|p| p.as_dvec2()).collect();
        // Pixel rows run down: positive there is clockwise as seen.
        if signed_area(&doubles) > 0.0 {
            points.reverse();
        }
        let low = points.iter().fold(Vec2::INFINITY, |m, &p| m.min(p));
        let high = points.iter().fold(Vec2::NEG_INFINITY, |m, &p| m.max(p));
        let mut hull = Self { points, low, high, core: Vec2::ZERO, core_radius: 0.0 };
        (hull.core, hull.core_radius) = hull.inscribed_circle();
        hull
    }

    /// The hull moved by so many pixels.
    #[must_use]
    pub fn moved(mut self, by: Vec2) -> Self {
        self.points.iter_mut().for_each(|p| *p += by);
        Self { low: self.low + by, high: self.high + by, core: self.core + by, ..self }
    }

    /// The conservative hull of all alpha in the first component of `mask`, whose top left corner lies at `origin`.
    /// `None` if nothing has alpha. Where alpha falls apart into pieces, the hull is that of one of them.
    #[must_use]
    pub fn of_mask(mask: &Image, origin: IVec2) -> Option<Self> {
        let contour = contour(mask)?;
        let budget = HULL_EXTRA_AREA * signed_area(&contour);
        let points = simplify(contour, budget, HULL_VERTICES, HULL_MOST_VERTICES);
        Some(Self::new(points.iter().map(|&p| (p + origin.as_dvec2()).as_vec2()).collect()))
    }

    /// The corners, counter-clockwise seen with y up (the pixel rows run down).
    #[must_use]
    pub fn points(&self) -> &[Vec2] {
        &self.points
    }

    /// Lowest and highest coordinates.
    #[must_use]
    pub const fn bounds(&self) -> [Vec2; 2] {
        [self.low, self.high]
    }

    /// Area in square pixels.
    #[must_use]
    pub fn area(&self) -> f64 {
        signed_area(&self.points.iter().map(|p| p.as_dvec2()).collect::<Vec<_>>()).abs()
    }

    /// Distance of the corner farthest from a point.
    #[must_use]
    pub fn reach(&self, from: Vec2) -> f32 {
        self.points.iter().map(|p| p.distance(from)).fold(0.0, f32::max)
    }

    /// The sides, each from one corner to the next.
    fn sides(&self) -> impl Iterator<Item = (Vec2, Vec2)> + '_ {
        let last = self.points.last().copied().unwrap_or_default();
        self.points.iter().scan(last, |from, &to| Some((std::mem::replace(from, to), to)))
    }

    /// True if the point lies inside; a point on the boundary may be told either way.
    #[must_use]
    pub fn contains(&self, point: Vec2) -> bool {
        if point.cmplt(self.low).any() || point.cmpgt(self.high).any() {
            return false;
        }
        let p = point.as_dvec2();
        self.sides().fold(false, |inside, (a, b)| inside != crosses_leftward(p, a.as_dvec2(), b.as_dvec2()))
    }

    /// True if the segment from `a` to `b` meets the interior. Both ends may lie outside; touching the boundary, or
    /// running along it, does not count.
    #[must_use]
    pub fn crosses_interior(&self, a: Vec2, b: Vec2) -> bool {
        if a.max(b).cmple(self.low).any() || a.min(b).cmpge(self.high).any() {
            return false;
        }
        if point_segment_distance_squared(self.core, a, b) < self.core_radius * self.core_radius {
            return true;
        }
        let (start, end) = (a.as_dvec2(), b.as_dvec2());
        let along = end - start;
        let mut touches = false;
        let mut p = self.points.last().map_or(DVec2::ZERO, |p| p.as_dvec2());
        let mut p_side = along.perp_dot(p - start);
        for &q in &self.points {
            let q = q.as_dvec2();
            let q_side = along.perp_dot(q - start);
            // Only the few sides that the segment's line meets are looked at closer.
            if p_side * q_side <= 0.0 {
                let side = q - p;
                let ends = side.perp_dot(start - p) * side.perp_dot(end - p);
                if ends < 0.0 && p_side * q_side < 0.0 {
                    return true;
                }
                touches |= ends <= 0.0;
            }
            (p, p_side) = (q, q_side);
        }
        if touches { self.passes_inside(start, end) } else { self.contains(a) }
    }

    /// [`Self::crosses_interior`] for segments that touch corners or sides: cuts the segment there and looks at the middle
    /// of each part.
    fn passes_inside(&self, a: DVec2, b: DVec2) -> bool {
        let along = b - a;
        let length = along.length_squared();
        let at = |t: f64| a + along * t;
        let mut cuts = vec![0.0, 1.0];
        for (p, q) in self.sides() {
            let (p, q) = (p.as_dvec2(), q.as_dvec2());
            let side = q - p;
            let across = along.perp_dot(side);
            if across != 0.0 {
                cuts.push((p - a).perp_dot(side) / across);
            }
            if length > 0.0 {
                cuts.extend([along.dot(p - a) / length, along.dot(q - a) / length]);
            }
        }
        cuts.retain(|t| (0.0..=1.0).contains(t));
        cuts.sort_by(f64::total_cmp);
        // Closer than this to the boundary counts as on it: far below a pixel, far above the rounding of the cuts.
        let tolerance = 1e-9 * f64::from((self.high - self.low).max_element()).max(length.sqrt());
        cuts.windows(2).any(|pair| {
            let middle = at(0.5 * (pair[0] + pair[1]));
            self.contains(middle.as_vec2())
                && self.sides().all(|(p, q)| segment_distance(middle, p.as_dvec2(), q.as_dvec2()) > tolerance)
        })
    }

    /// A large circle inside the polygon: the deepest point of a coarse grid.
    fn inscribed_circle(&self) -> (Vec2, f32) {
        const STEPS: usize = 24;
        let step = (self.high - self.low) / STEPS as f32;
        let depth = |p: Vec2| {
            let d = self.sides().map(|(a, b)| segment_distance(p.as_dvec2(), a.as_dvec2(), b.as_dvec2()));
            d.fold(f64::INFINITY, f64::min) as f32
        };
        (0..STEPS * STEPS)
            .map(|i| self.low + step * Vec2::new((i % STEPS) as f32 + 0.5, (i / STEPS) as f32 + 0.5))
            .filter(|&p| self.contains(p))
            .map(|p| (p, depth(p) * (1.0 - 1e-5)))
            .fold((self.low, 0.0), |best, this| if this.1 > best.1 { this } else { best })
    }
}

/// True if a ray from `p` towards lower x crosses the side from `a` to `b`, counting each corner once.
#[inline]
fn crosses_leftward(p: DVec2, a: DVec2, b: DVec2) -> bool {
    let up = b.y > a.y;
    ((a.y > p.y) != (b.y > p.y)) && (((b - a).perp_dot(p - a) < 0.0) == up)
}

#[inline]
fn point_segment_distance_squared(p: Vec2, a: Vec2, b: Vec2) -> f32 {
    let ab = b - a;
    let length = ab.length_squared();
    let t = if length > 0.0 { ((p - a).dot(ab) / length).clamp(0.0, 1.0) } else { 0.0 };
    (a + ab * t).distance_squared(p)
}

/// The outer boundary of the bilinear support of all alpha, of positive signed area, corners only.
fn contour(mask: &Image) -> Option<Vec<DVec2>> {
    let mut squares = Squares::new(mask);
    squares.bridge_corners();
    squares.trace()
}

/// The unit squares between pixel centres: square (x, y) spans pixel coordinates x - 0.5 to x + 0.5, y - 0.5 to y + 0.5.
/// One empty row and column surround them.
struct Squares {
    width: usize,
    active: Vec<bool>,
}

impl Squares {
    fn new(mask: &Image) -> Self {
        let [w, h] = mask.size().map(|n| n as usize);
        let width = w + 3;
        let mut active = vec![false; width * (h + 3)];
        for (y, row) in mask.data().chunks_exact(w * mask.components()).enumerate() {
            for (x, _) in row.iter().step_by(mask.components()).enumerate().filter(|&(_, &alpha)| alpha > 0.0) {
                let first = (y + 1) * width + x + 1;
                active[first..first + 2].fill(true);
                active[first + width..first + width + 2].fill(true);
            }
        }
        Self { width, active }
    }

    /// Fills squares until no two active ones meet in a corner only.
    fn bridge_corners(&mut self) {
        let w = self.width;
        let mut spoiled = Vec::new();
        for corner in w + 1..self.active.len() {
            let mut next = Some(corner);
            while let Some(corner) = next {
                if let Some(filled) = self.bridge(corner) {
                    spoiled.extend([filled, filled + 1, filled + w, filled + w + 1]);
                }
                next = spoiled.pop();
            }
        }
    }

    /// Fills a square if two active ones meet only in the corner at the upper left of square `corner`; returns it.
    fn bridge(&mut self, corner: usize) -> Option<usize> {
        let (below, above) = (corner, corner.checked_sub(self.width)?);
        let now = [above.checked_sub(1)?, above, below - 1, below].map(|i| self.active.get(i).copied().unwrap_or(false));
        let fill = match now {
            [true, false, false, true] => above,
            [false, true, true, false] => above - 1,
            _ => return None,
        };
        self.active[fill] = true;
        Some(fill)
    }

    /// Walks around the first active square's piece with the inside to the left (towards +y when going +x).
    fn trace(&self) -> Option<Vec<DVec2>> {
        let first = self.active.iter().position(|&a| a)?;
        let w = self.width as isize;
        // Going +x, +y, -x, -y: the step between corners, and the squares ahead to the left and right of a corner.
        let steps = [1, w, -1, -w];
        let left = [0, -1, -1 - w, -w];
        let right = [-w, 0, -1, -1 - w];
        let active = |i: isize| usize::try_from(i).ok().and_then(|i| self.active.get(i)).copied().unwrap_or(false);
        let (mut corner, mut direction) = (first as isize, 0);
        let mut points = Vec::new();
        // The first corner is one where the contour turns; every corner is visited at most once.
        for _ in 0..=self.active.len() {
            let turn = if active(corner + right[direction]) {
                3
            } else if active(corner + left[direction]) {
                0
            } else {
                1
            };
            if turn != 0 {
                points.push(DVec2::new((corner % w) as f64 - 1.5, (corner / w) as f64 - 1.5));
            }
            direction = (direction + turn) % 4;
            corner += steps[direction];
            if corner == first as isize {
                break;
            }
        }
        // The walk starts at the first corner without emitting it.
        points.push(DVec2::new((first as isize % w) as f64 - 1.5, (first as isize / w) as f64 - 1.5));
        Some(points)
    }
}
