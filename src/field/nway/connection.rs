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
use glam::{DVec2, DVec3, Vec3};
use rayon::prelude::*;
use std::f64::consts::{PI, TAU};

/// Weights are kept within this factor of 1: needles would tie their neighbours together and wide angles push them apart.
const WEIGHT: f64 = 20.0;

/// Nodes whose neighbours one task finds, and how many each has about.
const PIECE: usize = 2048;
const USUAL: usize = 6;

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
    /// Curvature in each face, of nodes at the vertices: the sum of its scaled angles beyond that of a flat triangle. Empty of nodes at
    /// the faces.
    pub curvature: Vec<f64>,
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

    /// The turns of all neighbours of all nodes, one node after the other.
    pub(super) fn turns(&self) -> &[f64] {
        &self.turn
    }

    /// Takes the rows in, each node's neighbours; made by several threads, a piece at a time.
    fn with_rows(mut self, row: impl Fn(u32, &mut Vec<Neighbour>) + Sync) -> Self {
        let nodes: Vec<u32> = (0..self.len() as u32).collect();
        let pieces: Vec<(Vec<u32>, Vec<Neighbour>)> = nodes
            .par_chunks(PIECE)
            .map(|piece| {
                let (mut ends, mut found) = (Vec::with_capacity(piece.len()), Vec::with_capacity(piece.len() * USUAL));
                for &node in piece {
                    row(node, &mut found);
                    ends.push(found.len() as u32);
                }
                (ends, found)
            })
            .collect();
        self.start.push(0);
        for (ends, found) in pieces {
            let before = self.neighbour.len() as u32;
            self.start.extend(ends.into_iter().map(|end| before + end));
            self.neighbour.extend(found.iter().map(|n| n.node));
            self.turn.extend(found.iter().map(|n| n.turn));
            self.weight.extend(found.iter().map(|n| n.weight.clamp(1.0 / WEIGHT, WEIGHT)));
        }
        self
    }
}

fn over_faces(mesh: &Mesh) -> Connection {
    let faces = || (0..mesh.face_count() as u32).into_par_iter();
    let axis_of = |f: u32| {
        let [a, b, _] = mesh.corners(f);
        (b - a).normalize_or_zero()
    };
    let out = Connection {
        over: Over::Faces,
        axis: faces().map(axis_of).collect(),
        normal: faces().map(|f| mesh.normal(f)).collect(),
        area: faces().map(|f| mesh.area(f)).collect(),
        curvature: Vec::new(),
        start: Vec::new(),
        neighbour: Vec::new(),
        turn: Vec::new(),
        weight: Vec::new(),
    };
    let (axis, normal, area) = (out.axis.clone(), out.normal.clone(), out.area.clone());
    out.with_rows(|f, row| {
        for h in 3 * f..3 * f + 3 {
            let o = mesh.opposite[h as usize];
            if o != NONE {
                let carried = across(mesh, o, axis[(o / 3) as usize]).unwrap_or_default();
                // Width of the common edge over the distance of the centroids across it. Both sides of an edge must count alike.
                let length = mesh.point(mesh.origin(h)).distance_squared(mesh.point(mesh.origin(next(h))));
                let weight = 1.5 * length / (area[f as usize] + area[(o / 3) as usize]).max(f64::MIN_POSITIVE);
                let turn = angle(axis[f as usize], carried, normal[f as usize]);
                row.push(Neighbour { node: o / 3, turn, weight: weight / 3_f64.sqrt() });
            }
        }
    })
}

/// The corners of all faces, each by the half-edge that leaves it.
struct Corners {
    /// Interior angles, scaled so that those around an inner vertex sum to a full turn.
    scaled: Vec<f64>,
    cotangent: Vec<f64>,
}

impl Corners {
    fn new(mesh: &Mesh) -> Self {
        let corner = |h: u32| {
            let at = |e: u32| mesh.point(mesh.origin(e));
            let (a, b) = (at(next(h)) - at(h), at(prev(h)) - at(h));
            let (sine, cosine) = (a.cross(b).length(), a.dot(b));
            (sine.atan2(cosine), cosine / sine.max(f64::MIN_POSITIVE))
        };
        let (mut angles, cotangent): (Vec<f64>, Vec<f64>) = (0..mesh.opposite.len() as u32).into_par_iter().map(corner).unzip();
        let mut sums = vec![0.0; mesh.vertex_count()];
        let mut inner = vec![true; mesh.vertex_count()];
        for h in 0..mesh.opposite.len() as u32 {
            sums[mesh.origin(h) as usize] += angles[h as usize];
            if mesh.opposite[h as usize] == NONE {
                inner[mesh.origin(h) as usize] = false;
                inner[mesh.origin(next(h)) as usize] = false;
            }
        }
        let scales: Vec<f64> =
            sums.into_iter().zip(inner).map(|(sum, inner)| if inner && sum > 0.0 { TAU / sum } else { 1.0 }).collect();
        (0..mesh.opposite.len() as u32).for_each(|h| angles[h as usize] *= scales[mesh.origin(h) as usize]);
        Self { scaled: angles, cotangent }
    }
}

fn over_vertices(mesh: &Mesh) -> Connection {
    let corners = Corners::new(mesh);
    let first = mesh.vertex_half_edges();
    let normal: Vec<DVec3> = mesh.vertex_normals().into_iter().map(Vec3::as_dvec3).collect();
    // Angle of each half-edge around its origin; of the last edge on a boundary, which only comes in, around its target.
    let mut outward = vec![0.0; mesh.opposite.len()];
    let mut inward = vec![0.0; mesh.opposite.len()];
    for &start in first.iter().filter(|&&start| start != NONE) {
        let mut sum = 0.0;
        for h in mesh.ring(start) {
            outward[h as usize] = sum;
            sum += corners.scaled[h as usize];
            inward[prev(h) as usize] = sum;
        }
    }
    let axis_of = |v: u32| {
        let (start, normal) = (first[v as usize], normal[v as usize]);
        let any = normal.any_orthonormal_vector();
        if start == NONE {
            return any;
        }
        let edge = mesh.point(mesh.origin(next(start))) - mesh.point(v);
        (edge - normal * edge.dot(normal)).normalize_or(any)
    };
    let mut area = vec![0.0; mesh.vertex_count()];
    for f in 0..mesh.face_count() as u32 {
        let share = mesh.area(f) / 3.0;
        mesh.faces[f as usize].into_iter().for_each(|v| area[v as usize] += share);
    }
    let out = Connection {
        over: Over::Vertices,
        axis: (0..mesh.vertex_count() as u32).into_par_iter().map(axis_of).collect(),
        normal,
        area,
        curvature: corners.scaled.chunks_exact(3).map(|c| c.iter().sum::<f64>() - PI).collect(),
        start: Vec::new(),
        neighbour: Vec::new(),
        turn: Vec::new(),
        weight: Vec::new(),
    };
    let cotangent = |h: u32| corners.cotangent[prev(h) as usize];
    out.with_rows(|v, row| {
        if first[v as usize] == NONE {
            return;
        }
        let mut push = |node: u32, turn: f64, weight: f64| row.push(Neighbour { node, turn, weight: weight * 3_f64.sqrt() / 2.0 });
        let mut last = NONE;
        for h in mesh.ring(first[v as usize]) {
            let o = mesh.opposite[h as usize];
            // How the edge leaves here, and how it arrives there.
            let there = if o == NONE { inward[h as usize] } else { outward[o as usize] };
            let weight = if o == NONE { cotangent(h) } else { cotangent(h) + cotangent(o) };
            push(mesh.origin(next(h)), outward[h as usize] - there - PI, weight);
            last = prev(h);
        }
        if mesh.opposite[last as usize] == NONE {
            push(mesh.origin(last), inward[last as usize] - outward[last as usize] - PI, cotangent(last));
        }
    })
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
