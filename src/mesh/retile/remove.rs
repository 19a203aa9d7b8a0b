//! Removal of the old vertices.
//!
//! Turk takes a vertex out with the faces around it and triangulates the hole. Here it is pulled into that neighbour from
//! which the hole's triangles are best, and their edges are flipped until they are Delaunay: the same triangulation, but every
//! step on the way is a sound mesh, and where the topology or the shape forbids one the vertex waits. What cannot go in the
//! end takes the place of a new vertex beside it.

use super::flips::flip_from;
use super::surgery::{Fan, Surgery};
use super::{Role, Tiling};
use crate::mesh::{NONE, next, prev};
use glam::DVec3;

/// Passes over the vertices that are left, and how far (cosine) a face may turn when it changes in each: gentle removals first,
/// since they make the others gentler.
const PASSES: [f64; 5] = [0.7, 0.4, 0.1, -0.2, -0.2];

/// Buffers of the walk around vertices.
#[derive(Debug, Default)]
pub(super) struct Scratch {
    pub(super) fan: Fan,
    pub(super) others: Fan,
    pub(super) queue: Vec<u32>,
    choices: Vec<(f64, u32)>,
}

/// Removes old vertices. What stays takes the role of a site, and as many sites go instead as can.
pub(super) fn remove_old(t: &mut Tiling, scratch: &mut Scratch) {
    let mut left: Vec<u32> = (0..t.role.len() as u32).filter(|&v| t.role[v as usize] == Role::Old).collect();
    for least in PASSES {
        left.retain(|&v| !remove(t, v, least, scratch));
    }
    left.retain(|&v| {
        ease(&mut t.surgery, v, scratch);
        !remove(t, v, PASSES[PASSES.len() - 1], scratch)
    });
    for v in left {
        t.role[v as usize] = if is_on_line(&t.surgery, v, &mut scratch.fan) { Role::Fixed } else { Role::Free };
        t.kept_old += 1;
    }
}

pub(super) fn is_on_line(s: &Surgery, vertex: u32, fan: &mut Fan) -> bool {
    s.fan(vertex, fan);
    !fan.closed || fan.spokes.iter().any(|&h| s.feature[h as usize])
}

/// Pulls a vertex into its best neighbour, if there is one; faces may turn by `least` (cosine).
pub(super) fn remove(t: &mut Tiling, v: u32, least: f64, scratch: &mut Scratch) -> bool {
    let s = &mut t.surgery;
    s.fan(v, &mut scratch.fan);
    // On a line it may only go along the line.
    let on_line = |h: &u32| s.feature[*h as usize];
    let closing = prev(scratch.fan.spokes[scratch.fan.spokes.len() - 1]);
    let mut edges: Vec<u32> = scratch.fan.spokes.clone();
    if !scratch.fan.closed {
        edges.push(closing);
    }
    if edges.iter().any(on_line) {
        edges.retain(on_line);
        if edges.len() != 2 {
            return false;
        }
    }
    scratch.choices.clear();
    for &h in &edges {
        if let Some(quality) = hole_quality(s, h, v, &scratch.fan, least) {
            scratch.choices.push((quality, h));
        }
    }
    scratch.choices.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
    for i in 0..scratch.choices.len() {
        let h = scratch.choices[i].1;
        if s.can_collapse(h, &mut scratch.fan, &mut scratch.others) {
            let into = if s.origin(h) == v { s.target(h) } else { s.origin(h) };
            s.collapse(h, v, &mut scratch.fan);
            s.fan(into, &mut scratch.fan);
            scratch.queue.clear();
            for &spoke in &scratch.fan.spokes {
                scratch.queue.extend([next(spoke), spoke]);
            }
            flip_from(s, &mut scratch.queue, &mut scratch.fan);
            return true;
        }
    }
    false
}

/// Flips edges away from a vertex with many, so that a hole too bent to be seen from any of its corners becomes small.
fn ease(s: &mut Surgery, v: u32, scratch: &mut Scratch) {
    let mut flipped = true;
    while flipped {
        flipped = false;
        s.fan(v, &mut scratch.fan);
        if scratch.fan.spokes.len() <= 3 {
            return;
        }
        for h in scratch.fan.spokes.clone() {
            let Some([c, d]) = s.diagonal(h) else { continue };
            let [a, b, p, q] = [v, s.target(h), c, d].map(|w| s.positions[w as usize]);
            let both = (b - a).cross(p - a) + (a - b).cross(q - b);
            let seen = |n: DVec3| n.dot(both) > 0.1 * n.length() * both.length();
            if seen((q - a).cross(p - a)) && seen((b - q).cross(p - q)) && !s.are_joined(c, d, &mut scratch.others) {
                s.flip(h);
                flipped = true;
                break;
            }
        }
    }
}

/// The worst of the triangles that pulling `v` along `h` makes, between 0 (a line) and 1 (equilateral), less what the worst of
/// them turns; `None` if one turns too far.
fn hole_quality(s: &Surgery, h: u32, v: u32, fan: &Fan, least: f64) -> Option<f64> {
    let into = if s.origin(h) == v { s.target(h) } else { s.origin(h) };
    let goal = s.positions[into as usize];
    let mut worst = 1.0_f64;
    for &spoke in &fan.spokes {
        let (a, b) = (s.target(spoke), s.origin(prev(spoke)));
        if a == into || b == into {
            continue;
        }
        let [from, a, b] = [v, a, b].map(|w| s.positions[w as usize]);
        let (old, new) = ((a - from).cross(b - from), (a - goal).cross(b - goal));
        let turn = new.dot(old) / (new.length() * old.length()).max(f64::MIN_POSITIVE);
        // A face without width says nothing of where it looked.
        let told = shape(from, a, b) > 1e-3;
        if told && turn < least {
            return None;
        }
        worst = worst.min(shape(goal, a, b) - if told { 0.5 * (1.0 - turn) } else { 0.0 });
    }
    Some(worst)
}

/// Shape of a triangle, 1 if it is equilateral, 0 if it has no width.
pub(super) fn shape(a: DVec3, b: DVec3, c: DVec3) -> f64 {
    let squares = a.distance_squared(b) + b.distance_squared(c) + c.distance_squared(a);
    2.0 * 3_f64.sqrt() * (b - a).cross(c - a).length() / squares.max(f64::MIN_POSITIVE)
}

/// Half-edges of a face.
pub(super) fn sides(face: u32) -> [u32; 3] {
    debug_assert_ne!(face, NONE, "a face");
    [3 * face, 3 * face + 1, 3 * face + 2]
}
