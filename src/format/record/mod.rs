//! The lapped-texture record: a GLB that every glTF tool opens as the plain mesh, with the pastes in the root extension
//! `LAPPED_texture` (used, never required).
//!
//! Images are PNGs inside the file: colour in 8-bit sRGB, everything else in 8 bits where those are exact and in 16 where
//! not. Texture coordinates are those of each face's corners over the patch's mask.

mod read;
mod write;

pub use read::{holds_record, read_record, read_record_bytes};
pub use write::write_record;

use super::look::Look;
use super::model::Model;
use crate::paste::LappedTexture;
use glam::Vec3;
use serde_json::Value;

/// Name of the glTF extension.
pub(crate) const EXTENSION: &str = "LAPPED_texture";
/// Version of it that is written and read.
pub(crate) const VERSION: u64 = 1;

/// A lapped texture together with the model it lies on.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Record {
    /// The model. Face indices of the pastes are indices of its faces, texture coordinates follow its faces' corners.
    pub model: Model,
    /// Exemplars, texture patches and pastes.
    pub lapped: LappedTexture,
    /// T of the tangent field for each face, if there was a field.
    pub field: Option<Vec<Vec3>>,
    /// For each face the face of the user's file that it is a part of, if faces were subdivided.
    pub source_face: Option<Vec<u32>>,
    /// Name and version of the program that made it.
    pub generator: String,
    /// How it was made: any JSON, or null.
    pub job: Value,
    /// A baked atlas for whoever knows nothing of pastes. Written; of a file, [`super::read_look`] reads it.
    pub look: Option<Look>,
}

impl Record {
    /// Checks every index and every length; what passes can be written, and what is read has passed.
    ///
    /// # Errors
    /// Where, and what is wrong there.
    pub(crate) fn check(&self) -> Result<(), (String, String)> {
        let Self { model, lapped, field, source_face, .. } = self;
        let (faces, vertices) = (model.faces.len(), model.positions.len());
        let fail = |place: &str, what: String| Err((place.to_owned(), what));
        if faces == 0 {
            return fail("model", "it has no faces".into());
        }
        for (k, face) in model.faces.iter().enumerate() {
            if let Some(v) = face.iter().find(|&&v| v as usize >= vertices) {
                return fail(&format!("face {k}"), format!("it uses vertex {v}, but there are only {vertices}"));
            }
        }
        let lengths = [
            ("positions", Some(vertices), vertices),
            ("normals", model.normals.as_ref().map(Vec::len), vertices),
            ("texture coordinates", model.uvs.as_ref().map(Vec::len), vertices),
            ("colours", model.colors.as_ref().map(Vec::len), vertices),
            ("polygons", model.polygons.as_ref().map(Vec::len), faces),
            ("field", field.as_ref().map(Vec::len), faces),
            ("source faces", source_face.as_ref().map(Vec::len), faces),
        ];
        for (what, length, needed) in lengths {
            if length.is_some_and(|l| l != needed) {
                return fail(what, format!("there are {}, {needed} are needed", length.unwrap_or_default()));
            }
        }
        if let Some(v) = model.positions.iter().position(|p| !p.is_finite()) {
            return fail(&format!("vertex {v}"), "a coordinate is NaN or infinite".into());
        }
        if let Some(f) = field.iter().flatten().position(|t| !t.is_finite()) {
            return fail(&format!("field of face {f}"), "it is NaN or infinite".into());
        }
        if let Some(motion) = &model.motion {
            motion.check(vertices).map_err(|e| ("motion".to_owned(), e.to_string()))?;
        }
        let mut next = 0;
        for (k, group) in model.groups.iter().enumerate() {
            if u64::from(group.start) != next {
                return fail(&format!("group {k}"), format!("it begins at face {}, not at {next}", group.start));
            }
            next += u64::from(group.count);
        }
        if !model.groups.is_empty() && next != faces as u64 {
            return fail("groups", format!("they hold {next} of {faces} faces"));
        }
        if let Some(look) = &self.look {
            look.check(vertices, faces)?;
        }
        check_lapped(lapped, faces)
    }
}

fn check_lapped(lapped: &LappedTexture, faces: usize) -> Result<(), (String, String)> {
    for (k, layer) in lapped.layers.iter().enumerate() {
        let fail = |what: String| Err((format!("layer {k}"), what));
        if ![0, faces].contains(&layer.weights.len()) {
            return fail(format!("it has weights for {} faces, not for {faces}", layer.weights.len()));
        }
        if ![0, faces].contains(&layer.base.len()) {
            return fail(format!("it has a base for {} faces, not for {faces}", layer.base.len()));
        }
        if layer.weights.as_flattened().iter().any(|w| !(0.0..=1.0).contains(w)) {
            return fail("a weight is not between 0 and 1".into());
        }
    }
    let held: u64 = lapped.layers.iter().map(|l| u64::from(l.pastes)).sum();
    if !lapped.layers.is_empty() && held != lapped.pastes.len() as u64 {
        return Err(("layers".into(), format!("they hold {held} of {} pastes", lapped.pastes.len())));
    }
    for (k, patch) in lapped.patches.iter().enumerate() {
        let fail = |what: String| Err((format!("patch {k}"), what));
        if usize::from(patch.exemplar) >= lapped.exemplars.len() {
            return fail(format!("its exemplar {} does not exist", patch.exemplar));
        }
        if patch.mask.finest().components() != 1 {
            return fail("its mask has more than one component".into());
        }
        let finite = patch.hull.points().iter().chain([&patch.centre]).all(|p| p.is_finite());
        if !(finite && patch.weight > 0.0 && patch.weight.is_finite()) {
            return fail("its hull, centre or weight is out of range".into());
        }
    }
    for (k, paste) in lapped.pastes.iter().enumerate() {
        let fail = |what: String| Err((format!("paste {k}"), what));
        if usize::from(paste.patch) >= lapped.patches.len() {
            return fail(format!("its patch {} does not exist", paste.patch));
        }
        if let Some(face) = paste.faces.iter().find(|&&f| f as usize >= faces) {
            return fail(format!("it lies on face {face}, but there are only {faces}"));
        }
        if paste.uv.len() != paste.faces.len() {
            return fail(format!("it has {} faces, but texture coordinates for {}", paste.faces.len(), paste.uv.len()));
        }
        if !paste.offset.is_finite() || paste.uv.as_flattened().iter().any(|t| !t.is_finite()) {
            return fail("a texture coordinate is NaN or infinite".into());
        }
    }
    Ok(())
}
