//! The colours that a model came with, as a texture of its clean mesh: vertex colours, or an image over its texture
//! coordinates.

use super::bake::at_corners;
use crate::exemplar::{Channel, ChannelSet, Image};
use crate::format::Model;
use crate::mesh::clean::UserFace;
use crate::mesh::{Mesh, SurfacePoint};
use crate::surface::{SurfaceTexture, Texel};
use glam::{Vec2, Vec3, Vec4};

/// A model's own colours.
#[derive(Debug)]
pub struct Painted<'a> {
    mesh: &'a Mesh,
    paint: Paint<'a>,
}

#[derive(Debug)]
enum Paint<'a> {
    /// Linear colours at the corners of each face.
    Colors(Vec<[Vec3; 3]>),
    /// Texture coordinates at the corners of each face, and the image (linear light).
    Image(Vec<[Vec2; 3]>, &'a Image),
}

impl<'a> Painted<'a> {
    /// The colours of a model, on the mesh that cleaning made of it, `user_faces` leading there; `image` lies over its texture coordinates. `None` if the model
    /// has no vertex colours, or no texture coordinates for the image.
    #[must_use]
    pub fn new(model: &Model, mesh: &'a Mesh, user_faces: &[UserFace], image: Option<&'a Image>) -> Option<Self> {
        let paint = match image {
            Some(image) => {
                let uvs = model.uvs.as_deref()?;
                Paint::Image(at_corners(model, mesh, user_faces, |_, v| uvs[v as usize]), image)
            }
            None => {
                let colors = model.colors.as_deref()?;
                Paint::Colors(at_corners(model, mesh, user_faces, |_, v| colors[v as usize].truncate()))
            }
        };
        Some(Self { mesh, paint })
    }

    /// Linear colours at the corners of each face, opaque, if they are those of vertices.
    #[must_use]
    pub fn corners(&self) -> Option<Vec<[Vec4; 3]>> {
        match &self.paint {
            Paint::Colors(faces) => Some(faces.iter().map(|corners| corners.map(|c| c.extend(1.0))).collect()),
            Paint::Image(..) => None,
        }
    }
}

impl SurfaceTexture for Painted<'_> {
    fn channels(&self) -> ChannelSet {
        ChannelSet::default().with(Channel::BaseColor)
    }

    fn texel(&self, at: SurfacePoint, _footprint: f32) -> Texel {
        let normal = self.mesh.normal(at.face).as_vec3();
        let base_color = match &self.paint {
            Paint::Colors(faces) => (0..3).map(|k| faces[at.face as usize][k] * at.bary[k]).sum(),
            Paint::Image(faces, image) => {
                let uv: Vec2 = (0..3).map(|k| faces[at.face as usize][k] * at.bary[k]).sum();
                let [w, h] = image.size().map(|n| n as f32);
                image.bilinear((uv - uv.floor()) * Vec2::new(w, h))
            }
        };
        Texel { base_color, alpha: 1.0, ..Texel::empty(normal) }
    }
}
