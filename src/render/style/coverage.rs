//! How many pastes each face draws, and where the surface still shows through.

use super::layers::Layers;
use super::legend::Legend;
use super::{Show, colour_only, coloured, palette};
use crate::exemplar::ChannelSet;
use crate::mesh::{Mesh, SurfacePoint};
use crate::paste::LappedTexture;
use crate::surface::{SurfaceTexture, Texel};
use glam::Vec3;

/// Draws from which on all faces look alike.
const MANY: usize = 8;

pub(super) struct Coverage<'a> {
    layers: Layers<'a>,
}

impl<'a> Coverage<'a> {
    pub(super) fn new(mesh: &'a Mesh, lapped: &'a LappedTexture) -> Self {
        Self { layers: Layers::new(mesh, lapped) }
    }
}

fn colour(draws: usize) -> Vec3 {
    palette::sequential((draws.clamp(1, MANY) - 1) as f32 / (MANY - 1) as f32)
}

impl SurfaceTexture for Coverage<'_> {
    fn channels(&self) -> ChannelSet {
        colour_only()
    }

    fn texel(&self, at: SurfacePoint, footprint: f32) -> Texel {
        let bare: f32 = self.layers.at(at, footprint).map(|layer| 1.0 - layer.alpha).product();
        coloured(colour(self.layers.lists.of(at.face).len()).lerp(palette::ALARM, bare))
    }
}

impl Show for Coverage<'_> {
    fn texture(&self) -> &dyn SurfaceTexture {
        self
    }

    fn legend(&self) -> Option<Legend> {
        let mut entries = vec![(palette::ALARM, "bare".to_owned())];
        entries.extend((1..=MANY).map(|n| (colour(n), if n < MANY { n.to_string() } else { format!("{n}+") })));
        Some(Legend { title: "pastes drawn per face", entries })
    }
}
