//! Lapped Textures: cover a mesh with overlapping pastes of texture patches.
//!
//! Based on: Praun, Finkelstein, Hoppe, "Lapped Textures", SIGGRAPH 2000.
//!
//! One paste goes through [`grow`] (a disc of faces over the texture patch), [`fit`] (aligned with the field),
//! [`coverage`] (what has become opaque); [`layout`] repeats that until everything is. Then [`audit`](mod@audit) looks
//! again, [`order`] sorts the pastes so that hard edges hide, [`overlay`] lays others over those that do not and
//! [`small`] smaller ones over what is left, [`prune`](mod@prune) leaves out those that the others make needless, [`window`] chooses what each of them shows and
//! [`seam`] where it ends, [`contrast`] how it fades, and what nobody can see is dropped. The result is a
//! [`LappedTexture`]; [`Composite`] shows it. [`draft`](mod@draft) shows at once what a change will bring.

pub mod audit;
mod base;
pub mod composite;
pub mod composite_backend;
pub mod contrast;
pub mod coverage;
pub mod coverage_backend;
pub mod cut;
pub mod draft;
mod error;
mod figures;
pub mod fit;
pub mod frame;
pub mod grow;
mod lapped;
pub mod lay;
pub mod layout;
mod levels;
mod options;
pub mod order;
pub mod overlay;
pub mod prune;
mod relief;
pub mod seam;
pub mod seed;
mod size;
pub mod small;
pub mod statistics;
pub mod stencil;
mod turn;
pub mod watch;
mod waves;
mod ways;
pub mod window;

pub use base::own_base;
pub use composite::Composite;
pub use composite_backend::{CompositeBackend, Compositing};
pub use coverage_backend::{Coverage, CoverageBackend};
pub use cut::Cut;
pub use error::PasteError;
pub use figures::{PasteStatistics, StageSeconds};
pub use fit::{IsotropicFit, Weights};
pub use grow::{Predictor, Stops};
pub use lapped::{AGREES, BaseColor, FaceLists, LappedTexture, Layer, Paste, base_color};
pub use layout::Seeding;
pub use options::{DISTORTION_DIRECTED, DISTORTION_ISOTROPIC, Finish, PasteOptions};
pub use seam::{ContrastStatistics, CutStatistics};
pub use size::PASTES_PER_COVER;
pub use statistics::SpreadSummary;
pub use turn::{TURNS, Turn};
pub use watch::Growth;

use crate::exemplar::symmetry::exemplar_symmetry;
use crate::exemplar::{CoverageMask, Exemplar, TexturePatch};
use crate::field::Guide;
use crate::mesh::Mesh;
use crate::progress::Progress;
use audit::audit;
use grow::PatchPlan;
use layout::{Layout, LayoutInput, Loop};
use order::{HardEdge, permute};
use overlay::lay_over_hard_edges;
use prune::prune;
use rayon::prelude::*;
use seam::{choose_agreements, choose_cuts, see_without_holes};
use size::{check, check_size, least_scale, mean_scale};
use small::Smaller;
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

/// Confidence from which an exemplar that seems to look the same every way may lie across the field. Photographs of pebbles, stones and
/// gravel have 0.33 to 0.73; a stone wall, whose courses show, has 0.
const SURE: f64 = 0.25;

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
    seed: u64,
    cull: bool,
    statistics: PasteStatistics,
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
    let overlays = options.hide_hard_edges && options.overlays;
    // Where there is a processor to spare it finds what overlays and windows ask of the exemplars later, and they remember.
    let look = || {
        if overlays {
            exemplars.par_iter().for_each(|e| drop(exemplar_symmetry(e)));
        }
    };
    let (laid, ()) = rayon::join(|| work.run(progress), look);
    laid?;
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
    let looks_same = |e: &Exemplar| exemplar_symmetry(e).is_some_and(|found| found.isotropic && found.confidence >= SURE);
    let loose: Vec<bool> = exemplars.iter().map(|e| overlays && (guide.field().is_none() || looks_same(e))).collect();
    if overlays {
        let loose: Vec<bool> = patches.iter().map(|p| loose[usize::from(p.exemplar)]).collect();
        statistics.overlays = lay_over_hard_edges(&mut work, &loose, options.seed, progress)?;
    }
    let smaller = if overlays && options.small { Smaller::new(&work, &masks) } else { None };
    if let Some(smaller) = &smaller {
        work = work.with(&smaller.patches, &smaller.plans, &smaller.masks);
        statistics.small = smaller.lay(&mut work, &loose, options.seed, progress)?;
    }
    let input = *work.input();
    let mut layout = work.finish();
    statistics.pastes_laid = layout.pastes.len();
    if options.prune {
        statistics.pruned = prune(&input, &mut layout, repairs);
    }
    let (patches, masks) = match smaller {
        Some(smaller) => smaller.used(patches.len(), &mut layout),
        None => (patches, masks),
    };
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
    Ok(Covered { lapped, seedings, edges, masks, pitch, scale, directed: guide.field().is_some(), seed, cull, statistics })
}

impl Covered {
    /// The second part of [`paste`], on the same mesh: chooses windows and cuts if asked to, and leaves out what nobody sees. With the
    /// result comes where each of its pastes began, so that its growth can be looked at ([`watch`]).
    #[must_use]
    pub fn finish(self, mesh: &Mesh, asked: Finish, progress: &dyn Progress) -> (LappedTexture, Vec<Seeding>, PasteStatistics) {
        let begin = Instant::now();
        let Self { mut lapped, mut seedings, mut edges, masks, pitch, scale, directed, seed, cull, mut statistics } = self;
        // Before culling: what lies hidden below tells how the texture goes on.
        let pitch = |f: u32| f64::from(pitch[f as usize]);
        if asked.windows {
            progress.stage("choosing windows", 0);
            let turns = turns(&lapped, directed);
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

/// How each exemplar may be turned under its masks. Under a direction nothing is turned: courses stay level and the light of a photographed
/// relief comes from one side. Without one every paste lies at a chance angle anyway.
fn turns(lapped: &LappedTexture, directed: bool) -> Vec<Turns> {
    let of = |(k, exemplar): (usize, &Exemplar)| {
        if directed || !lapped.patches.iter().any(|p| p.slides && p.exemplar as usize == k) {
            return Turns::None;
        }
        match exemplar_symmetry(exemplar) {
            Some(found) if found.isotropic => Turns::Any,
            Some(found) => Turns::Parts(found.n),
            None => Turns::None,
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
