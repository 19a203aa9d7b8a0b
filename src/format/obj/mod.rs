//! Wavefront OBJ, read with [`tobj`]: polygons of any number of corners, negative indices, objects, groups, materials,
//! vertex colours.
//!
//! 1. [`statements`] goes over the lines once: it hands on those that hold geometry, free of what tobj would misread, and
//!    takes down names, counts and notes.
//! 2. tobj reads numbers, indices and polygons. It numbers vertices, texture coordinates and normals by their first use
//!    and drops those that are not used; triangles that name them all in order come first, so that its numbers are the
//!    file's. There are no object or material lines, so all is one tobj model and the faces keep the file's order.
//! 3. Polygons are cut, and corners joined to vertices.
//!
//! tobj tells no lines; if it cannot read a number, a second look at the text finds where. Material files are not opened:
//! only their names matter. Curves, surfaces, lines and points are left out with a note.

mod statements;

use super::corners::{cut_polygons, first_face, join_corners};
use super::error::Problem;
use super::model::{FaceGroup, Model};
use super::text::{Lines, at_line, float_at, words};
use crate::exemplar::srgb;
use crate::mesh::NONE;
use glam::{Vec2, Vec3, Vec4};
use statements::{Names, Statements, Survey, geometry};
use std::collections::HashMap;
use std::io::{Read as _, Write as _};
use std::path::Path;

/// Reads a whole file.
pub(crate) fn parse(text: &[u8]) -> Result<Model, Problem> {
    let mut survey = Survey::of(text)?;
    let mesh = match load(&mut survey) {
        Ok(mesh) if mesh.positions.iter().all(|c| c.is_finite()) => mesh,
        Ok(_) => return Err(bad_number(text, "a coordinate is not finite")),
        Err(error) => return Err(bad_number(text, &error.to_string())),
    };
    to_model(mesh, survey)
}

/// Has tobj read the lines of `survey`, which are used up.
fn load(survey: &mut Survey) -> Result<tobj::Mesh, tobj::LoadError> {
    let lines = std::mem::take(&mut survey.lines);
    let (first, corners) = naming_triangles(survey.counts);
    let no_materials = |_: &Path| Ok((Vec::new(), HashMap::new()));
    let mut all = first.chain(lines.as_slice());
    let (models, _) = tobj::load_obj_buf(&mut all, &tobj::LoadOptions::default(), no_materials)?;
    let mut mesh = models.into_iter().next().map(|m| m.mesh).unwrap_or_default();
    for indices in [&mut mesh.indices, &mut mesh.texcoord_indices, &mut mesh.normal_indices] {
        indices.drain(..corners.min(indices.len()));
    }
    mesh.face_arities.drain(..(corners / 3).min(mesh.face_arities.len()));
    // Where a corner has no texture coordinate or normal, tobj repeats that of the corner before.
    for (k, &(start, form)) in survey.forms.iter().enumerate() {
        let end = survey.forms.get(k + 1).map_or(mesh.indices.len(), |next| next.0);
        for (has, indices) in form.into_iter().zip([&mut mesh.texcoord_indices, &mut mesh.normal_indices]) {
            if let (false, Some(run)) = (has, indices.get_mut(start..end)) {
                run.fill(NONE);
            }
        }
    }
    Ok(mesh)
}

/// Lines of triangles whose corners go through all vertices, texture coordinates and normals in order, and the number of
/// those corners.
fn naming_triangles(counts: [usize; 3]) -> (std::io::Cursor<Vec<u8>>, usize) {
    let corners = if counts[0] > 0 { counts.into_iter().max().unwrap_or(0).next_multiple_of(3) } else { 0 };
    let mut lines = Vec::new();
    for corner in 0..corners {
        lines.extend_from_slice(if corner % 3 == 0 { b"\nf " } else { b" " });
        for (kind, count) in counts.into_iter().enumerate() {
            if kind > 0 {
                lines.push(b'/');
            }
            if count > 0 {
                write!(lines, "{}", (corner + 1).min(count)).expect("a Vec takes any bytes");
            }
        }
    }
    lines.push(b'\n');
    (std::io::Cursor::new(lines), corners)
}

/// What is wrong with the first number that cannot be used; `otherwise` if there is none to be found.
fn bad_number(text: &[u8], otherwise: &str) -> Problem {
    let found = Statements::of(text).find_map(|(number, line)| check_numbers(number, &geometry(&line)).err());
    found.unwrap_or_else(|| Problem::damaged("", format!("the file cannot be read as OBJ: {otherwise}")))
}

fn check_numbers(line: usize, words: &[&[u8]]) -> Result<(), Problem> {
    let (count, what) = match words.first().copied() {
        Some(b"v") => (3, "a coordinate of the vertex"),
        Some(b"vt") => (words.len().clamp(2, 3) - 1, "the texture coordinate"),
        Some(b"vn") => (3, "a component of the normal"),
        _ => return Ok(()),
    };
    for k in 1..=count {
        let number = float_at(words.get(k).copied(), line, what)?;
        if words[0] == b"v" && !number.is_finite() {
            let what = format!("{what} is NaN, infinite or beyond 32-bit range");
            return Err(Problem::new(at_line(line), what, "repair the mesh where it was made"));
        }
    }
    Ok(())
}

fn to_model(mesh: tobj::Mesh, survey: Survey) -> Result<Model, Problem> {
    let mut model = Model::default();
    model.source.format = "Wavefront OBJ".into();
    model.source.notes = survey.notes();
    model.source.vertices = survey.counts[0];
    model.source.polygons = survey.polygons;
    model.source.unit = survey.unit;
    model.name = survey.runs.iter().map(|(_, n)| n.object.clone()).find(|o| !o.is_empty()).unwrap_or_default();

    let positions: Vec<Vec3> = mesh.positions.as_chunks().0.iter().copied().map(Vec3::from_array).collect();
    let ends = ends_of(&mesh);
    let (mut faces, polygons) = cut_polygons(&ends, |c| positions[mesh.indices[c as usize] as usize]);
    for (k, (polygon, names)) in survey.runs.iter().enumerate() {
        let first = |polygon| first_face(polygons.as_deref(), faces.len(), polygon);
        if k == 0 {
            model.groups.push(FaceGroup { count: first(*polygon), ..FaceGroup::default() });
        }
        let next = survey.runs.get(k + 1).map_or(ends.len() as u32, |(p, _)| *p);
        let Names { object, group, material } = names.clone();
        let start = first(*polygon);
        model.groups.push(FaceGroup { object, group, material, start, count: first(next) - start });
    }
    // tobj's lists of indices are empty where the file has nothing of the kind.
    let index = |indices: &[u32], c: u32| indices.get(c as usize).copied().unwrap_or(NONE);
    let kept = join_corners(&mut faces, positions.len(), |c| {
        (mesh.indices[c as usize], [index(&mesh.texcoord_indices, c), index(&mesh.normal_indices, c)])
    });
    model.faces = faces;
    model.polygons = polygons;
    let attribute = |entry: &(u32, Option<[u32; 2]>), which: usize| entry.1.map_or(NONE, |a| a[which]) as usize;
    if mesh.texcoord_indices.iter().any(|&i| i != NONE) {
        let texture = mesh.texcoords.as_chunks().0;
        let uv = |k| texture.get(attribute(k, 0)).map_or(Vec2::ZERO, |&[u, v]| Vec2::new(u, 1.0 - v));
        model.uvs = Some(kept.iter().map(uv).collect());
    }
    if mesh.normal_indices.iter().any(|&i| i != NONE) {
        let normals = mesh.normals.as_chunks().0;
        let normal = |k| normals.get(attribute(k, 1)).copied().map_or(Vec3::ZERO, Vec3::from_array);
        model.normals = Some(kept.iter().map(normal).collect());
    }
    if !mesh.vertex_color.is_empty() {
        // Some exporters write 0 to 255.
        let scale = if mesh.vertex_color.iter().any(|&c| c > 1.0) { 1.0 / 255.0 } else { 1.0 };
        let colors = mesh.vertex_color.as_chunks().0;
        let color = |&[r, g, b]: &[f32; 3]| srgb::decode_color((Vec3::new(r, g, b) * scale).extend(1.0));
        model.colors = Some(kept.iter().map(|k| colors.get(k.0 as usize).map_or(Vec4::ONE, color)).collect());
    }
    model.positions =
        if kept.len() == positions.len() { positions } else { kept.iter().map(|&(v, _)| positions[v as usize]).collect() };
    model.finish(|v| format!("vertex {}", v + 1))
}

/// For each polygon the end of its corners.
fn ends_of(mesh: &tobj::Mesh) -> Vec<u32> {
    // No arities: all are triangles.
    let triangles = if mesh.face_arities.is_empty() { mesh.indices.len() / 3 } else { 0 };
    let arities = mesh.face_arities.iter().copied().chain(std::iter::repeat_n(3, triangles));
    arities
        .scan(0, |end, arity| {
            *end += arity;
            Some(*end)
        })
        .collect()
}

/// True if a text's first statements are those of an OBJ file.
pub(crate) fn looks_like(text: &[u8]) -> bool {
    const LINES_LOOKED_AT: usize = 1000;
    const STATEMENTS: [&[u8]; 12] = [b"v", b"vt", b"vn", b"vp", b"f", b"o", b"g", b"s", b"l", b"p", b"usemtl", b"mtllib"];
    let mut lines = Lines::new(text);
    for _ in 0..LINES_LOOKED_AT {
        let Some((_, line)) = lines.next_line() else { return false };
        match words(line).next() {
            None => {}
            Some(word) if word[0] == b'#' => {}
            Some(word) => return STATEMENTS.contains(&word),
        }
    }
    false
}
