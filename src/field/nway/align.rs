//! Wishes: where an n-way field should point, and how much.
//!
//! A wish at a node is the n-th power of a direction times a strength; smoothness counts about 1 for each neighbour. Wishes add up.
//! Curvature and creases know lines, not directions, so they can only guide fields whose n is even.

use super::connection::{Connection, Over, unit};
use crate::field::Anchor;
use crate::mesh::curvature::Curvature;
use crate::mesh::transport::turned;
use crate::mesh::{Mesh, NONE, next};
use glam::{DVec2, DVec3};

/// How strong a wish of a constraint of weight 1 is.
const CONSTRAINT: f64 = 100.0;

/// How strong a wish of a crease is at strength 1.
const CREASE: f64 = 10.0;

/// Curvature is told from noise up to this bend within one node: sharper bends count as creases do.
const BEND: f64 = 1.0;

/// Adds the wish for one direction at a node.
pub fn wish(table: &Connection, n: u32, wishes: &mut [DVec2], node: u32, direction: DVec3, strength: f64) {
    wishes[node as usize] += unit(f64::from(n) * table.angle_of(node, direction)) * strength;
}

/// Adds wishes at the places of constraints that have a direction.
pub fn constraints(mesh: &Mesh, table: &Connection, n: u32, wishes: &mut [DVec2], anchors: &[Anchor]) {
    for anchor in anchors {
        let Some(direction) = anchor.direction else { continue };
        let face = anchor.at.face;
        match table.over {
            Over::Faces => wish(table, n, wishes, face, direction, CONSTRAINT * anchor.weight),
            Over::Vertices => {
                for (k, v) in mesh.faces[face as usize].into_iter().enumerate() {
                    let carried = turned(direction, mesh.normal(face), table.normal[v as usize]);
                    let strength = CONSTRAINT * anchor.weight * f64::from(anchor.at.bary[k]);
                    wish(table, n, wishes, v, carried, strength);
                }
            }
        }
    }
}

/// Adds wishes along the direction in which the surface bends least, as strong as the two curvatures differ over the node's area.
pub fn least_curvature(mesh: &Mesh, table: &Connection, n: u32, wishes: &mut [DVec2], bent: &Curvature, strength: f64) {
    let at = |node: usize, v: u32, share: f64, wishes: &mut [DVec2]| {
        let [most, least] = bent.principal[v as usize].map(f64::from);
        let normal = table.normal[node];
        let along = turned(bent.direction[v as usize].as_dvec3(), normal_of(bent, v, normal), normal);
        let bend = ((most.abs() - least.abs()).powi(2) * table.area[node]).min(BEND);
        wish(table, n, wishes, node as u32, normal.cross(along), strength * bend * share);
    };
    match table.over {
        Over::Vertices => (0..table.len()).for_each(|v| at(v, v as u32, 1.0, wishes)),
        Over::Faces => {
            for (f, corners) in mesh.faces.iter().enumerate() {
                corners.iter().for_each(|&v| at(f, v, 1.0 / 3.0, wishes));
            }
        }
    }
}

/// Directions of curvature lie across the vertex normal; what is left of the node's normal across them stands in for it.
fn normal_of(bent: &Curvature, v: u32, normal: DVec3) -> DVec3 {
    let along = bent.direction[v as usize].as_dvec3();
    (normal - along * normal.dot(along)).normalize_or(normal)
}

/// Adds wishes along edges over which the surface bends by more than `angle` (radians).
pub fn creases(mesh: &Mesh, table: &Connection, n: u32, wishes: &mut [DVec2], angle: f64, strength: f64) {
    let sharp = angle.cos();
    for h in 0..mesh.opposite.len() as u32 {
        let o = mesh.opposite[h as usize];
        if o == NONE || mesh.normal(h / 3).dot(mesh.normal(o / 3)) > sharp {
            continue;
        }
        let [a, b] = [mesh.origin(h), mesh.origin(next(h))];
        let edge = mesh.point(b) - mesh.point(a);
        match table.over {
            Over::Faces => wish(table, n, wishes, h / 3, edge, CREASE * strength),
            Over::Vertices => [a, b].into_iter().for_each(|v| wish(table, n, wishes, v, edge, CREASE * strength)),
        }
    }
}
