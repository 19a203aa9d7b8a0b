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

#[cfg(test)]
mod tests {
    use super::{Ring, segments_touch, signed_area, simplify};
    use glam::{DVec2, dvec2};

    /// Collapses one edge and returns the polygon and the added area that was told.
    fn collapse(points: &[DVec2], edge: u32) -> (Vec<DVec2>, f64) {
        let mut ring = Ring::new(points.to_vec());
        let collapse = ring.collapse(edge).expect("this edge can go");
        ring.apply(edge, collapse.at);
        (ring.points(), collapse.area)
    }

    fn check(points: &[DVec2], edge: u32, expected: &[DVec2]) {
        let (found, told) = collapse(points, edge);
        assert_eq!(found.len(), expected.len(), "one vertex fewer: {found:?}");
        for (found, expected) in found.iter().zip(expected) {
            assert!(found.distance(*expected) < 1e-12, "{found} where {expected} should be");
        }
        let added = signed_area(&found) - signed_area(points);
        assert!(added >= 0.0 && (added - told).abs() < 1e-12, "area grew by {added}, told was {told}");
    }

    #[test]
    fn both_ends_convex_extends_the_outer_edges() {
        // A square with a cut corner gets its corner back.
        let points = [dvec2(0.0, 0.0), dvec2(4.0, 0.0), dvec2(4.0, 3.0), dvec2(3.0, 4.0), dvec2(0.0, 4.0)];
        check(&points, 2, &[dvec2(0.0, 0.0), dvec2(4.0, 0.0), dvec2(4.0, 4.0), dvec2(0.0, 4.0)]);
    }

    #[test]
    fn convex_and_concave_extends_to_the_edge_beyond() {
        // A step: the edge at its convex end runs on until it meets the riser, whose foot (the concave end) goes.
        let step = [dvec2(0.0, 0.0), dvec2(6.0, 0.0), dvec2(5.0, 2.0), dvec2(6.0, 3.0), dvec2(4.5, 5.0), dvec2(0.0, 5.0)];
        let (found, told) = collapse(&step, 1);
        // Edge 1 runs from (6, 0), convex, to (5, 2), concave: its predecessor y = 0 never meets x - y = 3 beyond (5, 2).
        assert_eq!(found, [step[0], step[1], step[3], step[4], step[5]], "the concave vertex is dropped");
        assert!((told - 1.5).abs() < 1e-12, "by its triangle: {told}");
        let zigzag = [dvec2(0.0, 0.0), dvec2(4.0, 0.0), dvec2(5.0, 1.0), dvec2(4.0, 2.0), dvec2(8.0, 6.0), dvec2(0.0, 6.0)];
        // Edge 2 from (5, 1), convex, to (4, 2), concave: x - y = 4 and x - y = 2 are parallel, so again a drop.
        check(&zigzag, 2, &[zigzag[0], zigzag[1], zigzag[2], zigzag[4], zigzag[5]]);
        let meets = [dvec2(0.0, 0.0), dvec2(4.0, 0.0), dvec2(4.0, 1.0), dvec2(3.0, 2.0), dvec2(7.0, 4.0), dvec2(0.0, 4.0)];
        // From (4, 1), convex, to (3, 2), concave: x = 4 meets the edge from (3, 2) to (7, 4) at (4, 2.5).
        check(&meets, 2, &[meets[0], meets[1], dvec2(4.0, 2.5), meets[4], meets[5]]);
        // The same seen in a mirror, where the concave end comes first.
        let mirrored: Vec<DVec2> = meets.iter().rev().map(|p| dvec2(7.0 - p.x, p.y)).collect();
        check(&mirrored, 2, &[mirrored[0], mirrored[1], dvec2(3.0, 2.5), mirrored[4], mirrored[5]]);
    }

    #[test]
    fn both_ends_concave_drops_the_cheaper_vertex() {
        let dent = [dvec2(0.0, 0.0), dvec2(9.0, 0.0), dvec2(9.0, 5.0), dvec2(6.0, 4.0), dvec2(2.0, 3.0), dvec2(0.0, 5.0)];
        // Triangles at (6, 4): 0.5; at (2, 3): 5.
        check(&dent, 3, &[dent[0], dent[1], dent[2], dent[4], dent[5]]);
    }

    #[test]
    fn a_collapse_through_another_part_is_refused() {
        // A C whose mouth is closed by a tongue from its own end: extending the cut corner would run into the tongue.
        let points = vec![
            dvec2(0.0, 0.0),
            dvec2(10.0, 0.0),
            dvec2(10.0, 6.0),
            dvec2(5.4, 6.0),
            dvec2(5.0, 4.8),
            dvec2(4.6, 6.0),
            dvec2(4.6, 4.0),
            dvec2(8.0, 4.0),
            dvec2(8.0, 2.0),
            dvec2(2.0, 2.0),
            dvec2(2.0, 6.0),
            dvec2(0.0, 6.0),
        ];
        assert!(simple(&points), "the polygon to begin with is simple");
        let found = simplify(points.clone(), f64::INFINITY, 3, 3);
        assert!(simple(&found), "and stays so: {found:?}");
        assert!(signed_area(&found) >= signed_area(&points), "without loss");
    }

    #[test]
    fn straight_corners_go_for_nothing() {
        let points: Vec<DVec2> = [[0, 0], [1, 0], [2, 0], [3, 0], [3, 1], [3, 3], [1, 3], [0, 3], [0, 1]]
            .iter()
            .map(|&[x, y]| dvec2(f64::from(x), f64::from(y)))
            .collect();
        let found = simplify(points, 1.0, 100, 200);
        assert_eq!(found.len(), 4, "four corners remain even far below the vertices allowed: {found:?}");
        assert_eq!(signed_area(&found), 9.0, "the square");
    }

    #[test]
    fn segments_touch_in_points_lines_and_clearance() {
        let touch = |a: [f64; 4], b: [f64; 4], clearance| {
            let segment = |s: [f64; 4]| [dvec2(s[0], s[1]), dvec2(s[2], s[3])];
            segments_touch(segment(a), segment(b), clearance)
        };
        assert!(touch([0.0, 0.0, 2.0, 2.0], [0.0, 2.0, 2.0, 0.0], 0.0), "crossing");
        assert!(touch([0.0, 0.0, 2.0, 0.0], [1.0, 0.0, 1.0, 5.0], 0.0), "an end on the other");
        assert!(touch([0.0, 0.0, 2.0, 0.0], [1.0, 0.0, 3.0, 0.0], 0.0), "overlapping on one line");
        assert!(!touch([0.0, 0.0, 2.0, 0.0], [3.0, 0.0, 4.0, 0.0], 0.0), "apart on one line");
        assert!(!touch([0.0, 0.0, 2.0, 0.0], [0.0, 1.0, 2.0, 1.0], 0.5), "parallel, farther than the clearance");
        assert!(touch([0.0, 0.0, 2.0, 0.0], [0.0, 1.0, 2.0, 1.0], 1.5), "parallel, within the clearance");
    }

    fn simple(points: &[DVec2]) -> bool {
        let n = points.len();
        let side = |i: usize| [points[i], points[(i + 1) % n]];
        (0..n).all(|i| (i + 2..n).all(|j| (j + 1) % n == i || !segments_touch(side(i), side(j), 0.0)))
    }
}
