//! glTF of a model with its look: one GLB, or a document with its buffer and images beside it.

use super::{Export, image_name, write_images};
use crate::format::FormatError;
use crate::format::gltf::build::Builder;
use crate::format::gltf::scene_out::add_scene;
use crate::format::output::write_file;
use serde_json::json;
use std::path::{Path, PathBuf};

fn fail(path: &Path, what: String) -> FormatError {
    FormatError::Write { path: path.to_owned(), what, remedy: "bake at a smaller size".into() }
}

pub(super) fn write_glb(path: &Path, export: &Export<'_>) -> Result<(), FormatError> {
    let mut tables = Builder::default();
    let parts = add_scene(&mut tables, export.model, Some(export.look)).map_err(|what| fail(path, what))?;
    let document = tables.document(export.generator, parts);
    tables.write_glb(path, &document)
}

pub(super) fn write_gltf(path: &Path, export: &Export<'_>) -> Result<Vec<PathBuf>, FormatError> {
    let look = export.look;
    let mut tables = Builder::with_images_beside(|page, slot| image_name(path, look, page, slot));
    let parts = add_scene(&mut tables, export.model, Some(look)).map_err(|what| fail(path, what))?;
    let mut document = tables.document(export.generator, parts);
    let bin = path.with_extension("bin");
    document["buffers"][0]["uri"] = json!(bin.file_name().map(|n| n.to_string_lossy().into_owned()).unwrap_or_default());
    let mut written = write_images(path, look, |page| look.slots(page))?;
    write_file(&bin, |out| tables.write_data(out))?;
    written.push(bin);
    write_file(path, |out| writeln!(out, "{document}"))?;
    Ok(written)
}
