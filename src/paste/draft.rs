//! A draft of a change: texture patches laid again where an earlier run has laid them, under what steers them now.
//!
//! Who combs a field or moves a scale wants to see at once where the texture runs now; which points pastes begin at matters little
//! to that. So a draft takes seeds, texture patches and paint order from before. It looks for no holes, for nothing that lies
//! hidden and for no hard edges, and fits each paste once ([`FitChoice::once`]). Where the change lets pastes reach less far
//! than before, the ground shows until the whole answer is there.

use super::grow::{PatchPlan, Site};
use super::lapped::LappedTexture;
use super::lay::{FitChoice, lay};
use super::layout::{Seeding, record};
use super::size::{check, opaque_pixels};
use super::{PasteError, PasteOptions};
use crate::exemplar::{CoverageMask, Exemplar, TexturePatch};
use crate::field::Guide;
use crate::mesh::Mesh;
use crate::mesh::disc::Scratch;
use rayon::prelude::*;
use std::ops::RangeInclusive;
use std::sync::Arc;

/// Opaque areas of all pastes in areas of the surface for which a draft is worth its time: with less, too much ground shows; with more
/// the pastes laid where they are needed take less time than those.
const WORTH: RangeInclusive<f64> = 1.3..=6.0;

/// Pastes that one task lays.
const TASK: usize = 4;

/// Lays patches at these seeds of an earlier run, on this mesh and in this order. `None` if the change is so large that so many pastes
/// say nothing of what will be. With the pastes come their seeds; those of patches that are no more, and where the field has no basis,
/// are left out.
///
/// # Errors
/// If the guide belongs to another mesh, or an option is none.
pub fn draft(
    mesh: &Mesh,
    guide: &Guide,
    exemplars: Vec<Exemplar>,
    patches: Vec<TexturePatch>,
    seedings: &[Seeding],
    options: &PasteOptions,
) -> Result<Option<(LappedTexture, Vec<Seeding>)>, PasteError> {
    check(mesh, guide, &patches, options)?;
    let seedings: Vec<&Seeding> =
        seedings.iter().filter(|s| usize::from(s.patch) < patches.len() && (s.at.face as usize) < mesh.face_count()).collect();
    let plan = |p: &TexturePatch| PatchPlan::new(p, exemplars[p.exemplar as usize].size()[0]);
    let plans: Vec<PatchPlan> = patches.iter().map(plan).collect();
    // In exemplar widths, squared.
    let opaque: Vec<f64> = patches.iter().zip(&plans).map(|(p, plan)| opaque_pixels(p) / plan.pixels_per_width().powi(2)).collect();
    let covered: f64 = seedings.iter().map(|s| opaque[usize::from(s.patch)] * f64::from(guide.scale(s.at.face)).powi(2)).sum();
    if !WORTH.contains(&(covered / mesh.total_area())) {
        return Ok(None);
    }
    let kept = options.masks.clone().filter(|kept| kept.len() == patches.len());
    let masks: Arc<[CoverageMask]> = kept.unwrap_or_else(|| patches.iter().map(CoverageMask::new).collect());
    let choice = FitChoice { once: true, ..options.fit() };
    let one = |scratch: &mut Scratch, seeding: &Seeding| {
        let plan = &plans[usize::from(seeding.patch)];
        let distortion = options.distortion_for(guide, seeding.free);
        let site = Site { mesh, guide, plan, seed: seeding.at, distortion, predictor: options.predictor, free: seeding.free };
        let laid = lay(site, seeding.angle, choice, scratch)?;
        Some((record(&laid, seeding.patch, plan, &masks[usize::from(seeding.patch)]).0, *seeding))
    };
    let tasks = seedings.par_chunks(TASK).map_init(
        || Scratch::new(mesh),
        |scratch, seedings| seedings.iter().filter_map(|seeding| one(scratch, seeding)).collect::<Vec<_>>(),
    );
    let (pastes, seedings) = tasks.collect::<Vec<_>>().into_iter().flatten().unzip();
    Ok(Some((LappedTexture { exemplars, patches, pastes, layers: Vec::new() }, seedings)))
}
