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
use super::remove::{Scratch, is_on_line, remove, sides};
use super::surgery::{Fan, Surgery};
use super::{Role, Tiling};
use crate::mesh::transport::{projected, turned};
use crate::mesh::walk::walk;
use crate::mesh::{NONE, SurfacePoint, next, prev};
use glam::DVec3;
use rayon::prelude::*;

/// Edges shorter and longer than these shares of the mean length that the count asks for are crowded and roomy.
const SHORT: f64 = 0.66;
const LONG: f64 = 1.42;

/// How far beyond the centroid a step goes: Lloyd's method falls short of where it would end.
const BEYOND: f64 = 1.5;

/// A step is no longer than this share of an edge.
const LONGEST_STEP: f64 = 0.4;

/// A face may turn by this much (cosine) in one step, and its height must stay this share of an edge.
const LEAST_TURN: f64 = 0.5;
const LEAST_HEIGHT: f64 = 0.02;

/// One round: flips, moves, and moves back where a face would turn over. Returns the mean step as a share of an edge.
pub(super) fn relax(t: &mut Tiling, scratch: &mut Scratch) -> f64 {
    flip_all(&mut t.surgery, &mut scratch.fan);
    let seen: &Tiling = t;
    let steps: Vec<Option<(SurfacePoint, DVec3)>> =
        (0..seen.role.len() as u32).into_par_iter().map_init(Fan::default, |fan, v| step(seen, v, fan)).collect();
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
fn step(t: &Tiling, v: u32, fan: &mut Fan) -> Option<(SurfacePoint, DVec3)> {
    let s = &t.surgery;
    if t.role[v as usize] != Role::Free || !s.is_alive(v) {
        return None;
    }
    s.fan(v, fan);
    let here = s.positions[v as usize];
    let (mut centre, mut normal, mut total) = (DVec3::ZERO, DVec3::ZERO, 0.0);
    for &spoke in &fan.spokes {
        let (p, q) = (s.positions[s.target(spoke) as usize] - here, s.positions[s.origin(prev(spoke)) as usize] - here);
        let area = p.cross(q);
        normal += area;
        let size = area.length();
        total += size;
        centre += (p + q) * (size / 3.0);
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
        let old = (b - a).cross(c - a);
        let p = s.corners(f);
        let new = s.area_vector(f);
        let moved = p != [a, b, c];
        let longest = p[0].distance(p[1]).max(p[1].distance(p[2])).max(p[2].distance(p[0]));
        let flat = new.length() < LEAST_HEIGHT * edge * longest && new.length() < old.length();
        moved && (flat || new.dot(old) < LEAST_TURN * new.length() * old.length())
    };
    (0..s.faces.len() as u32).into_par_iter().filter(spoilt).collect()
}

/// Takes vertices out where they crowd and puts as many where there is room; the count comes to what was asked for as far as
/// possible. `exactly` goes on beyond crowded and roomy edges until it does. Returns how many were moved.
pub(super) fn relocate(t: &mut Tiling, exactly: bool, scratch: &mut Scratch) -> usize {
    let s = &t.surgery;
    let alive = s.alive_vertices();
    let (mut short, mut long) = (Vec::new(), Vec::new());
    for h in 0..3 * s.faces.len() as u32 {
        if !s.face_alive(h / 3) || (s.opposite[h as usize] != NONE && s.opposite[h as usize] < h) {
            continue;
        }
        let length = s.length(h);
        let ends = [s.origin(h), s.target(h)];
        if exactly && alive > t.count || length < SHORT * t.edge {
            short.push((length, h, ends));
        }
        // The longest edges of two faces only, so that halving them makes good ones.
        let longest = |f: u32| sides(f).iter().all(|&e| s.length(e) <= length);
        let roomy = length > LONG * t.edge || exactly && alive < t.count;
        if roomy && !s.feature[h as usize] && longest(h / 3) && longest(s.opposite[h as usize] / 3) {
            long.push((length, h, ends));
        }
    }
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
        let taken = |v: u32, t: &mut Tiling, scratch: &mut Scratch| t.role[v as usize] == Role::Free && remove(t, v, LEAST_TURN, scratch);
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
            split(t, h, scratch);
            put += 1;
        }
    }
    out + put
}

/// Puts a vertex at the middle of an edge, on the original.
fn split(t: &mut Tiling, h: u32, scratch: &mut Scratch) {
    let s = &mut t.surgery;
    let (a, b) = (s.origin(h), s.target(h));
    let (from, to) = if t.role[a as usize] == Role::Free { (a, b) } else { (b, a) };
    let half = (s.positions[to as usize] - s.positions[from as usize]) / 2.0;
    let at = t.at[from as usize];
    let normal = (s.area_vector(h / 3) + s.area_vector(s.opposite[h as usize] / 3)).normalize_or_zero();
    let face = t.original.normal(at.face);
    let flat = projected(turned(half, normal, face), face).normalize_or_zero() * half.length();
    let at = walk(t.original, at, flat);
    // Where the surface between folds, the walk may lead astray; the new vertex must lie between the two old ones.
    let middle = s.positions[from as usize] + half;
    let position = t.original.position(at);
    let position = if position.distance(middle) < half.length() { position } else { middle };
    let m = s.split_edge(h, position);
    t.at.push(at);
    t.role.push(Role::Free);
    s.fan(m, &mut scratch.fan);
    scratch.queue.clear();
    for &spoke in &scratch.fan.spokes {
        scratch.queue.extend([next(spoke), spoke]);
    }
    flip_from(s, &mut scratch.queue, &mut scratch.fan);
}

/// Vertices that the lines have taken since are free no longer.
pub(super) fn fix_lines(t: &mut Tiling, scratch: &mut Scratch) {
    for v in 0..t.role.len() as u32 {
        if t.surgery.is_alive(v) && t.role[v as usize] == Role::Free && is_on_line(&t.surgery, v, &mut scratch.fan) {
            t.role[v as usize] = Role::Fixed;
        }
    }
}
