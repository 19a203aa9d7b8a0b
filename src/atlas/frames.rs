//! Smooth normals and tangent frames at the corners of each face, as renderers of glTF will interpolate them.
//!
//! Based on: M. Mikkelsen, "Simulation of Wrinkled Surfaces Revisited", 2008 (MikkTSpace), through the crate
//! `bevy_mikktspace`. glTF takes green as up in the image, so the bitangent runs against v.

use super::Atlas;
use crate::mesh::Mesh;
use bevy_mikktspace::{Geometry, TangentSpace, generate_tangents};
use glam::{Mat3, Quat, Vec3, Vec4};

/// Frames at the corners of a mesh's faces.
#[derive(Debug, Clone, PartialEq)]
pub struct Frames {
    /// Unit normals.
    pub normals: Vec<[Vec3; 3]>,
    /// Unit tangents, w the sign of the bitangent `w (N x T)`; empty if no channel needs them.
    pub tangents: Vec<[Vec4; 3]>,
}

struct Corners<'a> {
    mesh: &'a Mesh,
    atlas: &'a Atlas,
    normals: &'a [[Vec3; 3]],
    tangents: Vec<[Vec4; 3]>,
}

impl Geometry for Corners<'_> {
    fn num_faces(&self) -> usize {
        self.mesh.face_count()
    }

    fn num_vertices_of_face(&self, _face: usize) -> usize {
        3
    }

    fn position(&self, face: usize, vert: usize) -> [f32; 3] {
        self.mesh.positions[self.mesh.faces[face][vert] as usize].to_array()
    }

    fn normal(&self, face: usize, vert: usize) -> [f32; 3] {
        self.normals[face][vert].to_array()
    }

    fn tex_coord(&self, face: usize, vert: usize) -> [f32; 2] {
        let uv = self.atlas.face_uv(face as u32)[vert];
        [uv.x, 1.0 - uv.y]
    }

    fn set_tangent(&mut self, tangent_space: Option<TangentSpace>, face: usize, vert: usize) {
        if let Some(space) = tangent_space {
            self.tangents[face][vert] = Vec4::from_array(space.tangent_encoded());
        }
    }
}

impl Frames {
    /// Normals alone.
    #[must_use]
    pub const fn smooth(normals: Vec<[Vec3; 3]>) -> Self {
        Self { normals, tangents: Vec::new() }
    }

    /// Normals and the tangents that belong to them on an atlas.
    #[must_use]
    pub fn with_tangents(mesh: &Mesh, atlas: &Atlas, normals: Vec<[Vec3; 3]>) -> Self {
        // Where nothing is known (a face without area in the atlas), any direction across the normal.
        let any = |n: &[Vec3; 3]| n.map(|n| n.any_orthonormal_vector().extend(1.0));
        let tangents = normals.iter().map(any).collect();
        let mut corners = Corners { mesh, atlas, normals: &normals, tangents };
        // The error type of the crate has no values.
        let _ = generate_tangents(&mut corners);
        let mut tangents = corners.tangents;
        for (t, n) in tangents.as_flattened_mut().iter_mut().zip(normals.as_flattened()) {
            // Unit length to the last bit matters to validators.
            let unit = t.truncate().try_normalize().unwrap_or_else(|| n.any_orthonormal_vector());
            *t = unit.extend(if t.w < 0.0 { -1.0 } else { 1.0 });
        }
        Self { normals, tangents }
    }

    /// The smooth normal at a point of a face; `flat` where it vanishes.
    #[inline]
    #[must_use]
    pub fn normal(&self, face: u32, bary: Vec3, flat: Vec3) -> Vec3 {
        let n = self.normals[face as usize];
        (n[0] * bary.x + n[1] * bary.y + n[2] * bary.z).normalize_or(flat)
    }

    /// Turns a normal that was given as if the face were flat to the smooth surface.
    #[inline]
    #[must_use]
    pub fn turn(flat: Vec3, smooth: Vec3, normal: Vec3) -> Vec3 {
        if flat == Vec3::ZERO { normal } else { Quat::from_rotation_arc(flat, smooth) * normal }
    }

    /// Tangent, bitangent and normal at a point of a face, as columns.
    #[inline]
    #[must_use]
    pub fn frame(&self, face: u32, bary: Vec3, smooth: Vec3) -> Mat3 {
        let t = self.tangents[face as usize];
        let mean = t[0] * bary.x + t[1] * bary.y + t[2] * bary.z;
        let tangent = mean.truncate().reject_from_normalized(smooth).normalize_or(smooth.any_orthonormal_vector());
        let bitangent = smooth.cross(tangent) * if mean.w < 0.0 { -1.0 } else { 1.0 };
        Mat3::from_cols(tangent, bitangent, smooth)
    }
}
