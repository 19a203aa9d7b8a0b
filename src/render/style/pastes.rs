//! Each paste in its own colour, blended as the texture is, with dark outlines where the topmost paste changes.

use super::super::picture::Picture;
use super::super::raster::Visibility;
use super::layers::Layers;
use super::{Show, colour_only, coloured, palette};
use crate::exemplar::ChannelSet;
use crate::mesh::{Mesh, NONE, SurfacePoint};
use crate::paste::LappedTexture;
use crate::surface::{SurfaceTexture, Texel};
use glam::Vec3;
use rayon::prelude::*;

/// Where no paste lies: linear light.
const BARE: Vec3 = Vec3::new(0.55, 0.55, 0.55);
/// Colour of outlines, sRGB.
const INK: Vec3 = Vec3::new(0.1, 0.1, 0.12);

pub(super) struct Pastes<'a> {
    mesh: &'a Mesh,
    layers: Layers<'a>,
}

impl<'a> Pastes<'a> {
    pub(super) fn new(mesh: &'a Mesh, lapped: &'a LappedTexture) -> Self {
        Self { mesh, layers: Layers::new(mesh, lapped) }
    }
}

impl SurfaceTexture for Pastes<'_> {
    fn channels(&self) -> ChannelSet {
        colour_only()
    }

    fn texel(&self, at: SurfacePoint, footprint: f32) -> Texel {
        let (mut colour, mut left) = (Vec3::ZERO, 1.0);
        for layer in self.layers.at(at, footprint) {
            colour += palette::distinct(layer.paste) * (left * layer.alpha);
            left *= 1.0 - layer.alpha;
        }
        coloured(colour + BARE * left)
    }
}

impl Show for Pastes<'_> {
    fn texture(&self) -> &dyn SurfaceTexture {
        self
    }

    fn overlay(&self, seen: &Visibility, picture: &mut Picture) {
        let [across, down] = seen.grid().size();
        // The topmost paste of each sample; NONE off the mesh, NONE - 1 on it where there is none.
        let tops: Vec<u32> = (0..across * down)
            .into_par_iter()
            .map(|i| match seen.hit(self.mesh, i % across, i / across) {
                None => NONE,
                Some(hit) => self.layers.top(hit.at, hit.footprint as f32).map_or(NONE - 1, |layer| layer.paste),
            })
            .collect();
        let n = seen.grid().samples as usize;
        // Half the width of an outline, samples: a pixel or a little more in all.
        let reach = (3 * n).div_ceil(4);
        let changes = |x: usize, y: usize| {
            let here = tops[y * across + x];
            let other = |u: usize, v: usize| u < across && v < down && tops[v * across + u] != here && tops[v * across + u] != NONE;
            here != NONE
                && (1..=reach)
                    .any(|r| other(x + r, y) || other(x, y + r) || other(x.wrapping_sub(r), y) || other(x, y.wrapping_sub(r)))
        };
        let width = picture.width as usize;
        let shares: Vec<f32> = (0..width * picture.height as usize)
            .into_par_iter()
            .map(|i| {
                let (x, y) = (i % width * n, i / width * n);
                let inked = (y..y + n).flat_map(|v| (x..x + n).map(move |u| (u, v))).filter(|&(u, v)| changes(u, v)).count();
                inked as f32 / (n * n) as f32
            })
            .collect();
        for (i, share) in shares.into_iter().enumerate() {
            picture.blend((i % width) as i64, (i / width) as i64, INK, 0.8 * share);
        }
    }
}
