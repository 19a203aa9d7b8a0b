//! The exemplar repeated over automatic charts, as a modeller's default: unwrap, tile, done.

use super::tile::{Tile, onto};
use crate::atlas::Atlas;
use crate::compare::source::{Origin, Sourced, steps};
use crate::exemplar::{ChannelSet, Exemplar};
use crate::mesh::{Mesh, SurfacePoint};
use crate::surface::{SurfaceTexture, Texel};
use glam::{Vec2, Vec3};

/// An exemplar repeated over the charts of an atlas, at one scale for all.
#[derive(Debug)]
pub struct Tiling<'a> {
    mesh: &'a Mesh,
    atlas: &'a Atlas,
    tile: Tile<'a>,
    /// Texels of the atlas a world unit.
    density: f64,
}

impl<'a> Tiling<'a> {
    /// Tiles an exemplar whose width is `scale` world units.
    #[must_use]
    pub fn new(mesh: &'a Mesh, atlas: &'a Atlas, exemplar: &'a Exemplar, scale: f64) -> Self {
        Self { mesh, atlas, tile: Tile::new(exemplar, scale), density: atlas.density(mesh) }
    }

    /// World directions in which the atlas goes right and down on a face, unit.
    fn axes(&self, face: u32) -> [Vec3; 2] {
        let [a, b, c] = self.atlas.face_texels(face);
        let (d, e) = (b - a, c - a);
        let [p, q, r] = self.mesh.corners(face);
        let side = d.perp_dot(e).signum();
        let right = ((q - p) * e.y - (r - p) * d.y) * side;
        let down = ((r - p) * d.x - (q - p) * e.x) * side;
        [right, down].map(|v| v.normalize_or_zero().as_vec3())
    }
}

impl Sourced for Tiling<'_> {
    fn origin(&self, at: SurfacePoint) -> Option<Origin> {
        let pixels = f64::from(self.tile.pixel(Vec2::X).x) / self.density.max(f64::MIN_POSITIVE);
        let corners = self.atlas.face_texels(at.face).map(|p| p * pixels);
        let bary = at.bary.as_dvec3();
        let place = corners[0] * bary.x + corners[1] * bary.y + corners[2] * bary.z;
        let steps = steps(self.mesh.corners(at.face), corners)?;
        let pixel = place.rem_euclid(self.tile.size().as_dvec2());
        Some(Origin { pixel, right: steps[0].normalize_or_zero(), steps: Some(steps) })
    }
}

impl SurfaceTexture for Tiling<'_> {
    fn channels(&self) -> ChannelSet {
        self.tile.channels()
    }

    fn texel(&self, at: SurfacePoint, footprint: f32) -> Texel {
        let flat = self.mesh.normal(at.face).as_vec3();
        let [a, b, c] = self.atlas.face_texels(at.face);
        let bary = at.bary.as_dvec3();
        let place = (a * bary.x + b * bary.y + c * bary.z) / self.density.max(f64::MIN_POSITIVE);
        let texel = self.tile.texel(self.tile.pixel(Vec2::new(place.x as f32, place.y as f32)), self.tile.lod(footprint));
        let [right, down] = self.axes(at.face);
        onto(texel, right, down, flat)
    }
}
