//! An exemplar repeated over the plane.

use crate::exemplar::{ChannelSet, Exemplar};
use crate::surface::Texel;
use glam::{Vec2, Vec3};

/// An exemplar repeated over the plane.
#[derive(Debug, Clone, Copy)]
pub struct Tile<'a> {
    exemplar: &'a Exemplar,
    /// Pixels a world unit.
    density: f32,
}

impl<'a> Tile<'a> {
    /// An exemplar whose width is `scale` world units.
    #[must_use]
    pub fn new(exemplar: &'a Exemplar, scale: f64) -> Self {
        Self { exemplar, density: (f64::from(exemplar.size()[0]) / scale.max(f64::MIN_POSITIVE)) as f32 }
    }

    /// The channels it has.
    #[must_use]
    pub fn channels(&self) -> ChannelSet {
        self.exemplar.channels()
    }

    /// Pixels of the exemplar.
    #[must_use]
    pub fn size(&self) -> Vec2 {
        Vec2::from(self.exemplar.size().map(|s| s as f32))
    }

    /// The pixel at a place of the plane, world units right and down.
    #[must_use]
    pub fn pixel(&self, place: Vec2) -> Vec2 {
        place * self.density
    }

    /// The level of detail that a sample so wide, world units, is read at.
    #[must_use]
    pub fn lod(&self, footprint: f32) -> f32 {
        (footprint * self.density).max(1.0).log2()
    }

    /// What it shows at a pixel; the normal is in its own frame: right, up, outward.
    #[must_use]
    pub fn texel(&self, pixel: Vec2, lod: f32) -> Texel {
        let place = pixel.rem_euclid(self.size());
        let mut texel = Texel { alpha: 1.0, ..Texel::empty(Vec3::Z) };
        for channel in self.exemplar.channels().iter() {
            if let Some(image) = self.exemplar.channel(channel) {
                texel.set(channel, image.sample(place, lod));
            }
        }
        texel
    }
}

/// The mean of texels by weights that add up to one; normals in one frame.
pub(super) fn mean(parts: &[(f32, Texel)]) -> Texel {
    let mut sum = Texel { base_color: Vec3::ZERO, alpha: 1.0, normal: Vec3::ZERO, ..Texel::empty(Vec3::Z) };
    let number = |get: fn(&Texel) -> f32| parts.iter().map(|(w, t)| w * get(t)).sum::<f32>();
    let three = |get: fn(&Texel) -> Vec3| parts.iter().map(|(w, t)| *w * get(t)).sum::<Vec3>();
    sum.base_color = three(|t| t.base_color);
    sum.emissive = three(|t| t.emissive);
    sum.normal = three(|t| t.normal).normalize_or_zero();
    sum.height = number(|t| t.height);
    sum.roughness = number(|t| t.roughness);
    sum.metallic = number(|t| t.metallic);
    sum.occlusion = number(|t| t.occlusion);
    sum.opacity = number(|t| t.opacity);
    sum
}

/// Turns a texel's normal from its own frame into the mesh's space; `right` is along the surface, unit.
pub(super) fn onto(mut texel: Texel, right: Vec3, down: Vec3, normal: Vec3) -> Texel {
    let n = texel.normal;
    texel.normal = (right * n.x - down * n.y + normal * n.z).normalize_or(normal);
    texel
}
