//! Singularities of n-way fields and their index.
//!
//! Around a face (of a field over vertices) or a vertex (of one over faces) the turns from node to node and the curvature inside
//! sum to a whole number of n-th parts of a full turn (Ray, Vallet, Li, Levy 2008). On closed meshes these sum to n times the
//! Euler characteristic, for any field.

use super::connection::{Connection, Over, wrapped};
use super::relax::angles;
use crate::mesh::{Mesh, NONE, next, prev};
use glam::DVec2;
use rayon::prelude::*;
use serde::Serialize;
use std::f64::consts::TAU;

/// A place around which the directions turn.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct NWaySingularity {
    /// The face, of a field over vertices, or the vertex, of a field over faces.
    pub place: u32,
    /// How many n-th parts of a full turn, counter-clockwise.
    pub parts: i32,
}

/// The singularities of a field of `n` directions a node, given as the n-th powers of unit complex numbers.
pub(super) fn singularities(mesh: &Mesh, table: &Connection, n: u32, powers: &[DVec2]) -> Vec<NWaySingularity> {
    let degree = f64::from(n);
    let angles = angles(powers);
    // The turn from node i to its neighbour j, in n-th parts.
    let turn = |i: u32, j: u32, carry: f64| wrapped(angles[j as usize] + degree * carry - angles[i as usize]);
    let parts = |sum: f64| (sum / TAU).round() as i32;
    match table.over {
        Over::Faces => {
            let first = mesh.vertex_half_edges();
            let one = |vertex: u32| {
                let start = first[vertex as usize];
                if start == NONE || mesh.opposite[start as usize] == NONE {
                    return None;
                }
                let mut sum = degree * TAU;
                for h in mesh.ring(start) {
                    let e = prev(h);
                    let o = mesh.opposite[e as usize];
                    sum += both_ways(mesh, table, &turn, e, o);
                    let [a, b] = [next(h), prev(h)].map(|at| mesh.point(mesh.origin(at)) - mesh.point(vertex));
                    sum -= degree * a.cross(b).length().atan2(a.dot(b));
                }
                let parts = parts(sum);
                (parts != 0).then_some(NWaySingularity { place: vertex, parts })
            };
            (0..mesh.vertex_count() as u32).into_par_iter().filter_map(one).collect()
        }
        Over::Vertices => {
            let one = |face: u32| {
                let mut sum = degree * table.curvature[face as usize];
                for h in 3 * face..3 * face + 3 {
                    let (i, j) = (mesh.origin(h), mesh.origin(next(h)));
                    sum += between(table, &turn, i, j);
                }
                let parts = parts(sum);
                (parts != 0).then_some(NWaySingularity { place: face, parts })
            };
            (0..mesh.face_count() as u32).into_par_iter().filter_map(one).collect()
        }
    }
}

/// The turn from node `i` to `j`, computed one way only so that the other is its exact negative.
fn between(table: &Connection, turn: &impl Fn(u32, u32, f64) -> f64, i: u32, j: u32) -> f64 {
    let (low, high) = (i.min(j), i.max(j));
    let carry = table.neighbours(low).find(|n| n.node == high).map_or(0.0, |n| n.turn);
    let turned = turn(low, high, carry);
    if low == i { turned } else { -turned }
}

/// The same over an edge of faces, which may share several: by the edge and not by its faces.
fn both_ways(mesh: &Mesh, table: &Connection, turn: &impl Fn(u32, u32, f64) -> f64, h: u32, o: u32) -> f64 {
    let low = h.min(o);
    let other = mesh.opposite[low as usize];
    let before = (3 * (low / 3)..low).filter(|&e| mesh.opposite[e as usize] != NONE).count();
    let carry = table.neighbours(low / 3).nth(before).map_or(0.0, |n| n.turn);
    let turned = turn(low / 3, other / 3, carry);
    if low == h { turned } else { -turned }
}
