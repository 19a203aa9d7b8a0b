//! Files: binary PLY, OBJ and PNG, as bytes in memory.

use super::Triangles;
use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{ExtendedColorType, ImageEncoder, ImageError};
use std::fmt::Write;

/// Little-endian binary PLY with float positions and `vertex_indices` as lists of uchar and int.
pub(crate) fn ply(mesh: &Triangles) -> Vec<u8> {
    let (vertices, faces) = (mesh.positions.len(), mesh.faces.len());
    let mut out = format!(
        "ply\nformat binary_little_endian 1.0\nelement vertex {vertices}\nproperty float x\nproperty float y\nproperty float z\n\
         element face {faces}\nproperty list uchar int vertex_indices\nend_header\n"
    )
    .into_bytes();
    for p in &mesh.positions {
        for c in p.as_vec3().to_array() {
            out.extend(c.to_le_bytes());
        }
    }
    for face in &mesh.faces {
        out.push(3);
        for &v in face {
            out.extend((v as i32).to_le_bytes());
        }
    }
    out
}

/// Wavefront OBJ, positions only.
pub(crate) fn obj(mesh: &Triangles) -> Vec<u8> {
    let mut out = String::new();
    for p in &mesh.positions {
        let _ = writeln!(out, "v {:.5} {:.5} {:.5}", p.x, p.y, p.z);
    }
    for [a, b, c] in &mesh.faces {
        let _ = writeln!(out, "f {} {} {}", a + 1, b + 1, c + 1);
    }
    out.into_bytes()
}

/// A square 8-bit PNG of one or three components.
///
/// # Errors
/// If the encoder refuses the sizes.
pub(crate) fn png(pixels: &[u8], size: usize, components: usize) -> Result<Vec<u8>, ImageError> {
    let color = if components == 1 { ExtendedColorType::L8 } else { ExtendedColorType::Rgb8 };
    let mut out = Vec::new();
    PngEncoder::new_with_quality(&mut out, CompressionType::Best, FilterType::Adaptive).write_image(
        pixels,
        size as u32,
        size as u32,
        color,
    )?;
    Ok(out)
}
