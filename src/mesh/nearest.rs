//! Nearest surface points and ray hits, through a bounding volume hierarchy.
//!
//! The hierarchy is built by `obvhs` (parallel locally-ordered clustering) on the mesh scaled to unit size, so that no size of
//! mesh over- or underflows its 32-bit areas; boxes are then taken from the mesh itself, and faces are tested in double
//! precision. Of equally near faces the first one counts.

use super::{Mesh, SurfacePoint};
use glam::{DVec3, Vec3, Vec3A};
use obvhs::aabb::Aabb;
use obvhs::bvh2::builder::build_bvh2;
use obvhs::{Boundable, BvhBuildParams};
use std::borrow::Cow;
use std::time::Duration;

/// A point of the surface found by a query.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hit {
    /// Where on the surface.
    pub at: SurfacePoint,
    /// For the nearest point, its distance in world units; for a ray, the multiple of the ray's direction.
    pub distance: f64,
}

/// A mesh with its hierarchy, to be asked.
#[derive(Debug, Clone)]
pub struct Nearest<'m> {
    mesh: &'m Mesh,
    tree: Cow<'m, Tree>,
}

/// The hierarchy over the faces of one mesh, to be kept beside it.
#[derive(Debug, Clone)]
pub struct Tree {
    nodes: Vec<Node>,
    /// Faces in the order of the leaves.
    faces: Vec<u32>,
}

#[derive(Debug, Clone, Copy)]
struct Node {
    low: Vec3,
    high: Vec3,
    /// First face of a leaf; the first of two neighbouring children of an inner node.
    first: u32,
    /// Faces of a leaf; 0 for an inner node.
    count: u32,
}

struct FaceBox(Aabb);

impl Boundable for FaceBox {
    fn aabb(&self) -> Aabb {
        self.0
    }
}

impl Tree {
    /// Builds the hierarchy; n log n.
    #[must_use]
    pub fn new(mesh: &Mesh) -> Self {
        let (low, high) = mesh.bounds();
        let middle = (low.as_dvec3() + high.as_dvec3()) / 2.0;
        let size = (high.as_dvec3() - low.as_dvec3()).max_element().max(f64::MIN_POSITIVE);
        let boxes: Vec<FaceBox> = (0..mesh.face_count() as u32)
            .map(|f| {
                let p = mesh.corners(f).map(|p| Vec3A::from(((p - middle) / size).as_vec3()));
                FaceBox(Aabb::from_points(&p))
            })
            .collect();
        let tree = build_bvh2(&boxes, BvhBuildParams::fast_build(), &mut Duration::default());
        let nodes = tree.nodes.iter().map(|n| Node {
            low: Vec3::INFINITY,
            high: Vec3::NEG_INFINITY,
            first: n.first_index,
            count: n.prim_count,
        });
        let mut built = Self { nodes: nodes.collect(), faces: tree.primitive_indices };
        built.fit_boxes(mesh);
        built
    }

    /// Boxes from the mesh's own positions, children before parents.
    fn fit_boxes(&mut self, mesh: &Mesh) {
        let mut order = vec![0_u32];
        let mut at = 0;
        while at < order.len() {
            let node = self.nodes[order[at] as usize];
            if node.count == 0 {
                order.extend([node.first, node.first + 1]);
            }
            at += 1;
        }
        for &n in order.iter().rev() {
            let node = self.nodes[n as usize];
            let (mut low, mut high) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
            if node.count == 0 {
                for child in [node.first, node.first + 1] {
                    low = low.min(self.nodes[child as usize].low);
                    high = high.max(self.nodes[child as usize].high);
                }
            }
            for &f in self.leaf(node) {
                for v in mesh.faces[f as usize] {
                    low = low.min(mesh.positions[v as usize]);
                    high = high.max(mesh.positions[v as usize]);
                }
            }
            self.nodes[n as usize] = Node { low, high, ..node };
        }
    }

    fn leaf(&self, node: Node) -> &[u32] {
        // An inner node's `first` counts nodes, of which there are more than faces.
        if node.count == 0 { &[] } else { &self.faces[node.first as usize..][..node.count as usize] }
    }
}

impl<'m> Nearest<'m> {
    /// Builds the hierarchy; n log n.
    #[must_use]
    pub fn new(mesh: &'m Mesh) -> Self {
        Self { mesh, tree: Cow::Owned(Tree::new(mesh)) }
    }

    /// With the hierarchy that was built over this mesh before.
    #[must_use]
    pub const fn over(mesh: &'m Mesh, tree: &'m Tree) -> Self {
        Self { mesh, tree: Cow::Borrowed(tree) }
    }

    /// The surface point nearest to a point; `None` only if the point is not finite.
    #[must_use]
    pub fn nearest(&self, point: DVec3) -> Option<Hit> {
        if !point.is_finite() {
            return None;
        }
        let to_box = |node: &Node| {
            let inside = point.clamp(node.low.as_dvec3(), node.high.as_dvec3());
            point.distance_squared(inside)
        };
        let to_face = |face: u32| {
            let bary = nearest_in_triangle(point, self.mesh.corners(face));
            let [a, b, c] = self.mesh.corners(face);
            let at = a * bary.x + b * bary.y + c * bary.z;
            Some((point.distance_squared(at), bary))
        };
        let (squared, at) = self.closest(f64::INFINITY, to_box, to_face)?;
        Some(Hit { at, distance: squared.sqrt() })
    }

    /// The first face a ray meets at `origin + t direction` with `t` from 0 to `longest`, from either side.
    #[must_use]
    pub fn ray(&self, origin: DVec3, direction: DVec3, longest: f64) -> Option<Hit> {
        if !origin.is_finite() || !direction.is_finite() || direction == DVec3::ZERO {
            return None;
        }
        let inverse = direction.recip();
        let to_box = |node: &Node| {
            let (mut enter, mut leave) = (0.0_f64, f64::INFINITY);
            for k in 0..3 {
                let (low, high) = (f64::from(node.low[k]) - origin[k], f64::from(node.high[k]) - origin[k]);
                if direction[k] == 0.0 {
                    if low > 0.0 || high < 0.0 {
                        return f64::INFINITY;
                    }
                    continue;
                }
                let (a, b) = (low * inverse[k], high * inverse[k]);
                // Boxes can be flat: a little wider than rounding, so that the ray does not slip past the face in them.
                enter = enter.max(a.min(b) * (1.0 - 1e-12));
                leave = leave.min(a.max(b) * (1.0 + 1e-12));
            }
            if enter <= leave { enter } else { f64::INFINITY }
        };
        let to_face = |face: u32| ray_meets_triangle(origin, direction, self.mesh.corners(face));
        let (distance, at) = self.closest(longest, to_box, to_face)?;
        Some(Hit { at, distance })
    }

    /// Depth-first search for the face of smallest measure, at most `bound`; `to_box` never exceeds `to_face` inside it.
    fn closest(
        &self,
        bound: f64,
        to_box: impl Fn(&Node) -> f64,
        to_face: impl Fn(u32) -> Option<(f64, DVec3)>,
    ) -> Option<(f64, SurfacePoint)> {
        let mut best: Option<(f64, u32, DVec3)> = None;
        let mut stack = Vec::with_capacity(64);
        let nodes = &self.tree.nodes;
        stack.push((to_box(&nodes[0]), 0_u32));
        while let Some((least, n)) = stack.pop() {
            // Equal measures are looked at too: the first face must win whatever the tree looks like.
            if least > best.map_or(bound, |b| b.0) || least == f64::INFINITY {
                continue;
            }
            let node = nodes[n as usize];
            if node.count == 0 {
                let mut pair = [node.first, node.first + 1].map(|c| (to_box(&nodes[c as usize]), c));
                if pair[0].0 < pair[1].0 {
                    pair.swap(0, 1);
                }
                stack.extend(pair);
                continue;
            }
            for &face in self.tree.leaf(node) {
                if let Some((measure, bary)) = to_face(face) {
                    let better = best.is_none_or(|b| (measure, face) < (b.0, b.1));
                    if measure <= bound && better {
                        best = Some((measure, face, bary));
                    }
                }
            }
        }
        best.map(|(measure, face, bary)| (measure, SurfacePoint { face, bary: bary.as_vec3() }))
    }
}

/// Barycentric coordinates of the point of a triangle nearest to `p`: Voronoi regions of corners and edges first, then the
/// inside (Ericson, "Real-Time Collision Detection", 2005, sec. 5.1.5).
fn nearest_in_triangle(p: DVec3, [a, b, c]: [DVec3; 3]) -> DVec3 {
    let (ab, ac) = (b - a, c - a);
    let (d1, d2) = (ab.dot(p - a), ac.dot(p - a));
    if d1 <= 0.0 && d2 <= 0.0 {
        return DVec3::X;
    }
    let (d3, d4) = (ab.dot(p - b), ac.dot(p - b));
    if d3 >= 0.0 && d4 <= d3 {
        return DVec3::Y;
    }
    let (d5, d6) = (ab.dot(p - c), ac.dot(p - c));
    if d6 >= 0.0 && d5 <= d6 {
        return DVec3::Z;
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        let t = d1 / (d1 - d3);
        return DVec3::new(1.0 - t, t, 0.0);
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        let t = d2 / (d2 - d6);
        return DVec3::new(1.0 - t, 0.0, t);
    }
    let va = d3 * d6 - d5 * d4;
    if va <= 0.0 && d4 >= d3 && d5 >= d6 {
        let t = (d4 - d3) / ((d4 - d3) + (d5 - d6));
        return DVec3::new(0.0, 1.0 - t, t);
    }
    DVec3::new(va, vb, vc) / (va + vb + vc)
}

/// Where a ray meets a triangle. The three volumes it spans with the edges are computed so that two faces see the same
/// number, but for the sign, at their common edge: no ray slips between them.
fn ray_meets_triangle(origin: DVec3, direction: DVec3, corners: [DVec3; 3]) -> Option<(f64, DVec3)> {
    let [a, b, c] = corners.map(|p| p - origin);
    let volumes = DVec3::new(direction.dot(b.cross(c)), direction.dot(c.cross(a)), direction.dot(a.cross(b)));
    if volumes.min_element() < 0.0 && volumes.max_element() > 0.0 {
        return None;
    }
    let total = volumes.element_sum();
    if total == 0.0 {
        return None;
    }
    let bary = volumes / total;
    let t = (a * bary.x + b * bary.y + c * bary.z).dot(direction) / direction.length_squared();
    (t >= 0.0).then_some((t, bary))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;
    use crate::random::Random;

    fn anywhere(random: &mut Random, size: f64) -> DVec3 {
        DVec3::new(random.range(-size, size), random.range(-size, size), random.range(-size, size))
    }

    #[test]
    fn the_nearest_point_is_the_one_found_by_trying_all_faces() {
        for size in [1.0, 1e-6, 1e6] {
            let mut mesh = shapes::torus(30, 20, 1.0, 0.4);
            mesh.positions.iter_mut().for_each(|p| *p *= size as f32);
            let tree = Nearest::new(&mesh);
            let mut random = Random::new(2, 0);
            for _ in 0..300 {
                let p = anywhere(&mut random, 2.0 * size);
                let hit = tree.nearest(p).expect("a finite point has a nearest one");
                let twin = (0..mesh.face_count() as u32)
                    .map(|f| {
                        let w = nearest_in_triangle(p, mesh.corners(f));
                        let [a, b, c] = mesh.corners(f);
                        p.distance(a * w.x + b * w.y + c * w.z)
                    })
                    .fold(f64::INFINITY, f64::min);
                assert!((hit.distance - twin).abs() <= 1e-12 * twin, "{} for {twin}", hit.distance);
                let there = mesh.position(hit.at).distance(p);
                assert!((there - twin).abs() <= 1e-5 * size, "the point told is at {there}, not {twin}");
            }
        }
    }

    #[test]
    fn no_point_of_a_triangle_is_nearer_than_the_nearest() {
        let mut random = Random::new(4, 0);
        for _ in 0..200 {
            let corners = [0; 3].map(|_| anywhere(&mut random, 1.0));
            let p = anywhere(&mut random, 2.0);
            let at = |w: DVec3| corners[0] * w.x + corners[1] * w.y + corners[2] * w.z;
            let best = p.distance(at(nearest_in_triangle(p, corners)));
            for i in 0..=20 {
                for j in 0..=20 - i {
                    let w = DVec3::new(f64::from(i), f64::from(j), f64::from(20 - i - j)) / 20.0;
                    assert!(best <= p.distance(at(w)) + 1e-12, "{w} is nearer than {best}");
                }
            }
        }
    }

    #[test]
    fn a_ray_hits_the_face_found_by_trying_all_faces() {
        let mesh = shapes::torus(30, 20, 1.0, 0.4);
        let tree = Nearest::new(&mesh);
        let mut random = Random::new(6, 0);
        let mut hits = 0;
        for _ in 0..500 {
            let (origin, direction) = (anywhere(&mut random, 2.0), anywhere(&mut random, 1.0));
            let twin = (0..mesh.face_count() as u32)
                .filter_map(|f| ray_meets_triangle(origin, direction, mesh.corners(f)).map(|(t, _)| (t, f)))
                .min_by(|a, b| a.partial_cmp(b).expect("finite"));
            let hit = tree.ray(origin, direction, f64::INFINITY);
            assert_eq!(hit.map(|h| (h.distance, h.at.face)), twin, "ray from {origin} along {direction}");
            if let Some(hit) = hit {
                hits += 1;
                let there = mesh.position(hit.at);
                assert!(there.distance(origin + direction * hit.distance) < 1e-5, "the hit lies on the ray");
                assert_eq!(tree.ray(origin, direction, hit.distance * 0.999), None, "nothing lies before it");
            }
        }
        assert!(hits > 50, "{hits} of 500 rays hit");
    }

    #[test]
    fn no_ray_slips_between_faces() {
        let mesh = shapes::sphere(3);
        let tree = Nearest::new(&mesh);
        for v in 0..mesh.vertex_count() as u32 {
            let direction = mesh.point(v);
            assert!(tree.ray(DVec3::ZERO, direction, f64::INFINITY).is_some(), "through vertex {v}");
            let edge = mesh.point(mesh.faces[v as usize % mesh.face_count()][0]) + direction;
            assert!(edge == DVec3::ZERO || tree.ray(DVec3::ZERO, edge, f64::INFINITY).is_some(), "between vertices, {edge}");
        }
    }

    #[test]
    fn what_is_not_finite_finds_nothing() {
        let mesh = shapes::sphere(1);
        let tree = Nearest::new(&mesh);
        assert_eq!(tree.nearest(DVec3::NAN), None, "NaN");
        assert_eq!(tree.ray(DVec3::ZERO, DVec3::ZERO, 1.0), None, "no direction");
        let single = Mesh::new(vec![Vec3::ZERO, Vec3::X, Vec3::Y], vec![[0, 1, 2]]).expect("one face");
        assert!(Nearest::new(&single).nearest(DVec3::ONE).is_some(), "a single face is a tree too");
    }
}
