//! The tangential basis of a face and its dual: from world steps to texture steps and back (LT 3.2).

use crate::field::TangentField;
use crate::mesh::Mesh;
use glam::{DMat2, DVec2, DVec3};

/// The tangential basis (S, T) of one face. Texture space is in exemplar widths, s right and t up.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Frame {
    /// S: the world step that maps to one exemplar width to the right.
    pub right: DVec3,
    /// T: the world step that maps to one exemplar width up.
    pub up: DVec3,
    /// Rows of the map from world steps in the face's plane to texture steps.
    to_s: DVec3,
    to_t: DVec3,
}

impl Frame {
    /// From a basis in the plane with unit normal `normal`; `None` if it does not span the plane the right way round.
    #[must_use]
    pub fn new(right: DVec3, up: DVec3, normal: DVec3) -> Option<Self> {
        let det = right.cross(up).dot(normal);
        let usable = det > 0.0 && det.is_finite();
        usable.then(|| Self { right, up, to_s: up.cross(normal) / det, to_t: normal.cross(right) / det })
    }

    /// From T alone, with S = T x N.
    #[must_use]
    pub fn from_up(up: DVec3, normal: DVec3) -> Option<Self> {
        Self::new(up.cross(normal), up, normal)
    }

    /// The frame of a face in a tangent field.
    #[must_use]
    pub fn of(mesh: &Mesh, field: &TangentField, face: u32) -> Option<Self> {
        let (right, up) = field.basis(mesh, face);
        Self::new(right, up, mesh.normal(face))
    }

    /// The texture step of a world step in the face's plane.
    #[inline]
    #[must_use]
    pub fn texture_step(&self, step: DVec3) -> DVec2 {
        DVec2::new(self.to_s.dot(step), self.to_t.dot(step))
    }

    /// The images of S and T (columns) under the linear map that sends the face's corners `p` to `uv`, or `None` for a
    /// face without area. The identity if texture and field agree.
    #[inline]
    #[must_use]
    pub fn image(&self, p: &[DVec3; 3], uv: &[DVec2; 3]) -> Option<DMat2> {
        let wanted = DMat2::from_cols(self.texture_step(p[1] - p[0]), self.texture_step(p[2] - p[0]));
        let found = DMat2::from_cols(uv[1] - uv[0], uv[2] - uv[0]);
        let det = wanted.determinant();
        (det != 0.0 && det.is_finite()).then(|| found * wanted.inverse())
    }
}

/// Largest and smallest singular value of a 2x2 matrix; the smallest is negative if the matrix mirrors.
#[must_use]
pub fn singular_values(m: DMat2) -> (f64, f64) {
    let (a, b, c, d) = (m.x_axis.x, m.y_axis.x, m.x_axis.y, m.y_axis.y);
    let (e, f) = (0.5 * (a + d), 0.5 * (a - d));
    let (g, h) = (0.5 * (c + b), 0.5 * (c - b));
    let (q, r) = (e.hypot(h), f.hypot(g));
    (q + r, q - r)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_frame_maps_its_own_axes_to_the_unit_steps_even_sheared() {
        let normal = DVec3::new(1.0, 2.0, 2.0) / 3.0;
        let up = normal.any_orthonormal_vector() * 0.7;
        let right = up.cross(normal) * 1.5 + up * 0.3;
        let frame = Frame::new(right, up, normal).unwrap();
        assert!((frame.texture_step(right) - DVec2::X).length() < 1e-12, "S to (1, 0)");
        assert!((frame.texture_step(up) - DVec2::Y).length() < 1e-12, "T to (0, 1)");
        assert!(Frame::new(-right, up, normal).is_none(), "a mirrored basis is refused");
    }

    #[test]
    fn singular_values_of_a_rotated_stretch() {
        let m = DMat2::from_angle(0.4) * DMat2::from_diagonal(DVec2::new(3.0, 0.5)) * DMat2::from_angle(-1.1);
        let (large, small) = singular_values(m);
        assert!((large - 3.0).abs() < 1e-12 && (small - 0.5).abs() < 1e-12, "{large} {small}");
        let mirrored = singular_values(DMat2::from_diagonal(DVec2::new(-2.0, 1.0)));
        assert!((mirrored.0 - 2.0).abs() < 1e-12 && (mirrored.1 + 1.0).abs() < 1e-12, "{mirrored:?}");
    }
}
