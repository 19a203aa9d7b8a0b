//! Smaller pastes: laid over hard edges that overlays leave.
//!
//! On thin limbs, ears and tails a patch as wide as the exemplar meets itself behind, or bends too far, and ends in shards. One that is
//! narrower ends by its mask before that: it shows the same exemplar at the same scale, less of it ([`TexturePatch::smaller`]). Laid all
//! over, such patches would only have more borders, so nothing but hard edges that show asks for them. The paper leaves hard edges to
//! future work (section 6).
//!
//! 1. If hard edges show, texture patches that slide get smaller ones beside them.
//! 2. From the widest to the narrowest they are laid at the middles of hard edges that show, drawn by how much they do, as overlays are
//!    ([`Loop::lay_over`]). They follow the field, unless their exemplar looks the same every way.
//! 3. Kept is what hides far more of hard edges than it ends in, and more than a good part of its own width: a border that is
//!    soft still is one.
//! 4. In the result are those of the smaller patches that a paste uses.

use super::PasteError;
use super::grow::PatchPlan;
use super::lapped::{FaceLists, Paste};
use super::layout::{Layout, Loop};
use super::order::{HardEdge, edge_alpha, mask_pixels, visible_edges};
use super::overlay::{SHOWS, middle};
use crate::exemplar::{CoverageMask, TexturePatch};
use crate::mesh::SurfacePoint;
use crate::progress::Progress;
use crate::random::Random;
use rayon::prelude::*;
use std::ops::Range;
use std::sync::Arc;

/// Widths of smaller patches, in those of the patches that they are made of. The widest hides most for the draws that it costs; narrower
/// ones than the last fit anywhere, but are hardly more than a border.
const SHARES: [f32; 3] = [0.7, 0.5, 0.35];

/// Rounds for each width: where one paste was turned down, one beside it may do.
const ROUNDS: u64 = 2;

/// The first of the random streams that rounds draw from.
const STREAM: u64 = 2000;

/// Hard edges of a new paste must be less than this share of what it hides.
const WORTH: f64 = 0.5;

/// What it hides beyond its own must be longer than this share of its width.
const LEAST: f64 = 0.6;

/// Texture patches with smaller ones beside them.
#[derive(Debug)]
pub struct Smaller {
    /// Those given, then the smaller ones.
    pub patches: Vec<TexturePatch>,
    /// Their plans.
    pub plans: Vec<PatchPlan>,
    /// Their masks.
    pub masks: Arc<[CoverageMask]>,
    /// Which are how wide, the widest first.
    widths: Vec<Range<usize>>,
}

/// A hard edge that shows, with the length that does.
struct Shown {
    face: u32,
    edge: u8,
    length: f64,
}

impl Smaller {
    /// Smaller ones of the patches of a loop. `None` if no hard edge shows, no patch slides, or there would be too many.
    #[must_use]
    pub fn new(work: &Loop, masks: &Arc<[CoverageMask]>) -> Option<Self> {
        let (given, plans) = (work.input().patches, work.input().plans);
        if shown(work).is_empty() {
            return None;
        }
        let made: Vec<Vec<Option<TexturePatch>>> = given.par_iter().map(|p| p.smaller(&SHARES)).collect();
        let (mut patches, mut all_plans, mut widths) = (given.to_vec(), plans.to_vec(), Vec::new());
        for number in 0..SHARES.len() {
            let first = patches.len();
            for (small, plan) in made.iter().zip(plans) {
                let Some(Some(small)) = small.get(number) else { continue };
                all_plans.push(PatchPlan::new(small, plan.pixels_per_width() as u32));
                patches.push(small.clone());
            }
            if patches.len() > first {
                widths.push(first..patches.len());
            }
        }
        if widths.is_empty() || patches.len() > usize::from(u16::MAX) {
            return None;
        }
        let made: Vec<CoverageMask> = patches[given.len()..].iter().map(CoverageMask::new).collect();
        let masks = masks.iter().cloned().chain(made).collect();
        Some(Self { patches, plans: all_plans, masks, widths })
    }

    /// Lays them over the hard edges that show of pastes sorted by them, and sorts again. `loose` says of each exemplar whether it need not
    /// follow the field. Returns how many were laid.
    ///
    /// # Errors
    /// If cancelled.
    pub fn lay(&self, work: &mut Loop, loose: &[bool], seed: u64, progress: &dyn Progress) -> Result<usize, PasteError> {
        let guide = work.input().guide;
        let free = |_: SurfacePoint, patch: usize| loose[usize::from(self.patches[patch].exemplar)];
        let (mut laid, mut stream) = (0, STREAM);
        for among in &self.widths {
            for _ in 0..ROUNDS {
                let shown = shown(work);
                let worth = |at: SurfacePoint, paste: &Paste, edges: &[HardEdge]| {
                    let own: f64 = edges.iter().map(|e| f64::from(e.weight)).sum();
                    let width = 2.0 * self.plans[usize::from(paste.patch)].radius * f64::from(guide.scale(at.face));
                    let hidden = self.hidden(paste, &shown);
                    own < WORTH * hidden && hidden - own > LEAST * width
                };
                let mut random = Random::new(seed, stream);
                stream += 1;
                let new = work.lay_over(&drawn(&shown, &mut random), among, &free, &worth, progress)?;
                if new == 0 {
                    break;
                }
                laid += new;
                work.sort_by_hard_edges();
            }
        }
        Ok(laid)
    }

    /// How much of hard edges that show a paste hides; they are in the order of their faces.
    fn hidden(&self, paste: &Paste, shown: &[Shown]) -> f64 {
        let (patch, mask) = (&self.patches[usize::from(paste.patch)], &self.masks[usize::from(paste.patch)]);
        let on_face = |(slot, &face): (usize, &u32)| {
            let here = &shown[shown.partition_point(|e| e.face < face)..];
            let here = here.iter().take_while(|e| e.face == face);
            let pixels = mask_pixels(paste, slot as u32, patch.mask.size());
            here.map(|e| e.length * f64::from(edge_alpha(mask, &pixels, usize::from(e.edge)))).sum::<f64>()
        };
        paste.faces.iter().enumerate().map(on_face).sum()
    }

    /// The patches and masks given, `given` of them, and those that some paste uses; pastes and seedings now name these.
    #[must_use]
    pub fn used(self, given: usize, layout: &mut Layout) -> (Vec<TexturePatch>, Arc<[CoverageMask]>) {
        let mut used = vec![false; self.patches.len()];
        used[..given].fill(true);
        layout.pastes.iter().for_each(|paste| used[usize::from(paste.patch)] = true);
        let mut number = 0;
        let mut next = |&used: &bool| {
            number += u16::from(used);
            number.saturating_sub(1)
        };
        let numbers: Vec<u16> = used.iter().map(&mut next).collect();
        layout.pastes.iter_mut().for_each(|paste| paste.patch = numbers[usize::from(paste.patch)]);
        layout.seedings.iter_mut().for_each(|seeding| seeding.patch = numbers[usize::from(seeding.patch)]);
        let masks = self.masks.iter().zip(&used).filter(|(_, used)| **used).map(|(mask, _)| mask.clone()).collect();
        let patches = self.patches.into_iter().zip(&used).filter(|(_, used)| **used).map(|(patch, _)| patch).collect();
        (patches, masks)
    }
}

/// The hard edges that show, in the order of their faces.
fn shown(work: &Loop) -> Vec<Shown> {
    let (mesh, patches, edges) = (work.input().mesh, work.input().patches, work.edges());
    let lists = FaceLists::new(mesh.face_count(), work.pastes());
    let lengths = visible_edges(mesh, patches, work.pastes(), &lists, edges);
    let all = edges.iter().flatten().zip(lengths.into_iter().flatten());
    let shows = |&(edge, length): &(&HardEdge, f64)| length > SHOWS * f64::from(edge.weight);
    let mut shown: Vec<Shown> = all.filter(shows).map(|(e, length)| Shown { face: e.face, edge: e.edge, length }).collect();
    shown.sort_by_key(|e| e.face);
    shown
}

/// Their middles, as if drawn one after the other by how much they show.
fn drawn(shown: &[Shown], random: &mut Random) -> Vec<SurfacePoint> {
    let key = |e: &Shown| (-(1.0 - random.unit()).ln() / e.length, middle(e.face, e.edge));
    let mut points: Vec<(f64, SurfacePoint)> = shown.iter().map(key).collect();
    points.sort_by(|a, b| a.0.total_cmp(&b.0));
    points.into_iter().map(|(_, point)| point).collect()
}
