//! Writing models for other tools: GLB, glTF with its files, OBJ with MTL, PLY.
//!
//! GLB holds everything in one file. glTF and OBJ keep images beside the document, named after it; PLY knows no images of
//! its own, so they lie beside it too, the first named in a comment that viewers follow.

mod gltf;
mod layers;
mod obj;
mod ply;

pub use layers::{LayersReport, write_layers};

use super::ktx2;
use super::look::Look;
use super::model::Model;
use super::output::write_file;
use super::pixels::{Pixels, Slot, slots};
use super::{FormatError, Record, write_record};
use crate::mesh::Mesh;
use glam::Vec3;
use rayon::prelude::*;
use std::path::{Path, PathBuf};

/// Kinds of file that can be written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// Binary glTF, one file.
    Glb,
    /// glTF with a .bin and images beside it.
    Gltf,
    /// Wavefront OBJ with an MTL and images beside it.
    Obj,
    /// PLY, binary.
    Ply,
}

impl Kind {
    /// The kind of file that a path's ending asks for.
    ///
    /// # Errors
    /// If there is no such kind.
    pub fn of(path: &Path) -> Result<Self, FormatError> {
        match path.extension().map(|e| e.to_string_lossy().to_ascii_lowercase()).as_deref() {
            Some("glb") => Ok(Self::Glb),
            Some("gltf") => Ok(Self::Gltf),
            Some("obj") => Ok(Self::Obj),
            Some("ply") => Ok(Self::Ply),
            _ => Err(FormatError::Write {
                path: path.to_owned(),
                what: "no kind of model is known by this ending".into(),
                remedy: "give the name the ending .glb, .gltf, .obj or .ply".into(),
            }),
        }
    }
}

/// A model with its look.
#[derive(Debug, Clone, Copy)]
pub struct Export<'a> {
    /// The model.
    pub model: &'a Model,
    /// How it looks.
    pub look: &'a Look,
    /// Name and version of the program that made it.
    pub generator: &'a str,
}

/// Writes a model with its look; returns the files written beside the one named.
///
/// # Errors
/// If a file cannot be written.
pub fn write_look(path: &Path, kind: Kind, export: &Export<'_>) -> Result<Vec<PathBuf>, FormatError> {
    let (model, look) = (export.model, export.look);
    look.check(model.positions.len(), model.faces.len()).map_err(|(place, what)| FormatError::Write {
        path: path.to_owned(),
        what: format!("{place}: {what}"),
        remedy: "this is a fault of the program that made the bake".into(),
    })?;
    match kind {
        Kind::Glb => gltf::write_glb(path, export).map(|()| Vec::new()),
        Kind::Gltf => gltf::write_gltf(path, export),
        Kind::Obj => obj::write_textured(path, export),
        Kind::Ply => ply::write_textured(path, export),
    }
}

/// Writes a mesh without any look; a GLB also keeps a vector for each face, which `lapped render --style field` shows.
///
/// # Errors
/// If the file cannot be written.
pub fn write_mesh(path: &Path, kind: Kind, name: &str, mesh: &Mesh, field: Option<Vec<Vec3>>) -> Result<(), FormatError> {
    match kind {
        Kind::Obj => write_file(path, |out| obj::plain(out, mesh)),
        Kind::Ply => write_file(path, |out| ply::plain(out, mesh)),
        Kind::Glb | Kind::Gltf => {
            let model =
                Model { name: name.to_owned(), positions: mesh.positions.clone(), faces: mesh.faces.clone(), ..Model::default() };
            let generator = concat!("lapped ", env!("CARGO_PKG_VERSION")).to_owned();
            write_record(path, &Record { model, field, generator, ..Record::default() })
        }
    }
}

/// Writes the mip levels of a look beside a file, for each page and map a KTX 2.0 file of all its levels; returns their paths.
///
/// # Errors
/// If a file cannot be written.
pub fn write_mips(path: &Path, look: &Look) -> Result<Vec<PathBuf>, FormatError> {
    let mut written = Vec::new();
    for (page, (finest, coarser)) in look.pages.iter().zip(&look.mips).enumerate() {
        for slot in slots(finest) {
            let file = path.with_file_name(image_name(path, look, page, slot)).with_extension("ktx2");
            let levels: Result<Vec<Pixels>, String> =
                std::iter::once(finest).chain(coarser).map(|images| Pixels::new(images, slot)).collect();
            let levels = levels.map_err(|what| FormatError::Write {
                path: file.clone(),
                what,
                remedy: "this is a fault of the program that made the bake".into(),
            })?;
            let bytes = ktx2::encode(slot, &levels);
            write_file(&file, |out| out.write_all(&bytes))?;
            written.push(file);
        }
    }
    Ok(written)
}

/// The name of an image beside a file: its stem, the page if there are several, and what the image holds.
fn image_name(path: &Path, look: &Look, page: usize, slot: Slot) -> String {
    let stem = path.file_stem().map(|s| s.to_string_lossy().into_owned()).unwrap_or_default();
    let page = if look.pages.len() > 1 { format!("_{page}") } else { String::new() };
    format!("{stem}{page}_{}.png", slot.name())
}

/// Encodes and writes images beside a file; returns their paths.
fn write_images(path: &Path, look: &Look, slots: impl Fn(usize) -> Vec<Slot>) -> Result<Vec<PathBuf>, FormatError> {
    let all: Vec<(usize, Slot)> = (0..look.pages.len()).flat_map(|page| slots(page).into_iter().map(move |s| (page, s))).collect();
    let encoded: Vec<(PathBuf, Result<Vec<u8>, String>)> = all
        .into_par_iter()
        .map(|(page, slot)| (path.with_file_name(image_name(path, look, page, slot)), look.png(page, slot)))
        .collect();
    let mut written = Vec::new();
    for (file, png) in encoded {
        let png = png.map_err(|what| FormatError::Write { path: file.clone(), what, remedy: "bake at a smaller size".into() })?;
        write_file(&file, |out| out.write_all(&png))?;
        written.push(file);
    }
    Ok(written)
}
