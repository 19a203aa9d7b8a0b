//! From a model and exemplars to a record with pastes.
//!
//! 1. Clean the model into a mesh.
//! 2. Choose the scale, make the field, and cut the faces that are too large for it near its singularities.
//! 3. Cut texture patches from each exemplar.
//! 4. Paste; detail alone if it is to lie over a base.
//! 5. Bring the pastes back onto the model's own faces.

use super::base::{Base, of_mesh, of_vertices, split};
use super::bind::Outgoing;
use super::error::JobError;
use super::guide::{Guided, difficulty, guided};
use super::input::{ExemplarInput, PasteJob};
use super::patches::cut_patches;
use super::report::JobReport;
use crate::exemplar::{Exemplar, Image, TexturePatch};
use crate::field::Guide;
use crate::format::{Model, Record};
use crate::mesh::subdivide::Subdivision;
use crate::mesh::{Cleaned, Mesh, clean};
use crate::paste::draft::draft;
use crate::paste::{Finish, LappedTexture, Layer, PasteError, PasteStatistics, Seeding, cover};
use crate::progress::Progress;
use std::time::Instant;

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
    job.base.map_or(Ok(()), |base| base.check(model))?;
    progress.stage("cutting texture patches", 0);
    let mut warnings = Vec::new();
    let (mut exemplars, patches) = cut_patches(inputs, job, &mut warnings)?;
    let slow = job.base.map(|base| (base, split(&mut exemplars, &mut warnings)));
    let prepared = begin.elapsed().as_secs_f64();
    let mut laid = lay(&cleaned, exemplars, patches, job, progress)?;
    laid.report.prepare_seconds += prepared;
    warnings.append(&mut laid.report.warnings);
    laid.report.warnings = warnings;
    if let Some((base, slow)) = slow {
        progress.stage("smoothing the base", 0);
        laid.add_base(base, slow, model, &cleaned);
    }
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

    /// Lays its pastes, which are detail alone, over a base; `slow` is what [`split`] took out of each exemplar.
    pub fn add_base(&mut self, base: Base, slow: Vec<Image>, model: &Model, cleaned: &Cleaned) {
        let (mesh, out) = (self.mesh(cleaned), Outgoing::new(model, cleaned, self.fine.as_ref()));
        let painted = || of_vertices(&out.model, mesh, &out.faces);
        let base = of_mesh(base, (mesh, &self.guide), &self.lapped, slow, painted);
        let pastes = self.lapped.pastes.len() as u32;
        self.lapped.layers = vec![Layer { pastes, base, ..Layer::default() }];
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
                layers: out.layers(&lapped.layers),
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
