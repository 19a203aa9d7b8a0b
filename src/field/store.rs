//! Saving a tangent field face by face, and reading it back.
//!
//! The file is JSON: `{ "version": 1, "up": [[x, y, z], ...], "right": [[x, y, z], ...], "ways": n }` with one vector a face, `right`
//! only for a full tangential basis, and `ways` only if the texture looks the same turned by a full turn over n.

use super::nway::MOST_WAYS;
use super::{FieldError, TangentField};
use crate::mesh::Mesh;
use crate::mesh::transport::projected;
use glam::Vec3;
use serde::{Deserialize, Serialize};

/// The version of the field file.
pub const FIELD_VERSION: u32 = 1;

const WHAT: &str = "field file";

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Stored {
    version: u32,
    up: Vec<Vec3>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    right: Option<Vec<Vec3>>,
    #[serde(default = "one", skip_serializing_if = "is_one")]
    ways: u32,
}

const fn one() -> u32 {
    1
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde calls it so")]
const fn is_one(ways: &u32) -> bool {
    *ways == 1
}

/// A vector shorter than this share of its length once laid into the face's plane says nothing there.
const SQUARE: f32 = 1e-3;

impl TangentField {
    /// A field of given vectors, one a face, laid into the faces' planes at their full length.
    ///
    /// # Errors
    /// If there are not as many vectors as faces, or one is not finite, zero, square to its face, or the pair at a face would
    /// mirror the texture.
    pub fn new(mesh: &Mesh, up: Vec<Vec3>, right: Option<Vec<Vec3>>) -> Result<Self, FieldError> {
        let up = laid(mesh, "up", up)?;
        let right = right.map(|right| laid(mesh, "right", right)).transpose()?;
        for (face, (s, t)) in right.iter().flatten().zip(&up).enumerate() {
            let area = s.as_dvec3().cross(t.as_dvec3()).dot(mesh.normal(face as u32));
            if area <= f64::from(SQUARE) * f64::from(s.length()) * f64::from(t.length()) {
                let reason =
                    "it does not lie to the right of `up` seen from outside, so the texture would be mirrored or flat: turn it";
                return Err(FieldError::Vector { which: "right", face, vector: s.as_dvec3(), reason });
            }
        }
        Ok(Self { up, right, ways: 1 })
    }

    /// Reads a field file's text for a mesh.
    ///
    /// # Errors
    /// If it is no field file, of another version, made for another mesh, or holds an unusable vector.
    pub fn from_json(mesh: &Mesh, text: &str) -> Result<Self, FieldError> {
        let syntax = |e: serde_json::Error| FieldError::Syntax { what: WHAT, reason: e.to_string() };
        let stored: Stored = serde_json::from_str(text).map_err(syntax)?;
        if stored.version != FIELD_VERSION {
            return Err(FieldError::Version { what: WHAT, found: stored.version, expected: FIELD_VERSION });
        }
        if !(1..=MOST_WAYS).contains(&stored.ways) {
            return Err(FieldError::Ways(stored.ways));
        }
        Ok(Self { ways: stored.ways, ..Self::new(mesh, stored.up, stored.right)? })
    }

    /// The text of a field file.
    ///
    /// # Errors
    /// Never for finite vectors; JSON has no others.
    pub fn to_json(&self) -> Result<String, FieldError> {
        let stored = Stored { version: FIELD_VERSION, up: self.up.clone(), right: self.right.clone(), ways: self.ways };
        serde_json::to_string(&stored).map_err(|e| FieldError::Syntax { what: WHAT, reason: e.to_string() })
    }
}

fn laid(mesh: &Mesh, which: &'static str, vectors: Vec<Vec3>) -> Result<Vec<Vec3>, FieldError> {
    if vectors.len() != mesh.face_count() {
        return Err(FieldError::Length { which, found: vectors.len(), faces: mesh.face_count() });
    }
    let lay = |(face, vector): (usize, Vec3)| {
        let length = vector.length();
        let error = |reason| FieldError::Vector { which, face, vector: vector.as_dvec3(), reason };
        if !length.is_normal() {
            return Err(error("give three finite numbers that are not all zero"));
        }
        let flat = projected(vector.as_dvec3(), mesh.normal(face as u32)).as_vec3();
        if flat.length() < SQUARE * length {
            return Err(error("it stands square to its face: give one that lies along it"));
        }
        Ok(flat * (length / flat.length()))
    };
    vectors.into_iter().enumerate().map(lay).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::up;
    use crate::mesh::shapes;
    use glam::DVec3;

    #[test]
    fn a_field_survives_its_file() {
        let mesh = shapes::torus(12, 8, 1.0, 0.3);
        let (mut field, _) = up(&mesh, DVec3::Z, 0.3).expect("a field");
        field.right = Some((0..mesh.face_count() as u32).map(|f| (2.0 * field.basis(&mesh, f).0).as_vec3()).collect());
        field.ways = 4;
        let again = TangentField::from_json(&mesh, &field.to_json().expect("finite")).expect("its own text");
        for (a, b) in field.up.iter().zip(&again.up).chain(field.right.iter().flatten().zip(again.right.iter().flatten())) {
            assert!((a - b).length() < 1e-6, "{a} became {b}");
        }
        assert_eq!(again.ways, 4, "the ways are kept");
        assert_eq!(again.right.map(|r| r.len()), Some(mesh.face_count()), "the basis is kept");
    }

    #[test]
    fn unusable_vectors_are_told_by_face() {
        let mesh = shapes::torus(12, 8, 1.0, 0.3);
        let (field, _) = up(&mesh, DVec3::Z, 0.3).expect("a field");
        let with = |face: usize, vector: Vec3| {
            let mut up = field.up.clone();
            up[face] = vector;
            TangentField::new(&mesh, up, None)
        };
        for vector in [Vec3::ZERO, Vec3::NAN, mesh.normal(7).as_vec3()] {
            assert!(matches!(with(7, vector), Err(FieldError::Vector { which: "up", face: 7, .. })), "vector {vector}");
        }
        let left = (0..mesh.face_count() as u32).map(|f| -field.basis(&mesh, f).0.as_vec3()).collect();
        let mirrored = TangentField::new(&mesh, field.up.clone(), Some(left));
        assert!(matches!(mirrored, Err(FieldError::Vector { which: "right", face: 0, .. })), "{mirrored:?}");
        let short = TangentField::new(&mesh, field.up[1..].to_vec(), None);
        assert_eq!(short, Err(FieldError::Length { which: "up", found: 191, faces: 192 }), "a vector is missing");
        assert!(matches!(TangentField::from_json(&mesh, "{}"), Err(FieldError::Syntax { .. })), "no field file");
        let other = TangentField::from_json(&mesh, r#"{"version": 9, "up": []}"#);
        assert!(matches!(other, Err(FieldError::Version { found: 9, .. })), "another version: {other:?}");
    }
}
