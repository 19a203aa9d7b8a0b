//! How large a job is, and whether it can be done at all.

use super::frame::singular_values;
use super::grow::PatchPlan;
use super::options::PasteOptions;
use super::{CELL_TEXELS, PasteError};
use crate::exemplar::TexturePatch;
use crate::field::Guide;
use crate::mesh::Mesh;
use glam::DMat2;

/// Opaque areas of pastes laid per area of surface: what random seeding takes until nothing is left.
pub const PASTES_PER_COVER: f64 = 2.3;

/// More pastes than this are refused: the scale is surely a mistake.
const MAX_PASTES: f64 = 4e6;

/// More coverage cells than this are refused.
const MAX_CELLS: f64 = 4e9;

/// A scale above this many bounding box diagonals is refused.
const MAX_SCALE: f64 = 1e4;

/// World length of one exemplar width at a face, in the direction where it is least.
pub(super) fn least_scale(mesh: &Mesh, guide: &Guide, face: u32) -> f64 {
    match guide {
        Guide::Directed(field) if field.right.is_some() => {
            let (right, up) = field.basis(mesh, face);
            let normal = mesh.normal(face);
            let e1 = normal.any_orthonormal_vector();
            let e2 = normal.cross(e1);
            let m = DMat2::from_cols_array(&[right.dot(e1), right.dot(e2), up.dot(e1), up.dot(e2)]);
            singular_values(m).1.abs()
        }
        _ => f64::from(guide.scale(face)),
    }
}

/// Mean scale over the area.
pub(super) fn mean_scale(mesh: &Mesh, guide: &Guide) -> f64 {
    let sum: f64 = (0..mesh.face_count() as u32).map(|f| mesh.area(f) * f64::from(guide.scale(f))).sum();
    sum / mesh.total_area()
}

pub(super) fn check(mesh: &Mesh, guide: &Guide, patches: &[TexturePatch], options: &PasteOptions) -> Result<(), PasteError> {
    if patches.is_empty() {
        return Err(PasteError::NoPatches);
    }
    if patches.len() > usize::from(u16::MAX) {
        return Err(PasteError::TooManyPatches(patches.len()));
    }
    let found = match guide {
        Guide::Directed(field) => field.up.len(),
        Guide::Isotropic { scale } => scale.len(),
    };
    if found != mesh.face_count() {
        return Err(PasteError::GuideSize { found, expected: mesh.face_count() });
    }
    match options.distortion {
        Some(bound) if bound.is_nan() || bound <= 0.0 => Err(PasteError::Distortion(bound)),
        _ => Ok(()),
    }
}

/// Pixels of a patch with alpha of at least one half.
pub(super) fn opaque_pixels(patch: &TexturePatch) -> f64 {
    patch.mask.finest().data().iter().filter(|&&a| a >= 0.5).count() as f64
}

/// Refuses scales at which the job would never end, or show nothing.
pub(super) fn check_size(
    mesh: &Mesh,
    guide: &Guide,
    texel: &[f32],
    patches: &[TexturePatch],
    plans: &[PatchPlan],
    texels: f64,
) -> Result<(), PasteError> {
    let least = |f: u32| f64::from(texel[f as usize]) * texels;
    if let Some(face) = (0..mesh.face_count() as u32).find(|&f| !(least(f) > 0.0 && least(f).is_finite())) {
        return Err(PasteError::NoBasis { face });
    }
    let scale = mean_scale(mesh, guide);
    let (low, high) = mesh.bounds();
    let diagonal = f64::from((high - low).length());
    if scale > MAX_SCALE * diagonal {
        return Err(PasteError::ScaleTooLarge { scale, times: scale / diagonal, usable: MAX_SCALE * diagonal });
    }
    let widths: f64 = (0..mesh.face_count() as u32).map(|f| mesh.area(f) / (least(f) * least(f))).sum();
    let opaque: f64 = patches.iter().zip(plans).map(|(p, plan)| opaque_pixels(p) / plan.pixels_per_width().powi(2)).sum();
    let pastes = PASTES_PER_COVER * widths / (opaque / patches.len() as f64).max(f64::MIN_POSITIVE);
    let cells = widths * (texels / CELL_TEXELS).powi(2);
    let excess = (pastes / MAX_PASTES).max(cells / MAX_CELLS);
    if excess > 1.0 {
        return Err(PasteError::ScaleTooSmall { scale, pastes, cells, usable: scale * excess.sqrt() });
    }
    Ok(())
}
