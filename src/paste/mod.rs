//! Lapped Textures: cover a mesh with overlapping pastes of texture patches.
//!
//! Based on: Praun, Finkelstein, Hoppe, "Lapped Textures", SIGGRAPH 2000.
//!
//! One paste goes through [`grow`] (a disc of faces over the texture patch), [`fit`] (aligned with the field),
//! [`coverage`] (what has become opaque); [`layout`] repeats that until everything is. Then [`audit`](mod@audit) looks
//! again, [`order`] sorts the pastes so that hard edges hide, [`overlay`] lays others over those that do not,
//! [`prune`](mod@prune) leaves out those that the others make needless, [`window`] chooses what each of them shows and
//! [`seam`] where it ends, [`contrast`] how it fades, and what nobody can see is dropped. The result is a
//! [`LappedTexture`]; [`Composite`] shows it. [`draft`](mod@draft) shows at once what a change will bring.

pub mod audit;
pub mod composite;
pub mod composite_backend;
pub mod contrast;
pub mod coverage;
pub mod coverage_backend;
pub mod cut;
pub mod draft;
pub mod fit;
pub mod frame;
pub mod grow;
mod lapped;
pub mod lay;
pub mod layout;
mod levels;
pub mod order;
pub mod overlay;
pub mod prune;
mod relief;
pub mod seam;
pub mod seed;
pub mod statistics;
pub mod stencil;
mod turn;
pub mod watch;
mod ways;
pub mod window;

pub use composite::Composite;
pub use composite_backend::{CompositeBackend, Compositing};
pub use coverage_backend::{Coverage, CoverageBackend};
pub use cut::Cut;
pub use fit::{IsotropicFit, Weights};
pub use grow::{Predictor, Stops};
pub use lapped::{AGREES, FaceLists, LappedTexture, Layer, Paste};
pub use layout::Seeding;
pub use seam::{ContrastStatistics, CutStatistics};
pub use statistics::SpreadSummary;
pub use turn::{TURNS, Turn};
pub use watch::Growth;

use crate::exemplar::symmetry::{exemplar_symmetry, looks_same_every_way};
use crate::exemplar::{CoverageMask, Exemplar, TexturePatch};
use crate::field::Guide;
use crate::mesh::Mesh;
use crate::progress::Progress;
use audit::audit;
use frame::singular_values;
use glam::DMat2;
use grow::PatchPlan;
use layout::{Layout, LayoutInput, Loop};
use order::{HardEdge, permute};
use overlay::lay_over_hard_edges;
use prune::prune;
use rayon::prelude::*;
use seam::{choose_agreements, choose_cuts, see_without_holes};
use serde::Serialize;
use std::sync::Arc;
use std::time::Instant;
use ways::Turns;
use window::choose_windows;
pub use window::{FINEST_WINDOW, WindowStatistics};

/// Width of a coverage cell in texels. Cells keep the least alpha within them, so they may be coarser than texels: at 2
/// the loop looks at a quarter of the texels and needs about 2 % more pastes.
const CELL_TEXELS: f64 = 2.0;

/// Width of a cell of the final audit in texels.
const AUDIT_TEXELS: f64 = 1.0;

/// Rounds of repairing what the audit found.
const REPAIRS: usize = 4;

/// Default distortion bound for directed guides: above it pastes shear visibly at the poles of the field, below it their
/// number rises fast.
pub const DISTORTION_DIRECTED: f64 = 1.0;

/// Default distortion bound for isotropic guides, whose directions are only propagated.
pub const DISTORTION_ISOTROPIC: f64 = 1.4;

/// Opaque areas of pastes laid per area of surface: what random seeding takes until nothing is left.
pub const PASTES_PER_COVER: f64 = 2.3;

/// More pastes than this are refused: the scale is surely a mistake.
const MAX_PASTES: f64 = 4e6;

/// More coverage cells than this are refused.
const MAX_CELLS: f64 = 4e9;

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
    /// Lay pastes over hard edges that show ([`overlay`]), if they are hidden at all.
    pub overlays: bool,
    /// Leave out pastes that the others make needless ([`prune`](mod@prune)).
    pub prune: bool,
    /// Remove faces that later pastes hide.
    pub cull: bool,
    /// Let each paste show the part of its exemplar that agrees best with what lies around it ([`window`]).
    pub windows: bool,
    /// Let the border of each paste run where it shows least ([`seam`]).
    pub cuts: bool,
    /// Let transitions keep the contrast of what they mix ([`contrast`]).
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
        Self { overlays: false, prune: false, windows: false, cuts: false, contrast: false, ..self }
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

    fn fit(&self) -> lay::FitChoice {
        lay::FitChoice { weights: self.weights, isotropic: self.isotropic_fit, once: false }
    }
}

/// Why pasting ended without a result.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PasteError {
    /// Nothing to paste.
    #[error("there is no texture patch to paste: give at least one exemplar")]
    NoPatches,
    /// More patches than a record can name.
    #[error("there are {0} texture patches; a record can name {max}", max = u16::MAX)]
    TooManyPatches(usize),
    /// The guide belongs to another mesh.
    #[error("the field has {found} faces, the mesh {expected}: it was made for another mesh")]
    GuideSize {
        /// Faces of the guide.
        found: usize,
        /// Faces of the mesh.
        expected: usize,
    },
    /// The field has no usable basis at a face.
    #[error("the tangent field vanishes or turns inside out at face {face}: give it a direction there")]
    NoBasis {
        /// The face.
        face: u32,
    },
    /// The job is far too large for its scale.
    #[error(
        "at a scale of {scale:.3e} (world length of one exemplar width) this surface takes about {pastes:.1e} pastes and \
         {cells:.1e} coverage samples: use a scale of at least {usable:.3e}"
    )]
    ScaleTooSmall {
        /// Mean scale.
        scale: f64,
        /// Pastes estimated.
        pastes: f64,
        /// Samples estimated.
        cells: f64,
        /// A scale that would do.
        usable: f64,
    },
    /// The scale dwarfs the mesh.
    #[error(
        "a scale of {scale:.3e} (world length of one exemplar width) is {times:.0e} times the size of the mesh, which would \
         show a single texel: use one below {usable:.3e}"
    )]
    ScaleTooLarge {
        /// Mean scale.
        scale: f64,
        /// Relative to the mesh.
        times: f64,
        /// A scale that would do.
        usable: f64,
    },
    /// The distortion bound is no bound.
    #[error("the distortion bound is {0}: give a number above zero (1 is usual)")]
    Distortion(f64),
    /// Something else was to draw coverage, and cannot.
    #[error("{0}: or let the processor draw coverage (--coverage cpu)")]
    Coverage(String),
    /// The progress sink asked to stop.
    #[error("pasting was cancelled")]
    Cancelled,
}

/// A scale above this many bounding box diagonals is refused.
const MAX_SCALE: f64 = 1e4;

/// Figures of a run.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct PasteStatistics {
    /// Pastes in the record.
    pub pastes: usize,
    /// Pastes laid; the difference was pruned or hidden completely.
    pub pastes_laid: usize,
    /// Faces of all surface patches together, as grown.
    pub grown_faces: u64,
    /// Draws per face before culling: mean over faces.
    pub draws_before_cull: f64,
    /// Draws per face in the record: mean over faces.
    pub draws_per_face: f64,
    /// The same, mean over the surface's area.
    pub draws_per_area: f64,
    /// Conjugate gradient iterations per fit.
    pub iterations_per_fit: f64,
    /// Share of pastes that grew again after a fit.
    pub regrowths_per_paste: f64,
    /// Seeds whose texture patch was too thin to cover a coverage cell.
    pub forced_seeds: u64,
    /// Coverage samples.
    pub coverage_samples: u64,
    /// Points of the final audit.
    pub audit_samples: u64,
    /// The least composite alpha it found.
    pub least_alpha: f32,
    /// Pastes laid for holes it found.
    pub repairs: usize,
    /// Pastes laid over hard edges that showed.
    pub overlays: usize,
    /// Pastes left out because the others cover all they did.
    pub pruned: usize,
    /// Pastes with a hard edge.
    pub pastes_with_hard_edges: u64,
    /// World length of all hard edges, weighted by alpha.
    pub hard_edge_length: f64,
    /// World length of hard edges that show, weighted by their alpha and by what lies over them.
    pub visible_hard_edge_length: f64,
    /// The same, divided by mean exemplar width, per exemplar area of surface.
    pub visible_hard_edges_per_exemplar: f64,
    /// Why growth stopped inside the hull, in edges.
    pub stops: Stops,
    /// How the fitted faces deviate from the field.
    pub deviation: SpreadSummary,
    /// Windows chosen, and how much better borders agree.
    pub windows: WindowStatistics,
    /// Pastes cut, and how much less borders show.
    pub cuts: CutStatistics,
    /// How far pastes agree with what lies below, if contrast is kept.
    pub contrast: ContrastStatistics,
    /// Seconds per stage.
    pub seconds: StageSeconds,
}

/// Seconds per stage. Growing, fitting and covering run on several threads: their seconds are summed over threads.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct StageSeconds {
    /// Masks, lattices, tables (wall).
    pub prepare: f64,
    /// Growing and fitting (all threads).
    pub lay: f64,
    /// Coverage and recording (all threads).
    pub cover: f64,
    /// The whole loop (wall).
    pub pasting: f64,
    /// The audit and its repairs (wall).
    pub audit: f64,
    /// Ordering and culling (wall).
    pub order_and_cull: f64,
    /// All of it (wall).
    pub total: f64,
}

/// Covers a mesh. `difficulty` says per face, 0 to 1, how hard a patch is to lay flat there (empty: nowhere).
///
/// # Errors
/// If there is nothing to paste, the guide does not fit the mesh, the scale is absurd, or the sink cancels.
pub fn paste(
    mesh: &Mesh,
    guide: &Guide,
    exemplars: Vec<Exemplar>,
    patches: Vec<TexturePatch>,
    difficulty: &[f32],
    options: &PasteOptions,
    progress: &dyn Progress,
) -> Result<(LappedTexture, PasteStatistics), PasteError> {
    let covered = cover(mesh, guide, exemplars, patches, difficulty, options, progress)?;
    let (lapped, _, statistics) = covered.finish(mesh, options.finish(), progress);
    Ok((lapped, statistics))
}

/// A mesh that is covered: the pastes in paint order, each whole and as its patch was cut. [`finish`](Self::finish) makes the result
/// of them; that is quick without windows, which can be chosen later from the same.
#[derive(Debug, Clone)]
pub struct Covered {
    lapped: LappedTexture,
    seedings: Vec<Seeding>,
    edges: Vec<Vec<HardEdge>>,
    masks: Arc<[CoverageMask]>,
    /// Width of a coverage cell by face, world units.
    pitch: Vec<f32>,
    /// Mean scale.
    scale: f64,
    /// The guide has a direction.
    directed: bool,
    /// Which exemplars look the same every way, if that was asked.
    same: Vec<Option<bool>>,
    seed: u64,
    cull: bool,
    statistics: PasteStatistics,
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

/// The first part of [`paste`]: lays pastes until nothing shows through, and sorts them. `options.windows`, `options.cuts` and
/// `options.contrast` are not looked at.
///
/// # Errors
/// As [`paste`].
pub fn cover(
    mesh: &Mesh,
    guide: &Guide,
    exemplars: Vec<Exemplar>,
    patches: Vec<TexturePatch>,
    difficulty: &[f32],
    options: &PasteOptions,
    progress: &dyn Progress,
) -> Result<Covered, PasteError> {
    let begin = Instant::now();
    check(mesh, guide, &patches, options)?;
    let width = |p: &TexturePatch| exemplars[p.exemplar as usize].size()[0];
    let plans: Vec<PatchPlan> = patches.iter().map(|p| PatchPlan::new(p, width(p))).collect();
    let kept = options.masks.clone().filter(|kept| kept.len() == patches.len());
    let masks = kept.unwrap_or_else(|| patches.iter().map(CoverageMask::new).collect());
    let texels = f64::from(patches.iter().map(width).max().unwrap_or(1));
    let texel: Vec<f32> =
        (0..mesh.face_count() as u32).into_par_iter().map(|f| (least_scale(mesh, guide, f) / texels) as f32).collect();
    check_size(mesh, guide, &texel, &patches, &plans, texels)?;
    let pitch: Vec<f32> = texel.iter().map(|t| t * CELL_TEXELS as f32).collect();
    let none = vec![0.0; if difficulty.is_empty() { mesh.face_count() } else { 0 }];
    let drawer = options.coverage.0.as_ref().map(|b| b.prepare(&masks)).transpose().map_err(PasteError::Coverage)?;
    let mut work = Loop::new(LayoutInput {
        mesh,
        guide,
        patches: &patches,
        plans: &plans,
        masks: &masks,
        pitch: &pitch,
        difficulty: if difficulty.is_empty() { &none } else { difficulty },
        distortion: [false, true].map(|free| options.distortion_for(guide, free)),
        predictor: options.predictor,
        fit: options.fit(),
        seed: options.seed,
        drawer: drawer.as_deref(),
    });
    let mut statistics = PasteStatistics::default();
    statistics.seconds.prepare = begin.elapsed().as_secs_f64();

    let start = Instant::now();
    work.run(progress)?;
    statistics.seconds.pasting = start.elapsed().as_secs_f64();

    let start = Instant::now();
    progress.stage("checking coverage", 0);
    for round in 0..=REPAIRS {
        let found = audit(mesh, &patches, &masks, work.pastes(), &|f| f64::from(texel[f as usize]) * AUDIT_TEXELS);
        statistics.audit_samples = found.samples;
        statistics.least_alpha = found.least_alpha;
        if found.holes.is_empty() || round == REPAIRS {
            break;
        }
        statistics.repairs += found.holes.len();
        work.patch_up(&found.holes)?;
    }
    let repairs = (work.pastes().len() - statistics.repairs) as u32..work.pastes().len() as u32;
    statistics.seconds.audit = start.elapsed().as_secs_f64();

    let start = Instant::now();
    progress.stage("ordering and culling", 0);
    if options.hide_hard_edges {
        work.sort_by_hard_edges();
    }
    let overlays = options.hide_hard_edges && options.overlays;
    let same: Vec<Option<bool>> = exemplars.par_iter().map(|e| overlays.then(|| looks_same_every_way(e))).collect();
    if overlays {
        let loose: Vec<bool> = patches.iter().map(|p| guide.field().is_none() || same[p.exemplar as usize] == Some(true)).collect();
        statistics.overlays = lay_over_hard_edges(&mut work, &loose, options.seed, progress)?;
    }
    let input = *work.input();
    let mut layout = work.finish();
    statistics.pastes_laid = layout.pastes.len();
    if options.prune {
        statistics.pruned = prune(&input, &mut layout, repairs);
    }
    let Layout { pastes, seedings, edges, totals } = layout;
    statistics.draws_before_cull = draws(mesh, &pastes).0;
    statistics.grown_faces = totals.grown_faces;
    statistics.iterations_per_fit = totals.iterations as f64 / (statistics.pastes_laid as f64 + totals.regrowths as f64);
    statistics.regrowths_per_paste = totals.regrowths as f64 / statistics.pastes_laid as f64;
    statistics.forced_seeds = totals.forced;
    statistics.coverage_samples = totals.samples;
    statistics.pastes_with_hard_edges = totals.pastes_with_hard_edges;
    statistics.stops = totals.stops;
    statistics.deviation = totals.spread.summary();
    statistics.seconds.lay = totals.lay_seconds;
    statistics.seconds.cover = totals.cover_seconds;
    statistics.seconds.order_and_cull = start.elapsed().as_secs_f64();
    statistics.seconds.total = begin.elapsed().as_secs_f64();
    let lapped = LappedTexture { exemplars, patches, pastes, layers: Vec::new() };
    let (scale, seed, cull) = (mean_scale(mesh, guide), options.seed, options.cull);
    Ok(Covered { lapped, seedings, edges, masks, pitch, scale, directed: guide.field().is_some(), same, seed, cull, statistics })
}

impl Covered {
    /// The second part of [`paste`], on the same mesh: chooses windows and cuts if asked to, and leaves out what nobody sees. With the
    /// result comes where each of its pastes began, so that its growth can be looked at ([`watch`]).
    #[must_use]
    pub fn finish(self, mesh: &Mesh, asked: Finish, progress: &dyn Progress) -> (LappedTexture, Vec<Seeding>, PasteStatistics) {
        let begin = Instant::now();
        let Self { mut lapped, mut seedings, mut edges, masks, pitch, scale, directed, same, seed, cull, mut statistics } = self;
        // Before culling: what lies hidden below tells how the texture goes on.
        let pitch = |f: u32| f64::from(pitch[f as usize]);
        if asked.windows {
            progress.stage("choosing windows", 0);
            let turns = turns(&lapped, &same, directed);
            statistics.windows = choose_windows(mesh.face_count(), &mut lapped, &turns, seed);
        }
        if asked.cuts {
            progress.stage("cutting borders", 0);
            statistics.cuts = choose_cuts(mesh, &mut lapped, &masks, &edges);
        }
        let lists = FaceLists::new(mesh.face_count(), &lapped.pastes);
        let (seen, whole) = see_without_holes(mesh, &mut lapped, &lists, &masks, &pitch, cull);
        statistics.cuts.given_up = whole;
        let left = order::cull(&mut lapped, &seen);
        if asked.contrast {
            statistics.contrast = choose_agreements(mesh, &mut lapped, &masks);
        }
        edges = permute(edges, &left);
        seedings = permute(seedings, &left);
        let lists = FaceLists::new(mesh.face_count(), &lapped.pastes);
        statistics.visible_hard_edge_length =
            order::visible_edges(mesh, &lapped.patches, &lapped.pastes, &lists, &edges).iter().flatten().sum();
        statistics.hard_edge_length = edges.iter().flatten().map(|e| f64::from(e.weight)).sum();
        let squares = mesh.total_area() / (scale * scale);
        statistics.visible_hard_edges_per_exemplar = statistics.visible_hard_edge_length / scale / squares;
        statistics.pastes = lapped.pastes.len();
        (statistics.draws_per_face, statistics.draws_per_area) = draws(mesh, &lapped.pastes);
        let seconds = begin.elapsed().as_secs_f64();
        statistics.seconds.order_and_cull += seconds;
        statistics.seconds.total += seconds;
        (lapped, seedings, statistics)
    }
}

/// How each exemplar may be turned under its masks. Those that look the `same` every way are turned only if nothing gives them a direction:
/// a photograph's light then lies as it was told to.
fn turns(lapped: &LappedTexture, same: &[Option<bool>], directed: bool) -> Vec<Turns> {
    let of = |(k, exemplar): (usize, &Exemplar)| {
        if !lapped.patches.iter().any(|p| p.slides && p.exemplar as usize == k) {
            return Turns::None;
        }
        match (same[k].unwrap_or_else(|| looks_same_every_way(exemplar)), directed) {
            (true, true) => Turns::None,
            (true, false) => Turns::Any,
            _ => exemplar_symmetry(exemplar).map_or(Turns::None, |found| Turns::Parts(found.n)),
        }
    };
    lapped.exemplars.par_iter().enumerate().map(of).collect()
}

/// Mean draws per face, and per area.
fn draws(mesh: &Mesh, pastes: &[Paste]) -> (f64, f64) {
    let (mut count, mut area) = (0_usize, 0.0);
    for paste in pastes {
        count += paste.faces.len();
        area += paste.faces.iter().map(|&f| mesh.area(f)).sum::<f64>();
    }
    (count as f64 / mesh.face_count() as f64, area / mesh.total_area())
}

/// World length of one exemplar width at a face, in the direction where it is least.
fn least_scale(mesh: &Mesh, guide: &Guide, face: u32) -> f64 {
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
fn mean_scale(mesh: &Mesh, guide: &Guide) -> f64 {
    let sum: f64 = (0..mesh.face_count() as u32).map(|f| mesh.area(f) * f64::from(guide.scale(f))).sum();
    sum / mesh.total_area()
}

fn check(mesh: &Mesh, guide: &Guide, patches: &[TexturePatch], options: &PasteOptions) -> Result<(), PasteError> {
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
fn opaque_pixels(patch: &TexturePatch) -> f64 {
    patch.mask.finest().data().iter().filter(|&&a| a >= 0.5).count() as f64
}

/// Refuses scales at which the job would never end, or show nothing.
fn check_size(
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
