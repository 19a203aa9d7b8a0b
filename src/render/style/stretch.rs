//! How far the topmost paste is from what the field asks for.
//!
//! A paste maps a face's plane to texture coordinates, measured in exemplar widths. Walking along the field's basis vectors
//! S and T should walk one exemplar width right and one up: the map expressed in that basis should be the identity. Shown is
//! its singular value that is farther from 1: above, the texture is squeezed together there, below, drawn out. A map that
//! turns the face over is marked.

use super::layers::Layers;
use super::legend::Legend;
use super::{Show, colour_only, coloured, palette};
use crate::exemplar::ChannelSet;
use crate::field::Guide;
use crate::mesh::{Mesh, SurfacePoint};
use crate::paste::LappedTexture;
use crate::surface::{SurfaceTexture, Texel};
use glam::{DMat2, DVec2, DVec3, Vec3};
use rayon::prelude::*;

/// Where no paste lies: linear light.
const BARE: Vec3 = Vec3::new(0.25, 0.25, 0.25);
/// The factor at which the colour scale ends.
const MOST: f32 = 2.0;
/// Colours in the legend's bar.
const BAR: usize = 9;

pub(super) struct Stretch<'a> {
    layers: Layers<'a>,
    /// For each entry of the face lists the singular value to show, or NaN for a flipped face.
    values: Vec<f32>,
}

impl<'a> Stretch<'a> {
    pub(super) fn new(mesh: &'a Mesh, lapped: &'a LappedTexture, guide: &Guide) -> Self {
        let layers = Layers::new(mesh, lapped);
        let values = (0..mesh.face_count() as u32)
            .into_par_iter()
            .flat_map_iter(|face| {
                let layers = &layers;
                layers.lists.of(face).iter().map(move |&(paste, slot)| {
                    let widths = exemplar_width(lapped, paste);
                    let steps =
                        layers.corners(paste, slot).map(|c| c.map(|p| DVec2::new(f64::from(p.x), -f64::from(p.y)) / widths));
                    steps.map_or(f32::NAN, |steps| worst(basis(mesh, guide, face), mesh.corners(face), steps))
                })
            })
            .collect();
        Self { layers, values }
    }
}

/// Width in pixels of the exemplar under a paste.
fn exemplar_width(lapped: &LappedTexture, paste: u32) -> f64 {
    let patch = lapped.pastes.get(paste as usize).and_then(|p| lapped.patches.get(p.patch as usize));
    patch.and_then(|patch| lapped.exemplars.get(patch.exemplar as usize)).map_or(1.0, |e| f64::from(e.size()[0]))
}

/// The field's basis at a face; any of the right size where only the scale is given.
fn basis(mesh: &Mesh, guide: &Guide, face: u32) -> (DVec3, DVec3) {
    guide.field().map_or_else(
        || {
            let (s, t) = mesh.normal(face).any_orthonormal_pair();
            let scale = f64::from(guide.scale(face));
            (s * scale, t * scale)
        },
        |field| field.basis(mesh, face),
    )
}

/// The singular value farther from 1 of the map from the basis to texture coordinates; NaN if it turns the face over.
fn worst((s, t): (DVec3, DVec3), [a, b, c]: [DVec3; 3], [p, q, r]: [DVec2; 3]) -> f32 {
    let (u, v) = (b - a, c - a);
    // The basis vectors as sums of the face's sides.
    let gram = DMat2::from_cols(DVec2::new(u.dot(u), u.dot(v)), DVec2::new(u.dot(v), v.dot(v)));
    let sides = gram.inverse() * DMat2::from_cols(DVec2::new(u.dot(s), v.dot(s)), DVec2::new(u.dot(t), v.dot(t)));
    let map = DMat2::from_cols(q - p, r - p) * sides;
    let (determinant, squares) = (map.determinant(), map.x_axis.length_squared() + map.y_axis.length_squared());
    // The basis is right-handed seen from outside only if S x T points outward.
    let upright = determinant * s.cross(t).dot(u.cross(v));
    if upright.is_nan() || upright <= 0.0 {
        return f32::NAN;
    }
    let determinant = determinant.abs();
    let (sum, difference) = ((squares + 2.0 * determinant).sqrt(), (squares - 2.0 * determinant).max(0.0).sqrt());
    let (large, small) = (0.5 * (sum + difference), 0.5 * (sum - difference));
    (if large.ln() > -small.ln() { large } else { small }) as f32
}

fn colour(value: f32) -> Vec3 {
    if value.is_nan() { palette::ALARM } else { palette::diverging(value.ln() / MOST.ln()) }
}

impl SurfaceTexture for Stretch<'_> {
    fn channels(&self) -> ChannelSet {
        colour_only()
    }

    fn texel(&self, at: SurfacePoint, footprint: f32) -> Texel {
        coloured(self.layers.top(at, footprint).map_or(BARE, |layer| colour(self.values[layer.entry])))
    }
}

impl Show for Stretch<'_> {
    fn texture(&self) -> &dyn SurfaceTexture {
        self
    }

    fn legend(&self) -> Option<Legend> {
        let mut entries: Vec<(Vec3, String)> = (0..BAR)
            .map(|i| {
                let value = MOST.powf(2.0 * i as f32 / (BAR - 1) as f32 - 1.0);
                (colour(value), if i.is_multiple_of(2) { format!("{value:.2}") } else { String::new() })
            })
            .collect();
        entries.push((palette::ALARM, "flipped".to_owned()));
        Some(Legend { title: "texture density, 1 as asked", entries })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_value_is_the_scale_of_a_scaled_map_and_the_worse_of_two() {
        let face = [DVec3::new(1.0, 2.0, 0.0), DVec3::new(4.0, 2.5, 0.0), DVec3::new(1.5, 5.0, 0.0)];
        let basis = (DVec3::X * 2.0, DVec3::Y * 2.0);
        let mapped = |x: f64, y: f64| face.map(|p| DVec2::new(x * p.x, y * p.y) / 2.0);
        for (x, y, expected) in [(1.0, 1.0, 1.0), (1.5, 1.5, 1.5), (1.1, 0.5, 0.5), (1.9, 0.9, 1.9)] {
            let value = worst(basis, face, mapped(x, y));
            assert!((value - expected).abs() < 1e-5, "scaled by {x}, {y}: {value}");
        }
        assert!(worst(basis, face, mapped(-1.0, 1.0)).is_nan(), "mirrored");
    }
}
