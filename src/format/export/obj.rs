//! Wavefront OBJ and MTL.

use super::{Export, image_name, write_images};
use crate::exemplar::Channel;
use crate::format::FormatError;
use crate::format::output::write_file;
use crate::format::pixels::Slot;
use crate::mesh::Mesh;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// A mesh, positions and faces.
pub(super) fn plain(out: &mut dyn Write, mesh: &Mesh) -> io::Result<()> {
    mesh.positions.iter().try_for_each(|p| writeln!(out, "v {} {} {}", p.x, p.y, p.z))?;
    mesh.faces.iter().try_for_each(|f| writeln!(out, "f {} {} {}", f[0] + 1, f[1] + 1, f[2] + 1))
}

/// Image files that an MTL names, each by its statement. Names in files follow no standard for metallic and roughness but
/// the one most readers share.
fn slots(export: &Export<'_>, page: usize) -> Vec<(Slot, &'static str)> {
    let has = |c: Channel| export.look.pages[page].iter().any(|(other, _)| *other == c);
    [
        (Channel::BaseColor, Slot::Color, "map_Kd"),
        (Channel::Opacity, Slot::Opacity, "map_d"),
        (Channel::Normal, Slot::Normal, "norm"),
        (Channel::Roughness, Slot::Roughness, "map_Pr"),
        (Channel::Metallic, Slot::Metallic, "map_Pm"),
        (Channel::Occlusion, Slot::Occlusion, "map_Ka"),
        (Channel::Emissive, Slot::Emissive, "map_Ke"),
        (Channel::Height, Slot::Height, "disp"),
    ]
    .into_iter()
    .filter_map(|(channel, slot, statement)| has(channel).then_some((slot, statement)))
    .collect()
}

/// A model with its look: the OBJ, an MTL and images beside it.
pub(super) fn write_textured(path: &Path, export: &Export<'_>) -> Result<Vec<PathBuf>, FormatError> {
    let (model, look) = (export.model, export.look);
    let mut written = write_images(path, look, |page| slots(export, page).into_iter().map(|(slot, _)| slot).collect())?;
    let mtl = path.with_extension("mtl");
    write_file(&mtl, |out| {
        for page in 0..look.pages.len() {
            writeln!(out, "newmtl baked{page}\nKa 1 1 1\nKd 1 1 1\nKs 0 0 0\nillum 1")?;
            for (slot, statement) in slots(export, page) {
                writeln!(out, "{statement} {}", image_name(path, look, page, slot))?;
            }
        }
        Ok(())
    })?;
    let library = mtl.file_name().map(|n| n.to_string_lossy().into_owned()).unwrap_or_default();
    written.push(mtl);
    write_file(path, |out| {
        writeln!(out, "# {}\nmtllib {library}", export.generator)?;
        model.positions.iter().try_for_each(|p| writeln!(out, "v {} {} {}", p.x, p.y, p.z))?;
        // OBJ counts v from the bottom.
        look.uv.iter().try_for_each(|t| writeln!(out, "vt {} {}", t.x, 1.0 - t.y))?;
        let normals = model.normals.as_deref().unwrap_or_default();
        normals.iter().try_for_each(|n| writeln!(out, "vn {} {} {}", n.x, n.y, n.z))?;
        let mut page = None;
        for (f, corners) in model.faces.iter().enumerate() {
            let mine = look.face_page.get(f).copied().unwrap_or(0);
            if page != Some(mine) {
                writeln!(out, "usemtl baked{mine}")?;
                page = Some(mine);
            }
            write!(out, "f")?;
            for v in corners.map(|v| v + 1) {
                if normals.is_empty() { write!(out, " {v}/{v}")? } else { write!(out, " {v}/{v}/{v}")? }
            }
            writeln!(out)?;
        }
        Ok(())
    })?;
    Ok(written)
}
