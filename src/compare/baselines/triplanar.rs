//! Triplanar projection: the exemplar along the three axes, blended by the normal.
//!
//! Based on: R. Geiss, "Generating Complex Procedural Terrains Using the GPU", GPU Gems 3, chapter 1, 2007, section 1.5; with the
//! sharpened weights that are common today. Planes are laid so that up in the exemplar is up in the world on the four sides.

use super::hex::{HexOptions, hex_place, hex_texel};
use super::tile::{Tile, mean, onto};
use crate::compare::source::{Origin, Sourced, steps};
use crate::exemplar::{ChannelSet, Exemplar};
use crate::mesh::{Mesh, SurfacePoint};
use crate::surface::{SurfaceTexture, Texel};
use glam::{DVec2, Vec2, Vec3};

/// How a plane is filled.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Sheet {
    /// With the exemplar, repeated.
    #[default]
    Plain,
    /// With hexagons of it.
    Hex(HexOptions),
}

/// How planes are projected.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TriplanarOptions {
    /// What each plane shows.
    pub sheet: Sheet,
    /// Power of the normal's parts; larger makes the blend narrower. 4 is common.
    pub power: f32,
}

impl Default for TriplanarOptions {
    fn default() -> Self {
        Self { sheet: Sheet::Plain, power: 4.0 }
    }
}

/// A plane with too little weight is not read.
const NOTHING: f32 = 1e-3;

/// An exemplar projected along the three axes.
#[derive(Debug)]
pub struct Triplanar<'a> {
    mesh: &'a Mesh,
    normals: Vec<Vec3>,
    tile: Tile<'a>,
    options: TriplanarOptions,
}

impl<'a> Triplanar<'a> {
    /// Projects an exemplar whose width is `scale` world units.
    #[must_use]
    pub fn new(mesh: &'a Mesh, exemplar: &'a Exemplar, scale: f64, options: TriplanarOptions) -> Self {
        Self { mesh, normals: mesh.vertex_normals(), tile: Tile::new(exemplar, scale), options }
    }

    /// The normal of the smooth surface at a point.
    fn smooth(&self, at: SurfacePoint, flat: Vec3) -> Vec3 {
        let corners = self.mesh.faces[at.face as usize].map(|v| self.normals[v as usize]);
        (corners[0] * at.bary.x + corners[1] * at.bary.y + corners[2] * at.bary.z).normalize_or(flat)
    }

    /// The weight of each axis at a smooth normal; they add up to one.
    #[must_use]
    pub fn weights(&self, smooth: Vec3) -> [f32; 3] {
        let powers = smooth.abs().to_array().map(|c| c.powf(self.options.power));
        let sum: f32 = powers.iter().sum();
        powers.map(|w| if sum > 0.0 { w / sum } else { 1.0 / 3.0 })
    }
}

impl Sourced for Triplanar<'_> {
    /// That of the plane that weighs most.
    fn origin(&self, at: SurfacePoint) -> Option<Origin> {
        let smooth = self.smooth(at, self.mesh.normal(at.face).as_vec3());
        let weights = self.weights(smooth);
        let axis = (0..3).fold(0, |most, axis| if weights[axis] > weights[most] { axis } else { most });
        let directions = plane(axis, 1.0_f32.copysign(smooth[axis])).map(Vec3::as_dvec3);
        let unit = f64::from(self.tile.pixel(Vec2::X).x);
        let corners = self.mesh.corners(at.face);
        let bary = at.bary.as_dvec3();
        let places = corners.map(|p| DVec2::new(p.dot(directions[0]), p.dot(directions[1])) * unit);
        let place = places[0] * bary.x + places[1] * bary.y + places[2] * bary.z;
        let pixel = match &self.options.sheet {
            Sheet::Plain => place,
            Sheet::Hex(options) => hex_place(&self.tile, place.as_vec2(), options).as_dvec2(),
        };
        let steps = steps(corners, places)?;
        let pixel = pixel.rem_euclid(self.tile.size().as_dvec2());
        Some(Origin { pixel, right: steps[0].normalize_or_zero(), steps: Some(steps) })
    }
}

/// World directions in which the plane along an axis goes right and down, seen from the side that the normal points to.
fn plane(axis: usize, side: f32) -> [Vec3; 2] {
    match axis {
        0 => [Vec3::NEG_Z * side, Vec3::NEG_Y],
        1 => [Vec3::X, Vec3::Z * side],
        _ => [Vec3::X * side, Vec3::NEG_Y],
    }
}

impl SurfaceTexture for Triplanar<'_> {
    fn channels(&self) -> ChannelSet {
        self.tile.channels()
    }

    fn texel(&self, at: SurfacePoint, footprint: f32) -> Texel {
        let flat = self.mesh.normal(at.face).as_vec3();
        let smooth = self.smooth(at, flat);
        let p = self.mesh.position(at).as_vec3();
        let lod = self.tile.lod(footprint);
        let parts: Vec<(f32, Texel)> = self
            .weights(smooth)
            .into_iter()
            .enumerate()
            .filter(|(_, w)| *w > NOTHING)
            .map(|(axis, weight)| {
                let [right, down] = plane(axis, 1.0_f32.copysign(smooth[axis]));
                let pixel = self.tile.pixel(Vec2::new(p.dot(right), p.dot(down)));
                let texel = match &self.options.sheet {
                    Sheet::Plain => self.tile.texel(pixel, lod),
                    Sheet::Hex(options) => hex_texel(&self.tile, pixel, lod, options),
                };
                let along = |d: Vec3| d.reject_from_normalized(flat).normalize_or_zero();
                let normal = flat.normalize_or(smooth);
                (weight, onto(texel, along(right), along(down), normal))
            })
            .collect();
        let total: f32 = parts.iter().map(|(w, _)| w).sum();
        let parts: Vec<(f32, Texel)> = parts.into_iter().map(|(w, t)| (w / total, t)).collect();
        mean(&parts)
    }
}
