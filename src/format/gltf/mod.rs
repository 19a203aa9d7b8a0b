//! glTF 2.0, as JSON with its buffers or as one GLB file.
//!
//! Read as Khronos specifies, leniently where a rule does not matter to geometry: the whole default scene, node
//! transforms (mirroring ones turn faces), triangles, strips and fans, sparse and quantised accessors, every index type,
//! data URIs and external buffers. Skins, morph targets and animations become a [`crate::format::Motion`].

pub(crate) mod accessor;
pub(crate) mod build;
pub(crate) mod document;
pub(crate) mod glb;
pub(crate) mod motion;
mod motion_out;
pub(crate) mod scene;
pub(crate) mod scene_out;
pub(crate) mod uri;

use super::error::Problem;
use super::model::Model;
use accessor::Data;
use document::Document;
use std::path::Path;

/// Reads a GLB or a glTF document whose external buffers lie in `folder`.
pub(crate) fn parse(file: &[u8], folder: Option<&Path>) -> Result<Model, Problem> {
    let (json, bin, format) = if glb::is_glb(file) {
        let (json, bin) = glb::split(file)?;
        (json, bin, "glTF (binary)")
    } else {
        (file, None, "glTF")
    };
    let document = Document::parse(json)?;
    let buffers = uri::load_buffers(&document, bin, folder)?;
    scene::read_scene(&Data { document: &document, buffers: &buffers }, format)
}
