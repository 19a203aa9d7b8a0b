//! STL, binary and ascii. It names no shared vertices: every triangle brings its own three, which cleaning welds.

use super::corners::cut_polygons;
use super::error::Problem;
use super::model::{FaceGroup, Model, stated_unit};
use super::text::{Lines, at_line, float_at, line_text, show, words};
use glam::Vec3;

/// Bytes before the first triangle of a binary file: 80 of comment and the number of triangles.
const HEADER: usize = 84;
/// Bytes of a triangle: normal, three corners, two bytes of attributes.
const TRIANGLE: usize = 50;

/// True if the file has exactly the length that its binary header declares. Decides before the word `solid` does: many
/// binary files begin with it too.
pub(crate) fn is_binary(file: &[u8]) -> bool {
    declared(file).is_some_and(|count| HEADER + TRIANGLE * count == file.len())
}

fn declared(file: &[u8]) -> Option<usize> {
    let (count, _) = file.get(80..)?.split_first_chunk()?;
    Some(u32::from_le_bytes(*count) as usize)
}

/// Reads a whole file.
pub(crate) fn parse(file: &[u8]) -> Result<Model, Problem> {
    if !is_binary(file) && looks_ascii(file) { parse_ascii(file) } else { parse_binary(file) }
}

/// True if the file begins with `solid` and has text where binary triangles would be.
pub(crate) fn looks_ascii(file: &[u8]) -> bool {
    let head = &file[..file.len().min(1024)];
    head.trim_ascii_start().get(..5).is_some_and(|w| w.eq_ignore_ascii_case(b"solid")) && !head.contains(&0)
}

fn parse_binary(file: &[u8]) -> Result<Model, Problem> {
    let count = declared(file).ok_or_else(|| Problem::damaged("", "the file is shorter than the header of a binary STL"))?;
    let body = &file[HEADER..];
    if body.len() < count * TRIANGLE {
        let what = format!("the header declares {count} triangles, but only {} follow", body.len() / TRIANGLE);
        return Err(Problem::damaged("", what));
    }
    let mut model = Model::default();
    let header = line_text(&file[..80]);
    model.source.format = "STL (binary)".into();
    model.source.unit = stated_unit(&header);
    model.source.vertices = 3 * count;
    model.source.polygons = count;
    if body.len() > count * TRIANGLE {
        let extra = body.len() - count * TRIANGLE;
        model.source.notes.push(format!("{extra} bytes after the last triangle were left out"));
    }
    model.positions.reserve_exact(3 * count);
    for triangle in body.chunks_exact(TRIANGLE).take(count) {
        for corner in triangle[12..48].chunks_exact(12) {
            let number = |k: usize| f32::from_le_bytes([corner[k], corner[k + 1], corner[k + 2], corner[k + 3]]);
            model.positions.push(Vec3::new(number(0), number(4), number(8)));
        }
    }
    model.faces = (0..count as u32).map(|f| [3 * f, 3 * f + 1, 3 * f + 2]).collect();
    model.finish(|v| format!("triangle {}", v / 3))
}

fn parse_ascii(file: &[u8]) -> Result<Model, Problem> {
    let mut model = Model::default();
    let mut ends: Vec<u32> = Vec::new();
    let mut solids: Vec<(u32, String)> = Vec::new();
    let mut lines = Lines::new(file);
    let mut closed = true;
    while let Some((number, line)) = lines.next_line() {
        let mut words = words(line);
        let Some(word) = words.next() else { continue };
        match word.to_ascii_lowercase().as_slice() {
            b"vertex" => {
                let mut coordinate = || float_at(words.next(), number, "a coordinate of the vertex");
                let position = Vec3::new(coordinate()?, coordinate()?, coordinate()?);
                if !position.is_finite() {
                    let what = "a coordinate of the vertex is NaN, infinite or beyond 32-bit range";
                    return Err(Problem::new(at_line(number), what, "repair the mesh where it was made"));
                }
                model.positions.push(position);
            }
            b"endloop" | b"endfacet" => {
                let (start, end) = (ends.last().copied().unwrap_or(0), model.positions.len() as u32);
                match end - start {
                    0 => {}
                    3.. => ends.push(end),
                    corners => return Err(Problem::damaged(at_line(number), format!("the facet has {corners} corners"))),
                }
            }
            b"solid" => {
                closed = false;
                solids.push((ends.len() as u32, words.map(show).collect::<Vec<_>>().join(" ")));
            }
            b"endsolid" => closed = true,
            b"facet" | b"outer" | b"color" => {}
            _ => return Err(Problem::damaged(at_line(number), format!("{:?} is no word of an STL file", show(word)))),
        }
    }
    if model.positions.len() != ends.last().map_or(0, |&e| e as usize) {
        return Err(Problem::damaged("", "the last facet has no end"));
    }
    if !closed {
        model.source.notes.push("the last solid has no end: the file may be cut short".into());
    }
    model.source.format = "STL (ascii)".into();
    model.source.vertices = model.positions.len();
    model.source.polygons = ends.len();
    (model.faces, model.polygons) = cut_polygons(&ends, |c| model.positions[c as usize]);
    for (k, (polygon, name)) in solids.iter().enumerate() {
        let first = |polygon| super::corners::first_face(model.polygons.as_deref(), model.faces.len(), polygon);
        let end = solids.get(k + 1).map_or(ends.len() as u32, |s| s.0);
        let (start, count) = (first(*polygon), first(end) - first(*polygon));
        model.groups.push(FaceGroup { object: name.clone(), start, count, ..FaceGroup::default() });
    }
    model.name = solids.first().map(|s| s.1.clone()).unwrap_or_default();
    model.finish(|v| format!("vertex {v}"))
}
