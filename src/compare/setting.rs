//! What all methods share: the mesh, the exemplar, the scale and the field.
//!
//! 1. The exemplar is brought to one size: a synthesised texture has a vertex for each of its pixels, and a comparison of
//!    different amounts of detail would say nothing. Only its colour is compared; where it is transparent its colours are extended.
//! 2. Scale and field are made as for pasting, and the mesh is cut as for pasting. Everything is measured on that mesh.
//! 3. Synthesis is steered by that field. A field of several ways is made anew on its own vertices, by the same method.

use super::CompareError;
use super::source::Plane;
use crate::exemplar::auto::Choice;
use crate::exemplar::extend::extend_exemplar;
use crate::exemplar::{Channel, Exemplar, PatchOptions, Wrap};
use crate::field::{Guide, TangentField};
use crate::format::Model;
use crate::job::patches::default_feather;
use crate::job::synth::prepared;
use crate::job::{Guided, PasteJob, Scale, Steer, guided};
use crate::mesh::{CleanOptions, Cleaned, Mesh, clean};
use crate::paste::PasteOptions;
use glam::DVec2;

/// What all methods share.
#[derive(Debug, Clone)]
pub struct Setting {
    /// The mesh that everything lies on.
    pub cleaned: Cleaned,
    /// What steers.
    pub guide: Guide,
    /// What steers synthesis.
    pub steer: Steer,
    /// The exemplar as all methods use it.
    pub exemplar: Exemplar,
    /// Its pixels on the surface.
    pub plane: Plane,
    /// World length of one exemplar width.
    pub scale: f64,
    /// Area of the surface in areas of the exemplar.
    pub ratio: f64,
    /// The job of pasting.
    pub job: PasteJob,
    /// Seed of all random choices.
    pub seed: u64,
    /// What the exemplar asks for, if it chooses its own patches.
    pub choice: Option<Choice>,
}

/// How large and which way.
#[derive(Debug, Clone, PartialEq)]
pub struct SettingOptions {
    /// How large the texture is.
    pub scale: Scale,
    /// Which way.
    pub steer: Steer,
    /// The exemplar's longer side at most, pixels.
    pub side: u32,
    /// How to clean the model.
    pub clean: CleanOptions,
    /// Seed of all random choices.
    pub seed: u64,
    /// Let the exemplar choose its patches.
    pub choose: bool,
    /// Lay smaller pastes over hard edges that still show ([`PasteOptions::small`]).
    pub small: bool,
}

/// The exemplar's longer side at most, unless another is asked for: as in synthesis.
pub const SIDE: u32 = crate::job::synth::SIDE;

/// Surface area over exemplar area, unless a scale is asked for: half of pasting's, since synthesis takes a vertex a pixel.
pub const RATIO: f64 = 20.0;

impl Default for SettingOptions {
    fn default() -> Self {
        Self {
            scale: Scale::Ratio(RATIO),
            steer: Steer::default(),
            side: SIDE,
            clean: CleanOptions::default(),
            seed: 1,
            choose: false,
            small: false,
        }
    }
}

/// The exemplar as all methods use it: its colour alone, at most so large.
fn brought(exemplar: &Exemplar, side: u32) -> Result<Exemplar, CompareError> {
    let mut own = exemplar.clone();
    own.remove_frames();
    extend_exemplar(&mut own)?;
    Channel::ALL.into_iter().filter(|c| *c != Channel::BaseColor).for_each(|c| own.remove(c));
    let longer = own.size()[0].max(own.size()[1]);
    Ok(prepared(&own, Some(longer.min(side)), None))
}

impl Setting {
    /// Makes what all methods share.
    ///
    /// # Errors
    /// If the model is no mesh, or the scale or field cannot be used.
    pub fn new(model: &Model, exemplar: &Exemplar, options: &SettingOptions) -> Result<Self, CompareError> {
        let exemplar = brought(exemplar, options.side)?;
        let cleaned = clean(&model.positions, &model.faces, &options.clean)?;
        let job = PasteJob {
            clean: options.clean.clone(),
            scale: options.scale,
            steer: options.steer.clone(),
            patches: PatchOptions { seed: options.seed, ..PatchOptions::default() },
            paste: PasteOptions { seed: options.seed, small: options.small, ..PasteOptions::default() },
            ..PasteJob::default()
        };
        let Guided { fine, guide, report } = guided(&cleaned, std::slice::from_ref(&exemplar), &job)?;
        let mesh = fine.map_or(cleaned.mesh, |f| f.mesh);
        let cleaned = Cleaned { mesh, ..cleaned };
        let size = exemplar.size().map(f64::from);
        let plane = Plane { size: DVec2::from(size), tiles: exemplar.wrap == Wrap::Repeat, pixel: report.scale / size[0] };
        let steer = match (&guide, &options.steer) {
            (Guide::Directed(field), _) if field.ways == 1 => Steer::Field(field.to_json()?),
            (Guide::Directed(_), asked) => asked.clone(),
            (Guide::Isotropic { .. }, _) => Steer::Relaxed(1),
        };
        let choice = options.choose.then(|| Choice::of(&exemplar, default_feather(exemplar.size())));
        Ok(Self {
            cleaned,
            guide,
            steer,
            exemplar,
            plane,
            scale: report.scale,
            ratio: report.ratio,
            job,
            seed: options.seed,
            choice,
        })
    }

    /// The mesh.
    #[must_use]
    pub const fn mesh(&self) -> &Mesh {
        &self.cleaned.mesh
    }

    /// The field, if there are directions.
    #[must_use]
    pub const fn field(&self) -> Option<&TangentField> {
        self.guide.field()
    }
}
