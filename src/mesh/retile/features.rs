//! Lines that re-tiling keeps: boundaries, and creases on request.
//!
//! Lines run over edges of the original from corner to corner or in loops. Corners are vertices where lines end or meet, and
//! places where a line turns sharply at the scale of the new edges. Corners stay; between them each line is cut into
//! equal lengths, and the ends of these pieces are fixed vertices of the new mesh.

use crate::mesh::{Mesh, NONE, next};
use glam::DVec3;

/// A line that turns by more than this within an edge's length has a corner there. 50 degrees: pentagons are round.
const CORNER: f64 = 50.0;

/// A piece's end nearer to a vertex than this share of the spacing takes the vertex.
const SNAP: f64 = 0.05;

/// The lines of a mesh and the places to cut them.
#[derive(Debug, Clone, Default)]
pub(super) struct Features {
    /// Per half-edge: it lies on a line.
    pub(super) on_line: Vec<bool>,
    /// Vertices of the original that stay, in order.
    pub(super) fixed: Vec<u32>,
    /// New vertices on lines: a half-edge and how far along it, between 0 and 1.
    pub(super) cuts: Vec<(u32, f64)>,
}

/// Marks the half-edges on boundaries, and on edges that bend by more than `crease` (radians) if given.
pub(super) fn lines(mesh: &Mesh, crease: Option<f64>) -> Vec<bool> {
    let sharp = crease.map(f64::cos);
    let on_line = |(h, &o): (usize, &u32)| {
        o == NONE || sharp.is_some_and(|cosine| mesh.normal(h as u32 / 3).dot(mesh.normal(o / 3)) < cosine)
    };
    mesh.opposite.iter().enumerate().map(on_line).collect()
}

/// Length of all lines.
pub(super) fn line_length(mesh: &Mesh, on_line: &[bool]) -> f64 {
    edges(mesh, on_line).map(|h| length(mesh, h)).sum()
}

/// One half-edge for each edge on a line.
fn edges<'a>(mesh: &'a Mesh, on_line: &'a [bool]) -> impl Iterator<Item = u32> + 'a {
    (0..on_line.len() as u32)
        .filter(|&h| on_line[h as usize] && (mesh.opposite[h as usize] == NONE || h < mesh.opposite[h as usize]))
}

fn length(mesh: &Mesh, h: u32) -> f64 {
    mesh.point(mesh.origin(h)).distance(mesh.point(mesh.origin(next(h))))
}

/// Finds corners and cuts all lines into pieces about `spacing` long.
pub(super) fn features(mesh: &Mesh, on_line: Vec<bool>, spacing: f64) -> Features {
    let mut out = Features { on_line, ..Features::default() };
    let mut fixed = vec![false; mesh.vertex_count()];
    for chain in chains(mesh, &out.on_line) {
        cut(mesh, &chain, spacing, &mut fixed, &mut out.cuts);
    }
    out.fixed = (0..fixed.len() as u32).filter(|&v| fixed[v as usize]).collect();
    out
}

/// A line from one corner to the next, or round: its half-edges and whether each runs forward.
#[derive(Debug, Default)]
struct Chain {
    edges: Vec<(u32, bool)>,
    closed: bool,
}

impl Chain {
    fn vertex(&self, mesh: &Mesh, i: usize) -> u32 {
        let ends = |(h, forward): (u32, bool)| {
            let pair = [mesh.origin(h), mesh.origin(next(h))];
            if forward { pair } else { [pair[1], pair[0]] }
        };
        self.edges.get(i).map_or_else(|| ends(self.edges[self.edges.len() - 1])[1], |&e| ends(e)[0])
    }
}

/// All lines, cut where they end or meet.
fn chains(mesh: &Mesh, on_line: &[bool]) -> Vec<Chain> {
    let mut around: Vec<(u32, u32)> = Vec::new();
    for h in edges(mesh, on_line) {
        around.extend([(mesh.origin(h), h), (mesh.origin(next(h)), h)]);
    }
    around.sort_unstable();
    let at = |v: u32| {
        let first = around.partition_point(|&(w, _)| w < v);
        let last = around.partition_point(|&(w, _)| w <= v);
        &around[first..last]
    };
    let mut used = vec![false; on_line.len()];
    let mut out = Vec::new();
    let mut follow = |from: u32, first: u32| {
        let mut chain = Chain::default();
        let (mut v, mut h) = (from, first);
        loop {
            used[h as usize] = true;
            let forward = mesh.origin(h) == v;
            chain.edges.push((h, forward));
            v = if forward { mesh.origin(next(h)) } else { mesh.origin(h) };
            match *at(v) {
                [(_, a), (_, b)] if v != from => h = if a == h { b } else { a },
                _ => break,
            }
        }
        chain.closed = v == from && at(from).len() == 2;
        (chain, v)
    };
    // From corners first, so that what is left are loops without any.
    let mut taken = vec![false; on_line.len()];
    for loops in [false, true] {
        for &(v, h) in &around {
            if taken[h as usize] || (at(v).len() == 2) != loops {
                continue;
            }
            let (chain, _) = follow(v, h);
            chain.edges.iter().for_each(|&(e, _)| taken[e as usize] = true);
            out.push(chain);
        }
    }
    out
}

/// Cuts one line.
fn cut(mesh: &Mesh, chain: &Chain, spacing: f64, fixed: &mut [bool], cuts: &mut Vec<(u32, f64)>) {
    let n = chain.edges.len();
    let points: Vec<DVec3> = (0..=n).map(|i| mesh.point(chain.vertex(mesh, i))).collect();
    let mut along = vec![0.0];
    for i in 0..n {
        along.push(along[i] + points[i].distance(points[i + 1]));
    }
    let mut ends = corners(&points, &along, chain.closed, spacing / 2.0);
    if chain.closed {
        let first = ends.first().copied().unwrap_or(0);
        if ends.is_empty() {
            ends.push(0);
        }
        ends.push(first + n);
    } else {
        ends.insert(0, 0);
        ends.push(n);
    }
    let total = along[n];
    // Beyond the end of a loop the line goes on at its beginning.
    let reach = |i: usize| along[i % n.max(1)] + if i >= n { total } else { 0.0 };
    let reach = |i: usize| if i == n { total } else { reach(i) };
    for pair in ends.windows(2) {
        fixed[chain.vertex(mesh, pair[0] % n) as usize] = true;
        if pair[1] <= n {
            fixed[chain.vertex(mesh, if chain.closed { pair[1] % n } else { pair[1] }) as usize] = true;
        }
        let (from, to) = (reach(pair[0]), reach(pair[1]));
        let round = chain.vertex(mesh, pair[0] % n) == chain.vertex(mesh, if pair[1] == n { n } else { pair[1] % n });
        let pieces = ((to - from) / spacing).round().max(if round { 3.0 } else { 1.0 }) as usize;
        let mut i = pair[0];
        for j in 1..pieces {
            let goal = from + (to - from) * j as f64 / pieces as f64;
            while i + 1 < pair[1] && reach(i + 1) < goal {
                i += 1;
            }
            let (h, forward) = chain.edges[i % n];
            let edge = reach(i + 1) - reach(i);
            let share = ((goal - reach(i)) / edge).clamp(0.0, 1.0);
            let near = SNAP * spacing.min((to - from) / pieces as f64) / edge;
            if share < near {
                fixed[chain.vertex(mesh, i % n) as usize] = true;
            } else if 1.0 - share < near {
                fixed[chain.vertex(mesh, (i + 1) % if chain.closed { n } else { n + 1 }) as usize] = true;
            } else {
                cuts.push((h, if forward { share } else { 1.0 - share }));
            }
        }
    }
}

/// Inner points where a line turns sharply within `radius` to both sides, each the sharpest within that distance.
fn corners(points: &[DVec3], along: &[f64], closed: bool, radius: f64) -> Vec<usize> {
    let n = points.len() - 1;
    let total = along[n];
    if total < 3.0 * radius {
        return Vec::new();
    }
    let place = |mut s: f64| {
        if closed {
            s = s.rem_euclid(total);
        }
        let i = along.partition_point(|&a| a <= s).clamp(1, n) - 1;
        let edge = along[i + 1] - along[i];
        points[i].lerp(points[i + 1], if edge > 0.0 { ((s - along[i]) / edge).clamp(0.0, 1.0) } else { 0.0 })
    };
    let inner = if closed { 0..n } else { 1..n };
    let turn = |i: usize| {
        let p = points[i];
        (p - place(along[i] - radius)).angle_between(place(along[i] + radius) - p)
    };
    let mut sharp: Vec<(f64, usize)> = inner.map(|i| (turn(i), i)).filter(|t| t.0 > CORNER.to_radians()).collect();
    sharp.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
    // Along the line, so that each is compared with its neighbours only.
    let mut chosen: std::collections::BTreeMap<usize, f64> = std::collections::BTreeMap::new();
    for (_, i) in sharp {
        let apart = |j: Option<(&usize, &f64)>| {
            j.is_none_or(|(_, &s)| {
                let d = (s - along[i]).abs();
                d.min(if closed { total - d } else { d }) > radius
            })
        };
        let wraps = apart(chosen.iter().next()) && apart(chosen.iter().next_back());
        if apart(chosen.range(..i).next_back()) && apart(chosen.range(i..).next()) && wraps {
            chosen.insert(i, along[i]);
        }
    }
    chosen.into_keys().collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;

    #[test]
    fn a_squares_outline_keeps_its_corners_and_is_cut_evenly() {
        let mesh = shapes::uneven_square(10);
        let found = features(&mesh, lines(&mesh, None), 0.125);
        let corners: Vec<_> =
            found.fixed.iter().map(|&v| mesh.point(v)).filter(|p| [p.x, p.y].iter().all(|&c| c == 0.0 || c == 1.0)).collect();
        assert_eq!(corners.len(), 4, "corners {corners:?}");
        assert_eq!(found.fixed.len() + found.cuts.len(), 32, "8 pieces a side: {found:?}");
    }

    #[test]
    fn round_outlines_have_no_corners() {
        let mesh = shapes::parametric(60, 20, |u, v| {
            let a = u * std::f64::consts::TAU;
            [a.cos(), a.sin(), v]
        });
        let found = features(&mesh, lines(&mesh, None), 0.2);
        let pieces = (60.0 * 2.0 * (std::f64::consts::PI / 60.0).sin() / 0.2).round() as usize;
        assert_eq!(found.fixed.len() + found.cuts.len(), 2 * pieces, "two loops of {pieces}");
    }

    #[test]
    fn creases_of_a_cube_are_its_edges() {
        let mesh = shapes::cube(5);
        let on_line = lines(&mesh, Some(0.5));
        assert!((line_length(&mesh, &on_line) - 24.0).abs() < 1e-6, "twelve edges of length 2");
        let found = features(&mesh, on_line, 0.5);
        assert_eq!(found.fixed.len() + found.cuts.len(), 8 + 12 * 3, "{found:?}");
        assert_eq!(lines(&mesh, None).iter().filter(|&&l| l).count(), 0, "no boundary, no line");
    }
}
