//! What lies around each vertex of a level, in the vertex's own texture frame.
//!
//! For each neighbour: where it is (at its true distance, in the direction of its projection on the tangent plane), and how its
//! frame is turned against this one. That is all that flattening, coherence and convolution need to know of a mesh.

use crate::mesh::transport::turned;
use crate::mesh::{Mesh, NONE, next, prev};
use glam::{DVec3, Vec2};
use rayon::prelude::*;

/// A texture frame: right and up are unit tangents, at right angles to each other and to the normal.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Frame {
    /// Texture right.
    pub right: DVec3,
    /// Texture up.
    pub up: DVec3,
    /// Outward normal.
    pub normal: DVec3,
}

impl Frame {
    /// The frame of a normal and a direction of "right"; a direction along the normal gives any frame.
    #[must_use]
    pub fn new(normal: DVec3, right: DVec3) -> Self {
        let normal = normal.try_normalize().unwrap_or(DVec3::Z);
        let right = (right - normal * right.dot(normal)).try_normalize().unwrap_or_else(|| normal.any_orthonormal_vector());
        Self { right, up: normal.cross(right), normal }
    }

    /// A vector's part in the tangent plane, right and up.
    #[inline]
    #[must_use]
    pub fn project(&self, vector: DVec3) -> Vec2 {
        Vec2::new(vector.dot(self.right) as f32, vector.dot(self.up) as f32)
    }

    /// How another frame is turned against this one: its "right" carried here, as a unit complex number.
    #[must_use]
    pub fn turn(&self, other: &Self) -> Vec2 {
        self.project(turned(other.right, other.normal, self.normal)).try_normalize().unwrap_or(Vec2::X)
    }
}

/// A neighbour of a vertex.
#[derive(Debug, Clone, Copy)]
pub(super) struct Spoke {
    pub(super) to: u32,
    /// The face between this spoke and the next, if there is one.
    pub(super) face: bool,
    /// Where the neighbour lies in this vertex's frame, in units of the level's spacing.
    pub(super) out: Vec2,
    /// Where this vertex lies in the neighbour's frame.
    pub(super) back: Vec2,
    /// How the neighbour's frame is turned against this one.
    pub(super) turn: Vec2,
}

/// All spokes of a mesh.
#[derive(Debug, Clone)]
pub(super) struct Fans {
    start: Vec<u32>,
    spokes: Vec<Spoke>,
}

impl Fans {
    /// The fans of a mesh with a frame at each vertex and a spacing.
    pub(super) fn new(mesh: &Mesh, frames: &[Frame], spacing: f64) -> Self {
        let first = mesh.vertex_half_edges();
        let fan = |v: usize| -> Vec<Spoke> {
            let mut out = Vec::with_capacity(8);
            if first[v] == NONE {
                return out;
            }
            let spoke = |to: u32, face: bool| {
                let way = (mesh.point(to) - mesh.point(v as u32)) / spacing;
                let length = way.length() as f32;
                let flat = |frame: &Frame, way: DVec3| frame.project(way).normalize_or_zero() * length;
                let (here, there) = (&frames[v], &frames[to as usize]);
                Spoke { to, face, out: flat(here, way), back: flat(there, -way), turn: here.turn(there) }
            };
            let mut last = NONE;
            for h in mesh.ring(first[v]) {
                out.push(spoke(mesh.origin(next(h)), true));
                last = h;
            }
            // At a boundary one more neighbour lies beyond the last face.
            if mesh.opposite[prev(last) as usize] == NONE {
                out.push(spoke(mesh.origin(prev(last)), false));
            }
            out
        };
        let fans: Vec<Vec<Spoke>> = (0..mesh.vertex_count()).into_par_iter().with_min_len(256).map(fan).collect();
        let mut start = Vec::with_capacity(fans.len() + 1);
        start.push(0);
        let mut sum = 0;
        start.extend(fans.iter().map(|f| {
            sum += f.len() as u32;
            sum
        }));
        Self { start, spokes: fans.concat() }
    }

    #[inline]
    pub(super) fn of(&self, vertex: u32) -> &[Spoke] {
        &self.spokes[self.start[vertex as usize] as usize..self.start[vertex as usize + 1] as usize]
    }

    pub(super) const fn len(&self) -> usize {
        self.start.len() - 1
    }
}
