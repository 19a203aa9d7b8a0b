//! Writing a vertex texture: GLB or PLY by the file's ending.

use super::{FormatError, Model, Record, write_file, write_record};
use crate::exemplar::{Channel, srgb};
use crate::mesh::Mesh;
use crate::synth::VertexTexture;
use glam::{Vec3, Vec4};
use std::io::{self, Write};
use std::path::Path;

/// Endings that can be written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// Binary glTF, colours in COLOR_0.
    Glb,
    /// PLY, binary, all channels as properties.
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
            Some("ply") => Ok(Self::Ply),
            _ => Err(FormatError::Write {
                path: path.to_owned(),
                what: "vertex textures are written as .glb or .ply".into(),
                remedy: "give the name one of these endings".into(),
            }),
        }
    }
}

/// Writes a vertex texture on `mesh`, which is the texture's own or that one displaced.
///
/// # Errors
/// If the file cannot be written.
pub fn write_vertices(path: &Path, kind: Kind, name: &str, mesh: &Mesh, texture: &VertexTexture) -> Result<(), FormatError> {
    match kind {
        Kind::Ply => write_file(path, |out| ply(out, mesh, texture)),
        Kind::Glb => {
            let colors = texture.channel(Channel::BaseColor).map(|c| {
                let opacity = texture.channel(Channel::Opacity);
                let alpha = |v: usize| opacity.map_or(1.0, |o| o[v]);
                c.as_chunks::<3>().0.iter().enumerate().map(|(v, &[r, g, b])| Vec4::new(r, g, b, alpha(v))).collect()
            });
            let normals = Some(mesh.vertex_normals().iter().map(|n| n.normalize_or(Vec3::Z)).collect());
            let model = Model {
                name: name.to_owned(),
                positions: mesh.positions.clone(),
                faces: mesh.faces.clone(),
                normals,
                colors,
                ..Model::default()
            };
            let generator = concat!("lapped ", env!("CARGO_PKG_VERSION")).to_owned();
            write_record(path, &Record { model, generator, ..Record::default() })
        }
    }
}

/// Colours as bytes in sRGB, which is how everybody reads them; every other channel as floats.
fn ply(out: &mut dyn Write, mesh: &Mesh, texture: &VertexTexture) -> io::Result<()> {
    write!(
        out,
        "ply\nformat binary_little_endian 1.0\nelement vertex {}\nproperty float x\nproperty float y\nproperty float z\n",
        mesh.vertex_count()
    )?;
    for (channel, _) in texture.all() {
        match channel {
            Channel::BaseColor => write!(out, "property uchar red\nproperty uchar green\nproperty uchar blue\n")?,
            c if c.components() == 3 => {
                ["x", "y", "z"].iter().try_for_each(|k| writeln!(out, "property float {}_{k}", c.name()))?;
            }
            c => writeln!(out, "property float {}", c.name())?,
        }
    }
    write!(out, "element face {}\nproperty list uchar uint vertex_indices\nend_header\n", mesh.face_count())?;
    for (v, p) in mesh.positions.iter().enumerate() {
        out.write_all(p.to_array().map(f32::to_le_bytes).as_flattened())?;
        for (channel, values) in texture.all() {
            let n = channel.components();
            for &x in &values[v * n..(v + 1) * n] {
                match channel {
                    Channel::BaseColor => out.write_all(&[(srgb::encode(x).clamp(0.0, 1.0) * 255.0).round() as u8])?,
                    _ => out.write_all(&x.to_le_bytes())?,
                }
            }
        }
    }
    mesh.faces.iter().try_for_each(|f| {
        out.write_all(&[3])?;
        out.write_all(f.map(u32::to_le_bytes).as_flattened())
    })
}
