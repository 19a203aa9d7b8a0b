//! The hinge of the house: whatever can say what the surface looks like at a point is a [`SurfaceTexture`].

use crate::exemplar::{Channel, ChannelSet};
use crate::mesh::SurfacePoint;
use glam::Vec3;

/// What the surface looks like at one point. Only the channels the texture has are meaningful; the others hold neutral
/// values.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Texel {
    /// Base colour, linear light, not multiplied by `alpha`.
    pub base_color: Vec3,
    /// How much of the point is covered by texture, 0 to 1.
    pub alpha: f32,
    /// Unit normal in the mesh's space, as if the face were flat: a renderer that shades smoothly turns it by the
    /// rotation from the face's normal to the smooth one.
    pub normal: Vec3,
    /// Height, 0 to 1, bright is outward.
    pub height: f32,
    /// Roughness, 0 to 1.
    pub roughness: f32,
    /// Metallic, 0 to 1.
    pub metallic: f32,
    /// Ambient occlusion, 0 (dark) to 1.
    pub occlusion: f32,
    /// Emitted light, linear.
    pub emissive: Vec3,
    /// Opacity of the material itself, 0 to 1.
    pub opacity: f32,
}

impl Texel {
    /// Nothing at all on a face with unit normal `normal`.
    #[must_use]
    pub const fn empty(normal: Vec3) -> Self {
        Self {
            base_color: Vec3::ZERO,
            alpha: 0.0,
            normal,
            height: 0.5,
            roughness: 0.8,
            metallic: 0.0,
            occlusion: 1.0,
            emissive: Vec3::ZERO,
            opacity: 1.0,
        }
    }

    /// Sets what belongs to a channel: of those of one component the first, of a normal one in the mesh's space.
    pub const fn set(&mut self, channel: Channel, value: Vec3) {
        match channel {
            Channel::BaseColor => self.base_color = value,
            Channel::Normal => self.normal = value,
            Channel::Height => self.height = value.x,
            Channel::Roughness => self.roughness = value.x,
            Channel::Metallic => self.metallic = value.x,
            Channel::Occlusion => self.occlusion = value.x,
            Channel::Emissive => self.emissive = value,
            Channel::Opacity => self.opacity = value.x,
        }
    }
}

/// How a point is seen: unit vectors, world space.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sight {
    /// To the eye.
    pub to_eye: Vec3,
    /// To the main lamp.
    pub to_light: Vec3,
}

/// A texture defined on the surface itself.
pub trait SurfaceTexture: Sync {
    /// The channels it has.
    fn channels(&self) -> ChannelSet;
    /// The texture at a surface point, averaged over about `footprint` (world units, the width of a pixel there; 0 asks
    /// for the finest level).
    fn texel(&self, at: SurfacePoint, footprint: f32) -> Texel;
    /// The texture at many points at once, each with its footprint; `shown` is as long as `points`. Textures that another
    /// machine knows, such as a graphics adapter, answer faster this way.
    ///
    /// # Errors
    /// If that machine fails: a sentence.
    fn texels(&self, points: &[(SurfacePoint, f32)], shown: &mut [Texel]) -> Result<(), String> {
        for (&(at, footprint), shown) in points.iter().zip(shown) {
            *shown = self.texel(at, footprint);
        }
        Ok(())
    }
    /// The same as seen from a side and in a light. Only textures whose relief shifts what is seen, or that change with either, look
    /// different from there; without either they are as if seen and lit straight from above.
    fn texel_seen(&self, at: SurfacePoint, footprint: f32, _sight: &Sight) -> Texel {
        self.texel(at, footprint)
    }
}
