//! Edge flips towards the Delaunay triangulation of the surface.
//!
//! Based on: Lawson, "Transforming triangulations", 1972, with the cotangent test for surfaces: an edge is flipped if the two
//! angles across it sum to more than half a turn. An edge that the surface bends over stays unless the bend over the other
//! diagonal is no sharper; lines are never flipped.

use super::surgery::{Fan, Surgery};
use crate::mesh::{NONE, next, prev};
use glam::DVec3;
use rayon::prelude::*;

/// How much less than half a turn counts as half a turn, as a sum of cotangents: squares are left as they are.
const EVEN: f64 = 1e-6;

/// Cosine of a bend over an edge that is none to speak of.
const FLAT: f64 = 0.85;

/// Flips for each edge in the queue at most; on curved surfaces nothing guarantees an end.
const PER_EDGE: usize = 8;

/// Flips until no edge of those given, nor around a flipped one, wants to. Returns how many were flipped.
pub(super) fn flip_from(s: &mut Surgery, queue: &mut Vec<u32>, fan: &mut Fan) -> usize {
    let mut budget = PER_EDGE * queue.len();
    let mut flipped = 0;
    while let Some(h) = queue.pop() {
        if !s.face_alive(h / 3) || !wants_flip(s, h) {
            continue;
        }
        let Some([a, b]) = s.diagonal(h) else { continue };
        if s.are_joined(a, b, fan) {
            continue;
        }
        let o = s.opposite[h as usize];
        s.flip(h);
        flipped += 1;
        budget -= 1;
        if budget == 0 {
            queue.clear();
            break;
        }
        for e in [3 * (h / 3), 3 * (h / 3) + 1, 3 * (h / 3) + 2, 3 * (o / 3), 3 * (o / 3) + 1, 3 * (o / 3) + 2] {
            queue.push(e);
        }
    }
    flipped
}

/// Flips everywhere.
pub(super) fn flip_all(s: &mut Surgery, fan: &mut Fan) -> usize {
    let half_edges = 3 * s.faces.len() as u32;
    let seen: &Surgery = s;
    let wanted = |&h: &u32| seen.face_alive(h / 3) && h < seen.opposite[h as usize] && wants_flip(seen, h);
    let mut queue: Vec<u32> = (0..half_edges).into_par_iter().filter(wanted).collect();
    flip_from(s, &mut queue, fan)
}

fn wants_flip(s: &Surgery, h: u32) -> bool {
    let o = s.opposite[h as usize];
    if o == NONE || s.feature[h as usize] {
        return false;
    }
    let at = |e: u32| s.positions[s.origin(e) as usize];
    let (a, b, c, d) = (at(h), at(next(h)), at(prev(h)), at(prev(o)));
    let (cosine_c, cosine_d) = ((a - c).dot(b - c), (a - d).dot(b - d));
    // Nearly always; no root need be taken then.
    if cosine_c >= 0.0 && cosine_d >= 0.0 {
        return false;
    }
    let cotangent = |p: DVec3, cosine: f64| cosine / (a - p).cross(b - p).length().max(f64::MIN_POSITIVE);
    if cotangent(c, cosine_c) + cotangent(d, cosine_d) > -EVEN {
        return false;
    }
    let (f, g) = ((b - a).cross(c - a), (a - b).cross(d - b));
    let (x, y) = ((d - a).cross(c - a), (b - d).cross(c - d));
    let both = f + g;
    if x.dot(both) <= 0.0 || y.dot(both) <= 0.0 {
        return false;
    }
    let bend = |m: DVec3, n: DVec3| m.dot(n) / (m.length() * n.length()).max(f64::MIN_POSITIVE);
    let (before, after) = (bend(f, g), bend(x, y));
    after >= FLAT || after >= before
}
