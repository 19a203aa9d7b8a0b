//! What coverage asks of a paste: its patch's mask, and its own cut if it has one.

use super::coverage::Reach;
use super::cut::Cut;
use crate::exemplar::CoverageMask;
use glam::{DVec2, Vec2};

/// A mask as one paste shows it. Positions are pixels of the mask.
#[derive(Debug, Clone, Copy)]
pub struct Stencil<'a> {
    mask: &'a CoverageMask,
    cut: Option<&'a Cut>,
    /// Mask sizes a pixel.
    step: Vec2,
}

impl<'a> Stencil<'a> {
    /// A mask, and a cut inside it.
    #[must_use]
    pub fn new(mask: &'a CoverageMask, cut: Option<&'a Cut>) -> Self {
        Self { mask, cut, step: Vec2::ONE / Vec2::from(mask.size().map(|s| s as f32)) }
    }

    /// How far the cut's alpha goes up and down within a radius.
    #[inline]
    fn bounds(&self, cut: &Cut, at: Vec2, radius: f32) -> [f32; 2] {
        let (uv, reach, blur) = (at * self.step, radius * self.step.max_element(), pixel_blur(self.step));
        let out = (uv * 2.0 - 1.0).abs().max_element();
        if out + 2.0 * reach <= cut.inner(blur) { [1.0; 2] } else { cut.bounds(uv, reach, blur) }
    }

    /// How much of a disc is hidden, as far as one look tells.
    #[inline]
    #[must_use]
    pub fn reach(&self, at: Vec2, radius: f32) -> Reach {
        let depth = self.mask.depth(at);
        if depth <= -radius {
            return Reach::None;
        }
        let Some(cut) = self.cut else { return if depth >= radius { Reach::All } else { Reach::Some } };
        let [least, most] = self.bounds(cut, at, radius);
        match () {
            () if most <= 0.0 => Reach::None,
            () if depth >= radius && least >= 1.0 => Reach::All,
            () => Reach::Some,
        }
    }

    /// How much of a face is hidden whose corners lie there, as far as one look tells.
    #[must_use]
    pub fn reach_of_face(&self, pixel: &[DVec2; 3]) -> Reach {
        let middle = (pixel[0] + pixel[1] + pixel[2]) / 3.0;
        let radius = pixel.iter().map(|p| p.distance(middle)).fold(0.0, f64::max);
        self.reach(middle.as_vec2(), radius as f32)
    }

    /// A lower bound of alpha * 255 within a radius.
    #[inline]
    #[must_use]
    pub fn eroded_alpha(&self, at: Vec2, radius: f32) -> u8 {
        let alpha = self.mask.eroded_alpha(at, radius);
        match self.cut {
            Some(cut) if alpha > 0 => (f32::from(alpha) * self.bounds(cut, at, radius)[0]) as u8,
            _ => alpha,
        }
    }

    /// False only if alpha is 0 within a radius.
    #[inline]
    #[must_use]
    pub fn touches(&self, at: Vec2, radius: f32) -> bool {
        self.mask.touches(at, radius) && self.cut.is_none_or(|cut| self.bounds(cut, at, radius)[1] > 0.0)
    }
}

/// The width of one pixel as a cut's blur, from mask sizes a pixel: distances go from 0 to 1 over half a mask.
#[inline]
pub(super) fn pixel_blur(step: Vec2) -> f32 {
    2.0 * step.max_element()
}
