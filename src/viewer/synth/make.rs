//! One synthesis: from what is shown to a vertex texture on the graphics device.

use super::{Figures, Method};
use crate::exemplar::{Channel, Exemplar};
use crate::field::{DEFAULT_RATIO, default_scale};
use crate::job::round::{RoundJob, RoundJobError, march, synthesize_marched};
use crate::job::synth::{SynthJob, SynthJobError, synthesize_on};
use crate::job::{Beside, Marched, Project};
use crate::mesh::retile::RetileError;
use crate::paste::LappedTexture;
use crate::progress::Progress;
use crate::render::gpu::{GpuError, Renderer, Subject};
use crate::render::{DrawOptions, Stage};
use crate::synth::round::{RoundError, RoundOptions};
use crate::synth::{SynthError as MatchError, VertexTexture};
use crate::viewer::build::Shown;
use crate::viewer::library::OpenModel;
use glam::Vec4;
use std::sync::{Arc, Mutex, PoisonError};

/// Why there is no synthesis.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SynthError {
    /// By Wei and Levoy.
    #[error("Wei-Levoy: {0}")]
    Levels(#[from] SynthJobError),
    /// By Chen and Dong.
    #[error("Chen-Dong: {0}")]
    Round(#[from] RoundJobError),
    /// The device.
    #[error(transparent)]
    Gpu(#[from] GpuError),
}

impl SynthError {
    /// True if it was stopped because something newer was wanted, or by the user.
    #[must_use]
    pub const fn is_cancelled(&self) -> bool {
        matches!(
            self,
            Self::Levels(SynthJobError::Synth(MatchError::Cancelled) | SynthJobError::Retile(RetileError::Cancelled))
                | Self::Round(RoundJobError::Round(RoundError::Cancelled) | RoundJobError::Retile(RetileError::Cancelled))
        )
    }
}

/// What circles were marched for: they serve every exemplar, direction and seed.
#[derive(Debug, Clone)]
struct Place {
    open: Arc<OpenModel>,
    vertices: usize,
    levels: usize,
}

/// The circles that were marched last.
#[derive(Debug, Default)]
pub(super) struct Circles(Mutex<Option<(Place, Arc<Marched>)>>);

impl Circles {
    /// Those about the vertices of a model, marched now unless they are kept; and the seconds that it took now.
    fn of(
        &self,
        open: &Arc<OpenModel>,
        exemplar: &Exemplar,
        job: &RoundJob,
        progress: &dyn Progress,
    ) -> Result<(Arc<Marched>, f64), RoundJobError> {
        let (used, levels) = job.exemplar(exemplar);
        let vertices = job.density.vertices(&open.cleaned.mesh, used.size()[0])?;
        let mut kept = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let same = |p: &Place| Arc::ptr_eq(&p.open, open) && (p.vertices, p.levels) == (vertices, levels);
        if let Some((_, marched)) = kept.as_ref().filter(|(place, _)| same(place)) {
            return Ok((Arc::clone(marched), 0.0));
        }
        // The seed of the matching is none of theirs.
        let options = RoundOptions { seed: RoundOptions::default().seed, ..job.options };
        let marched = Arc::new(march(&open.cleaned.mesh, exemplar, &RoundJob { options, ..job.clone() }, None, progress)?.0);
        let seconds = marched.seconds.iter().sum();
        *kept = Some((Place { open: Arc::clone(open), vertices, levels }, Arc::clone(&marched)));
        Ok((marched, seconds))
    }
}

/// Takes what is there to be seen.
pub(super) type Show<'a> = &'a dyn Fn(Subject, Option<Arc<VertexTexture>>, Figures);

/// Synthesises what a project asks for on what is shown; `show` is told of levels, and of the whole at last.
#[allow(clippy::too_many_arguments, reason = "what a job is given by the room")]
pub(super) fn make(
    method: Method,
    project: &Project,
    shown: &Shown,
    exemplar: &Exemplar,
    circles: &Circles,
    renderer: &Renderer,
    progress: &dyn Progress,
    show: Show<'_>,
) -> Result<(), SynthError> {
    let cleaned = &shown.open.cleaned;
    let [width, height] = exemplar.size().map(f64::from);
    let usual = || default_scale(&cleaned.mesh, DEFAULT_RATIO, width / height);
    let jobs = Beside::new(project, &cleaned.mesh, exemplar, shown.report().map_or_else(usual, |report| report.scale));
    let (texture, figures) = match method {
        Method::WeiLevoy => by_levels(&jobs.levels, shown, exemplar, renderer, progress, show)?,
        Method::ChenDong => {
            let (marched, seconds) = circles.of(&shown.open, exemplar, &jobs.round, progress)?;
            let made = synthesize_marched(cleaned, &marched, exemplar, &jobs.round, progress)?;
            let [_, _, directions, matching] = made.report.seconds;
            let vertices = made.texture.mesh.vertex_count();
            let levels = [made.report.levels.len(); 2];
            let seconds = [seconds, directions, matching];
            (made.texture, Figures { levels, vertices, exemplar: made.report.exemplar, seconds })
        }
    };
    show(subject(&texture, renderer)?, Some(Arc::new(texture)), figures);
    Ok(())
}

fn by_levels(
    job: &SynthJob,
    shown: &Shown,
    exemplar: &Exemplar,
    renderer: &Renderer,
    progress: &dyn Progress,
    show: Show<'_>,
) -> Result<(VertexTexture, Figures), SynthError> {
    let made = synthesize_on(&shown.open.cleaned, exemplar, job, progress, &mut |levels, exemplar, done| {
        // The finest one is shown with the whole.
        let Some(level) = levels.levels().get(done.level).filter(|_| done.level > 0) else { return };
        let texture = VertexTexture::of_exemplar(level, exemplar, done.places);
        let (all, vertices) = (levels.len(), level.mesh.vertex_count());
        let figures = Figures { levels: [all - done.level, all], vertices, exemplar: exemplar.size(), seconds: [0.0; 3] };
        // What cannot be shown now is told when the last level is.
        if let Ok(subject) = subject(&texture, renderer) {
            show(subject, None, figures);
        }
    })?;
    let levels = [made.levels.len(); 2];
    let vertices = made.texture.mesh.vertex_count();
    let figures = Figures { levels, vertices, exemplar: made.report.exemplar, seconds: made.report.seconds };
    Ok((made.texture, figures))
}

/// A vertex texture by its colours, on the device.
fn subject(texture: &VertexTexture, renderer: &Renderer) -> Result<Subject, GpuError> {
    let values = texture.channel(Channel::BaseColor).unwrap_or(&[]).as_chunks::<3>().0;
    let colour = |v: u32| values.get(v as usize).map_or(Vec4::ONE, |&[r, g, b]| Vec4::new(r, g, b, 1.0));
    let tints: Vec<[Vec4; 3]> = texture.mesh.faces.iter().map(|face| face.map(colour)).collect();
    let stage = Stage::new(&texture.mesh, &DrawOptions::default());
    renderer.load_tinted(&stage, &LappedTexture::default(), Some(&tints))
}
