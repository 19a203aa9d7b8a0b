//! What direction at one place means at the next: a connection over the vertices or the faces of a mesh.
//!
//! Every node has a tangent frame, and every pair of neighbours the angle between their frames once one is carried to the other.
//! All of this folder works on that table alone, so a field over vertices (as synthesis wants it) and one over faces (as
//! pasting wants it) are the same to it.
//!
//! * Over faces: frames of the face planes, carried over the common edge as if it were a hinge.
//! * Over vertices: the angles of the faces around are scaled to sum to a full turn (Knoppel, Crane, Pinkall, Schroder, "Globally
//!   optimal direction fields", 2013, sec. 2.1 and 6), so that the tangent plane is flat and curvature sits in the faces.

use crate::mesh::transport::{across, angle};
use crate::mesh::{Mesh, NONE, next, prev};
use glam::{DVec2, DVec3};
use std::f64::consts::{PI, TAU};

/// Weights are kept within this factor of 1: needles would tie their neighbours together and wide angles push them apart.
const WEIGHT: f64 = 20.0;

/// What the nodes of a connection are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Over {
    /// Vertices of the mesh; singularities lie in faces.
    Vertices,
    /// Faces; singularities lie at vertices.
    Faces,
}

/// Nodes, their frames and their neighbours.
#[derive(Debug, Clone)]
pub struct Connection {
    /// What the nodes are.
    pub over: Over,
    /// First axis of each node's frame, a unit tangent; angles count counter-clockwise from it.
    pub axis: Vec<DVec3>,
    /// Unit normal of each node.
    pub normal: Vec<DVec3>,
    /// Area that each node stands for, world units squared.
    pub area: Vec<f64>,
    start: Vec<u32>,
    neighbour: Vec<u32>,
    turn: Vec<f64>,
    weight: Vec<f64>,
}

/// A neighbour of a node.
#[derive(Debug, Clone, Copy)]
pub struct Neighbour {
    /// Its number.
    pub node: u32,
    /// A direction at angle `a` there is at angle `a + turn` here.
    pub turn: f64,
    /// How much the pair counts.
    pub weight: f64,
}

impl Connection {
    /// The connection over a mesh.
    #[must_use]
    pub fn new(mesh: &Mesh, over: Over) -> Self {
        match over {
            Over::Vertices => over_vertices(mesh),
            Over::Faces => over_faces(mesh),
        }
    }

    /// Number of nodes.
    #[must_use]
    pub const fn len(&self) -> usize {
        self.axis.len()
    }

    /// True if there are no nodes.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.axis.is_empty()
    }

    /// Neighbours of a node.
    #[inline]
    pub fn neighbours(&self, node: u32) -> impl Iterator<Item = Neighbour> + '_ {
        let range = self.start[node as usize] as usize..self.start[node as usize + 1] as usize;
        range.map(|i| Neighbour { node: self.neighbour[i], turn: self.turn[i], weight: self.weight[i] })
    }

    /// The angle of a direction in a node's frame; directions that leave its plane are projected.
    #[must_use]
    pub fn angle_of(&self, node: u32, direction: DVec3) -> f64 {
        angle(self.axis[node as usize], direction, self.normal[node as usize])
    }

    /// The unit direction at an angle in a node's frame.
    #[must_use]
    pub fn direction(&self, node: u32, angle: f64) -> DVec3 {
        let axis = self.axis[node as usize];
        axis * angle.cos() + self.normal[node as usize].cross(axis) * angle.sin()
    }

    fn with_room(over: Over, nodes: usize) -> Self {
        let mut start = Vec::with_capacity(nodes + 1);
        start.push(0);
        Self {
            over,
            axis: Vec::with_capacity(nodes),
            normal: Vec::with_capacity(nodes),
            area: vec![0.0; nodes],
            start,
            neighbour: Vec::new(),
            turn: Vec::new(),
            weight: Vec::new(),
        }
    }

    fn push(&mut self, node: u32, turn: f64, weight: f64) {
        self.neighbour.push(node);
        self.turn.push(turn);
        self.weight.push(weight.clamp(1.0 / WEIGHT, WEIGHT));
    }
}

fn over_faces(mesh: &Mesh) -> Connection {
    let mut out = Connection::with_room(Over::Faces, mesh.face_count());
    for f in 0..mesh.face_count() as u32 {
        let [a, b, _] = mesh.corners(f);
        out.axis.push((b - a).normalize_or_zero());
        out.normal.push(mesh.normal(f));
        out.area[f as usize] = mesh.area(f);
    }
    for h in 0..mesh.opposite.len() as u32 {
        let (f, o) = (h / 3, mesh.opposite[h as usize]);
        if o != NONE {
            let carried = across(mesh, o, out.axis[(o / 3) as usize]).unwrap_or_default();
            // Width of the common edge over the distance of the centroids across it.
            let length = mesh.point(mesh.origin(h)).distance_squared(mesh.point(mesh.origin(next(h))));
            let weight = 1.5 * length / (out.area[f as usize] + out.area[(o / 3) as usize]).max(f64::MIN_POSITIVE);
            let turn = out.angle_of(f, carried);
            // Both sides of an edge must count alike.
            out.push(o / 3, turn, weight / 3_f64.sqrt());
        }
        if h % 3 == 2 {
            out.start.push(out.neighbour.len() as u32);
        }
    }
    out
}

/// Interior angle of a face at the origin of a half-edge.
fn corner(mesh: &Mesh, h: u32) -> f64 {
    let at = |e: u32| mesh.point(mesh.origin(e));
    let (a, b) = (at(next(h)) - at(h), at(prev(h)) - at(h));
    a.cross(b).length().atan2(a.dot(b))
}

/// By how much the angles around each vertex are scaled so that inner ones sum to a full turn.
pub(super) fn angle_scales(mesh: &Mesh) -> Vec<f64> {
    let mut sums = vec![0.0; mesh.vertex_count()];
    let mut inner = vec![true; mesh.vertex_count()];
    for h in 0..mesh.opposite.len() as u32 {
        sums[mesh.origin(h) as usize] += corner(mesh, h);
        if mesh.opposite[h as usize] == NONE {
            inner[mesh.origin(h) as usize] = false;
            inner[mesh.origin(next(h)) as usize] = false;
        }
    }
    sums.into_iter().zip(inner).map(|(sum, inner)| if inner && sum > 0.0 { TAU / sum } else { 1.0 }).collect()
}

/// Curvature that scaled angles leave in a face: their sum beyond that of a flat triangle.
pub(super) fn face_curvature(mesh: &Mesh, scales: &[f64], face: u32) -> f64 {
    (3 * face..3 * face + 3).map(|h| corner(mesh, h) * scales[mesh.origin(h) as usize]).sum::<f64>() - PI
}

fn over_vertices(mesh: &Mesh) -> Connection {
    let scales = angle_scales(mesh);
    let first = mesh.vertex_half_edges();
    let normals = mesh.vertex_normals();
    let mut out = Connection::with_room(Over::Vertices, mesh.vertex_count());
    // Angle of each half-edge around its origin; of the last edge on a boundary, which only comes in, around its target.
    let mut outward = vec![0.0; mesh.opposite.len()];
    let mut inward = vec![0.0; mesh.opposite.len()];
    for v in 0..mesh.vertex_count() as u32 {
        let (mut sum, start) = (0.0, first[v as usize]);
        let normal = normals[v as usize].as_dvec3();
        let mut axis = normal.any_orthonormal_vector();
        if start != NONE {
            let edge = mesh.point(mesh.origin(next(start))) - mesh.point(v);
            axis = (edge - normal * edge.dot(normal)).normalize_or(axis);
            for h in mesh.ring(start) {
                outward[h as usize] = sum;
                sum += corner(mesh, h) * scales[v as usize];
                inward[prev(h) as usize] = sum;
            }
        }
        out.axis.push(axis);
        out.normal.push(normal);
    }
    for f in 0..mesh.face_count() as u32 {
        mesh.faces[f as usize].into_iter().for_each(|v| out.area[v as usize] += mesh.area(f) / 3.0);
    }
    let cotangent = |h: u32| {
        let at = |e: u32| mesh.point(mesh.origin(e));
        let (a, b) = (at(h) - at(prev(h)), at(next(h)) - at(prev(h)));
        a.dot(b) / a.cross(b).length().max(f64::MIN_POSITIVE)
    };
    for v in 0..mesh.vertex_count() as u32 {
        if first[v as usize] != NONE {
            let mut last = NONE;
            for h in mesh.ring(first[v as usize]) {
                let o = mesh.opposite[h as usize];
                // How the edge leaves here, and how it arrives there.
                let there = if o == NONE { inward[h as usize] } else { outward[o as usize] };
                let weight = if o == NONE { cotangent(h) } else { cotangent(h) + cotangent(o) };
                out.push(mesh.origin(next(h)), outward[h as usize] - there - PI, weight * 3_f64.sqrt() / 2.0);
                last = prev(h);
            }
            if mesh.opposite[last as usize] == NONE {
                let here = inward[last as usize];
                out.push(mesh.origin(last), here - outward[last as usize] - PI, cotangent(last) * 3_f64.sqrt() / 2.0);
            }
        }
        out.start.push(out.neighbour.len() as u32);
    }
    out
}

/// A unit complex number.
#[inline]
pub(super) fn unit(angle: f64) -> DVec2 {
    DVec2::from_angle(angle)
}

/// An angle in (-pi, pi].
#[inline]
pub(super) fn wrapped(angle: f64) -> f64 {
    let turned = angle - TAU * (angle / TAU).round();
    if turned <= -PI { turned + TAU } else { turned }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;

    #[test]
    fn neighbours_turn_against_each_other_and_count_alike() {
        for mesh in [shapes::torus(16, 9, 1.0, 0.4), shapes::uneven_square(8), shapes::sphere(2)] {
            for over in [Over::Vertices, Over::Faces] {
                let table = Connection::new(&mesh, over);
                for i in 0..table.len() as u32 {
                    for there in table.neighbours(i) {
                        let back = table.neighbours(there.node).find(|n| n.node == i).expect("neighbours name each other");
                        assert!(wrapped(back.turn + there.turn).abs() < 1e-9, "{over:?} {i}: {} and {}", there.turn, back.turn);
                        assert!((back.weight - there.weight).abs() < 1e-12, "{over:?} {i}: weights");
                    }
                }
            }
        }
    }

    #[test]
    fn on_a_plane_a_direction_stays_what_it_is() {
        let mesh = shapes::uneven_square(8);
        for over in [Over::Vertices, Over::Faces] {
            let table = Connection::new(&mesh, over);
            for i in 0..table.len() as u32 {
                let here = table.angle_of(i, DVec3::new(0.8, 0.6, 0.0));
                for there in table.neighbours(i) {
                    let carried = table.angle_of(there.node, DVec3::new(0.8, 0.6, 0.0)) + there.turn;
                    assert!(wrapped(carried - here).abs() < 1e-5, "{over:?}: node {i} {here} {carried}");
                }
            }
        }
    }
}
