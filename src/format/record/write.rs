//! Record to GLB. Lengths are known beforehand, so the JSON goes first and all numbers are streamed after it: beside the
//! record itself only the encoded images are held.

use super::{EXTENSION, Record, VERSION};
use crate::exemplar::{Channel, Exemplar, Frames, Image, Wrap};
use crate::format::FormatError;
use crate::format::gltf::build::{Builder, F32, Shape, U16, U32};
use crate::format::gltf::scene_out::add_scene;
use crate::format::picture::{Transfer, encode_png};
use crate::paste::cut::CUT_STEPS;
use crate::paste::{AGREES, Cut, Layer, Turn};
use rayon::prelude::*;
use serde_json::{Map, Value, json};
use std::path::Path;

/// Writes a record as GLB.
///
/// # Errors
/// If the record contradicts itself, is larger than the format's 4 GiB, or the file cannot be written. Nothing is left
/// behind then.
pub fn write_record(path: &Path, record: &Record) -> Result<(), FormatError> {
    let fail = |what: String, remedy: &str| FormatError::Write { path: path.to_owned(), what, remedy: remedy.into() };
    record
        .check()
        .map_err(|(place, what)| fail(format!("{place}: {what}"), "this is a fault of the program that made the record"))?;
    let mut tables = Tables(Builder::default());
    let extension = tables.extension(record).map_err(|what| fail(what, "use a smaller exemplar"))?;
    let mut parts =
        add_scene(&mut tables.0, &record.model, record.look.as_ref()).map_err(|what| fail(what, "bake at a smaller size"))?;
    parts.insert("extensionsUsed".into(), json!([EXTENSION]));
    parts.insert("extensions".into(), json!({ EXTENSION: extension }));
    let document = tables.0.document(&record.generator, parts);
    tables.0.write_glb(path, &document)
}

/// What the extension refers to.
struct Tables<'a>(Builder<'a>);

impl<'a> Tables<'a> {
    /// The extension's JSON, with everything it refers to.
    fn extension(&mut self, record: &'a Record) -> Result<Value, String> {
        let lapped = &record.lapped;
        let mut extension = json!({ "version": VERSION, "mesh": 0, "primitive": 0 });
        let mut put = |key: &str, value: Option<Value>| {
            if let Some(value) = value {
                extension[key] = value;
            }
        };
        put("field", record.field.as_ref().and_then(|f| self.0.vectors(None, f.len(), |k| f[k].to_array())).map(Value::from));
        put("sourceFace", record.source_face.as_ref().and_then(|f| self.0.whole(None, f)).map(Value::from));
        put("model", Some(self.model(record)));
        put("exemplars", Some(self.exemplars(&lapped.exemplars)?));
        let masks: Vec<_> = lapped.patches.par_iter().map(|p| encode_png(p.mask.finest(), Transfer::Linear)).collect();
        let mut patches = Vec::with_capacity(masks.len());
        for (k, (patch, mask)) in lapped.patches.iter().zip(masks).enumerate() {
            let mask = self.0.texture(format!("mask {k}"), mask?, Wrap::Clamp);
            let hull: Vec<f64> = patch.hull.points().iter().flat_map(|p| [f64::from(p.x), f64::from(p.y)]).collect();
            patches.push(json!({
                "exemplar": patch.exemplar, "mask": mask, "origin": patch.origin, "size": patch.mask.size(),
                "hull": hull, "centre": patch.centre.as_dvec2().to_array(), "weight": f64::from(patch.weight),
                "slides": patch.slides,
            }));
        }
        put("patches", Some(patches.into()));
        put("pastes", Some(self.pastes(record)));
        put("layers", (!lapped.layers.is_empty()).then(|| self.layers(&lapped.layers)));
        put("baked", record.look.is_some().then(|| true.into()));
        put("job", (!record.job.is_null()).then(|| record.job.clone()));
        Ok(extension)
    }

    /// What the user's file held beyond what a primitive can say.
    fn model(&mut self, record: &'a Record) -> Value {
        let model = &record.model;
        let mut value = json!({ "name": model.name, "groups": model.groups, "source": model.source });
        if let Some(polygons) = model.polygons.as_ref().and_then(|p| self.0.whole(None, p)) {
            value["polygon"] = polygons.into();
        }
        value
    }

    fn exemplars(&mut self, exemplars: &[Exemplar]) -> Result<Value, String> {
        // Each exemplar with its other frames after it.
        let encoded: Vec<Vec<Vec<_>>> = exemplars.par_iter().map(|e| frames_of(e).into_par_iter().map(encoded).collect()).collect();
        let mut list = Vec::with_capacity(exemplars.len());
        for (exemplar, frames) in exemplars.iter().zip(encoded) {
            let mut images = Vec::with_capacity(frames.len());
            for (number, channels) in frames.into_iter().enumerate() {
                let mut of_frame = Map::new();
                for (channel, png) in channels {
                    let frame = if number == 0 { String::new() } else { format!(" {}", number + 1) };
                    let name = format!("{}{frame} {}", exemplar.name, channel.name());
                    of_frame.insert(channel.name().into(), self.0.texture(name, png?, exemplar.wrap).into());
                }
                images.push(Value::from(of_frame));
            }
            let others = images.split_off(1);
            let mut value = json!({ "name": exemplar.name, "images": images[0], "size": exemplar.size(), "wrap": exemplar.wrap });
            if let Some(frames) = exemplar.frames() {
                value["frames"] = json!({ "by": frames.by(), "seconds": frames.seconds(), "images": others });
            }
            list.push(value);
        }
        Ok(list.into())
    }

    fn layers(&mut self, layers: &'a [Layer]) -> Value {
        let mut list = Vec::with_capacity(layers.len());
        for layer in layers {
            let weights = layer.weights.as_flattened();
            let accessor = self.0.vectors(None, weights.len(), |k| [weights[k]]);
            let mut value = json!({ "name": layer.name, "pastes": layer.pastes });
            if let Some(accessor) = accessor {
                value["weight"] = accessor.into();
            }
            let base = layer.base.as_flattened().as_flattened();
            let shape = Shape { name: "SCALAR", component: U16, target: None };
            let accessor = self.0.accessor(shape, base.len(), |out| base.iter().try_for_each(|c| out.write_all(&c.to_le_bytes())));
            if let Some(accessor) = accessor {
                value["base"] = accessor.into();
            }
            list.push(value);
        }
        list.into()
    }

    fn pastes(&mut self, record: &'a Record) -> Value {
        let pastes = &record.lapped.pastes;
        let faces: usize = pastes.iter().map(|p| p.faces.len()).sum();
        let mut value = json!({ "count": pastes.len() });
        let patch = self.0.accessor(Shape { name: "SCALAR", component: U16, target: None }, pastes.len(), |out| {
            pastes.iter().try_for_each(|p| out.write_all(&p.patch.to_le_bytes()))
        });
        let offsets = self.0.accessor(Shape { name: "SCALAR", component: U32, target: None }, pastes.len() + 1, |out| {
            let mut at = 0_u32;
            out.write_all(&at.to_le_bytes())?;
            pastes.iter().try_for_each(|p| {
                at += p.faces.len() as u32;
                out.write_all(&at.to_le_bytes())
            })
        });
        let face = self.0.accessor(Shape { name: "SCALAR", component: U32, target: None }, faces, |out| {
            pastes.iter().flat_map(|p| &p.faces).try_for_each(|f| out.write_all(&f.to_le_bytes()))
        });
        let uv = self.0.accessor(Shape { name: "VEC2", component: F32, target: None }, 3 * faces, |out| {
            let corners = pastes.iter().flat_map(|p| &p.uv);
            corners
                .map(|uv| uv.map(|t| t.to_array().map(f32::to_le_bytes)))
                .try_for_each(|b| out.write_all(b.as_flattened().as_flattened()))
        });
        let shifted = pastes.iter().any(|p| p.offset != glam::Vec2::ZERO);
        let offset = if shifted { self.0.vectors(None, pastes.len(), |k| pastes[k].offset.to_array()) } else { None };
        // Low byte the distance, high byte the softness.
        let steps = if pastes.iter().any(|p| p.cut.is_some()) { CUT_STEPS * pastes.len() } else { 0 };
        let cut = self.0.accessor(Shape { name: "SCALAR", component: U16, target: None }, steps, |out| {
            pastes.iter().try_for_each(|p| out.write_all(p.cut.as_deref().unwrap_or(&Cut::none()).steps().as_flattened()))
        });
        let turned = if pastes.iter().any(|p| p.turn != Turn::NONE) { pastes.len() } else { 0 };
        let turn = self.0.accessor(Shape { name: "SCALAR", component: U16, target: None }, turned, |out| {
            pastes.iter().try_for_each(|p| out.write_all(&(p.turn.parts() as u16).to_le_bytes()))
        });
        let kept = if pastes.iter().any(|p| p.agreement != AGREES) { pastes.len() } else { 0 };
        let agreement = self.0.accessor(Shape { name: "SCALAR", component: U16, target: None }, kept, |out| {
            pastes.iter().try_for_each(|p| out.write_all(&u16::from(p.agreement).to_le_bytes()))
        });
        let all = [
            ("patch", patch),
            ("faceOffset", offsets),
            ("face", face),
            ("uv", uv),
            ("offset", offset),
            ("turn", turn),
            ("cut", cut),
            ("agreement", agreement),
        ];
        for (key, accessor) in all {
            if let Some(accessor) = accessor {
                value[key] = accessor.into();
            }
        }
        value
    }
}

/// The channels of each of an exemplar's frames. Of those after the first, what it shares with the first is left out.
fn frames_of(exemplar: &Exemplar) -> Vec<Vec<(Channel, &Image)>> {
    let mut frames = vec![channels_of(exemplar)];
    for other in exemplar.frames().map_or(&[][..], Frames::others) {
        let shared = |c| exemplar.channel(c).zip(other.channel(c)).is_some_and(|(a, b)| a.shares_pixels(b));
        frames.push(channels_of(other).into_iter().filter(|(c, _)| !shared(*c)).collect());
    }
    frames
}

fn channels_of(frame: &Exemplar) -> Vec<(Channel, &Image)> {
    frame.channels().iter().filter_map(|c| Some((c, frame.channel(c)?.finest()))).collect()
}

fn encoded(images: Vec<(Channel, &Image)>) -> Vec<(Channel, Result<Vec<u8>, String>)> {
    images.into_par_iter().map(|(c, image)| (c, encode_png(image, Transfer::of(c)))).collect()
}
