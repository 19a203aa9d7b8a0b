//! Conservative simplification of a polygon: fewer vertices, never less inside.
//!
//! Based on: Praun, Finkelstein, Hoppe, "Lapped Textures" (2000), figure 4, after the progressive hulls of Sander et al.,
//! "Silhouette Clipping" (2000).
//!
//! 1. Each edge may be collapsed to one vertex. Both ends convex: their outer edges are extended until they meet. Convex
//!    and concave: the edge at the convex end is extended until it meets the one beyond the concave end (or the concave
//!    vertex is dropped, if they do not meet). Both concave: the cheaper of the two vertices is dropped.
//! 2. The collapse that adds the least area is made first.
//! 3. A collapse that would make the polygon touch itself is refused. A grid over the edges keeps that test local, so the
//!    whole is about n log n in the number of vertices.

use glam::DVec2;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// Pixels that two parts of the polygon keep apart, so that rounding to `f32` cannot make it cross itself.
const CLEARANCE: f64 = 1.0 / 64.0;

/// What one collapse does to an edge: its first vertex moves to `at`, its second goes.
#[derive(Clone, Copy)]
struct Collapse {
    area: f64,
    at: DVec2,
}

/// The polygon while it is simplified: a doubly linked ring.
struct Ring {
    at: Vec<DVec2>,
    next: Vec<u32>,
    previous: Vec<u32>,
    /// Counts the changes around a vertex; `u32::MAX` once it is gone.
    version: Vec<u32>,
    count: usize,
}

/// A collapse waiting for its turn: added area (bits of a positive number sort as the number), edge, version.
type Waiting = Reverse<(u64, u32, u32)>;

/// Collapses edges of a simple polygon of positive area that only add to its inside (figure 4), cheapest first: down to
/// `target` vertices while the area added stays within `budget`, and down to `most` vertices at any price.
pub(super) fn simplify(points: Vec<DVec2>, budget: f64, target: usize, most: usize) -> Vec<DVec2> {
    let mut ring = Ring::new(points);
    let mut grid = EdgeGrid::new(&ring);
    let mut added = 0.0;
    // Each round starts with every edge; what was refused in one may be free in the next.
    loop {
        let before = ring.count;
        let mut heap: BinaryHeap<Waiting> = BinaryHeap::new();
        for v in ring.alive() {
            heap.extend(ring.waiting(v));
        }
        while let Some(Reverse((area, v, version))) = heap.pop() {
            let area = f64::from_bits(area);
            // Corners on a straight line go whatever the number; rounding leaves them a tiny area.
            let straight = area <= 1e-9 * budget;
            if !straight && (ring.count <= target || (added + area > budget && ring.count <= most)) {
                break;
            }
            if ring.version[v as usize] != version {
                continue;
            }
            let Some(collapse) = ring.collapse(v) else { continue };
            if grid.blocks(&ring, v, collapse.at) {
                continue;
            }
            added += collapse.area;
            for changed in ring.apply(v, collapse.at) {
                heap.extend(ring.waiting(changed));
            }
            grid.insert(&ring, v);
            grid.insert(&ring, ring.previous[v as usize]);
        }
        if ring.count == before || ring.count <= target || (added >= budget && ring.count <= most) {
            return ring.points();
        }
    }
}

impl Ring {
    fn new(at: Vec<DVec2>) -> Self {
        let n = at.len() as u32;
        let next = (1..=n).map(|i| i % n.max(1)).collect();
        let previous = (0..n).map(|i| (i + n - 1) % n).collect();
        Self { count: at.len(), version: vec![0; at.len()], at, next, previous }
    }

    fn alive(&self) -> impl Iterator<Item = u32> + '_ {
        (0..self.at.len() as u32).filter(|&v| self.version[v as usize] != u32::MAX)
    }

    fn points(&self) -> Vec<DVec2> {
        self.alive().map(|v| self.at[v as usize]).collect()
    }

    /// The edge that starts at `v`.
    fn edge(&self, v: u32) -> [DVec2; 2] {
        [self.at[v as usize], self.at[self.next[v as usize] as usize]]
    }

    /// The vertices around the edge that starts at `v`: before it, its two ends, after it.
    fn around(&self, v: u32) -> [u32; 4] {
        let second = self.next[v as usize];
        [self.previous[v as usize], v, second, self.next[second as usize]]
    }

    fn waiting(&self, v: u32) -> Option<Waiting> {
        self.collapse(v).map(|c| Reverse((c.area.to_bits(), v, self.version[v as usize])))
    }

    /// The cheapest way to replace the edge that starts at `v` by one vertex without losing area; figure 4's three cases.
    fn collapse(&self, v: u32) -> Option<Collapse> {
        if self.count < 4 {
            return None;
        }
        let [before, first, second, after] = self.around(v).map(|v| self.at[v as usize]);
        let (into, edge, out) = (first - before, second - first, after - second);
        let (turn_first, turn_second) = (into.perp_dot(edge), edge.perp_dot(out));
        // Dropping a concave vertex adds the triangle with its neighbours.
        let drop_first = Collapse { area: 0.5 * -turn_first, at: second };
        let drop_second = Collapse { area: 0.5 * -turn_second, at: first };
        // Where the lines of the edges before and after meet: at first + s * into = second + t * out.
        let across = into.perp_dot(out);
        let (s, t) = (edge.perp_dot(out) / across, edge.perp_dot(into) / across);
        let meet = |at: DVec2| Collapse { area: 0.5 * edge.perp_dot(at - first).abs(), at };
        let choice = match (turn_first > 0.0, turn_second > 0.0) {
            (true, true) => (across > 0.0).then(|| meet(first + into * s))?,
            (true, false) if s > 0.0 && (0.0..1.0).contains(&t) => meet(second + out * t),
            (true, false) => drop_second,
            (false, true) if t < 0.0 && (-1.0..=0.0).contains(&s) => meet(first + into * s),
            (false, true) => drop_first,
            (false, false) if drop_first.area < drop_second.area => drop_first,
            (false, false) => drop_second,
        };
        // `+ 0.0` turns -0 into 0, whose bits sort first.
        (choice.area.is_finite() && choice.at.is_finite()).then_some(Collapse { area: choice.area + 0.0, ..choice })
    }

    /// Removes the end of the edge that starts at `v` and moves `v`; returns the edges whose collapses have changed.
    fn apply(&mut self, v: u32, at: DVec2) -> [u32; 4] {
        let [before, first, second, after] = self.around(v);
        self.at[first as usize] = at;
        self.next[first as usize] = after;
        self.previous[after as usize] = first;
        self.version[second as usize] = u32::MAX;
        self.count -= 1;
        let changed = [self.previous[before as usize], before, first, after];
        for edge in changed {
            self.version[edge as usize] += 1;
        }
        changed
    }
}

/// The edges of a ring by the grid cells they pass. An edge that has changed stays in its old cells as well, where it
/// costs a test but changes no answer.
struct EdgeGrid {
    low: DVec2,
    cell: f64,
    columns: usize,
    rows: usize,
    edges: Vec<Vec<u32>>,
}

impl EdgeGrid {
    fn new(ring: &Ring) -> Self {
        let low = ring.at.iter().fold(DVec2::INFINITY, |m, &p| m.min(p));
        let size = ring.at.iter().fold(DVec2::NEG_INFINITY, |m, &p| m.max(p)) - low;
        // About as many cells as vertices.
        let cell = (size.x * size.y / ring.count.max(1) as f64).sqrt().max(1.0);
        let count = |length: f64| (length / cell) as usize + 1;
        let (columns, rows) = if size.is_finite() { (count(size.x), count(size.y)) } else { (1, 1) };
        let mut grid = Self { low, cell, columns, rows, edges: vec![Vec::new(); columns * rows] };
        for v in ring.alive() {
            grid.insert(ring, v);
        }
        grid
    }

    /// Calls `visit` with each cell the segment passes (a little widened) until it returns true; cells at the border
    /// reach out to infinity.
    fn any_cell(&self, [a, b]: [DVec2; 2], mut visit: impl FnMut(usize) -> bool) -> bool {
        let (a, b) = if a.x <= b.x { (a, b) } else { (b, a) };
        let column = |x: f64| (((x - self.low.x) / self.cell) as usize).min(self.columns - 1);
        let row = |y: f64| (((y - self.low.y) / self.cell) as usize).min(self.rows - 1);
        let slope = if b.x > a.x { (b.y - a.y) / (b.x - a.x) } else { 0.0 };
        let (first, last) = (column(a.x - CLEARANCE), column(b.x + CLEARANCE));
        for c in first..=last {
            let x0 = if c == 0 { a.x } else { self.low.x + c as f64 * self.cell - CLEARANCE };
            let x1 = if c + 1 == self.columns { b.x } else { self.low.x + (c + 1) as f64 * self.cell + CLEARANCE };
            // The ends are taken as they are: a steep edge passes its whole height within one column.
            let y0 = if x0 <= a.x { a.y } else { a.y + slope * (x0.min(b.x) - a.x) };
            let y1 = if x1 >= b.x { b.y } else { a.y + slope * (x1.max(a.x) - a.x) };
            for r in row(y0.min(y1) - CLEARANCE)..=row(y0.max(y1) + CLEARANCE) {
                if visit(r * self.columns + c) {
                    return true;
                }
            }
        }
        false
    }

    fn insert(&mut self, ring: &Ring, v: u32) {
        let mut cells = Vec::new();
        self.any_cell(ring.edge(v), |cell| {
            cells.push(cell);
            false
        });
        for cell in cells {
            self.edges[cell].push(v);
        }
    }

    /// True if the collapse of the edge that starts at `v` would make the polygon touch itself.
    fn blocks(&self, ring: &Ring, v: u32, at: DVec2) -> bool {
        let [before, first, second, after] = ring.around(v);
        let removed = [before, first, second];
        let meets = |new: [DVec2; 2], neighbour: u32| {
            self.any_cell(new, |cell| {
                self.edges[cell].iter().any(|&e| {
                    ring.version[e as usize] != u32::MAX
                        && e != neighbour
                        && !removed.contains(&e)
                        && segments_touch(new, ring.edge(e), CLEARANCE)
                })
            })
        };
        meets([ring.at[before as usize], at], ring.previous[before as usize]) || meets([at, ring.at[after as usize]], after)
    }
}

/// Distance of a point from a segment.
pub(super) fn segment_distance(p: DVec2, a: DVec2, b: DVec2) -> f64 {
    let ab = b - a;
    let length = ab.length_squared();
    let t = if length > 0.0 { ((p - a).dot(ab) / length).clamp(0.0, 1.0) } else { 0.0 };
    (a + ab * t).distance(p)
}

/// Area enclosed, positive if the corners run from the x axis towards the y axis.
pub(super) fn signed_area(points: &[DVec2]) -> f64 {
    let Some(&origin) = points.first() else { return 0.0 };
    0.5 * points.windows(2).map(|w| (w[0] - origin).perp_dot(w[1] - origin)).sum::<f64>()
}

/// True if two segments come closer to each other than `clearance`.
pub(super) fn segments_touch([a, b]: [DVec2; 2], [p, q]: [DVec2; 2], clearance: f64) -> bool {
    if (a.min(b) - clearance).cmpgt(p.max(q)).any() || (a.max(b) + clearance).cmplt(p.min(q)).any() {
        return false;
    }
    let (ab, pq) = (b - a, q - p);
    let straddles = ab.perp_dot(p - a) * ab.perp_dot(q - a) <= 0.0 && pq.perp_dot(a - p) * pq.perp_dot(b - p) <= 0.0;
    // Parallel segments pass that test only on one line, where the distances below decide.
    (straddles && ab.perp_dot(pq) != 0.0)
        || segment_distance(a, p, q) <= clearance
        || segment_distance(b, p, q) <= clearance
        || segment_distance(p, a, b) <= clearance
        || segment_distance(q, a, b) <= clearance
}
