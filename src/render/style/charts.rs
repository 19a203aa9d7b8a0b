//! The charts of an atlas: each in a colour of its own, its border drawn.

use super::palette::distinct;
use crate::exemplar::{Channel, ChannelSet};
use crate::mesh::{Mesh, SurfacePoint};
use crate::surface::{SurfaceTexture, Texel};
use glam::Vec3;

/// Width of border lines, in footprints.
const LINE: f32 = 1.2;

/// Colour of border lines, linear light.
const BORDER: Vec3 = Vec3::splat(0.02);

/// The charts of a mesh as a texture.
#[derive(Debug)]
pub struct ChartColors<'a> {
    mesh: &'a Mesh,
    /// Chart of each face.
    chart: &'a [u32],
    /// For each half-edge whether it is a chart border.
    border: Vec<bool>,
}

impl<'a> ChartColors<'a> {
    /// `chart` has one entry a face; `borders` names the half-edges on chart borders, on either side.
    #[must_use]
    pub fn new(mesh: &'a Mesh, chart: &'a [u32], borders: impl IntoIterator<Item = u32>) -> Self {
        let mut border = vec![false; mesh.opposite.len()];
        for h in borders {
            if let Some(flag) = border.get_mut(h as usize) {
                *flag = true;
            }
        }
        Self { mesh, chart, border }
    }
}

impl SurfaceTexture for ChartColors<'_> {
    fn channels(&self) -> ChannelSet {
        ChannelSet::default().with(Channel::BaseColor)
    }

    fn texel(&self, at: SurfacePoint, footprint: f32) -> Texel {
        let face = at.face as usize;
        let own = distinct(self.chart.get(face).copied().unwrap_or(0));
        let corners = self.mesh.corners(at.face);
        let double = self.mesh.area_vector(at.face).length();
        let near = (0..3).filter(|&k| self.border[3 * face + k]).any(|k| {
            let length = corners[k].distance(corners[(k + 1) % 3]);
            let height = if length > 0.0 { (double / length) as f32 } else { 0.0 };
            at.bary[(k + 2) % 3] * height < LINE * footprint
        });
        let base_color = if near { BORDER } else { own };
        Texel { base_color, alpha: 1.0, ..Texel::empty(self.mesh.normal(at.face).as_vec3()) }
    }
}
