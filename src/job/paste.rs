//! From a model and exemplars to a record with pastes.
//!
//! 1. Clean the model into a mesh.
//! 2. Choose the scale, make the field, and cut the faces that are too large for it near its singularities.
//! 3. Cut texture patches from each exemplar.
//! 4. Paste.
//! 5. Bring the pastes back onto the model's own faces.

use super::bind::Outgoing;
use super::estimate::{Estimate, Work, in_words};
use crate::exemplar::extend::extend_exemplar;
use crate::exemplar::stack::tiles;
use crate::exemplar::symmetry::{Symmetry, exemplar_symmetry};
use crate::exemplar::{
    Channel, Exemplar, ExemplarError, PatchOptions, PatchSource, PatchSpec, TexturePatch, Wrap, make_patches, opacity_is_outline,
};
use crate::field::{
    self, Constraints, FieldError, FieldOptions, Guide, RefineOptions, RefineStatistics, TangentField, constrained_on,
    constrained_scale, default_scale, discontinuity, refine_near_singularities, up_on,
};
use crate::format::{Model, Record};
use crate::mesh::curvature::curvature;
use crate::mesh::subdivide::{Subdivision, cut_larger};
use crate::mesh::{CleanOptions, CleanReport, Cleaned, Mesh, MeshError, clean};
use crate::paste::draft::draft;
use crate::paste::{Finish, LappedTexture, PasteError, PasteOptions, PasteStatistics, Seeding, cover};
use crate::progress::{Progress, Silent};
use glam::DVec3;
use serde::Serialize;
use std::time::Instant;

/// How large the texture is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Scale {
    /// World length of one exemplar width.
    World(f64),
    /// So that the surface has this many times the first exemplar's area.
    Ratio(f64),
}

impl Default for Scale {
    fn default() -> Self {
        Self::Ratio(field::DEFAULT_RATIO)
    }
}

/// What steers the texture.
#[derive(Debug, Clone, PartialEq)]
pub enum Steer {
    /// An axis projected onto the surface.
    Up(DVec3),
    /// Constraints, with the axis they are measured against.
    Constraints(Constraints, DVec3),
    /// The smoothest field of so many ways, one of them at each face.
    Relaxed(u32),
    /// Along the direction in which the surface bends least.
    Curvature,
    /// No direction; constraints give the scale.
    Isotropic(Option<Constraints>),
    /// A field made for this model's mesh, as text.
    Field(String),
}

impl Default for Steer {
    fn default() -> Self {
        Self::Up(DVec3::Y)
    }
}

impl Steer {
    /// What an exemplar's own symmetry asks for, and the symmetry; the smoothest field where that cannot be told.
    #[must_use]
    pub fn by_exemplar(exemplar: &Exemplar) -> (Self, Option<Symmetry>) {
        let found = exemplar_symmetry(exemplar);
        (Self::by_symmetry(found.as_ref()), found)
    }

    /// What a symmetry asks for.
    #[must_use]
    pub fn by_symmetry(found: Option<&Symmetry>) -> Self {
        match found {
            None => Self::Relaxed(1),
            Some(found) if found.isotropic => Self::Isotropic(None),
            Some(found) => Self::Relaxed(found.n),
        }
    }
}

/// An exemplar and what to cut from it.
#[derive(Debug, Clone, PartialEq)]
pub struct ExemplarInput {
    /// The exemplar as read.
    pub exemplar: Exemplar,
    /// How often it is pasted, relative to the others.
    pub weight: f32,
    /// Shapes of its texture patches. Empty: its own transparency if it has any, else splotches.
    pub patches: Vec<PatchSpec>,
}

/// A job.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct PasteJob {
    /// How to clean the model.
    pub clean: CleanOptions,
    /// How large the texture is.
    pub scale: Scale,
    /// What steers it.
    pub steer: Steer,
    /// Leave large faces as they are.
    pub keep_faces: bool,
    /// Pixels over which alpha falls off at a patch's edge; `None` goes by each exemplar's size ([`default_feather`]).
    pub feather: Option<f32>,
    /// How else texture patches are cut; its feather is not used.
    pub patches: PatchOptions,
    /// How to paste.
    pub paste: PasteOptions,
    /// Memory the job may take, bytes; one that is estimated to take more is refused. `None` sets no bound.
    pub memory: Option<f64>,
}

/// Why a job ended without a result.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum JobError {
    /// The model.
    #[error(transparent)]
    Mesh(#[from] MeshError),
    /// An exemplar.
    #[error("{source}")]
    Exemplar {
        /// Its place among the exemplars given.
        index: usize,
        /// What is wrong.
        source: ExemplarError,
    },
    /// A scale that no number of the mesh's precision can hold.
    #[error("a scale of {0:e} (world length of one exemplar width) cannot be used: give a finite length above zero, like 0.5")]
    Scale(f64),
    /// A feather wider than the exemplar.
    #[error("a feather of {feather:e} pixels leaves nothing of an exemplar of {} x {}: give at most {most:.0}", size[0], size[1])]
    Feather {
        /// Pixels asked for.
        feather: f32,
        /// The exemplar's size.
        size: [u32; 2],
        /// Pixels that would do.
        most: f32,
    },
    /// The field.
    #[error(transparent)]
    Field(#[from] FieldError),
    /// Pasting.
    #[error(transparent)]
    Paste(#[from] PasteError),
    /// Where a region lies.
    #[error(transparent)]
    Area(#[from] super::area::AreaError),
    /// One of several regions.
    #[error("region {} ({name:?}): {source}", index + 1)]
    Region {
        /// Its place, from 0.
        index: usize,
        /// Its name.
        name: String,
        /// What is wrong.
        source: Box<JobError>,
    },
    /// More than the machine has.
    #[error(
        "this job takes about {} of memory ({faces} faces, {pastes:.0} pastes), but {} may be used: use a larger scale or a smaller \
         exemplar, split the mesh, or allow more with --memory", in_words(*needed), in_words(*limit)
    )]
    Memory {
        /// Estimated bytes.
        needed: f64,
        /// Bytes allowed.
        limit: f64,
        /// Faces of the mesh.
        faces: usize,
        /// Estimated pastes.
        pastes: f64,
    },
}

/// Figures of a job.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct JobReport {
    /// What cleaning did.
    pub clean: CleanReport,
    /// World length of one exemplar width, at relative scale 1.
    pub scale: f64,
    /// Surface area over the first exemplar's area.
    pub ratio: f64,
    /// What the job was thought to take.
    pub estimate: Estimate,
    /// Faces that took their direction from neighbours, because the axis says nothing there.
    pub filled_faces: usize,
    /// What subdivision near singularities did.
    pub refine: Option<RefineStatistics>,
    /// Texture patches.
    pub patches: usize,
    /// Figures of pasting.
    pub paste: PasteStatistics,
    /// Figures of each region, if there are several.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub regions: Vec<super::regions::RegionReport>,
    /// What the user should know, one sentence each.
    pub warnings: Vec<String>,
    /// Seconds of cleaning, field and patches (wall).
    pub prepare_seconds: f64,
}

/// A job done.
#[derive(Debug, Clone)]
pub struct Pasted {
    /// The user's model with the pastes on its faces, ready to be written.
    pub record: Record,
    /// The mesh that was worked on.
    pub mesh: Mesh,
    /// The lapped texture on that mesh.
    pub lapped: LappedTexture,
    /// What steered it.
    pub guide: Guide,
    /// Figures.
    pub report: JobReport,
}

/// Does a job.
///
/// # Errors
/// If the model is no mesh, an exemplar has no usable patch, the field or scale is unusable, or `progress` cancels.
pub fn paste_model(model: &Model, inputs: Vec<ExemplarInput>, job: &PasteJob, progress: &dyn Progress) -> Result<Pasted, JobError> {
    let begin = Instant::now();
    progress.stage("cleaning the mesh", 0);
    let cleaned = clean(&model.positions, &model.faces, &job.clean)?;
    progress.stage("cutting texture patches", 0);
    let mut warnings = Vec::new();
    let (exemplars, patches) = cut_patches(inputs, job, &mut warnings)?;
    let prepared = begin.elapsed().as_secs_f64();
    let mut laid = lay(&cleaned, exemplars, patches, job, progress)?;
    laid.report.prepare_seconds += prepared;
    warnings.append(&mut laid.report.warnings);
    laid.report.warnings = warnings;
    let record = laid.record(model, &cleaned);
    let mesh = laid.fine.map_or(cleaned.mesh, |f| f.mesh);
    Ok(Pasted { record, mesh, lapped: laid.lapped, guide: laid.guide, report: laid.report })
}

/// Pastes on a clean mesh, not yet brought back onto the model's faces.
#[derive(Debug, Clone)]
pub struct Laid {
    /// The subdivision of the clean mesh that was pasted on, if any face was cut.
    pub fine: Option<Subdivision>,
    /// The lapped texture on that mesh.
    pub lapped: LappedTexture,
    /// Where each of its pastes began.
    pub seedings: Vec<Seeding>,
    /// What steered it.
    pub guide: Guide,
    /// Figures.
    pub report: JobReport,
}

impl Laid {
    fn new(
        fine: Option<Subdivision>,
        guide: Guide,
        mut report: JobReport,
        (lapped, seedings, statistics): (LappedTexture, Vec<Seeding>, PasteStatistics),
    ) -> Self {
        report.warnings.extend(too_many_draws(&statistics));
        report.paste = statistics;
        Self { fine, lapped, seedings, guide, report }
    }

    /// The mesh that was pasted on.
    #[must_use]
    pub fn mesh<'a>(&'a self, cleaned: &'a Cleaned) -> &'a Mesh {
        self.fine.as_ref().map_or(&cleaned.mesh, |f| &f.mesh)
    }

    /// Where its pastes began, on another subdivision of the same clean mesh.
    fn seedings_on(&self, fine: Option<&Subdivision>) -> Vec<Seeding> {
        let moved = |seeding: &Seeding| {
            let at = self.fine.as_ref().map_or(seeding.at, |from| from.origin(seeding.at));
            Seeding { at: fine.map_or(at, |to| to.locate(at)), ..*seeding }
        };
        self.seedings.iter().map(moved).collect()
    }

    /// The model with the pastes on its faces, ready to be written; `cleaned` is what was pasted on.
    #[must_use]
    pub fn record(&self, model: &Model, cleaned: &Cleaned) -> Record {
        let out = Outgoing::new(model, cleaned, self.fine.as_ref());
        let Self { lapped, guide, .. } = self;
        Record {
            field: guide.field().map(|f| out.per_face(&f.up)),
            lapped: LappedTexture {
                pastes: out.pastes(&lapped.pastes),
                exemplars: lapped.exemplars.clone(),
                patches: lapped.patches.clone(),
                layers: Vec::new(),
            },
            model: out.model,
            source_face: out.source_face,
            generator: concat!("lapped ", env!("CARGO_PKG_VERSION")).to_owned(),
            job: serde_json::Value::Null,
            look: None,
        }
    }
}

/// The part of a job that is done again when only its size, field or method changes: steers and pastes on a mesh that is clean
/// with patches that are cut ([`cut_patches`]).
///
/// # Errors
/// If the field or scale is unusable, there are no patches, or `progress` cancels.
pub fn lay(
    cleaned: &Cleaned,
    exemplars: Vec<Exemplar>,
    patches: Vec<TexturePatch>,
    job: &PasteJob,
    progress: &dyn Progress,
) -> Result<Laid, JobError> {
    lay_with_draft(cleaned, exemplars, patches, job, progress, None)
}

/// How much a draft leaves out.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Draft {
    /// The pastes of before, laid again where they were ([`draft()`]): there may be holes. Figures are those of before.
    Again,
    /// The pastes that are to be, without windows and cuts.
    Uncut,
}

/// Who wants drafts.
pub struct Drafts<'a> {
    /// What is done with each.
    pub take: &'a mut dyn FnMut(Draft, Laid),
    /// What was laid on the same clean mesh before, if anything was.
    pub before: Option<&'a Laid>,
}

impl std::fmt::Debug for Drafts<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Drafts").field("before", &self.before.is_some()).finish_non_exhaustive()
    }
}

/// [`lay`] with drafts: at once with what was laid before, and once all pastes lie but windows and cuts are not chosen, if they are to be.
///
/// # Errors
/// As [`lay`].
pub fn lay_with_draft(
    cleaned: &Cleaned,
    exemplars: Vec<Exemplar>,
    patches: Vec<TexturePatch>,
    job: &PasteJob,
    progress: &dyn Progress,
    mut drafts: Option<Drafts<'_>>,
) -> Result<Laid, JobError> {
    let begin = Instant::now();
    progress.stage("making the field", 0);
    let Guided { fine, guide, mut report } = guided(cleaned, &exemplars, job)?;
    report.patches = patches.len();
    let mesh = fine.as_ref().map_or(&cleaned.mesh, |f| &f.mesh);
    if let Some(Drafts { take, before: Some(before) }) = &mut drafts {
        let seedings = before.seedings_on(fine.as_ref());
        if let Some((lapped, seedings)) = draft(mesh, &guide, exemplars.clone(), patches.clone(), &seedings, &job.paste)? {
            let report = JobReport { paste: before.report.paste.clone(), ..report.clone() };
            take(Draft::Again, Laid { fine: fine.clone(), lapped, seedings, guide: guide.clone(), report });
        }
    }
    let difficulty = difficulty(mesh, &guide);
    report.prepare_seconds = begin.elapsed().as_secs_f64();

    let covered = cover(mesh, &guide, exemplars, patches, &difficulty, &job.paste, progress)?;
    if let Some(Drafts { take, .. }) = drafts.filter(|_| job.paste.windows || job.paste.cuts) {
        let made = covered.clone().finish(mesh, Finish { windows: false, cuts: false, contrast: false }, progress);
        take(Draft::Uncut, Laid::new(fine.clone(), guide.clone(), report.clone(), made));
        if progress.cancelled() {
            return Err(PasteError::Cancelled.into());
        }
    }
    let made = covered.finish(mesh, job.paste.finish(), progress);
    Ok(Laid::new(fine, guide, report, made))
}

/// What steers a job, on the mesh that its pastes are laid on.
#[derive(Debug, Clone)]
pub struct Guided {
    /// The subdivision of the clean mesh that is pasted on, if any face was cut.
    pub fine: Option<Subdivision>,
    /// What steers.
    pub guide: Guide,
    /// Scale, field and estimate; nothing of pasting yet.
    pub report: JobReport,
}

/// The part of [`lay`] that needs no patches: the scale, the field, and the faces that are cut for both.
///
/// # Errors
/// If the field or scale is unusable, or the job would take more memory than it may.
pub fn guided(cleaned: &Cleaned, exemplars: &[Exemplar], job: &PasteJob) -> Result<Guided, JobError> {
    let mut report = JobReport { clean: cleaned.report.clone(), ..JobReport::default() };
    (report.scale, report.ratio) = scale_of(&cleaned.mesh, job, exemplars)?;
    let directed = !matches!(job.steer, Steer::Isotropic(_));
    report.estimate = Estimate::new(&Work::new(&cleaned.report, report.ratio, directed, job.paste.windows, exemplars));
    allow(&report.estimate, cleaned.report.faces, job.memory)?;
    let (fine, guide) = steer(cleaned, job, &mut report)?;
    Ok(Guided { fine, guide, report })
}

/// World length of one exemplar width, and the mesh's area in areas of the first exemplar.
pub(super) fn scale_of(mesh: &Mesh, job: &PasteJob, exemplars: &[Exemplar]) -> Result<(f64, f64), JobError> {
    let aspect = exemplars.first().map_or(1.0, |e| f64::from(e.size()[0]) / f64::from(e.size()[1]));
    let scale = match job.scale {
        Scale::World(length) => length,
        Scale::Ratio(ratio) => default_scale(mesh, ratio, aspect),
    };
    if !(scale as f32).is_normal() || scale < 0.0 {
        return Err(JobError::Scale(scale));
    }
    Ok((scale, mesh.total_area() * aspect / (scale * scale)))
}

/// Above this many pastes the scale is a mistake, and pasting itself says which one would do.
const ABSURD: f64 = 1e7;

/// Refuses what would not fit into the memory there is.
pub(super) fn allow(estimate: &Estimate, faces: usize, memory: Option<f64>) -> Result<(), JobError> {
    let &Estimate { memory_bytes: needed, pastes, .. } = estimate;
    match memory {
        Some(limit) if needed > limit && pastes < ABSURD => Err(JobError::Memory { needed, limit, faces, pastes }),
        _ => Ok(()),
    }
}

/// Exemplars with their colours extended under transparency, and the patches cut from them; what the user should know is added
/// to `warnings`.
///
/// # Errors
/// If an exemplar has no usable patch, or the feather is wider than it.
pub fn cut_patches(
    inputs: Vec<ExemplarInput>,
    job: &PasteJob,
    warnings: &mut Vec<String>,
) -> Result<(Vec<Exemplar>, Vec<TexturePatch>), JobError> {
    let (mut exemplars, mut patches) = (Vec::new(), Vec::new());
    for (index, mut input) in inputs.into_iter().enumerate() {
        let named = |source| JobError::Exemplar { index, source };
        extend_exemplar(&mut input.exemplar).map_err(named)?;
        let feather = job.feather.unwrap_or_else(|| default_feather(input.exemplar.size()));
        let size = input.exemplar.size();
        let most = size[0].min(size[1]) as f32 * WIDEST_FEATHER;
        if feather.is_finite() && feather > most.max(default_feather(size)) {
            return Err(JobError::Feather { feather, size, most });
        }
        if job.paste.windows && tiles(&input.exemplar) {
            input.exemplar.wrap = Wrap::Repeat;
        }
        // What tiles has every window as it is.
        let room = if job.paste.windows && input.exemplar.wrap == Wrap::Clamp { WINDOW_ROOM } else { job.patches.room };
        let options = PatchOptions { feather, room, ..job.patches.clone() };
        let default = [PatchSpec { source: default_source(&input.exemplar, feather), weight: 1.0 }];
        let specs = if input.patches.is_empty() { &default[..] } else { &input.patches[..] };
        let (cut, told) = make_patches(&input.exemplar, index as u16, specs, &options).map_err(named)?;
        warnings.extend(told);
        // As an outline opacity is in the masks; as a channel as well it would let the ground show at every border.
        if opacity_is_outline(&input.exemplar, feather) {
            input.exemplar.remove(Channel::Opacity);
        }
        let total: f32 = cut.iter().map(|p| p.weight).sum();
        patches.extend(cut.into_iter().map(|p| TexturePatch { weight: p.weight / total * input.weight, ..p }));
        exemplars.push(input.exemplar);
    }
    Ok((exemplars, patches))
}

/// The paper's 3 pixels were for images of about 200; on larger ones they cut like scissors.
const FEATHER_SHARE: f32 = 0.015;

/// Share of an exemplar's sides that splotches leave free for windows: a few courses of most textures, for a quarter more pastes.
const WINDOW_ROOM: f32 = 0.1;

/// A wider feather, as a share of the exemplar's smaller side, leaves no opaque middle.
const WIDEST_FEATHER: f32 = 0.4;

/// Pixels over which alpha falls off by default: 3, or 1.5 % of the exemplar's smaller side.
#[must_use]
pub fn default_feather(size: [u32; 2]) -> f32 {
    (size[0].min(size[1]) as f32 * FEATHER_SHARE).max(3.0)
}

/// Exemplars with transparent parts are their own outline; others get splotches, the shape whose seams show least on
/// textures of any kind.
fn default_source(exemplar: &Exemplar, feather: f32) -> PatchSource {
    if opacity_is_outline(exemplar, feather) { PatchSource::Whole } else { PatchSource::Splotch }
}

/// Exemplar areas on the surface beyond which no face is cut: pasting refuses such a job, and says why.
const MOST_TO_CUT: f64 = 1e6;

/// Larger faces than this share of an exemplar's area are cut: a texture patch then reaches over several.
const LARGEST_FACE: f64 = 0.25;

/// Makes a field on a subdivision of the mesh.
type Evaluate<'a> = dyn FnMut(&Subdivision) -> Result<TangentField, FieldError> + 'a;

/// The guide, on the mesh or on a subdivision of it.
///
/// Faces of more than [`LARGEST_FACE`] are cut first: all pastes on a face are looked at for every point of it, when covering
/// as when drawing. Then the faces around singularities of a field are.
pub(super) fn steer(cleaned: &Cleaned, job: &PasteJob, report: &mut JobReport) -> Result<(Option<Subdivision>, Guide), JobError> {
    let scale = report.scale;
    let tractable = cleaned.mesh.total_area() <= MOST_TO_CUT * scale * scale;
    let start = if job.keep_faces || !tractable { None } else { cut_larger(&cleaned.mesh, LARGEST_FACE * scale * scale)? };
    let mesh = start.as_ref().map_or(&cleaned.mesh, |s| &s.mesh);
    let anchors = |constraints: &Constraints, axis: DVec3| {
        let mut anchors = constraints.anchors(&cleaned.mesh, Some(&cleaned.user_faces), axis, scale)?;
        if let Some(start) = &start {
            anchors.iter_mut().for_each(|anchor| anchor.at = start.locate(anchor.at));
        }
        Ok::<_, FieldError>(anchors)
    };
    let options = |axis: DVec3, constraints: &Constraints| FieldOptions {
        scale,
        axis,
        base_weight: constraints.base_weight,
        ..FieldOptions::default()
    };
    let mut filled = 0;
    let mut evaluate: Box<Evaluate> = match &job.steer {
        Steer::Up(axis) => Box::new(|fine| {
            let (field, statistics) = up_on(mesh, fine, *axis, scale)?;
            filled = statistics.filled_faces;
            Ok(field)
        }),
        Steer::Constraints(constraints, axis) => {
            let axis = constraints.axis(*axis);
            let anchors = anchors(constraints, axis)?;
            let filled = &mut filled;
            Box::new(move |fine| {
                let (field, statistics) = constrained_on(mesh, fine, &anchors, &options(axis, constraints))?;
                *filled = statistics.filled_faces;
                Ok(field)
            })
        }
        Steer::Isotropic(constraints) => {
            let none = Constraints::default();
            let constraints = constraints.as_ref().unwrap_or(&none);
            let axis = constraints.axis(DVec3::Y);
            let (guide, _) = constrained_scale(mesh, &anchors(constraints, axis)?, &options(axis, constraints))?;
            return Ok((start, guide));
        }
        Steer::Field(text) => {
            let field = TangentField::from_json(&cleaned.mesh, text)?;
            let field = match &start {
                Some(start) => field.on(start),
                None => field,
            };
            return Ok((start, Guide::Directed(field)));
        }
        Steer::Relaxed(_) | Steer::Curvature => {
            let (up, _) = match job.steer {
                Steer::Relaxed(ways) => field::nway::relaxed(mesh, ways, scale, &Silent)?,
                _ => field::nway::along_curvature(mesh, scale, &Silent)?,
            };
            return Ok((start, Guide::Directed(up)));
        }
    };
    if job.keep_faces {
        let field = evaluate(&Subdivision::none(mesh))?;
        drop(evaluate);
        report.filled_faces = filled;
        return Ok((None, Guide::Directed(field)));
    }
    let refined = refine_near_singularities(mesh, &RefineOptions::default(), &mut evaluate)?;
    drop(evaluate);
    report.filled_faces = filled;
    report.refine = Some(refined.statistics);
    let fine = match start {
        Some(start) => start.then(refined.subdivision),
        None => refined.subdivision,
    };
    Ok((Some(fine), Guide::Directed(refined.field)))
}

/// Draws per point beyond which something could be better chosen: ordinary jobs have 1.5 to 4.
const MANY_DRAWS: f64 = 8.0;

/// A warning if points lie under very many pastes.
fn too_many_draws(statistics: &PasteStatistics) -> Option<String> {
    (statistics.draws_per_area > MANY_DRAWS).then(|| {
        format!(
            "a point lies under {:.0} pastes on the mean: the texture patches are thin or full of holes, or much wider than parts \
             of the mesh; choose more solid patches (--patch splotch) or a smaller texture (--scale)",
            statistics.draws_per_area
        )
    })
}

/// A patch that spans half an exemplar bends by this many radians where it is as hard to lay flat as can be told apart.
const HARDEST: f64 = std::f64::consts::FRAC_PI_2;

/// How hard a patch is to lay flat at each face, 0 to 1: by curvature or by the field's own turning (LT 3.3).
#[must_use]
pub fn difficulty(mesh: &Mesh, guide: &Guide) -> Vec<f32> {
    let bending = curvature(mesh).face_bending(mesh);
    let turning = discontinuity(mesh, guide);
    let one = |f: usize| {
        let bend = f64::from(bending[f]) * 0.5 * f64::from(guide.scale(f as u32)) / HARDEST;
        bend.max(f64::from(turning[f])).min(1.0) as f32
    };
    (0..mesh.face_count()).map(one).collect()
}
