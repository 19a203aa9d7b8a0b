//! The statements of an OBJ file, made ready for tobj, and what tobj does not tell of them.
//!
//! tobj reads one plain dialect: UTF-8, one statement a line, no comments behind it. It takes `l` for `f`, an index 0 for
//! none, and joins objects, groups and materials into one name. So it gets the lines that hold geometry only, each without
//! oddities; names, counts and notes are taken down here on the way.

use super::super::error::Problem;
use super::super::model::{MAX_MODEL_FACES, stated_unit};
use super::super::text::{Lines, at_line, float, line_text, show, words};
use std::borrow::Cow;

/// How many lines of comment are searched for a unit of length.
const UNIT_COMMENT_LINES: usize = 200;

/// Lines with their numbers; a line that ends in a backslash goes on in the next one.
pub(super) struct Statements<'a>(Lines<'a>);

impl<'a> Statements<'a> {
    pub(super) fn of(text: &'a [u8]) -> Self {
        Self(Lines::new(text))
    }
}

impl<'a> Iterator for Statements<'a> {
    type Item = (usize, Cow<'a, [u8]>);

    fn next(&mut self) -> Option<Self::Item> {
        let (number, line) = self.0.next_line()?;
        let Some(start) = line.strip_suffix(b"\\") else { return Some((number, Cow::Borrowed(line))) };
        let mut joined = start.to_vec();
        while let Some((_, more)) = self.0.next_line() {
            joined.push(b' ');
            let part = more.strip_suffix(b"\\");
            joined.extend_from_slice(part.unwrap_or(more));
            if part.is_none() {
                break;
            }
        }
        Some((number, Cow::Owned(joined)))
    }
}

/// The words of a statement of geometry, up to a comment.
pub(super) fn geometry(line: &[u8]) -> Vec<&[u8]> {
    words(line).take_while(|w| w[0] != b'#').collect()
}

/// The names in force at a polygon.
#[derive(Debug, Clone, Default)]
pub(super) struct Names {
    pub(super) object: String,
    pub(super) group: String,
    pub(super) material: String,
}

/// Everything about a file but its numbers, and the lines that hold those.
#[derive(Debug, Default)]
pub(super) struct Survey {
    /// Lines of `v`, `vt`, `vn` and `f` for tobj. Polygons have three corners or more, every index is in range, and either
    /// all vertices have a colour or none.
    pub(super) lines: Vec<u8>,
    /// Numbers of vertices, texture coordinates and normals.
    pub(super) counts: [usize; 3],
    pub(super) polygons: usize,
    /// Runs of corners: the first one, and whether they have texture coordinates and normals.
    pub(super) forms: Vec<(usize, [bool; 2])>,
    /// Runs of polygons: the first one, and the names.
    pub(super) runs: Vec<(u32, Names)>,
    pub(super) unit: Option<String>,
    names: Names,
    corners: usize,
    /// Vertices with a colour.
    colored: usize,
    /// Largest index of each kind used by a face, and its line: faces may precede their vertices.
    largest: [(usize, usize); 3],
    thin: usize,
    lines_and_points: usize,
    curves: usize,
}

impl Survey {
    pub(super) fn of(text: &[u8]) -> Result<Self, Problem> {
        let mut survey = Self::read(text, false)?;
        if survey.colored > 0 && survey.colored < survey.counts[0] {
            survey = Self::read(text, true)?;
        }
        for ((&(index, line), count), kind) in
            survey.largest.iter().zip(survey.counts).zip(["vertex", "texture coordinate", "normal"])
        {
            if index > count {
                let what = format!("the face uses {kind} {index}, but the file has only {count}");
                return Err(Problem::damaged(at_line(line), what));
            }
        }
        Ok(survey)
    }

    /// What was left out, one sentence each.
    pub(super) fn notes(&self) -> Vec<String> {
        [
            (self.thin, "faces with fewer than three corners were left out"),
            (self.lines_and_points, "lines and points were left out"),
            (self.curves, "free-form curves and surfaces were left out: convert them to polygons to use them"),
        ]
        .into_iter()
        .filter(|&(count, _)| count > 0)
        .map(|(count, what)| format!("{count} {what}"))
        .collect()
    }

    /// Goes through all statements. With `fill_colors`, vertices without a colour get one of NaN.
    fn read(text: &[u8], fill_colors: bool) -> Result<Self, Problem> {
        let mut survey = Self::default();
        for (number, line) in Statements::of(text) {
            match words(&line).next() {
                Some(b"v") => survey.vertex(&geometry(&line), fill_colors),
                Some(b"vt") => {
                    survey.counts[1] += 1;
                    let words = geometry(&line);
                    // A texture of one dimension.
                    let second: &[&[u8]] = if words.len() == 2 { &[b"0"] } else { &[] };
                    survey.put(words.iter().chain(second));
                }
                Some(b"vn") => {
                    survey.counts[2] += 1;
                    survey.put(&geometry(&line));
                }
                Some(b"f" | b"fo") => survey.polygon(number, &geometry(&line)[1..])?,
                Some(word) => survey.other(number, word, &line),
                None => {}
            }
        }
        Ok(survey)
    }

    /// Appends a line for tobj.
    fn put<'a>(&mut self, words: impl IntoIterator<Item = &'a &'a [u8]>) {
        for word in words {
            self.lines.extend_from_slice(word);
            self.lines.push(b' ');
        }
        self.lines.push(b'\n');
    }

    fn vertex(&mut self, words: &[&[u8]], fill_color: bool) {
        self.counts[0] += 1;
        // Three more numbers are a colour; one alone is the weight of a rational curve's point, by which tobj would divide.
        if words.get(4..7).is_some_and(|color| color.iter().all(|w| float(w).is_some())) {
            self.colored += 1;
            self.put(&words[..7]);
        } else {
            const UNKNOWN: [&[u8]; 3] = [b"nan"; 3];
            let color = if fill_color { UNKNOWN.as_slice() } else { &[] };
            self.put(words.iter().take(4).chain(color));
        }
    }

    fn polygon(&mut self, number: usize, corners: &[&[u8]]) -> Result<(), Problem> {
        let thin = corners.len() < 3;
        for (k, word) in corners.iter().enumerate() {
            let form = self
                .corner(number, word)
                .ok_or_else(|| Problem::damaged(at_line(number), format!("{:?} is no corner of a face", show(word))))?;
            if !thin && self.forms.last().is_none_or(|(_, f)| *f != form) {
                self.forms.push((self.corners + k, form));
            }
        }
        if thin {
            self.thin += 1;
            return Ok(());
        }
        self.polygons += 1;
        self.corners += corners.len();
        if self.corners > MAX_MODEL_FACES * 4 {
            let what = format!("more than {MAX_MODEL_FACES} faces");
            return Err(Problem::new(at_line(number), what, "split the mesh into several files"));
        }
        let statement: &[u8] = b"f";
        self.put([&statement].into_iter().chain(corners));
        Ok(())
    }

    /// Whether a corner has a texture coordinate and a normal. `None` if it is no corner.
    fn corner(&mut self, number: usize, word: &[u8]) -> Option<[bool; 2]> {
        let mut found = [false; 3];
        for (kind, part) in word.split(|&b| b == b'/').enumerate() {
            if part.is_empty() && kind > 0 {
                continue;
            }
            *found.get_mut(kind)? = true;
            let index: i64 = std::str::from_utf8(part).ok()?.parse().ok()?;
            match usize::try_from(index) {
                Ok(0) => return None,
                Ok(index) if index > self.largest[kind].0 => self.largest[kind] = (index, number),
                Ok(_) => {}
                Err(_) if index.unsigned_abs() as usize > self.counts[kind] => return None,
                Err(_) => {}
            }
        }
        Some([found[1], found[2]])
    }

    /// Lines that hold no geometry: names, comments, and what is not read here.
    fn other(&mut self, number: usize, word: &[u8], line: &[u8]) {
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
        let polygon = self.polygons as u32;
        self.runs.pop_if(|(start, _)| *start == polygon);
        self.runs.push((polygon, self.names.clone()));
    }
}

/// All of a line after its first word.
fn rest_of(line: &[u8]) -> String {
    let text = line_text(line);
    text.split_once(char::is_whitespace).map_or_else(String::new, |(_, rest)| rest.trim().to_owned())
}
