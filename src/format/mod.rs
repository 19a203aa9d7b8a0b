//! Reading and writing: meshes ([`read_model`]), exemplars, images, and the lapped-texture record.
//!
//! What a file is gets decided by its content first and its name second. Meshes come out as a [`Model`], which is what the
//! file holds and nothing more; [`crate::mesh::clean()`] makes a mesh of it. Readers allocate in proportion to the bytes they
//! are given, never to a number that a file declares. Everything is written to a temporary file first and then renamed.

pub(crate) mod corners;
mod error;
pub mod export;
mod frames;
mod gltf;
mod ktx2;
mod look;
mod material;
mod model;
pub mod motion;
mod obj;
mod output;
mod picture;
mod pixels;
mod ply;
mod polygon;
pub mod record;
mod stl;
mod text;
pub mod vertices;

pub use error::{FormatError, Warning};
pub use look::{Look, read_look, read_look_bytes};
pub use material::{
    ExemplarOptions, FRAMES_PER_SECOND, FrameOptions, FrameSource, NormalConvention, read_exemplar, read_exemplar_bytes, read_mask,
};
pub use model::{FaceGroup, Model, Source};
pub use motion::{Motion, MotionError};
pub use output::{abandon_outputs, check_output, write_file};
pub use picture::{save_channel, save_image};
pub use record::{Record, holds_record, read_record, read_record_bytes, write_record};
pub use vertices::write_vertices;

use std::path::Path;

/// Reads a mesh file: OBJ, PLY, STL, glTF or GLB.
///
/// # Errors
/// If the file cannot be read, is none of these, is malformed, or holds no faces.
pub fn read_model(path: &Path) -> Result<Model, FormatError> {
    read_model_bytes(path, &read_file(path, "the mesh file")?)
}

/// Reads a mesh from the bytes of a file; `path` is for its name, for messages and for files beside it.
///
/// # Errors
/// As [`read_model`].
pub fn read_model_bytes(path: &Path, file: &[u8]) -> Result<Model, FormatError> {
    if file.is_empty() {
        return Err(FormatError::Empty { path: path.to_owned() });
    }
    let parsed = match MeshKind::of(path, file)? {
        MeshKind::Obj => obj::parse(file),
        MeshKind::Ply => ply::parse(file),
        MeshKind::Stl => stl::parse(file),
        MeshKind::Gltf => gltf::parse(file, path.parent()),
    };
    let mut model = parsed.map_err(|problem| FormatError::malformed(path, problem))?;
    if model.name.is_empty() {
        model.name = path.file_stem().map(|s| s.to_string_lossy().into_owned()).unwrap_or_default();
    }
    Ok(model)
}

/// The bytes of a file; `wanted` says in an error what to name instead of a folder.
///
/// # Errors
/// If there is no such file, it is a folder, or it cannot be read.
pub fn read_file(path: &Path, wanted: &'static str) -> Result<Vec<u8>, FormatError> {
    if path.is_dir() {
        return Err(FormatError::Folder { path: path.to_owned(), wanted });
    }
    std::fs::read(path).map_err(|source| match source.kind() {
        std::io::ErrorKind::NotFound => FormatError::Missing { path: path.to_owned() },
        _ => FormatError::Read { path: path.to_owned(), source },
    })
}

/// Kinds of mesh files.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum MeshKind {
    Obj,
    Ply,
    Stl,
    Gltf,
}

impl MeshKind {
    fn of(path: &Path, file: &[u8]) -> Result<Self, FormatError> {
        let extension = path.extension().map(|e| e.to_string_lossy().to_ascii_lowercase()).unwrap_or_default();
        let start = file.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(file).trim_ascii_start();
        if gltf::glb::is_glb(file) {
            Ok(Self::Gltf)
        } else if start.starts_with(b"ply") && start.get(3).is_some_and(u8::is_ascii_whitespace) {
            Ok(Self::Ply)
        } else if let Some(found) = foreign(file) {
            let remedy = "export the mesh as glTF, OBJ, PLY or STL".into();
            Err(FormatError::Unknown {
                path: path.to_owned(),
                found: format!("this is {found}, which is not read as a mesh"),
                remedy,
            })
        } else if stl::is_binary(file) {
            Ok(Self::Stl)
        } else if start.starts_with(b"{") {
            Ok(Self::Gltf)
        } else if obj::looks_like(start) {
            Ok(Self::Obj)
        } else if stl::looks_ascii(file) || extension == "stl" {
            Ok(Self::Stl)
        } else if extension == "obj" && !file.contains(&0) {
            Ok(Self::Obj)
        } else {
            let found = if extension.is_empty() {
                "this is no mesh file known here".into()
            } else {
                format!("this is no mesh file known here, whatever its ending .{extension} says")
            };
            Err(FormatError::Unknown { path: path.to_owned(), found, remedy: "name an OBJ, PLY, STL, glTF or GLB file".into() })
        }
    }
}

/// Other kinds of file that are often tried, by their first bytes.
fn foreign(file: &[u8]) -> Option<&'static str> {
    const KNOWN: [(&[u8], &str); 17] = [
        (b"Kaydara FBX", "an FBX file"),
        (b"; FBX", "an FBX file"),
        (b"BLENDER", "a Blender file"),
        (b"PXR-USDC", "a USD file"),
        (b"#usda", "a USD file"),
        (b"PK\x03\x04", "a ZIP archive (USDZ, 3MF or a packed download)"),
        (b"\x1f\x8b", "a gzip archive"),
        (b"<?xml", "an XML file (Collada or X3D)"),
        (b"<COLLADA", "a Collada file"),
        (b"#VRML", "a VRML file"),
        (b"OFF", "an OFF file"),
        (b"\x89PNG", "a PNG image"),
        (b"\xFF\xD8\xFF", "a JPEG image"),
        (b"\x76\x2f\x31\x01", "an OpenEXR image"),
        (b"#?RADIANCE", "an HDR image"),
        (b"%PDF", "a PDF document"),
        (b"# vtk DataFile", "a VTK file"),
    ];
    KNOWN.iter().find(|(magic, _)| file.starts_with(magic)).map(|(_, name)| *name)
}
