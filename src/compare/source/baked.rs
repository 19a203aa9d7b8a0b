//! The source map of a bake: that of the texture that was baked.

use super::{Origin, PastedSource, Sourced};
use crate::atlas::{Atlas, AtlasTexture, Frames, Page};
use crate::exemplar::ChannelSet;
use crate::mesh::{Mesh, SurfacePoint};
use crate::surface::{SurfaceTexture, Texel};

/// A bake and the lapped texture it was made of.
#[derive(Debug)]
pub struct BakedSource<'a> {
    texture: AtlasTexture<'a>,
    from: PastedSource<'a>,
}

impl<'a> BakedSource<'a> {
    /// Binds the pages of a bake to their mesh.
    #[must_use]
    pub fn new(mesh: &'a Mesh, atlas: &Atlas, pages: &[Page], from: PastedSource<'a>) -> Self {
        let faces = 0..mesh.face_count() as u32;
        let uv = faces.clone().map(|f| atlas.face_uv(f)).collect();
        let page = faces.map(|f| atlas.page_of(f)).collect();
        let images = pages.iter().map(|p| p.images.clone()).collect();
        Self { texture: AtlasTexture::new(mesh, uv, page, images, Frames::smooth(Vec::new())), from }
    }
}

impl SurfaceTexture for BakedSource<'_> {
    fn channels(&self) -> ChannelSet {
        self.texture.channels()
    }

    fn texel(&self, at: SurfacePoint, footprint: f32) -> Texel {
        self.texture.texel(at, footprint)
    }
}

impl Sourced for BakedSource<'_> {
    fn origin(&self, at: SurfacePoint) -> Option<Origin> {
        self.from.origin(at)
    }

    fn ways(&self) -> u32 {
        self.from.ways()
    }
}
