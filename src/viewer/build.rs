//! From a project to what is shown of it: read, cut, steer, paste, and bring to the graphics device.
//!
//! Whatever did not change since the last time is taken from then: models and exemplars from the library, texture patches with
//! their images on the device from the [`Kitchen`].

use super::library::{Library, OpenError, OpenModel};
use crate::exemplar::{CoverageMask, Exemplar, Image, TexturePatch, equalize};
use crate::field::{Guide, TangentField};
use crate::format::{FormatError, Record};
use crate::job::project::{Direction, ProjectExemplar};
use crate::job::{Draft, Drafts, JobError, JobReport, Laid, Project, Steer, cut_patches, lay_with_draft, split};
use crate::mesh::Mesh;
use crate::paste::{LappedTexture, PasteError};
use crate::progress::Progress;
use crate::render::gpu::{Canvas, GpuError, PatchTextures, Path, Renderer, Subject};
use crate::render::normals::{corner_normals, crease_angle};
use crate::render::{DrawOptions, Stage};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};
use std::time::Instant;

/// Why there is nothing new to show.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum BuildError {
    /// Something cannot be opened.
    #[error(transparent)]
    Open(#[from] OpenError),
    /// A mask cannot be read.
    #[error(transparent)]
    Mask(#[from] FormatError),
    /// Pasting.
    #[error(transparent)]
    Job(#[from] JobError),
    /// The graphics device.
    #[error(transparent)]
    Gpu(#[from] GpuError),
}

impl BuildError {
    /// True if it was stopped because something newer was wanted.
    #[must_use]
    pub const fn is_cancelled(&self) -> bool {
        matches!(self, Self::Job(JobError::Paste(PasteError::Cancelled)))
    }
}

/// What is shown of a project.
#[derive(Debug)]
pub struct Shown {
    /// The document's revision that it was made for.
    pub revision: u64,
    /// What it leaves out, if it is a first answer.
    pub draft: Option<Draft>,
    /// The project as it was then.
    pub project: Project,
    /// The model.
    pub open: Arc<OpenModel>,
    /// The pastes, if there are exemplars.
    pub laid: Option<Laid>,
    /// The same on the graphics device.
    pub subject: Subject,
    /// Smooth normals at the corners of the faces.
    pub normals: Vec<[glam::Vec3; 3]>,
    /// What the user should know, one sentence each.
    pub told: Vec<String>,
    /// Seconds that it took.
    pub seconds: f64,
}

impl Shown {
    /// A number of its own for each answer: what was made of a draft is out of date once the whole is there.
    #[must_use]
    pub const fn number(&self) -> u64 {
        3 * self.revision
            + match self.draft {
                Some(Draft::Again) => 0,
                Some(Draft::Uncut) => 1,
                None => 2,
            }
    }

    /// The mesh that is drawn.
    #[must_use]
    pub fn mesh(&self) -> &Mesh {
        self.laid.as_ref().map_or(&self.open.cleaned.mesh, |laid| laid.mesh(&self.open.cleaned))
    }

    /// The lapped texture on it: pasted, or what the model came with.
    #[must_use]
    pub fn lapped(&self) -> Option<&LappedTexture> {
        self.laid.as_ref().map(|laid| &laid.lapped).or_else(|| self.open.own.as_ref().map(|own| &own.0))
    }

    /// The tangent field of the pastes.
    #[must_use]
    pub fn field(&self) -> Option<&TangentField> {
        match &self.laid {
            Some(laid) => laid.guide.field(),
            None => self.open.own.as_ref().and_then(|own| own.1.as_ref()),
        }
    }

    /// What steered the pastes.
    #[must_use]
    pub fn guide(&self) -> Option<Guide> {
        match &self.laid {
            Some(laid) => Some(laid.guide.clone()),
            None => self.field().cloned().map(Guide::Directed),
        }
    }

    /// Figures of pasting.
    #[must_use]
    pub fn report(&self) -> Option<&JobReport> {
        self.laid.as_ref().map(|laid| &laid.report)
    }

    /// The model with its pastes, ready to be written.
    #[must_use]
    pub fn record(&self) -> Option<Record> {
        let project = serde_json::to_value(&self.project).unwrap_or_default();
        self.laid.as_ref().map(|laid| Record { job: project, ..laid.record(&self.open.model, &self.open.cleaned) })
    }
}

/// What texture patches were cut by.
#[derive(Debug, Clone, PartialEq)]
struct Recipe {
    exemplars: Vec<ProjectExemplar>,
    feather: Option<f32>,
    splotches: u32,
    seed: u64,
    windows: bool,
    equalize: bool,
    /// Without what is slow in them.
    detail: bool,
}

/// Texture patches, ready.
#[derive(Debug)]
struct Cut {
    recipe: Recipe,
    exemplars: Vec<Exemplar>,
    /// What was taken out of each, if only their detail is left.
    slow: Vec<Image>,
    patches: Vec<TexturePatch>,
    masks: Arc<[CoverageMask]>,
    warnings: Vec<String>,
    textures: Arc<PatchTextures>,
    /// What the first exemplar's own symmetry asks for, once somebody wants to know.
    own_steer: OnceLock<Steer>,
}

/// What is kept from one building to the next.
#[derive(Debug, Default)]
pub struct Kitchen {
    cut: Mutex<Option<Arc<Cut>>>,
}

impl Kitchen {
    fn cut(&self, project: &Project, library: &Library, renderer: &Renderer) -> Result<Arc<Cut>, BuildError> {
        let recipe = Recipe {
            exemplars: project.exemplars.clone(),
            feather: project.feather,
            splotches: project.splotches,
            seed: project.seed,
            windows: project.windows,
            equalize: project.equalize,
            detail: project.base.is_some(),
        };
        let mut kept = self.cut.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(cut) = kept.as_ref().filter(|cut| cut.recipe == recipe) {
            return Ok(Arc::clone(cut));
        }
        let mut warnings = Vec::new();
        let mut inputs = Vec::new();
        for wanted in &project.exemplars {
            let read = library.exemplar(&wanted.link)?;
            warnings.extend(read.told.iter().cloned());
            let mut exemplar = read.exemplar.clone();
            if project.equalize {
                let (done, cost) = equalize(&mut exemplar).told();
                warnings.extend([Some(done), cost].into_iter().flatten().map(|text| format!("{}: {text}", exemplar.name)));
            }
            inputs.push(wanted.input(exemplar)?);
        }
        let (mut exemplars, patches) = cut_patches(inputs, &project.job(None), &mut warnings)?;
        let slow = if project.base.is_some() { split(&mut exemplars, &mut warnings) } else { Vec::new() };
        let textures = Arc::new(renderer.load_patches(&exemplars, &patches)?);
        warnings.extend(textures.warnings().iter().cloned());
        let masks = patches.iter().map(CoverageMask::new).collect();
        let own_steer = OnceLock::new();
        let cut = Arc::new(Cut { recipe, exemplars, slow, patches, masks, warnings, textures, own_steer });
        *kept = Some(Arc::clone(&cut));
        Ok(cut)
    }
}

/// First answers soon after a change.
pub struct FirstAnswers<'a> {
    /// What is shown now, if anything is: it makes the first answer come sooner.
    pub before: Option<&'a Shown>,
    /// Gets each ([`Draft`]).
    pub take: &'a dyn Fn(Shown),
}

impl std::fmt::Debug for FirstAnswers<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("FirstAnswers").field("before", &self.before).finish_non_exhaustive()
    }
}

/// Builds what is to be shown of a project that has a model, the whole after first answers.
///
/// # Errors
/// If anything it names cannot be read, it cannot be pasted, or does not fit the device.
pub fn build(
    project: &Project,
    revision: u64,
    kitchen: &Kitchen,
    library: &Library,
    renderer: &Renderer,
    progress: &dyn Progress,
    first: FirstAnswers<'_>,
) -> Result<Option<Shown>, BuildError> {
    let begin = Instant::now();
    let Some(link) = &project.model else { return Ok(None) };
    progress.stage("reading the model", 0);
    let open = library.model(link)?;
    let shown = |mut laid: Option<Laid>, cut: Option<&Cut>, draft: Option<Draft>| -> Result<Shown, BuildError> {
        progress.stage("preparing the picture", 0);
        if let (Some(laid), Some(cut), Some(base)) = (&mut laid, cut, project.base) {
            laid.add_base(base, cut.slow.clone(), &open.model, &open.cleaned);
        }
        let mesh = laid.as_ref().map_or(&open.cleaned.mesh, |laid| laid.mesh(&open.cleaned));
        let stage = Stage::new(mesh, &DrawOptions::default());
        let nothing = LappedTexture::default();
        let subject = match (&laid, cut) {
            (Some(laid), Some(cut)) if laid.lapped.patches.len() == cut.patches.len() => {
                renderer.load_with(&stage, &laid.lapped, None, Arc::clone(&cut.textures))?
            }
            // With smaller patches beside those that were cut.
            (Some(laid), Some(_)) => renderer.load(&stage, &laid.lapped)?,
            _ => renderer.load(&stage, open.own.as_ref().map_or(&nothing, |own| &own.0))?,
        };
        // Its shaders are made here, not when a pane first draws it paste by paste.
        drop(Canvas::new(renderer, &subject, [1, 1], Path::Layered));
        let mut told = open.model.source.notes.clone();
        told.extend(cut.into_iter().flat_map(|cut| &cut.warnings).chain(laid.iter().flat_map(|l| &l.report.warnings)).cloned());
        let (project, open, normals) = (project.clone(), Arc::clone(&open), stage.normals().to_vec());
        let seconds = begin.elapsed().as_secs_f64();
        Ok(Shown { revision, draft, project, open, laid, subject, normals, told, seconds })
    };
    if project.exemplars.is_empty() {
        return shown(None, None, None).map(Some);
    }
    project.base.map_or(Ok(()), |base| base.check(&open.model))?;
    progress.stage("cutting texture patches", 0);
    let cut = kitchen.cut(project, library, renderer)?;
    let mut job = project.job(None);
    if project.direction == Direction::Auto {
        job.steer = cut.own_steer.get_or_init(|| project.job(cut.exemplars.first()).steer).clone();
    }
    job.memory = crate::job::available_memory();
    job.paste.masks = Some(Arc::clone(&cut.masks));
    let mut failed = None;
    let mut take = |draft, laid| match shown(Some(laid), Some(&cut), Some(draft)) {
        Ok(draft) => (first.take)(draft),
        Err(error) => failed = Some(error),
    };
    let before = first.before.filter(|before| Arc::ptr_eq(&before.open, &open)).and_then(|before| before.laid.as_ref());
    let drafts = Drafts { take: &mut take, before };
    let laid = lay_with_draft(&open.cleaned, cut.exemplars.clone(), cut.patches.clone(), &job, progress, Some(drafts))?;
    match failed {
        Some(error) => Err(error),
        None => shown(Some(laid), Some(&cut), None).map(Some),
    }
}

/// Smooth normals at the corners of a mesh, as pictures of it have them.
#[must_use]
pub fn smooth_normals(mesh: &Mesh) -> Vec<[glam::Vec3; 3]> {
    corner_normals(mesh, crease_angle(mesh))
}
