//! Whether the borders of patches or charts can be seen: how much colours change across them, against how much they change anywhere
//! in the exemplar.
//!
//! A border that is invisible is crossed with the exemplar's own steps from pixel to pixel: some large, most small. One that is seen
//! has more large ones. So the measure is of the distribution: how often a step across a border is among the exemplar's largest
//! hundredth, and how large steps are on the mean.

use super::pieces::Pieces;
use crate::atlas::Atlas;
use crate::exemplar::srgb;
use crate::mesh::walk::walk;
use crate::mesh::{Mesh, SurfacePoint, next};
use crate::surface::SurfaceTexture;
use glam::{DVec3, Vec3};
use rayon::prelude::*;
use serde::Serialize;

/// A place on a border.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Border {
    /// A point just beside it.
    pub at: SurfacePoint,
    /// The direction over it, in the plane of the point's face; need not be unit.
    pub across: DVec3,
}

/// How visible borders are.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct SeamVisibility {
    /// Places looked at.
    pub places: usize,
    /// Mean step across borders over the exemplar's mean step from pixel to pixel: 1 is invisible.
    pub ratio: f64,
    /// Share of steps across borders that are larger than 99 % of the exemplar's: 0.01 is invisible.
    pub beyond: f64,
}

/// The largest hundredth of the exemplar's steps begins here.
const LARGE: f64 = 0.99;

/// How far a place lies beside its border, as a share of its face.
const BESIDE: f32 = 1e-3;

/// Places on chart borders, about `apart` world units from each other.
#[must_use]
pub fn chart_borders(mesh: &Mesh, atlas: &Atlas, apart: f64) -> Vec<Border> {
    let mut places = Vec::new();
    for (h, _) in atlas.seams(mesh) {
        let (from, to) = (mesh.point(mesh.origin(h)), mesh.point(mesh.origin(next(h))));
        let along = to - from;
        // Faces run around their normals, so this leads out of the face.
        let across = along.cross(mesh.normal(h / 3));
        let count = (along.length() / apart).ceil().max(1.0) as usize;
        for k in 0..count {
            let t = (k as f32 + 0.5) / count as f32;
            let mut bary = Vec3::splat(BESIDE / 3.0);
            bary[(h % 3) as usize] += (1.0 - BESIDE) * (1.0 - t);
            bary[(next(h) % 3) as usize] += (1.0 - BESIDE) * t;
            places.push(Border { at: SurfacePoint { face: h / 3, bary }, across });
        }
    }
    places
}

fn step(a: [f32; 3], b: [f32; 3]) -> f64 {
    (0..3).map(|k| f64::from(a[k] - b[k]).powi(2)).sum::<f64>().sqrt()
}

/// The exemplar's own steps from pixel to pixel, right and down.
#[derive(Debug, Clone, PartialEq)]
pub struct OwnSteps {
    mean: f64,
    /// 99 % are smaller.
    large: f64,
}

impl OwnSteps {
    /// Of pieces of an exemplar; `None` without any.
    #[must_use]
    pub fn new(exemplar: &Pieces) -> Option<Self> {
        let side = exemplar.side;
        let mut all = Vec::new();
        for piece in &exemplar.data {
            for i in 0..side * side {
                if i % side + 1 < side {
                    all.push(step(piece[i], piece[i + 1]));
                }
                if i + side < side * side {
                    all.push(step(piece[i], piece[i + side]));
                }
            }
        }
        all.sort_by(f64::total_cmp);
        let large = *all.get((all.len().checked_sub(1)? as f64 * LARGE) as usize)?;
        Some(Self { mean: all.iter().sum::<f64>() / all.len() as f64, large })
    }

    /// How visible borders with such steps across them are.
    #[must_use]
    pub fn visibility(&self, across: &[f64]) -> SeamVisibility {
        let places = across.len();
        if places == 0 {
            return SeamVisibility::default();
        }
        SeamVisibility {
            places,
            ratio: across.iter().sum::<f64>() / places as f64 / self.mean.max(f64::MIN_POSITIVE),
            beyond: across.iter().filter(|&&s| s > self.large).count() as f64 / places as f64,
        }
    }
}

/// How much colours change across each border over one pixel, `pixel` world units long.
#[must_use]
pub fn steps_across(mesh: &Mesh, texture: &dyn SurfaceTexture, borders: &[Border], pixel: f64) -> Vec<f64> {
    let color = |at: SurfacePoint| texture.texel(at, 0.0).base_color.to_array().map(srgb::encode);
    let across = |border: &Border| {
        let half = border.across.normalize_or_zero() * (0.5 * pixel);
        step(color(walk(mesh, border.at, -half)), color(walk(mesh, border.at, half)))
    };
    borders.par_iter().map(across).collect()
}

/// How visible borders are on a surface; `pixel` is the world length of a pixel of the exemplar, of which there are pieces. Zero
/// without borders or pieces.
#[must_use]
pub fn seam_visibility(
    mesh: &Mesh,
    texture: &dyn SurfaceTexture,
    borders: &[Border],
    pixel: f64,
    exemplar: &Pieces,
) -> SeamVisibility {
    OwnSteps::new(exemplar).map_or_else(SeamVisibility::default, |own| own.visibility(&steps_across(mesh, texture, borders, pixel)))
}
