//! Keeping the new mesh near the original: tips and thin parts that fell between the new vertices get theirs back.
//!
//! 1. Find the vertices of the original that lie farther from the new mesh than a share of an edge, the farthest one first, no two
//!    at neighbouring faces.
//! 2. Cut the face nearest to each in three there; the vertex stays fixed.
//!
//! Repulsion goes on after that and takes out as many others where they crowd.

use super::flips::flip_from;
use super::remove::Scratch;
use super::{Role, Tiling};
use crate::mesh::nearest::Nearest;
use crate::mesh::walk::at_origin;
use crate::mesh::{NONE, next};
use rayon::prelude::*;

/// Share of an edge beyond which a vertex of the original is too far. Half an edge is what the result promises; what comes
/// after still moves the surface a little.
const TOO_FAR: f64 = 0.35;

/// Puts back old vertices where the new mesh lies too far from them, if allowed to. Returns how many, and the largest distance of
/// an old vertex from the mesh before.
pub(super) fn put_back(t: &mut Tiling, allowed: bool, scratch: &mut Scratch) -> (usize, f64) {
    t.compact(None);
    let mesh = t.surgery.mesh();
    let first = t.original.vertex_half_edges();
    let tree = Nearest::new(&mesh);
    let one = |v: u32| tree.nearest(t.original.point(v)).map(|hit| (hit.distance, v, hit.at.face));
    let used = |&v: &u32| first[v as usize] != NONE;
    let found: Vec<(f64, u32, u32)> = (0..first.len() as u32).into_par_iter().filter(used).filter_map(one).collect();
    let farthest = found.iter().map(|d| d.0).fold(0.0, f64::max);
    let mut far: Vec<(f64, u32, u32)> = found.into_iter().filter(|d| allowed && d.0 > TOO_FAR * t.edge).collect();
    far.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
    let mut taken = vec![false; mesh.face_count()];
    let mut put = 0;
    for (_, v, face) in far {
        let mut around = (0..3).map(|k| mesh.neighbour(face, k)).filter(|&g| g != NONE);
        if taken[face as usize] || around.any(|g| taken[g as usize]) {
            continue;
        }
        taken[face as usize] = true;
        let m = t.surgery.split_face(face, t.original.point(v));
        t.at.push(at_origin(first[v as usize]));
        t.role.push(Role::Fixed);
        t.surgery.fan(m, &mut scratch.fan);
        scratch.queue.clear();
        scratch.fan.spokes.iter().for_each(|&spoke| scratch.queue.push(next(spoke)));
        flip_from(&mut t.surgery, &mut scratch.queue, &mut scratch.fan);
        put += 1;
    }
    (put, farthest)
}
