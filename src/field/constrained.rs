//! Fields from constraints: directions, scale and, where asked for, a full tangential basis.
//!
//! Directions that cancel where anchors disagree are taken from the neighbours (see [`super::fill`]), so that every face has one.

use super::constraints::Anchor;
use super::fill::fill;
use super::spread::{self, Carry};
use super::up::{directions as up_directions, stand_ins};
use super::{FieldError, Guide, TangentField, usable_scale};
use crate::mesh::Mesh;
use glam::{DVec3, Vec3};
use serde::Serialize;

/// Where the blended unit directions sum to less than this share of their weights they cancel: what is left of them is the
/// rounding and the roughness of the mesh.
const CANCELLED: f32 = 0.02;

/// How to make a field of constraints.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FieldOptions {
    /// World length of one exemplar width at relative scale 1.
    pub scale: f64,
    /// The axis of the base field, and of the whole field if no anchor has a direction.
    pub axis: DVec3,
    /// Weight of the base field against the anchors; see [`super::Constraints::base_weight`].
    pub base_weight: f64,
    /// How directions travel.
    pub carry: Carry,
}

impl Default for FieldOptions {
    fn default() -> Self {
        Self { scale: 1.0, axis: DVec3::Y, base_weight: 0.0, carry: Carry::default() }
    }
}

/// What [`constrained`] met.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct ConstrainedStatistics {
    /// Anchors used.
    pub anchors: usize,
    /// Largest distance of a position asked for from the surface, world units.
    pub farthest_position: f64,
    /// Faces that took their direction from neighbours.
    pub filled_faces: usize,
    /// Smallest and largest relative scale.
    pub relative_scale: [f32; 2],
}

/// A tangent field through anchors.
///
/// # Errors
/// If the axis or the scale is unusable, or becomes so by the anchors' relative scale.
pub fn constrained(
    mesh: &Mesh,
    anchors: &[Anchor],
    options: &FieldOptions,
) -> Result<(TangentField, ConstrainedStatistics), FieldError> {
    let (scales, mut statistics) = scales(mesh, anchors, options)?;
    let mut directions = if anchors.iter().any(|a| a.direction.is_some()) {
        let base = (options.base_weight > 0.0).then(|| up_directions(mesh, options.axis)).transpose()?;
        let base = base.as_ref().map(|(directions, _)| (directions.as_slice(), options.base_weight));
        let blended = spread::directions(mesh, anchors, base, options.carry);
        blended.into_iter().map(|d| if d.length() < CANCELLED { Vec3::ZERO } else { d.normalize() }).collect()
    } else {
        let (directions, filled) = up_directions(mesh, options.axis)?;
        statistics.filled_faces = filled;
        directions
    };
    statistics.filled_faces += fill(mesh, &mut directions, stand_ins(options.axis.normalize_or(DVec3::Y)));
    let up: Vec<Vec3> = directions.iter().zip(&scales).map(|(&d, &scale)| d * scale).collect();
    let right = anchors.iter().any(|a| a.ln_stretch.is_some() || a.shear.is_some()).then(|| {
        let stretch = spread::numbers(mesh, anchors, options.base_weight, |a| a.ln_stretch);
        let shear = spread::numbers(mesh, anchors, options.base_weight, |a| a.shear);
        let of = |f: usize| {
            let t = up[f].as_dvec3();
            let s = t.cross(mesh.normal(f as u32)) * f64::from(stretch[f]).exp() + t * f64::from(shear[f]);
            s.as_vec3()
        };
        (0..up.len()).map(of).collect()
    });
    Ok((TangentField { up, right }, statistics))
}

/// The same scale at every face, and no direction.
///
/// # Errors
/// If the scale is not a usable length.
pub fn isotropic(mesh: &Mesh, scale: f64) -> Result<Guide, FieldError> {
    constrained_scale(mesh, &[], &FieldOptions { scale, ..FieldOptions::default() }).map(|(guide, _)| guide)
}

/// A scale from the anchors' relative scales, and no direction.
///
/// # Errors
/// If the scale is unusable, or becomes so by the anchors' relative scale.
pub fn constrained_scale(
    mesh: &Mesh,
    anchors: &[Anchor],
    options: &FieldOptions,
) -> Result<(Guide, ConstrainedStatistics), FieldError> {
    let (scale, statistics) = scales(mesh, anchors, options)?;
    Ok((Guide::Isotropic { scale }, statistics))
}

/// World length of one exemplar width per face.
fn scales(mesh: &Mesh, anchors: &[Anchor], options: &FieldOptions) -> Result<(Vec<f32>, ConstrainedStatistics), FieldError> {
    usable_scale(options.scale)?;
    let relative = spread::numbers(mesh, anchors, options.base_weight, |a| a.ln_scale);
    let scales: Result<Vec<f32>, _> = relative.iter().map(|&ln| usable_scale(options.scale * f64::from(ln).exp())).collect();
    let (low, high) = relative.iter().fold((f32::INFINITY, f32::NEG_INFINITY), |(l, h), &x| (l.min(x), h.max(x)));
    let statistics = ConstrainedStatistics {
        anchors: anchors.len(),
        farthest_position: anchors.iter().map(|a| a.snapped).fold(0.0, f64::max),
        filled_faces: 0,
        relative_scale: [low.exp(), high.exp()],
    };
    Ok((scales?, statistics))
}
