//! Wavefront OBJ: polygons of any number of corners, negative indices, objects, groups, materials, vertex colours.
//!
//! Faces and vertices keep the file's order, and every message names its line; that is why the file is read here and not
//! by a library. Material files are not opened: only their names matter. Curves, surfaces, lines and points are left out
//! with a note.

use super::corners::{cut_polygons, first_face, join_corners};
use super::error::Problem;
use super::model::{FaceGroup, MAX_MODEL_FACES, Model, stated_unit};
use super::srgb;
use super::text::{Lines, at_line, float, float_at, line_text, show, words};
use crate::mesh::NONE;
use glam::{Vec2, Vec3, Vec4};
use std::borrow::Cow;

/// How many lines of comment are searched for a unit of length.
const UNIT_COMMENT_LINES: usize = 200;

/// Reads a whole file.
pub(crate) fn parse(text: &[u8]) -> Result<Model, Problem> {
    let mut reader = Reader::default();
    let mut lines = Lines::new(text);
    while let Some((number, line)) = lines.next_line() {
        let line = join_continued(line, &mut lines);
        reader.line(number, &line)?;
    }
    reader.finish()
}

/// A line that ends in a backslash goes on in the next one.
fn join_continued<'a>(line: &'a [u8], lines: &mut Lines<'a>) -> Cow<'a, [u8]> {
    let Some(start) = line.strip_suffix(b"\\") else { return Cow::Borrowed(line) };
    let mut joined = start.to_vec();
    while let Some((_, more)) = lines.next_line() {
        joined.push(b' ');
        match more.strip_suffix(b"\\") {
            Some(part) => joined.extend_from_slice(part),
            None => {
                joined.extend_from_slice(more);
                break;
            }
        }
    }
    Cow::Owned(joined)
}

/// A corner: indices from 0 of position, texture coordinate and normal; [`NONE`] where there is none.
#[derive(Debug, Clone, Copy)]
struct Corner {
    v: u32,
    vt: u32,
    vn: u32,
}

/// The names in force at a polygon.
#[derive(Debug, Clone, Default)]
struct Names {
    object: String,
    group: String,
    material: String,
}

#[derive(Debug, Default)]
struct Reader {
    positions: Vec<Vec3>,
    /// Colours of the vertices; shorter than `positions` while none had any.
    colors: Vec<Vec4>,
    texture: Vec<Vec2>,
    normals: Vec<Vec3>,
    /// Corners of all polygons in turn.
    corners: Vec<Corner>,
    /// For each polygon the end of its corners.
    ends: Vec<u32>,
    names: Names,
    /// Runs of polygons: the first one, and the names.
    runs: Vec<(u32, Names)>,
    /// Largest index of each kind of vertex data used so far, and its line: faces may precede their vertices.
    largest: [(u32, usize); 3],
    unit: Option<String>,
    thin: usize,
    lines_and_points: usize,
    curves: usize,
}

impl Reader {
    fn line(&mut self, number: usize, line: &[u8]) -> Result<(), Problem> {
        let mut words = words(line);
        match words.next() {
            Some(b"v") => self.vertex(number, words),
            Some(b"vt") => {
                let u = float_at(words.next(), number, "the texture coordinate")?;
                let v = words.next().and_then(float).unwrap_or(0.0);
                self.texture.push(Vec2::new(u, 1.0 - v));
                Ok(())
            }
            Some(b"vn") => {
                let mut number = || float_at(words.next(), number, "a component of the normal");
                self.normals.push(Vec3::new(number()?, number()?, number()?));
                Ok(())
            }
            Some(b"f" | b"fo") => self.polygon(number, words),
            Some(word) => {
                self.statement(number, word, line);
                Ok(())
            }
            None => Ok(()),
        }
    }

    /// Lines that cannot go wrong: names, comments, and what is not read here.
    fn statement(&mut self, number: usize, word: &[u8], line: &[u8]) {
        let name = match word {
            b"o" => &mut self.names.object,
            b"g" => &mut self.names.group,
            b"usemtl" => &mut self.names.material,
            b"l" | b"p" => return self.lines_and_points += 1,
            b"curv" | b"curv2" | b"surf" => return self.curves += 1,
            [b'#', ..] if self.unit.is_none() && number <= UNIT_COMMENT_LINES => {
                return self.unit = stated_unit(&line_text(line));
            }
            _ => return,
        };
        *name = rest_of(line);
        // Polygons from here on carry these names.
        let polygon = self.ends.len() as u32;
        self.runs.pop_if(|(start, _)| *start == polygon);
        self.runs.push((polygon, self.names.clone()));
    }

    fn vertex<'a>(&mut self, number: usize, mut words: impl Iterator<Item = &'a [u8]>) -> Result<(), Problem> {
        let mut coordinate = || float_at(words.next(), number, "a coordinate of the vertex");
        let position = Vec3::new(coordinate()?, coordinate()?, coordinate()?);
        if !position.is_finite() {
            return Err(Problem::new(
                at_line(number),
                "a coordinate of the vertex is NaN, infinite or beyond 32-bit range",
                "repair the mesh where it was made",
            ));
        }
        // Three more numbers are a colour; one alone is the weight of a rational curve's point.
        let mut more = [0.0; 4];
        let mut extra = 0;
        for value in words.map_while(float).take(4) {
            more[extra] = value;
            extra += 1;
        }
        if extra >= 3 {
            self.colors.resize(self.positions.len(), Vec4::ONE);
            self.colors.push(Vec4::new(more[0], more[1], more[2], if extra == 4 { more[3] } else { 1.0 }));
        }
        self.positions.push(position);
        Ok(())
    }

    fn polygon<'a>(&mut self, number: usize, words: impl Iterator<Item = &'a [u8]>) -> Result<(), Problem> {
        let start = self.corners.len();
        let counts = [self.positions.len(), self.texture.len(), self.normals.len()];
        for word in words.take_while(|w| w[0] != b'#') {
            let mut found = [NONE; 3];
            for (kind, part) in word.split(|&b| b == b'/').take(3).enumerate() {
                if part.is_empty() && kind > 0 {
                    continue;
                }
                let index = resolve(part, counts[kind])
                    .ok_or_else(|| Problem::damaged(at_line(number), format!("{:?} is no corner of a face", show(word))))?;
                found[kind] = index;
                if index >= self.largest[kind].0 {
                    self.largest[kind] = (index, number);
                }
            }
            self.corners.push(Corner { v: found[0], vt: found[1], vn: found[2] });
        }
        if self.corners.len() - start < 3 {
            self.corners.truncate(start);
            self.thin += 1;
            return Ok(());
        }
        if self.corners.len() > MAX_MODEL_FACES * 4 {
            return Err(too_large(number));
        }
        self.ends.push(self.corners.len() as u32);
        Ok(())
    }

    fn finish(mut self) -> Result<Model, Problem> {
        let counts = [self.positions.len(), self.texture.len(), self.normals.len()];
        let kinds = ["vertex", "texture coordinate", "normal"];
        for ((&(index, line), count), kind) in self.largest.iter().zip(counts).zip(kinds) {
            if line > 0 && index as usize >= count {
                let what = format!("the face uses {kind} {}, but the file has only {count}", index as usize + 1);
                return Err(Problem::damaged(at_line(line), what));
            }
        }
        let mut model = Model::default();
        model.source.format = "Wavefront OBJ".into();
        model.source.vertices = self.positions.len();
        model.source.polygons = self.ends.len();
        model.source.unit = self.unit.take();
        model.name = self.runs.iter().map(|(_, n)| n.object.clone()).find(|o| !o.is_empty()).unwrap_or_default();
        for (count, what) in [
            (self.thin, "faces with fewer than three corners were left out"),
            (self.lines_and_points, "lines and points were left out"),
            (self.curves, "free-form curves and surfaces were left out: convert them to polygons to use them"),
        ] {
            if count > 0 {
                model.source.notes.push(format!("{count} {what}"));
            }
        }
        let (mut faces, polygons) = cut_polygons(&self.ends, |c| self.positions[self.corners[c as usize].v as usize]);
        for (k, (polygon, names)) in self.runs.iter().enumerate() {
            let first = |polygon| first_face(polygons.as_deref(), faces.len(), polygon);
            if k == 0 {
                model.groups.push(FaceGroup { count: first(*polygon), ..FaceGroup::default() });
            }
            let next = self.runs.get(k + 1).map_or(self.ends.len() as u32, |(p, _)| *p);
            let Names { object, group, material } = names.clone();
            let start = first(*polygon);
            model.groups.push(FaceGroup { object, group, material, start, count: first(next) - start });
        }
        let kept = join_corners(&mut faces, self.positions.len(), |c| {
            let Corner { v, vt, vn } = self.corners[c as usize];
            (v, [vt, vn])
        });
        model.faces = faces;
        model.polygons = polygons;
        self.attributes(&kept, &mut model);
        model.finish(|v| format!("vertex {}", v + 1))
    }

    /// Positions and attributes of the vertices that are left after joining corners.
    fn attributes(self, kept: &[(u32, Option<[u32; 2]>)], model: &mut Model) {
        let index = |entry: &(u32, Option<[u32; 2]>), which: usize| entry.1.map_or(NONE, |a| a[which]) as usize;
        if self.corners.iter().any(|c| c.vt != NONE) {
            model.uvs = Some(kept.iter().map(|k| self.texture.get(index(k, 0)).copied().unwrap_or_default()).collect());
        }
        if self.corners.iter().any(|c| c.vn != NONE) {
            model.normals = Some(kept.iter().map(|k| self.normals.get(index(k, 1)).copied().unwrap_or_default()).collect());
        }
        if !self.colors.is_empty() {
            // Some exporters write 0 to 255.
            let scale = if self.colors.iter().any(|c| c.max_element() > 1.0) { 1.0 / 255.0 } else { 1.0 };
            let scale = Vec4::new(scale, scale, scale, 1.0);
            let color = |v: u32| self.colors.get(v as usize).map_or(Vec4::ONE, |&c| srgb::decode_color(c * scale));
            model.colors = Some(kept.iter().map(|&(v, _)| color(v)).collect());
        }
        model.positions = if kept.len() == self.positions.len() {
            self.positions
        } else {
            kept.iter().map(|&(v, _)| self.positions[v as usize]).collect()
        };
    }
}

/// An index of the file (from 1, or backwards from -1) as one from 0. `None` if it is no such number.
fn resolve(word: &[u8], count: usize) -> Option<u32> {
    let index: i64 = std::str::from_utf8(word).ok()?.parse().ok()?;
    match index {
        1.. => u32::try_from(index - 1).ok().filter(|&i| i != NONE),
        0 => None,
        _ => u32::try_from(count as i64 + index).ok(),
    }
}

/// All of a line after its first word.
fn rest_of(line: &[u8]) -> String {
    let text = line_text(line);
    text.split_once(char::is_whitespace).map_or_else(String::new, |(_, rest)| rest.trim().to_owned())
}

fn too_large(line: usize) -> Problem {
    Problem::new(at_line(line), format!("more than {MAX_MODEL_FACES} faces"), "split the mesh into several files")
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
