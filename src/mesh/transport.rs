//! Parallel transport of tangent vectors from face to face and from plane to plane.

use super::{Mesh, NONE};
use glam::DVec3;

/// A vector in the plane of the face of half-edge `h`, carried over that edge into the plane of the face beyond: the two
/// faces are thought hinged flat at the edge. `None` on a boundary.
#[must_use]
pub fn across(mesh: &Mesh, h: u32, vector: DVec3) -> Option<DVec3> {
    let o = mesh.opposite[h as usize];
    if o == NONE {
        return None;
    }
    let p = mesh.corners(h / 3);
    let k = (h % 3) as usize;
    let edge = (p[(k + 1) % 3] - p[k]).normalize_or_zero();
    let along = vector.dot(edge);
    let off = vector.dot(mesh.normal(h / 3).cross(edge));
    Some(edge * along + mesh.normal(o / 3).cross(edge) * off)
}

/// A vector turned by the shortest rotation that takes unit vector `from` to unit vector `to`: transport between the
/// tangent planes of two points near each other. For opposite normals, where no rotation is the shortest, the vector is
/// projected.
#[must_use]
pub fn turned(vector: DVec3, from: DVec3, to: DVec3) -> DVec3 {
    let cosine = from.dot(to);
    if cosine < -0.999_999 {
        return vector - to * vector.dot(to);
    }
    // Rodrigues' formula with axis x sine = from x to, for which (1 - cosine) / sine^2 = 1 / (1 + cosine).
    let axis = from.cross(to);
    vector * cosine + axis.cross(vector) + axis * (axis.dot(vector) / (1.0 + cosine))
}

/// The part of a vector in the plane with unit normal `normal`.
#[must_use]
pub fn projected(vector: DVec3, normal: DVec3) -> DVec3 {
    vector - normal * vector.dot(normal)
}

/// The angle in (-pi, pi] that turns `from` counter-clockwise about `normal` into the direction of `to`.
#[must_use]
pub fn angle(from: DVec3, to: DVec3, normal: DVec3) -> f64 {
    normal.dot(from.cross(to)).atan2(from.dot(to))
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{DQuat, Vec3};

    #[test]
    fn a_vector_keeps_its_angle_to_the_hinge() {
        let p = vec![Vec3::ZERO, Vec3::X, Vec3::new(0.3, 1.0, 0.0), Vec3::new(0.2, -0.4, 0.9)];
        let mesh = Mesh::new(p, vec![[0, 1, 2], [1, 0, 3]]).expect("two faces on an edge");
        let v = DVec3::new(0.6, -0.8, 0.0);
        let there = across(&mesh, 0, v).expect("an inner edge");
        assert!((there.dot(DVec3::X) - 0.6).abs() < 1e-12, "along the edge: {there}");
        assert!(there.dot(mesh.normal(1)).abs() < 1e-7, "in the plane beyond: {there}");
        assert!(there.dot(mesh.centroid(1)) > 0.0, "it still points over the edge: {there}");
        let h = (3..6).find(|&h| mesh.opposite[h as usize] == 0).expect("its opposite");
        assert!((across(&mesh, h, there).expect("inner") - v).length() < 1e-12, "and comes back");
        assert_eq!(across(&mesh, 1, v), None, "nothing lies beyond a boundary");
    }

    #[test]
    fn turned_is_the_shortest_rotation() {
        let (from, to) = (DVec3::new(1.0, 2.0, -0.5).normalize(), DVec3::new(-0.4, 1.0, 0.3).normalize());
        let v = DVec3::new(0.3, -0.2, 0.9);
        let twin = DQuat::from_rotation_arc(from, to) * v;
        assert!((turned(v, from, to) - twin).length() < 1e-12, "{} against {twin}", turned(v, from, to));
    }
}
