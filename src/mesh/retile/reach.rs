//! Keeping the new mesh near the original: tips and thin parts that fell between the new vertices get theirs back.
//!
//! 1. Find the vertices of the original that lie farther from the new mesh than an edge's share, the farthest one first, each
//!    well away from those before it.
//! 2. Cut the face nearest to each in three there; the vertex stays fixed.
//! 3. Take out as many others where they crowd most, relax, and look again.

use super::flips::flip_from;
use super::remove::Scratch;
use super::repulsion::{fix_lines, relax, relocate};
use super::{Role, Tiling};
use crate::mesh::nearest::Nearest;
use crate::mesh::walk::at_origin;
use crate::mesh::{Mesh, MeshError, NONE, next};
use rayon::prelude::*;

/// Rounds of looking and mending.
const ROUNDS: usize = 5;

/// Share of an edge beyond which a vertex of the original is too far. Half an edge is what the result promises; rounds after
/// this one still move the surface a little.
const TOO_FAR: f64 = 0.4;

/// Puts back what is needed, and brings the count to what was asked for. Returns how many were put back and how far the
/// farthest vertex of the original is from the new mesh.
pub(super) fn put_back(t: &mut Tiling, scratch: &mut Scratch) -> Result<(usize, f64), MeshError> {
    let first = t.original.vertex_half_edges();
    let mut put = 0;
    let mut farthest = 0.0;
    for round in 0..=ROUNDS {
        settle(t, scratch);
        let (mesh, kept) = t.surgery.finish()?;
        let far = far_vertices(t.original, &mesh, &first, TOO_FAR * t.edge);
        farthest = far.farthest;
        if far.places.is_empty() || round == ROUNDS {
            break;
        }
        // Faces here by their place among the living ones.
        let alive: Vec<u32> = (0..t.surgery.faces.len() as u32).filter(|&f| t.surgery.face_alive(f)).collect();
        debug_assert_eq!(alive.len(), mesh.face_count(), "{} vertices", kept.len());
        for (v, face) in far.places {
            let face = alive[face as usize];
            let m = t.surgery.split_face(face, t.original.point(v));
            t.at.push(at_origin(first[v as usize]));
            t.role.push(Role::Fixed);
            t.surgery.fan(m, &mut scratch.fan);
            scratch.queue.clear();
            scratch.fan.spokes.iter().for_each(|&spoke| scratch.queue.push(next(spoke)));
            flip_from(&mut t.surgery, &mut scratch.queue, &mut scratch.fan);
            put += 1;
        }
    }
    Ok((put, farthest))
}

/// Brings the count right, and evens out what that disturbed.
fn settle(t: &mut Tiling, scratch: &mut Scratch) {
    fix_lines(t, scratch);
    for _ in 0..4 {
        if t.surgery.alive_vertices() == t.count || relocate(t, true, scratch) == 0 {
            break;
        }
        relax(t, scratch);
        relax(t, scratch);
    }
    relax(t, scratch);
    super::flips::flip_all(&mut t.surgery, &mut scratch.fan);
}

struct Far {
    farthest: f64,
    /// Vertices of the original, and the face of the new mesh nearest to each. No face twice.
    places: Vec<(u32, u32)>,
}

fn far_vertices(original: &Mesh, mesh: &Mesh, first: &[u32], bound: f64) -> Far {
    let tree = Nearest::new(mesh);
    let used: Vec<u32> = (0..original.vertex_count() as u32).filter(|&v| first[v as usize] != NONE).collect();
    let hits: Vec<(f64, u32, u32)> = used
        .par_iter()
        .filter_map(|&v| tree.nearest(original.point(v)).map(|hit| (hit.distance, v, hit.at.face)))
        .filter(|h| h.0 > bound * 0.5)
        .collect();
    let farthest = hits.iter().map(|h| h.0).fold(0.0, f64::max);
    let mut far: Vec<(f64, u32, u32)> = hits.into_iter().filter(|h| h.0 > bound).collect();
    far.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
    let mut taken = vec![false; mesh.face_count()];
    let mut places = Vec::new();
    for (_, v, face) in far {
        let around = (0..3).map(|k| mesh.neighbour(face, k)).filter(|&g| g != NONE);
        if taken[face as usize] || around.clone().any(|g| taken[g as usize]) {
            continue;
        }
        taken[face as usize] = true;
        places.push((v, face));
    }
    Far { farthest, places }
}
