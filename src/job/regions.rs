//! Several textures on one model: each region has its own exemplars, scale and field, and covers a part of the surface.
//!
//! 1. Clean the model once.
//! 2. For each region find its weights ([`Area`]) and take the faces where any of it shows as a mesh of their own.
//! 3. Paste that part as if it were the whole: its cover is whole up to its rim.
//! 4. Stack the regions as [`Layer`]s, later ones on top; the weights mix them where borders are soft.
//!
//! Faces are not cut near singularities here: regions overlap, and would have to agree on the cuts.

use super::area::{Area, AreaError, shows};
use super::base::{of_mesh, of_vertices, split};
use super::bind::Outgoing;
use super::error::JobError;
use super::estimate::{Estimate, Work};
use super::guide::{allow, difficulty, scale_of, steer};
use super::input::{ExemplarInput, PasteJob};
use super::paste::{Pasted, paste_model};
use super::patches::cut_patches;
use super::report::{JobReport, RegionReport};
use crate::field::{Guide, TangentField};
use crate::format::{Model, Record};
use crate::mesh::part::Part;
use crate::mesh::{CleanOptions, Cleaned, clean};
use crate::paste::{BaseColor, LappedTexture, Layer, Paste, PasteError, PasteStatistics, paste};
use crate::progress::Progress;
use std::time::Instant;

/// One region.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Region {
    /// What it is called, in messages and in the record.
    pub name: String,
    /// Where it is.
    pub area: Area,
    /// Width of its soft border, world units; for areas given by names.
    pub border: f64,
    /// Its exemplars.
    pub inputs: Vec<ExemplarInput>,
    /// How it is pasted. Cleaning and memory are those of the first region.
    pub job: PasteJob,
}

/// Dresses a model in its regions, later ones on top. A single region that covers everything is [`paste_model`].
///
/// # Errors
/// As [`paste_model`], with the region's name; and if a region covers nothing.
pub fn paste_regions(model: &Model, mut regions: Vec<Region>, progress: &dyn Progress) -> Result<Pasted, JobError> {
    if let [Region { area: Area::Everything, inputs, job, .. }] = &mut regions[..] {
        return paste_model(model, std::mem::take(inputs), job, progress);
    }
    if regions.is_empty() {
        return Err(PasteError::NoPatches.into());
    }
    let begin = Instant::now();
    progress.stage("cleaning the mesh", 0);
    let options = regions.first().map_or_else(CleanOptions::default, |r| r.job.clean.clone());
    let memory = regions.first().and_then(|r| r.job.memory);
    let cleaned = clean(&model.positions, &model.faces, &options)?;
    let mut report = JobReport { clean: cleaned.report.clone(), ..JobReport::default() };
    report.prepare_seconds = begin.elapsed().as_secs_f64();
    let mut stack = Stack::default();
    for (index, region) in regions.into_iter().enumerate() {
        let name = region.name.clone();
        stack.add(model, &cleaned, region, memory, &mut report, progress).map_err(|source| JobError::Region {
            index,
            name,
            source: Box::new(source),
        })?;
    }
    let Stack { lapped, guides } = stack;
    let draws: usize = lapped.pastes.iter().map(|p| p.faces.len()).sum();
    report.paste.draws_per_face = draws as f64 / cleaned.mesh.face_count() as f64;
    let guide = merge(&cleaned, &guides);
    let out = Outgoing::new(model, &cleaned, None);
    let record = Record {
        field: guide.field().map(|f| out.per_face(&f.up)),
        lapped: LappedTexture {
            pastes: out.pastes(&lapped.pastes),
            layers: out.layers(&lapped.layers),
            exemplars: lapped.exemplars.clone(),
            patches: lapped.patches.clone(),
        },
        model: out.model,
        source_face: None,
        generator: concat!("lapped ", env!("CARGO_PKG_VERSION")).to_owned(),
        job: serde_json::Value::Null,
        look: None,
    };
    Ok(Pasted { record, mesh: cleaned.mesh, lapped, guide, report })
}

/// Regions pasted so far, and for each the guide on its own faces.
#[derive(Default)]
struct Stack {
    lapped: LappedTexture,
    guides: Vec<(Vec<u32>, Guide)>,
}

impl Stack {
    fn add(
        &mut self,
        model: &Model,
        cleaned: &Cleaned,
        region: Region,
        memory: Option<f64>,
        report: &mut JobReport,
        progress: &dyn Progress,
    ) -> Result<(), JobError> {
        let Region { name, area, border, inputs, job } = region;
        progress.stage(&format!("region {name}"), 0);
        let weights = area.weights(model, cleaned, border)?;
        let part = Part::new(&cleaned.mesh, |f| weights.as_ref().is_none_or(|w| shows(&w[f as usize])));
        let Part { mesh, faces } = part.ok_or(AreaError::Empty("region"))?;
        job.base.map_or(Ok(()), |base| base.check(model))?;
        let (mut exemplars, patches) = cut_patches(inputs, &job, &mut report.warnings)?;
        let slow = job.base.map(|base| (base, split(&mut exemplars, &mut report.warnings)));
        let (scale, ratio) = scale_of(&mesh, &job, &exemplars)?;
        let directed = !matches!(job.steer, super::Steer::Isotropic(_));
        let work = Work { faces: faces.len(), ..Work::new(&cleaned.report, ratio, directed, job.paste.windows, &exemplars) };
        let estimate = Estimate::new(&work);
        allow(&estimate, faces.len(), memory)?;
        let keep = PasteJob { keep_faces: true, ..job };
        let mut of_region = JobReport { scale, ..JobReport::default() };
        let (_, whole_guide) = steer(cleaned, &keep, &mut of_region)?;
        let guide = restrict(&whole_guide, &faces);
        let difficulty = difficulty(&mesh, &guide);

        let count = patches.len();
        let (done, statistics) = paste(&mesh, &guide, exemplars, patches, &difficulty, &keep.paste, progress)?;
        let all = self.lapped.patches.len() + done.patches.len();
        if all > usize::from(u16::MAX) {
            return Err(PasteError::TooManyPatches(all).into());
        }
        let base = slow.map_or_else(Vec::new, |(base, slow)| {
            let painted = || {
                let all = of_vertices(model, &cleaned.mesh, &cleaned.user_faces);
                faces.iter().map(|&f| all[f as usize]).collect()
            };
            let mine = of_mesh(base, (&mesh, &guide), &done, slow, painted);
            let mut all = vec![[BaseColor::default(); 3]; cleaned.mesh.face_count()];
            faces.iter().zip(mine).for_each(|(&face, mine)| all[face as usize] = mine);
            all
        });
        let first = [self.lapped.patches.len() as u16, self.lapped.exemplars.len() as u16];
        let moved =
            |p: Paste| Paste { patch: p.patch + first[0], faces: p.faces.iter().map(|&f| faces[f as usize]).collect(), ..p };
        let layer = Layer {
            name: name.clone(),
            pastes: done.pastes.len() as u32,
            weights: weights.filter(|w| w.iter().any(|w| shows(w) && *w != [1.0; 3])).unwrap_or_default(),
            base,
        };
        self.lapped.layers.push(layer);
        self.lapped.pastes.extend(done.pastes.into_iter().map(moved));
        self.lapped.exemplars.extend(done.exemplars);
        self.lapped.patches.extend(done.patches.into_iter().map(|mut p| {
            p.exemplar += first[1];
            p
        }));

        report.patches += count;
        report.filled_faces += of_region.filled_faces;
        report.estimate.add(&estimate);
        add_statistics(&mut report.paste, &statistics, report.regions.is_empty());
        if report.regions.is_empty() {
            (report.scale, report.ratio) = (scale, ratio);
        }
        report.regions.push(RegionReport { name, faces: faces.len(), scale, ratio, paste: statistics });
        self.guides.push((faces, guide));
        Ok(())
    }
}

/// Adds what sums up over regions, and keeps the worst of what does not.
fn add_statistics(all: &mut PasteStatistics, one: &PasteStatistics, first: bool) {
    all.pastes += one.pastes;
    all.pastes_laid += one.pastes_laid;
    all.grown_faces += one.grown_faces;
    all.repairs += one.repairs;
    all.coverage_samples += one.coverage_samples;
    all.audit_samples += one.audit_samples;
    all.hard_edge_length += one.hard_edge_length;
    all.visible_hard_edge_length += one.visible_hard_edge_length;
    all.least_alpha = if first { one.least_alpha } else { all.least_alpha.min(one.least_alpha) };
    all.seconds.total += one.seconds.total;
}

fn restrict(guide: &Guide, faces: &[u32]) -> Guide {
    let pick = |all: &[glam::Vec3]| faces.iter().map(|&f| all[f as usize]).collect();
    match guide {
        Guide::Directed(field) => {
            Guide::Directed(TangentField { up: pick(&field.up), right: field.right.as_ref().map(|r| pick(r)), ways: field.ways })
        }
        Guide::Isotropic { scale } => Guide::Isotropic { scale: faces.iter().map(|&f| scale[f as usize]).collect() },
    }
}

/// One guide for the whole mesh, of the topmost region at each face: directed if all regions are.
fn merge(cleaned: &Cleaned, guides: &[(Vec<u32>, Guide)]) -> Guide {
    let count = cleaned.mesh.face_count();
    let typical = guides.first().map_or(1.0, |(_, g)| g.scale(0));
    if guides.iter().all(|(_, g)| g.field().is_some()) {
        // Where no region is, any direction in the face's plane does.
        let mut up: Vec<glam::Vec3> =
            (0..count as u32).map(|f| (cleaned.mesh.normal(f).any_orthonormal_vector() * f64::from(typical)).as_vec3()).collect();
        for (faces, guide) in guides {
            if let Some(field) = guide.field() {
                faces.iter().zip(&field.up).for_each(|(&f, &t)| up[f as usize] = t);
            }
        }
        return Guide::Directed(TangentField::along(up));
    }
    let mut scale = vec![typical; count];
    for (faces, guide) in guides {
        faces.iter().zip(0..).for_each(|(&f, mine)| scale[f as usize] = guide.scale(mine));
    }
    Guide::Isotropic { scale }
}
