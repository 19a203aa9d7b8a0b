//! How much each paste agrees with what lies below where it fades: the correlation of their deviations from the exemplar's mean, over the
//! cells of its mask's grid that are neither clear nor opaque ([`contrast`](crate::paste::contrast)).
//!
//! What was pasted of another exemplar has another mean, so a paste that fades into one agrees by definition: it is laid over as ever.

use super::{Matcher, cells};
use crate::exemplar::CoverageMask;
use crate::mesh::Mesh;
use crate::paste::cut::Cut;
use crate::paste::lapped::{AGREES, LappedTexture};
use crate::paste::levels::Level;
use glam::Vec2;
use rayon::prelude::*;
use serde::Serialize;

/// Alphas between this and one less it are where a paste fades.
const FADED: f32 = 0.1;

/// What [`choose_agreements`] found.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct ContrastStatistics {
    /// Pastes that do not agree with what lies below wholly.
    pub kept: usize,
    /// The mean agreement of all pastes, 0 to 1.
    pub agreement: f64,
    /// Seconds.
    pub seconds: f64,
}

/// Gives each paste its agreement, once windows and cuts are chosen.
pub fn choose_agreements(mesh: &Mesh, lapped: &mut LappedTexture, masks: &[CoverageMask]) -> ContrastStatistics {
    let begin = std::time::Instant::now();
    let cuts: Vec<Option<Box<Cut>>> = lapped.pastes.iter().map(|p| p.cut.clone()).collect();
    let matcher = Matcher::new(mesh, lapped, masks, &[]);
    let means: Vec<Vec<f32>> = matcher.levels.iter().map(Level::mean).collect();
    let found: Vec<u8> = (0..cuts.len() as u32).into_par_iter().map(|k| matcher.agreement(k, &cuts, &means)).collect();
    lapped.pastes.iter_mut().zip(&found).for_each(|(paste, &agreement)| paste.agreement = agreement);
    let sum: f64 = found.iter().map(|&a| f64::from(a)).sum();
    ContrastStatistics {
        kept: found.iter().filter(|&&a| a != AGREES).count(),
        agreement: sum / f64::from(AGREES) / found.len().max(1) as f64,
        seconds: begin.elapsed().as_secs_f64(),
    }
}

impl Matcher<'_> {
    fn agreement(&self, k: u32, cuts: &[Option<Box<Cut>>], means: &[Vec<f32>]) -> u8 {
        let paste = &self.lapped.pastes[k as usize];
        let mask = &self.masks[paste.patch as usize];
        let exemplar = self.exemplar_of(k);
        let mean = &means[exemplar as usize];
        let size = Vec2::from(mask.size().map(|s| s as f32));
        let mut below = Vec::new();
        // Products of the deviations: below with below, with the paste's, and the paste's with themselves.
        let mut sums = [0.0_f64; 3];
        for (&face, uv) in paste.faces.iter().zip(&paste.uv) {
            let list = self.lists.of(face);
            let own = list.partition_point(|&(paste, _)| paste < k);
            for (cell, bary) in cells(uv) {
                let alpha = mask.alpha(cell * size) * paste.cut.as_deref().map_or(1.0, |cut| cut.alpha(cell, 0.0));
                if !(FADED..1.0 - FADED).contains(&alpha) {
                    continue;
                }
                if list[..own].iter().any(|&(other, _)| self.exemplar_of(other) != exemplar) {
                    return AGREES;
                }
                let covered = self.below(&list[..own], bary, cuts, &mut below)[0];
                if covered <= 0.5 {
                    continue;
                }
                for ((over, under), mean) in self.shown(k, list[own].1, bary).iter().zip(&below).zip(mean) {
                    let [over, under] = [over - mean, under / covered - mean].map(f64::from);
                    sums = [sums[0] + under * under, sums[1] + under * over, sums[2] + over * over];
                }
            }
        }
        let size = (sums[0] * sums[2]).sqrt();
        if size > 0.0 { ((sums[1] / size).clamp(0.0, 1.0) * f64::from(AGREES)).round() as u8 } else { AGREES }
    }

    fn exemplar_of(&self, paste: u32) -> u16 {
        self.lapped.patches[self.lapped.pastes[paste as usize].patch as usize].exemplar
    }
}
