//! Pictures of measures: the source map and the error of a texture, as textures of their own.

use super::measures::ErrorMap;
use super::source::{Plane, Sourced};
use crate::exemplar::{Channel, ChannelSet, srgb};
use crate::mesh::{Mesh, SurfacePoint};
use crate::render::style::sequential;
use crate::surface::{SurfaceTexture, Texel};
use glam::Vec3;

fn coloured(color: Vec3) -> Texel {
    Texel { base_color: color, alpha: 1.0, ..Texel::empty(Vec3::Z) }
}

fn colour_only() -> ChannelSet {
    ChannelSet::default().with(Channel::BaseColor)
}

/// Where each point comes from: red goes right in the exemplar, green goes down. Smooth ramps were copied together.
pub struct SourceColors<'a> {
    source: &'a dyn Sourced,
    plane: Plane,
}

/// The blue of all places, sRGB.
const BLUE: f32 = 0.45;

/// The colour of a place of the exemplar, linear light.
#[must_use]
pub fn place_color(plane: &Plane, place: glam::DVec2) -> Vec3 {
    let share = (plane.wrapped(place) / plane.size).as_vec2();
    Vec3::new(share.x, share.y, BLUE).map(srgb::decode)
}

impl<'a> SourceColors<'a> {
    /// The colours of a source map.
    #[must_use]
    pub const fn new(source: &'a dyn Sourced, plane: Plane) -> Self {
        Self { source, plane }
    }
}

impl SurfaceTexture for SourceColors<'_> {
    fn channels(&self) -> ChannelSet {
        colour_only()
    }

    fn texel(&self, at: SurfacePoint, _footprint: f32) -> Texel {
        self.source.origin(at).map_or(Texel::empty(Vec3::Z), |o| coloured(place_color(&self.plane, o.pixel)))
    }
}

/// How little each point looks like the exemplar: light where it does.
pub struct ErrorColors<'a> {
    mesh: &'a Mesh,
    errors: &'a ErrorMap,
    /// The error at the dark end of the scale.
    most: f64,
}

impl<'a> ErrorColors<'a> {
    /// The colours of an error map.
    #[must_use]
    pub const fn new(mesh: &'a Mesh, errors: &'a ErrorMap, most: f64) -> Self {
        Self { mesh, errors, most }
    }
}

impl SurfaceTexture for ErrorColors<'_> {
    fn channels(&self) -> ChannelSet {
        colour_only()
    }

    fn texel(&self, at: SurfacePoint, _footprint: f32) -> Texel {
        let error = self.errors.near(self.mesh.position(at)).unwrap_or(0.0);
        coloured(sequential((error / self.most) as f32))
    }
}
