//! The source map of a lapped texture: at each point the paste that shows most.

use super::{Origin, Sourced, steps};
use crate::exemplar::{ChannelSet, Wrap};
use crate::mesh::{Mesh, SurfacePoint};
use crate::paste::composite::{exemplar_pixel, paste_alpha};
use crate::paste::{Composite, LappedTexture, TURNS};
use crate::surface::{SurfaceTexture, Texel};
use glam::{DVec2, Vec2};

/// A lapped texture and where it comes from.
#[derive(Debug)]
pub struct PastedSource<'a> {
    mesh: &'a Mesh,
    lapped: &'a LappedTexture,
    composite: Composite<'a>,
    /// Turns of its pastes are multiples of a full turn over this.
    ways: u32,
}

impl<'a> PastedSource<'a> {
    /// Sorts the pastes by face.
    #[must_use]
    pub fn new(mesh: &'a Mesh, lapped: &'a LappedTexture) -> Self {
        let ways = TURNS / lapped.pastes.iter().map(|p| p.turn.parts()).fold(TURNS, common);
        Self { mesh, lapped, composite: Composite::new(mesh, lapped), ways }
    }

    /// The paste that shows most at a point and the face's place in it.
    fn top(&self, at: SurfacePoint) -> Option<(u32, u32)> {
        let (mut clear, mut most, mut found) = (1.0_f32, 0.0_f32, None);
        for &(paste, slot) in self.composite.lists().of(at.face).iter().rev() {
            if clear <= most {
                break;
            }
            let p = &self.lapped.pastes[paste as usize];
            let alpha = paste_alpha(&self.lapped.patches, p, slot, at.bary);
            if clear * alpha > most {
                (most, found) = (clear * alpha, Some((paste, slot)));
            }
            clear *= 1.0 - alpha;
        }
        found
    }
}

impl SurfaceTexture for PastedSource<'_> {
    fn channels(&self) -> ChannelSet {
        self.composite.channels()
    }

    fn texel(&self, at: SurfacePoint, footprint: f32) -> Texel {
        self.composite.texel(at, footprint)
    }
}

impl Sourced for PastedSource<'_> {
    fn origin(&self, at: SurfacePoint) -> Option<Origin> {
        let (index, slot) = self.top(at)?;
        let paste = &self.lapped.pastes[index as usize];
        let patch = &self.lapped.patches[paste.patch as usize];
        let exemplar = &self.lapped.exemplars[patch.exemplar as usize];
        let size = Vec2::from(patch.mask.size().map(|s| s as f32));
        let corners = paste.uv[slot as usize].map(|uv| exemplar_pixel(patch, paste, uv * size).as_dvec2());
        let bary = at.bary.as_dvec3();
        let mut pixel = corners[0] * bary.x + corners[1] * bary.y + corners[2] * bary.z;
        if exemplar.wrap == Wrap::Clamp {
            pixel = pixel.clamp(DVec2::ZERO, DVec2::from(exemplar.size().map(f64::from)));
        }
        let steps = steps(self.mesh.corners(at.face), corners)?;
        Some(Origin { pixel, right: steps[0].normalize_or_zero(), steps: Some(steps) })
    }

    fn ways(&self) -> u32 {
        self.ways
    }
}

/// The greatest common divisor.
const fn common(a: u32, b: u32) -> u32 {
    if b == 0 { a } else { common(b, a % b) }
}
