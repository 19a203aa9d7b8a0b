//! Repulsion: vertices move over the surface until they are evenly spread.
//!
//! Turk sums forces from all points within a radius and lays the neighbouring faces flat to find them. Here the neighbours are
//! those of the triangulation, which is kept Delaunay, so that no search is needed and thin sheets never mix up; and the step is
//! that of Lloyd's method (Du, Faber, Gunzburger 1999): towards the centroid of the faces around, which needs no radius and no
//! strength to tune. Points walk over the original, face by face, so they always lie on it.
//!
//! What moves only to its neighbours spreads slowly. So vertices that crowd are taken out, and as many are put where there is
//! most room: the ends of a long way in one step.

use super::flips::{flip_all, flip_from};
use super::remove::{Scratch, remove, sides};
use super::surgery::Surgery;
use super::{Role, Tiling};
use crate::mesh::transport::{projected, turned};
use crate::mesh::walk::walk;
use crate::mesh::{NONE, SurfacePoint, next, prev};
use glam::DVec3;
use rayon::prelude::*;

/// Edges shorter and longer than these shares of the mean length that the count asks for are crowded and roomy.
const SHORT: f64 = 0.78;
const LONG: f64 = 1.28;

/// How far beyond the centroid a step goes: Lloyd's method falls short of where it would end.
const BEYOND: f64 = 0.8;

/// A step is no longer than this share of an edge.
const LONGEST_STEP: f64 = 0.4;

/// A vertex put on an edge lies within this share of half of it from its middle.
const ASTRAY: f64 = 0.8;

/// A face may turn by this much (cosine) in one step, and its height must stay this share of an edge.
const LEAST_TURN: f64 = 0.5;
const LEAST_HEIGHT: f64 = 0.02;

/// One round: flips, moves, and moves back where a face would turn over. Returns the mean step as a share of an edge.
pub(super) fn relax(t: &mut Tiling, scratch: &mut Scratch) -> f64 {
    flip_all(&mut t.surgery, &mut scratch.fan);
    let seen: &Tiling = t;
    let steps: Vec<Option<(SurfacePoint, DVec3)>> = (0..seen.role.len() as u32).into_par_iter().map(|v| step(seen, v)).collect();
    let before = t.surgery.positions.clone();
    let (mut sum, mut count) = (0.0, 0);
    let mut from = Vec::with_capacity(steps.len());
    for (v, step) in steps.into_iter().enumerate() {
        from.push(t.at[v]);
        if let Some((at, position)) = step {
            sum += position.distance(before[v]);
            count += 1;
            t.at[v] = at;
            t.surgery.positions[v] = position;
        }
    }
    // Moving a vertex back can spoil a face that was fine with both moved; a second and a third look find nearly all of them.
    for _ in 0..3 {
        let spoilt = spoilt(&t.surgery, &before, t.edge);
        for &f in &spoilt {
            for v in t.surgery.faces[f as usize] {
                t.surgery.positions[v as usize] = before[v as usize];
                t.at[v as usize] = from[v as usize];
            }
        }
        if spoilt.is_empty() {
            break;
        }
    }
    sum / f64::from(count.max(1)) / t.edge
}

/// Where a vertex goes.
fn step(t: &Tiling, v: u32) -> Option<(SurfacePoint, DVec3)> {
    let s = &t.surgery;
    if t.role[v as usize] != Role::Free || !s.is_alive(v) {
        return None;
    }
    let here = s.positions[v as usize];
    let (mut centre, mut normal, mut total) = (DVec3::ZERO, DVec3::ZERO, 0.0);
    let start = s.start[v as usize];
    let mut spoke = start;
    let mut p = s.positions[s.target(start) as usize] - here;
    loop {
        let before = prev(spoke);
        let q = s.positions[s.origin(before) as usize] - here;
        let area = p.cross(q);
        normal += area;
        let size = area.length();
        total += size;
        centre += (p + q) * (size / 3.0);
        p = q;
        spoke = s.opposite[before as usize];
        if spoke == start {
            break;
        }
        if spoke == NONE {
            return None;
        }
    }
    let normal = normal.try_normalize()?;
    if !(total > 0.0) {
        return None;
    }
    let way = projected(centre / total * BEYOND, normal).clamp_length_max(LONGEST_STEP * t.edge);
    let face = t.original.normal(t.at[v as usize].face);
    let flat = projected(turned(way, normal, face), face);
    let flat = flat.normalize_or_zero() * way.length();
    let at = walk(t.original, t.at[v as usize], flat);
    Some((at, t.original.position(at)))
}

/// Faces that turned too far from where they looked before, or have no width any more.
fn spoilt(s: &Surgery, before: &[DVec3], edge: f64) -> Vec<u32> {
    let spoilt = |&f: &u32| {
        if !s.face_alive(f) {
            return false;
        }
        let [a, b, c] = s.faces[f as usize].map(|v| before[v as usize]);
        let p = s.corners(f);
        if p == [a, b, c] {
            return false;
        }
        let (old, new) = ((b - a).cross(c - a), (p[1] - p[0]).cross(p[2] - p[0]));
        let (same, old, new) = (new.dot(old), old.length_squared(), new.length_squared());
        let longest = p[0].distance_squared(p[1]).max(p[1].distance_squared(p[2])).max(p[2].distance_squared(p[0]));
        let flat = new < (LEAST_HEIGHT * edge).powi(2) * longest && new < old;
        flat || same < 0.0 || same * same < LEAST_TURN * LEAST_TURN * old * new
    };
    (0..s.faces.len() as u32).into_par_iter().filter(spoilt).collect()
}

/// Takes vertices out where they crowd and puts as many where there is room; the count comes to what was asked for as far as
/// possible. `exactly` goes on beyond crowded and roomy edges until it does. Returns how many were moved.
pub(super) fn relocate(t: &mut Tiling, exactly: bool, scratch: &mut Scratch) -> usize {
    let s = &t.surgery;
    let alive = s.alive_vertices();
    let edges = |wanted: &(dyn Fn(u32, f64) -> bool + Sync)| -> Vec<(f64, u32, [u32; 2])> {
        let one = |h: u32| {
            let listed = s.face_alive(h / 3) && (s.opposite[h as usize] == NONE || h < s.opposite[h as usize]);
            let length = if listed { s.length(h) } else { return None };
            wanted(h, length).then(|| (length, h, [s.origin(h), s.target(h)]))
        };
        (0..3 * s.faces.len() as u32).into_par_iter().filter_map(one).collect()
    };
    let mut short = edges(&|_, length| length < if exactly && alive > t.count { t.edge } else { SHORT * t.edge });
    let wanting = exactly && alive < t.count;
    let mut long = edges(&|h, length| {
        let roomy = length > if wanting { SHORT * t.edge } else { LONG * t.edge };
        // The longest edge of both its faces, so that halving it makes good ones; between lines there may be none.
        let longest = |f: u32| sides(f).iter().all(|&e| s.length(e) <= length);
        roomy && !s.feature[h as usize] && (wanting || longest(h / 3) && longest(s.opposite[h as usize] / 3))
    });
    short.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    long.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
    let mut out = 0;
    let most_out = alive.saturating_sub(t.count) + long.len().saturating_sub(t.count.saturating_sub(alive));
    for (_, h, [a, b]) in short {
        if out >= most_out {
            break;
        }
        let same = t.surgery.face_alive(h / 3) && t.surgery.origin(h) == a && t.surgery.target(h) == b;
        if !same {
            continue;
        }
        // Of two, the one with fewer neighbours goes: six each is what an even mesh has.
        let mut valence = |v: u32| {
            t.surgery.fan(v, &mut scratch.fan);
            scratch.fan.spokes.len()
        };
        let (first, second) = if valence(a) <= valence(b) { (a, b) } else { (b, a) };
        let taken =
            |v: u32, t: &mut Tiling, scratch: &mut Scratch| t.role[v as usize] == Role::Free && remove(t, v, LEAST_TURN, scratch);
        if taken(first, t, scratch) || taken(second, t, scratch) {
            out += 1;
        }
    }
    let most_in = (t.count + out).saturating_sub(alive);
    let mut put = 0;
    for (_, h, [a, b]) in long {
        if put >= most_in {
            break;
        }
        let s = &t.surgery;
        if s.face_alive(h / 3) && s.origin(h) == a && s.target(h) == b && !s.feature[h as usize] {
            put += usize::from(split(t, h, scratch));
        }
    }
    out + put
}

/// Puts a vertex at the middle of an edge, on the original; not where the way there over the original leads astray, as it may over
/// folds.
fn split(t: &mut Tiling, h: u32, scratch: &mut Scratch) -> bool {
    let s = &mut t.surgery;
    let normal = (s.area_vector(h / 3) + s.area_vector(s.opposite[h as usize] / 3)).normalize_or_zero();
    let corners = [h, next(h), prev(h), prev(s.opposite[h as usize])].map(|e| s.origin(e));
    let [a, b] = [corners[0], corners[1]].map(|v| s.positions[v as usize]);
    let (middle, reach) = ((a + b) / 2.0, ASTRAY * a.distance(b) / 2.0);
    // From whichever corner of the two faces the way over the original ends nearest.
    let from = |&v: &u32| {
        let (way, at) = (middle - s.positions[v as usize], t.at[v as usize]);
        let face = t.original.normal(at.face);
        let flat = projected(turned(way, normal, face), face).normalize_or_zero() * way.length();
        let at = walk(t.original, at, flat);
        (at, t.original.position(at))
    };
    let off = |found: &(SurfacePoint, DVec3)| found.1.distance(middle);
    let found = corners.iter().map(from).min_by(|x, y| off(x).total_cmp(&off(y))).filter(|found| off(found) < reach);
    let Some((at, position)) = found else { return false };
    let m = s.split_edge(h, position);
    t.at.push(at);
    t.role.push(Role::Free);
    s.fan(m, &mut scratch.fan);
    scratch.queue.clear();
    for &spoke in &scratch.fan.spokes {
        scratch.queue.extend([next(spoke), spoke]);
    }
    flip_from(s, &mut scratch.queue, &mut scratch.fan);
    true
}
