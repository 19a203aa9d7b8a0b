//! PLY, binary.

use super::{Export, image_name, write_images};
use crate::exemplar::{Channel, srgb};
use crate::format::FormatError;
use crate::format::output::write_file;
use crate::format::pixels::Slot;
use crate::mesh::Mesh;
use glam::Vec2;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// A mesh, positions and faces.
pub(super) fn plain(out: &mut dyn Write, mesh: &Mesh) -> io::Result<()> {
    write!(
        out,
        "ply\nformat binary_little_endian 1.0\nelement vertex {}\nproperty float x\nproperty float y\nproperty float z\n\
         element face {}\nproperty list uchar uint vertex_indices\nend_header\n",
        mesh.vertex_count(),
        mesh.face_count()
    )?;
    mesh.positions.iter().try_for_each(|p| out.write_all(p.to_array().map(f32::to_le_bytes).as_flattened()))?;
    faces(out, &mesh.faces)
}

fn faces(out: &mut dyn Write, faces: &[[u32; 3]]) -> io::Result<()> {
    faces.iter().try_for_each(|f| {
        out.write_all(&[3])?;
        out.write_all(f.map(u32::to_le_bytes).as_flattened())
    })
}

/// A model with its look: texture coordinates (s, t), the image named in the comment that viewers follow, and the colour at
/// each vertex for those that do not.
pub(super) fn write_textured(path: &Path, export: &Export<'_>) -> Result<Vec<PathBuf>, FormatError> {
    let (model, look) = (export.model, export.look);
    let written = write_images(path, look, |page| look.slots(page))?;
    let mut page_of = vec![0_usize; model.positions.len()];
    for (corners, &page) in model.faces.iter().zip(&look.face_page) {
        corners.iter().for_each(|&v| page_of[v as usize] = page as usize);
    }
    let color = |v: usize| -> [u8; 3] {
        let image = look.pages[page_of[v]].iter().find(|(c, _)| *c == Channel::BaseColor).map(|(_, image)| image);
        image.map_or([255; 3], |image| {
            let at = look.uv[v] * Vec2::from(image.size().map(|s| s as f32));
            image.bilinear(at).to_array().map(srgb::to_byte)
        })
    };
    write_file(path, |out| {
        write!(out, "ply\nformat binary_little_endian 1.0\ncomment made by {}\n", export.generator)?;
        for page in 0..look.pages.len() {
            writeln!(out, "comment TextureFile {}", image_name(path, look, page, Slot::Color))?;
        }
        write!(out, "element vertex {}\nproperty float x\nproperty float y\nproperty float z\n", model.positions.len())?;
        if model.normals.is_some() {
            write!(out, "property float nx\nproperty float ny\nproperty float nz\n")?;
        }
        write!(
            out,
            "property float s\nproperty float t\nproperty uchar red\nproperty uchar green\nproperty uchar blue\n\
             element face {}\nproperty list uchar uint vertex_indices\nend_header\n",
            model.faces.len()
        )?;
        for v in 0..model.positions.len() {
            out.write_all(model.positions[v].to_array().map(f32::to_le_bytes).as_flattened())?;
            if let Some(normals) = &model.normals {
                out.write_all(normals[v].to_array().map(f32::to_le_bytes).as_flattened())?;
            }
            out.write_all([look.uv[v].x, 1.0 - look.uv[v].y].map(f32::to_le_bytes).as_flattened())?;
            out.write_all(&color(v))?;
        }
        faces(out, &model.faces)
    })?;
    Ok(written)
}
