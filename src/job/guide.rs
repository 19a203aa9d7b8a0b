//! What steers a job: its scale, its field, and the faces that are cut for both.

use super::error::JobError;
use super::estimate::{Estimate, Work};
use super::input::{PasteJob, Scale, Steer};
use super::report::JobReport;
use crate::exemplar::Exemplar;
use crate::field::{
    self, Constraints, FieldError, FieldOptions, Guide, RefineOptions, TangentField, constrained_on, constrained_scale,
    default_scale, discontinuity, refine_near_singularities, up_on,
};
use crate::mesh::curvature::curvature;
use crate::mesh::subdivide::{Subdivision, cut_larger};
use crate::mesh::{Cleaned, Mesh};
use crate::progress::Silent;
use glam::DVec3;

/// Above this many pastes the scale is a mistake, and pasting itself says which one would do.
const ABSURD: f64 = 1e7;

/// Exemplar areas on the surface beyond which no face is cut: pasting refuses such a job, and says why.
const MOST_TO_CUT: f64 = 1e6;

/// Larger faces than this share of an exemplar's area are cut: a texture patch then reaches over several.
const LARGEST_FACE: f64 = 0.25;

/// Makes a field on a subdivision of the mesh.
type Evaluate<'a> = dyn FnMut(&Subdivision) -> Result<TangentField, FieldError> + 'a;

/// A patch that spans half an exemplar bends by this many radians where it is as hard to lay flat as can be told apart.
const HARDEST: f64 = std::f64::consts::FRAC_PI_2;

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

/// The part of [`lay`](super::lay) that needs no patches: the scale, the field, and the faces that are cut for both.
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

/// Refuses what would not fit into the memory there is.
pub(super) fn allow(estimate: &Estimate, faces: usize, memory: Option<f64>) -> Result<(), JobError> {
    let &Estimate { memory_bytes: needed, pastes, .. } = estimate;
    match memory {
        Some(limit) if needed > limit && pastes < ABSURD => Err(JobError::Memory { needed, limit, faces, pastes }),
        _ => Ok(()),
    }
}

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
