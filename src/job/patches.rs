//! The texture patches of a job: what is cut from each exemplar.

use super::error::JobError;
use super::input::{ExemplarInput, PasteJob};
use crate::exemplar::extend::extend_exemplar;
use crate::exemplar::stack::tiles;
use crate::exemplar::{
    Channel, Exemplar, PatchOptions, PatchSource, PatchSpec, TexturePatch, Wrap, make_patches, opacity_is_outline,
};

/// The paper's 3 pixels were for images of about 200; on larger ones they cut like scissors.
const FEATHER_SHARE: f32 = 0.015;

/// Share of an exemplar's sides that splotches leave free for windows: a few courses of most textures, for a quarter more pastes.
const WINDOW_ROOM: f32 = 0.1;

/// A wider feather, as a share of the exemplar's smaller side, leaves no opaque middle.
const WIDEST_FEATHER: f32 = 0.4;

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
        // Cuts move borders away from outlines, windows make them agree.
        let full = job.patches.full || job.paste.windows && job.paste.cuts;
        let options = PatchOptions { feather, room, full, ..job.patches.clone() };
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
