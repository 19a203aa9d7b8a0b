//! A baked atlas as a surface texture again: what `lapped render --mode atlas` shows.

use super::Frames;
use crate::exemplar::{Channel, ChannelSet, Image, MipChain};
use crate::mesh::{Mesh, SurfacePoint};
use crate::surface::{SurfaceTexture, Texel};
use glam::{Quat, Vec2, Vec3};

/// Images on a mesh through texture coordinates.
#[derive(Debug)]
pub struct AtlasTexture<'a> {
    mesh: &'a Mesh,
    /// Places of each face's corners, 0 to 1.
    uv: Vec<[Vec2; 3]>,
    /// For each face its page.
    page: Vec<u32>,
    pages: Vec<Vec<(Channel, MipChain)>>,
    frames: Frames,
    channels: ChannelSet,
}

impl<'a> AtlasTexture<'a> {
    /// Binds images to a mesh. `uv`, `page` and the frames have one entry a face; pages that do not exist show nothing.
    #[must_use]
    pub fn new(mesh: &'a Mesh, uv: Vec<[Vec2; 3]>, page: Vec<u32>, pages: Vec<Vec<(Channel, Image)>>, frames: Frames) -> Self {
        let pages: Vec<Vec<(Channel, MipChain)>> =
            pages.into_iter().map(|images| images.into_iter().map(|(c, image)| (c, MipChain::new(image))).collect()).collect();
        let usable = |c: Channel| c != Channel::Normal || frames.tangents.len() == mesh.face_count();
        let channels = pages.iter().flatten().map(|(c, _)| *c).filter(|&c| usable(c)).fold(ChannelSet::default(), ChannelSet::with);
        Self { mesh, uv, page, pages, frames, channels }
    }
}

impl SurfaceTexture for AtlasTexture<'_> {
    fn channels(&self) -> ChannelSet {
        self.channels
    }

    fn texel(&self, at: SurfacePoint, footprint: f32) -> Texel {
        let face = at.face as usize;
        let area = self.mesh.area_vector(at.face);
        let flat = area.normalize_or_zero().as_vec3();
        let mut texel = Texel::empty(flat);
        let images = self.page.get(face).and_then(|&p| self.pages.get(p as usize));
        let (Some(images), Some(&[a, b, c])) = (images, self.uv.get(face)) else { return texel };
        let uv = a * at.bary.x + b * at.bary.y + c * at.bary.z;
        texel.alpha = 1.0;
        for (channel, chain) in images {
            let size = Vec2::from(chain.size().map(|s| s as f32));
            let texels = ((b - a) * size).perp_dot((c - a) * size).abs();
            let lod = if area.length() > 0.0 {
                (footprint * (f64::from(texels) / area.length()).sqrt() as f32).max(1.0).log2()
            } else {
                0.0
            };
            let value = chain.sample(uv * size, lod);
            match channel {
                Channel::Normal if self.channels.has(Channel::Normal) => {
                    let smooth = self.frames.normal(at.face, at.bary, flat);
                    let own = self.frames.frame(at.face, at.bary, smooth) * value.normalize_or(Vec3::Z);
                    texel.normal = (Quat::from_rotation_arc(smooth, flat) * own).normalize_or(flat);
                }
                Channel::Normal => {}
                other => texel.set(*other, value),
            }
        }
        texel
    }
}
