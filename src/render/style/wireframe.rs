//! The mesh's edges as thin lines on a light surface.

use super::{Show, colour_only, coloured};
use crate::exemplar::ChannelSet;
use crate::mesh::{Mesh, SurfacePoint};
use crate::surface::{SurfaceTexture, Texel};
use glam::Vec3;

/// Half the width of a line, pixels.
const HALF_WIDTH: f32 = 0.6;
/// Triangles whose height is below this many pixels show ever fainter lines, or a fine mesh would be all lines.
const DENSE: f32 = 7.0;
/// Colours, linear light.
const SURFACE: Vec3 = Vec3::new(0.68, 0.70, 0.72);
const LINE: Vec3 = Vec3::new(0.03, 0.05, 0.09);

pub(super) struct Wireframe<'a> {
    mesh: &'a Mesh,
    samples: f32,
}

impl<'a> Wireframe<'a> {
    pub(super) const fn new(mesh: &'a Mesh, samples: u32) -> Self {
        Self { mesh, samples: samples as f32 }
    }
}

impl SurfaceTexture for Wireframe<'_> {
    fn channels(&self) -> ChannelSet {
        colour_only()
    }

    fn texel(&self, at: SurfacePoint, footprint: f32) -> Texel {
        let [a, b, c] = self.mesh.corners(at.face);
        let double_area = (b - a).cross(c - a).length();
        let pixel = f64::from(footprint * self.samples);
        // Heights over the sides, in pixels.
        let heights = [(c - b).length(), (a - c).length(), (b - a).length()].map(|side| (double_area / (side * pixel)) as f32);
        let distance = (0..3).map(|k| at.bary[k] * heights[k]).fold(f32::INFINITY, f32::min);
        // Ramps over one sample: the samples of a pixel do the rest.
        let ramp = 0.5 / self.samples;
        let ink = ((HALF_WIDTH + ramp - distance) / (2.0 * ramp)).clamp(0.0, 1.0);
        let room = heights.into_iter().fold(f32::INFINITY, f32::min) / DENSE;
        coloured(SURFACE.lerp(LINE, ink * room.clamp(0.15, 1.0)))
    }
}

impl Show for Wireframe<'_> {
    fn texture(&self) -> &dyn SurfaceTexture {
        self
    }
}
