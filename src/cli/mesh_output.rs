//! Writing a plain mesh: OBJ, PLY or GLB by the file's ending.

use crate::format::{FormatError, Model, Record, write_file, write_record};
use crate::mesh::Mesh;
use anyhow::bail;
use glam::Vec3;
use std::io::{self, Write};
use std::path::Path;

/// Endings that can be written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    /// Wavefront OBJ, text.
    Obj,
    /// PLY, binary.
    Ply,
    /// Binary glTF.
    Glb,
}

/// The kind of file that a path's ending asks for.
///
/// # Errors
/// If there is no such kind.
pub(super) fn kind(path: &Path) -> anyhow::Result<Kind> {
    match path.extension().map(|e| e.to_string_lossy().to_ascii_lowercase()).as_deref() {
        Some("obj") => Ok(Kind::Obj),
        Some("ply") => Ok(Kind::Ply),
        Some("glb") => Ok(Kind::Glb),
        _ => bail!("{}: meshes are written as .obj, .ply or .glb: give the name one of these endings", path.display()),
    }
}

/// Writes a mesh; a GLB also keeps a vector for each face, which `lapped render --style field` shows.
///
/// # Errors
/// If the file cannot be written.
pub(super) fn write(path: &Path, kind: Kind, name: &str, mesh: &Mesh, field: Option<Vec<Vec3>>) -> Result<(), FormatError> {
    match kind {
        Kind::Obj => write_file(path, |out| obj(out, mesh)),
        Kind::Ply => write_file(path, |out| ply(out, mesh)),
        Kind::Glb => {
            let model =
                Model { name: name.to_owned(), positions: mesh.positions.clone(), faces: mesh.faces.clone(), ..Model::default() };
            let generator = concat!("lapped ", env!("CARGO_PKG_VERSION")).to_owned();
            write_record(path, &Record { model, field, generator, ..Record::default() })
        }
    }
}

fn obj(out: &mut dyn Write, mesh: &Mesh) -> io::Result<()> {
    mesh.positions.iter().try_for_each(|p| writeln!(out, "v {} {} {}", p.x, p.y, p.z))?;
    mesh.faces.iter().try_for_each(|f| writeln!(out, "f {} {} {}", f[0] + 1, f[1] + 1, f[2] + 1))
}

fn ply(out: &mut dyn Write, mesh: &Mesh) -> io::Result<()> {
    write!(
        out,
        "ply\nformat binary_little_endian 1.0\nelement vertex {}\nproperty float x\nproperty float y\nproperty float z\n\
         element face {}\nproperty list uchar uint vertex_indices\nend_header\n",
        mesh.vertex_count(),
        mesh.face_count()
    )?;
    mesh.positions.iter().try_for_each(|p| out.write_all(p.to_array().map(f32::to_le_bytes).as_flattened()))?;
    mesh.faces.iter().try_for_each(|f| {
        out.write_all(&[3])?;
        out.write_all(f.map(u32::to_le_bytes).as_flattened())
    })
}
