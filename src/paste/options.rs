//! How to paste.

use super::coverage_backend::Coverage;
use super::fit::{IsotropicFit, Weights};
use super::grow::Predictor;
use super::lay::FitChoice;
use crate::exemplar::CoverageMask;
use crate::field::Guide;
use std::sync::Arc;

/// Default distortion bound for directed guides: above it pastes shear visibly at the poles of the field, below it their
/// number rises fast.
pub const DISTORTION_DIRECTED: f64 = 1.0;

/// Default distortion bound for isotropic guides, whose directions are only propagated.
pub const DISTORTION_ISOTROPIC: f64 = 1.4;

/// How to paste.
#[derive(Debug, Clone, PartialEq)]
pub struct PasteOptions {
    /// Seed of all random choices.
    pub seed: u64,
    /// Growth stops where the image of the tangential basis is further than this (Frobenius norm) from the texture's
    /// axes. `None` chooses by the guide.
    pub distortion: Option<f64>,
    /// How new vertices are placed.
    pub predictor: Predictor,
    /// Weights of faces in the fit.
    pub weights: Weights,
    /// How isotropic patches are fitted.
    pub isotropic_fit: IsotropicFit,
    /// Sort pastes so that hard edges lie at the bottom.
    pub hide_hard_edges: bool,
    /// Lay pastes over hard edges that show ([`overlay`](mod@super::overlay)), if they are hidden at all.
    pub overlays: bool,
    /// Lay smaller pastes over what still shows of them ([`small`](mod@super::small)), if overlays are laid.
    pub small: bool,
    /// Leave out pastes that the others make needless ([`prune`](mod@super::prune)).
    pub prune: bool,
    /// Remove faces that later pastes hide.
    pub cull: bool,
    /// Let each paste show the part of its exemplar that agrees best with what lies around it ([`window`](mod@super::window)).
    pub windows: bool,
    /// Let the border of each paste run where it shows least ([`seam`](mod@super::seam)).
    pub cuts: bool,
    /// Let transitions keep the contrast of what they mix ([`contrast`](mod@super::contrast)).
    pub contrast: bool,
    /// Where coverage is drawn.
    pub coverage: Coverage,
    /// Coverage masks of the texture patches, patch for patch, if they are there from an earlier time; else they are made.
    pub masks: Option<Arc<[CoverageMask]>>,
}

impl Default for PasteOptions {
    fn default() -> Self {
        Self {
            seed: 1,
            distortion: None,
            predictor: Predictor::default(),
            weights: Weights::default(),
            isotropic_fit: IsotropicFit::default(),
            hide_hard_edges: true,
            overlays: true,
            small: false,
            prune: true,
            cull: true,
            windows: true,
            cuts: true,
            contrast: false,
            coverage: Coverage::default(),
            masks: None,
        }
    }
}

impl PasteOptions {
    /// With nothing that the paper does not have, sorting apart: no windows, cuts, overlays, pruning and contrast kept.
    #[must_use]
    pub fn plain(self) -> Self {
        Self { overlays: false, small: false, prune: false, windows: false, cuts: false, contrast: false, ..self }
    }

    /// The distortion bound that holds for a guide, and for pastes that are free of its direction.
    #[must_use]
    pub fn distortion_for(&self, guide: &Guide, free: bool) -> f64 {
        let usual = if free || matches!(guide, Guide::Isotropic { .. }) { DISTORTION_ISOTROPIC } else { DISTORTION_DIRECTED };
        self.distortion.unwrap_or(usual)
    }

    /// What is done once everything is covered.
    #[must_use]
    pub const fn finish(&self) -> Finish {
        Finish { windows: self.windows, cuts: self.cuts, contrast: self.contrast }
    }

    pub(super) fn fit(&self) -> FitChoice {
        FitChoice { weights: self.weights, isotropic: self.isotropic_fit, once: false }
    }
}

/// What makes borders disappear, once everything is covered.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Finish {
    /// As [`PasteOptions::windows`].
    pub windows: bool,
    /// As [`PasteOptions::cuts`].
    pub cuts: bool,
    /// As [`PasteOptions::contrast`].
    pub contrast: bool,
}
