//! One direction out of n at each face, the same one as far as possible.
//!
//! From a face outward, best fits first, each face takes that of its n directions which continues its neighbour's. Around a
//! singularity that comes back turned by an n-th part, so a line must remain where the choice jumps: it runs where two
//! fronts meet, from singularity to singularity. The field says that it has n ways ([`TangentField::ways`]), so a patch grown over the
//! line goes on in the direction it has.

use super::{NWayField, NWaySolver, Over};
use crate::field::{FieldError, TangentField, usable_scale};
use crate::mesh::{Mesh, NONE, next};
use glam::DVec3;
use serde::Serialize;
use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::f64::consts::TAU;

/// A field combed, and the line that is left.
#[derive(Debug, Clone)]
pub struct Combed {
    /// One direction a face, of the length asked for.
    pub field: TangentField,
    /// Where the choice jumps.
    pub cut: Cut,
}

/// The line over which a choice of one direction out of n jumps.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct Cut {
    /// Edges of it.
    pub edges: usize,
    /// Its length, world units.
    pub length: f64,
}

/// Chooses one direction a face from a field over faces; `scale` is the length it gets.
///
/// # Errors
/// If the field is not over this solver's faces, or the scale is not a usable length.
pub fn comb(mesh: &Mesh, solver: &NWaySolver, field: &NWayField, scale: f64) -> Result<Combed, FieldError> {
    let length = usable_scale(scale)?;
    let faces = mesh.face_count();
    if field.over != Over::Faces || field.powers.len() != faces {
        return Err(FieldError::Length { which: "n-way", found: field.powers.len(), faces });
    }
    let part = TAU / f64::from(field.n);
    let mut angles: Vec<f64> = field.powers.iter().map(|p| p.to_angle() / f64::from(field.n)).collect();
    // How badly two neighbours fit whatever is chosen, as an integer for the heap: n-way turns up to half a part.
    let fit = |from: f64, to: f64| {
        let steps = ((from - to) / part).round();
        (to + steps * part, ((from - to - steps * part).abs() / part * 1e9) as u64)
    };
    let mut done = vec![false; faces];
    let mut heap = BinaryHeap::new();
    for seed in 0..faces as u32 {
        if done[seed as usize] {
            continue;
        }
        heap.push(Reverse((0_u64, seed, seed, 0_u32)));
        while let Some(Reverse((_, face, from, way))) = heap.pop() {
            if done[face as usize] {
                continue;
            }
            done[face as usize] = true;
            if from != face {
                let turn = solver.table.neighbours(face).nth(way as usize).map_or(0.0, |t| t.turn);
                angles[face as usize] = fit(angles[from as usize] + turn, angles[face as usize]).0;
            }
            for there in solver.table.neighbours(face).filter(|t| !done[t.node as usize]) {
                for (way, back) in solver.table.neighbours(there.node).enumerate().filter(|(_, b)| b.node == face) {
                    let cost = fit(angles[face as usize] + back.turn, angles[there.node as usize]).1;
                    heap.push(Reverse((cost, there.node, face, way as u32)));
                }
            }
        }
    }
    let mut cut = Cut::default();
    for h in 0..mesh.opposite.len() as u32 {
        let o = mesh.opposite[h as usize];
        if o == NONE || o < h {
            continue;
        }
        let before = (3 * (h / 3)..h).filter(|&e| mesh.opposite[e as usize] != NONE).count();
        let turn = solver.table.neighbours(h / 3).nth(before).map_or(0.0, |t| t.turn);
        let jump = super::connection::wrapped(angles[(o / 3) as usize] + turn - angles[(h / 3) as usize]);
        if field.n > 1 && jump.abs() > part / 2.0 {
            cut.edges += 1;
            cut.length += mesh.point(mesh.origin(h)).distance(mesh.point(mesh.origin(next(h))));
        }
    }
    let one = |(f, &angle): (usize, &f64)| {
        let direction: DVec3 = solver.table.direction(f as u32, angle);
        direction.as_vec3() * length
    };
    let up = angles.iter().enumerate().map(one).collect();
    Ok(Combed { field: TangentField { ways: field.n, ..TangentField::along(up) }, cut })
}
