//! Record to GLB. Lengths are known beforehand, so the JSON goes first and all numbers are streamed after it: beside the
//! record itself only the encoded images are held.

use super::motion::Moving;
use super::{EXTENSION, Record, VERSION};
use crate::exemplar::{Channel, Exemplar, Image, Wrap};
use crate::format::FormatError;
use crate::format::gltf::glb;
use crate::format::output::write_file;
use crate::format::picture::{Transfer, encode_png};
use crate::paste::Layer;
use glam::Vec3;
use rayon::prelude::*;
use serde_json::{Map, Value, json};
use std::io::{self, Write};
use std::path::Path;

/// Codes of glTF component types.
pub(super) const U16: u32 = 5123;
pub(super) const U32: u32 = 5125;
pub(super) const F32: u32 = 5126;
/// Codes of glTF buffer targets.
pub(super) const VERTICES: u32 = 34962;
const INDICES: u32 = 34963;

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
    let mut glb = Glb::default();
    let extension = glb.extension(record).map_err(|what| fail(what, "use a smaller exemplar"))?;
    let json = glb.document(record, extension).to_string();
    let size = glb::size(json.len(), glb.length);
    let size =
        size.ok_or_else(|| fail("a GLB cannot be larger than 4 GiB".into(), "use a larger texture scale, or split the mesh"))?;
    write_file(path, |out| {
        glb::write_head(out, json.as_bytes(), glb.length as u32, size)?;
        glb.parts.iter().try_for_each(|(length, part)| {
            part(out)?;
            out.write_all(&[0; 3][..glb::padding(*length)])
        })
    })
}

pub(super) type Part<'a> = Box<dyn Fn(&mut dyn Write) -> io::Result<()> + 'a>;

/// A GLB under construction: the tables of its JSON and what will write its binary data.
#[derive(Default)]
pub(super) struct Glb<'a> {
    parts: Vec<(u64, Part<'a>)>,
    length: u64,
    views: Vec<Value>,
    accessors: Vec<Value>,
    images: Vec<Value>,
    textures: Vec<Value>,
}

impl<'a> Glb<'a> {
    /// Adds a buffer view of `length` bytes; returns its number.
    pub(super) fn view(&mut self, length: u64, target: Option<u32>, part: Part<'a>) -> usize {
        let mut view = json!({ "buffer": 0, "byteOffset": self.length, "byteLength": length });
        if let Some(target) = target {
            view["target"] = target.into();
        }
        self.views.push(view);
        self.length += length + glb::padding(length) as u64;
        self.parts.push((length, part));
        self.views.len() - 1
    }

    /// Adds an accessor and its view; `None` if it is empty, which glTF does not allow.
    pub(super) fn accessor(
        &mut self,
        shape: Shape,
        count: usize,
        part: impl Fn(&mut dyn Write) -> io::Result<()> + 'a,
    ) -> Option<usize> {
        if count == 0 {
            return None;
        }
        let view = self.view(shape.bytes() * count as u64, shape.target, Box::new(part));
        let accessor = json!({ "bufferView": view, "componentType": shape.component, "count": count, "type": shape.name });
        Some(self.add_accessor(accessor))
    }

    pub(super) fn add_accessor(&mut self, accessor: Value) -> usize {
        self.accessors.push(accessor);
        self.accessors.len() - 1
    }

    /// States the least and the greatest of an accessor's numbers.
    pub(super) fn bound(&mut self, accessor: usize, low: &[f64], high: &[f64]) {
        self.accessors[accessor]["min"] = json!(low);
        self.accessors[accessor]["max"] = json!(high);
    }

    pub(super) fn vectors<const N: usize>(
        &mut self,
        target: Option<u32>,
        count: usize,
        item: impl Fn(usize) -> [f32; N] + 'a,
    ) -> Option<usize> {
        let name = if N == 16 { "MAT4" } else { ["SCALAR", "VEC2", "VEC3", "VEC4"][N - 1] };
        self.accessor(Shape { name, component: F32, target }, count, move |out| {
            (0..count).try_for_each(|k| out.write_all(item(k).map(f32::to_le_bytes).as_flattened()))
        })
    }

    fn whole(&mut self, target: Option<u32>, items: &'a [u32]) -> Option<usize> {
        self.accessor(Shape { name: "SCALAR", component: U32, target }, items.len(), |out| {
            items.iter().try_for_each(|i| out.write_all(&i.to_le_bytes()))
        })
    }

    /// Adds a PNG as image and texture; returns the texture's number.
    fn texture(&mut self, name: String, png: Vec<u8>, wrap: Wrap) -> usize {
        let view = self.view(png.len() as u64, None, Box::new(move |out| out.write_all(&png)));
        self.images.push(json!({ "bufferView": view, "mimeType": "image/png", "name": name }));
        self.textures.push(json!({ "source": self.images.len() - 1, "sampler": wrap as usize }));
        self.textures.len() - 1
    }

    /// The extension's JSON, with everything it refers to.
    fn extension(&mut self, record: &'a Record) -> Result<Value, String> {
        let lapped = &record.lapped;
        let mut extension = json!({ "version": VERSION, "mesh": 0, "primitive": 0 });
        let mut put = |key: &str, value: Option<Value>| {
            if let Some(value) = value {
                extension[key] = value;
            }
        };
        put("field", record.field.as_ref().and_then(|f| self.vectors(None, f.len(), |k| f[k].to_array())).map(Value::from));
        put("sourceFace", record.source_face.as_ref().and_then(|f| self.whole(None, f)).map(Value::from));
        put("model", Some(self.model(record)));
        put("exemplars", Some(self.exemplars(&lapped.exemplars)?));
        let masks: Vec<_> = lapped.patches.par_iter().map(|p| encode_png(p.mask.finest(), Transfer::Linear)).collect();
        let mut patches = Vec::with_capacity(masks.len());
        for (k, (patch, mask)) in lapped.patches.iter().zip(masks).enumerate() {
            let mask = self.texture(format!("mask {k}"), mask?, Wrap::Clamp);
            let hull: Vec<f64> = patch.hull.points().iter().flat_map(|p| [f64::from(p.x), f64::from(p.y)]).collect();
            patches.push(json!({
                "exemplar": patch.exemplar, "mask": mask, "origin": patch.origin, "size": patch.mask.size(),
                "hull": hull, "centre": patch.centre.as_dvec2().to_array(), "weight": f64::from(patch.weight),
            }));
        }
        put("patches", Some(patches.into()));
        put("pastes", Some(self.pastes(record)));
        put("layers", (!lapped.layers.is_empty()).then(|| self.layers(&lapped.layers)));
        put("job", (!record.job.is_null()).then(|| record.job.clone()));
        Ok(extension)
    }

    /// What the user's file held beyond what a primitive can say.
    fn model(&mut self, record: &'a Record) -> Value {
        let model = &record.model;
        let mut value = json!({ "name": model.name, "groups": model.groups, "source": model.source });
        if let Some(polygons) = model.polygons.as_ref().and_then(|p| self.whole(None, p)) {
            value["polygon"] = polygons.into();
        }
        value
    }

    fn exemplars(&mut self, exemplars: &[Exemplar]) -> Result<Value, String> {
        let all: Vec<(usize, Channel, &Image)> = exemplars
            .iter()
            .enumerate()
            .flat_map(|(k, e)| e.channels().iter().filter_map(move |c| e.channel(c).map(|chain| (k, c, chain.finest()))))
            .collect();
        let encoded: Vec<_> = all.par_iter().map(|&(k, c, image)| (k, c, encode_png(image, Transfer::of(c)))).collect();
        let mut images = vec![Map::new(); exemplars.len()];
        for (k, channel, png) in encoded {
            let texture = self.texture(format!("{} {}", exemplars[k].name, channel.name()), png?, exemplars[k].wrap);
            images[k].insert(channel.name().into(), texture.into());
        }
        let list = exemplars.iter().zip(images);
        Ok(list.map(|(e, images)| json!({ "name": e.name, "images": images, "size": e.size(), "wrap": e.wrap })).collect())
    }

    fn layers(&mut self, layers: &'a [Layer]) -> Value {
        let mut list = Vec::with_capacity(layers.len());
        for layer in layers {
            let weights = layer.weights.as_flattened();
            let accessor = self.vectors(None, weights.len(), |k| [weights[k]]);
            let mut value = json!({ "name": layer.name, "pastes": layer.pastes });
            if let Some(accessor) = accessor {
                value["weight"] = accessor.into();
            }
            list.push(value);
        }
        list.into()
    }

    fn pastes(&mut self, record: &'a Record) -> Value {
        let pastes = &record.lapped.pastes;
        let faces: usize = pastes.iter().map(|p| p.faces.len()).sum();
        let mut value = json!({ "count": pastes.len() });
        let patch = self.accessor(Shape { name: "SCALAR", component: U16, target: None }, pastes.len(), |out| {
            pastes.iter().try_for_each(|p| out.write_all(&p.patch.to_le_bytes()))
        });
        let offsets = self.accessor(Shape { name: "SCALAR", component: U32, target: None }, pastes.len() + 1, |out| {
            let mut at = 0_u32;
            out.write_all(&at.to_le_bytes())?;
            pastes.iter().try_for_each(|p| {
                at += p.faces.len() as u32;
                out.write_all(&at.to_le_bytes())
            })
        });
        let face = self.accessor(Shape { name: "SCALAR", component: U32, target: None }, faces, |out| {
            pastes.iter().flat_map(|p| &p.faces).try_for_each(|f| out.write_all(&f.to_le_bytes()))
        });
        let uv = self.accessor(Shape { name: "VEC2", component: F32, target: None }, 3 * faces, |out| {
            let corners = pastes.iter().flat_map(|p| &p.uv);
            corners
                .map(|uv| uv.map(|t| t.to_array().map(f32::to_le_bytes)))
                .try_for_each(|b| out.write_all(b.as_flattened().as_flattened()))
        });
        let shifted = pastes.iter().any(|p| p.offset != glam::Vec2::ZERO);
        let offset = if shifted { self.vectors(None, pastes.len(), |k| pastes[k].offset.to_array()) } else { None };
        for (key, accessor) in [("patch", patch), ("faceOffset", offsets), ("face", face), ("uv", uv), ("offset", offset)] {
            if let Some(accessor) = accessor {
                value[key] = accessor.into();
            }
        }
        value
    }

    /// The whole JSON: the model as a plain primitive, and the extension.
    fn document(&mut self, record: &'a Record, extension: Value) -> Value {
        let model = &record.model;
        let mut attributes = Map::new();
        let mut put = |name: &str, accessor: Option<usize>| accessor.map(|a| attributes.insert(name.into(), a.into()));
        let positions = self.vectors(Some(VERTICES), model.positions.len(), |k| model.positions[k].to_array());
        if let Some(accessor) = positions {
            let start = (Vec3::INFINITY, Vec3::NEG_INFINITY);
            let (low, high) = model.positions.iter().fold(start, |(lo, hi), &p| (lo.min(p), hi.max(p)));
            self.bound(accessor, &low.as_dvec3().to_array(), &high.as_dvec3().to_array());
        }
        put("POSITION", positions);
        put("NORMAL", model.normals.as_ref().and_then(|n| self.vectors(Some(VERTICES), n.len(), |k| n[k].to_array())));
        put("TEXCOORD_0", model.uvs.as_ref().and_then(|t| self.vectors(Some(VERTICES), t.len(), |k| t[k].to_array())));
        put("COLOR_0", model.colors.as_ref().and_then(|c| self.vectors(Some(VERTICES), c.len(), |k| c[k].to_array())));
        let indices = self.whole(Some(INDICES), model.faces.as_flattened());
        let moving = model.motion.as_ref().map(|m| self.motion(m, model.positions.len(), &mut attributes));
        let mut document = json!({
            "asset": { "version": "2.0", "generator": record.generator },
            "scene": 0,
            "scenes": [{ "nodes": [0] }],
            "nodes": [{ "mesh": 0, "name": model.name }],
            "meshes": [{ "name": model.name, "primitives": [{ "attributes": attributes, "indices": indices, "material": 0 }] }],
            "materials": [{
                "name": "neutral",
                "pbrMetallicRoughness": { "baseColorFactor": [0.8, 0.8, 0.8, 1.0], "metallicFactor": 0.0, "roughnessFactor": 0.8 },
                "doubleSided": true,
            }],
            "accessors": self.accessors,
            "bufferViews": self.views,
            "buffers": [{ "byteLength": self.length }],
            "extensionsUsed": [EXTENSION],
            "extensions": { EXTENSION: extension },
        });
        if let Some(moving) = moving {
            add_motion(&mut document, moving);
        }
        if !self.textures.is_empty() {
            document["images"] = json!(self.images);
            document["textures"] = json!(self.textures);
            // In the order of `Wrap`: clamp to edge, repeat.
            document["samplers"] = json!([{ "wrapS": 33071, "wrapT": 33071 }, { "wrapS": 10497, "wrapT": 10497 }]);
        }
        document
    }
}

/// Lets the mesh of a document move.
fn add_motion(document: &mut Value, moving: Moving) {
    let Moving { nodes, root, skin, animations, targets, weights, names } = moving;
    document["scenes"][0]["nodes"] = json!([0, root]);
    document["nodes"][0]["skin"] = json!(0);
    if let Some(list) = document["nodes"].as_array_mut() {
        list.extend(nodes);
    }
    document["skins"] = json!([skin]);
    if !animations.is_empty() {
        document["animations"] = animations.into();
    }
    if !targets.is_empty() {
        let mesh = &mut document["meshes"][0];
        mesh["primitives"][0]["targets"] = targets.into();
        mesh["weights"] = json!(weights);
        mesh["extras"] = json!({ "targetNames": names });
    }
}

/// What an accessor holds.
pub(super) struct Shape {
    pub(super) name: &'static str,
    pub(super) component: u32,
    pub(super) target: Option<u32>,
}

impl Shape {
    /// Bytes of an element.
    fn bytes(&self) -> u64 {
        let components = match self.name {
            "VEC2" => 2,
            "VEC3" => 3,
            "VEC4" => 4,
            "MAT4" => 16,
            _ => 1,
        };
        components * if self.component == U16 { 2 } else { 4 }
    }
}
