//! A glTF document under construction: the tables of its JSON, and what will write its binary data. Lengths are known
//! beforehand, so the JSON goes first and all numbers are streamed after it; only encoded images are held.

use super::glb;
use crate::exemplar::Wrap;
use crate::format::FormatError;
use crate::format::output::write_file;
use crate::format::pixels::Slot;
use serde_json::{Map, Value, json};
use std::io::{self, Write};
use std::path::Path;

/// Codes of glTF component types.
pub(crate) const U16: u32 = 5123;
pub(crate) const U32: u32 = 5125;
pub(crate) const F32: u32 = 5126;
/// Codes of glTF buffer targets.
pub(crate) const VERTICES: u32 = 34962;
pub(crate) const INDICES: u32 = 34963;

pub(crate) type Part<'a> = Box<dyn Fn(&mut dyn Write) -> io::Result<()> + 'a>;

/// The tables.
#[derive(Default)]
pub(crate) struct Builder<'a> {
    parts: Vec<(u64, Part<'a>)>,
    length: u64,
    views: Vec<Value>,
    accessors: Vec<Value>,
    images: Vec<Value>,
    textures: Vec<Value>,
    /// Names of the image files of a look that lie beside the document, by page and slot; `None` keeps them inside.
    pub(crate) name_image: Option<Box<dyn Fn(usize, Slot) -> String + 'a>>,
}

impl<'a> Builder<'a> {
    /// Empty tables of a document whose look has its images beside it, named by page and slot.
    pub(crate) fn with_images_beside(name: impl Fn(usize, Slot) -> String + 'a) -> Self {
        Self { name_image: Some(Box::new(name)), ..Self::default() }
    }

    /// Adds a buffer view of `length` bytes; returns its number.
    pub(crate) fn view(&mut self, length: u64, target: Option<u32>, part: Part<'a>) -> usize {
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
    pub(crate) fn accessor(
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

    pub(crate) fn add_accessor(&mut self, accessor: Value) -> usize {
        self.accessors.push(accessor);
        self.accessors.len() - 1
    }

    /// States the least and the greatest of an accessor's numbers.
    pub(crate) fn bound(&mut self, accessor: usize, low: &[f64], high: &[f64]) {
        self.accessors[accessor]["min"] = json!(low);
        self.accessors[accessor]["max"] = json!(high);
    }

    pub(crate) fn vectors<const N: usize>(
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

    pub(crate) fn whole(&mut self, target: Option<u32>, items: &'a [u32]) -> Option<usize> {
        self.accessor(Shape { name: "SCALAR", component: U32, target }, items.len(), |out| {
            items.iter().try_for_each(|i| out.write_all(&i.to_le_bytes()))
        })
    }

    /// Adds a PNG as image and texture; returns the texture's number.
    pub(crate) fn texture(&mut self, name: String, png: Vec<u8>, wrap: Wrap) -> usize {
        let view = self.view(png.len() as u64, None, Box::new(move |out| out.write_all(&png)));
        self.images.push(json!({ "bufferView": view, "mimeType": "image/png", "name": name }));
        self.textures.push(json!({ "source": self.images.len() - 1, "sampler": wrap as usize }));
        self.textures.len() - 1
    }

    /// Adds an image file that lies beside the document.
    pub(crate) fn outer_texture(&mut self, name: String, uri: String, wrap: Wrap) -> usize {
        self.images.push(json!({ "uri": uri, "name": name }));
        self.textures.push(json!({ "source": self.images.len() - 1, "sampler": wrap as usize }));
        self.textures.len() - 1
    }

    /// The document around scenes, meshes and materials: everything the tables hold.
    pub(crate) fn document(&self, generator: &str, mut parts: Map<String, Value>) -> Value {
        parts.insert("asset".into(), json!({ "version": "2.0", "generator": generator }));
        parts.insert("accessors".into(), json!(self.accessors));
        parts.insert("bufferViews".into(), json!(self.views));
        parts.insert("buffers".into(), json!([{ "byteLength": self.length }]));
        if !self.textures.is_empty() {
            parts.insert("images".into(), json!(self.images));
            parts.insert("textures".into(), json!(self.textures));
            // In the order of `Wrap`: clamp to edge, repeat.
            parts.insert("samplers".into(), json!([{ "wrapS": 33071, "wrapT": 33071 }, { "wrapS": 10497, "wrapT": 10497 }]));
        }
        parts.into()
    }

    /// Writes the document and its data as GLB.
    ///
    /// # Errors
    /// If it is larger than the format's 4 GiB, or the file cannot be written.
    pub(crate) fn write_glb(&self, path: &Path, document: &Value) -> Result<(), FormatError> {
        let json = document.to_string();
        let size = glb::size(json.len(), self.length).ok_or_else(|| FormatError::Write {
            path: path.to_owned(),
            what: "a GLB cannot be larger than 4 GiB".into(),
            remedy: "use a larger texture scale, or split the mesh".into(),
        })?;
        write_file(path, |out| {
            glb::write_head(out, json.as_bytes(), self.length as u32, size)?;
            self.write_data(out)
        })
    }

    /// Writes the binary data.
    pub(crate) fn write_data(&self, out: &mut dyn Write) -> io::Result<()> {
        self.parts.iter().try_for_each(|(length, part)| {
            part(out)?;
            out.write_all(&[0; 3][..glb::padding(*length)])
        })
    }
}

/// What an accessor holds.
pub(crate) struct Shape {
    pub(crate) name: &'static str,
    pub(crate) component: u32,
    pub(crate) target: Option<u32>,
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
