//! The header of a PLY file: its encoding, and the elements and properties that follow.

use crate::format::error::Problem;
use crate::format::model::stated_unit;
use crate::format::text::{Lines, at_line, line_text, show, words};

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Encoding {
    Ascii,
    Little,
    Big,
}

impl Encoding {
    pub(super) const fn name(self) -> &'static str {
        match self {
            Self::Ascii => "PLY (ascii)",
            Self::Little => "PLY (binary, little-endian)",
            Self::Big => "PLY (binary, big-endian)",
        }
    }
}

/// Type of a number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl Kind {
    fn named(word: &[u8]) -> Option<Self> {
        Some(match word {
            b"char" | b"int8" => Self::I8,
            b"uchar" | b"uint8" => Self::U8,
            b"short" | b"int16" => Self::I16,
            b"ushort" | b"uint16" => Self::U16,
            b"int" | b"int32" => Self::I32,
            b"uint" | b"uint32" => Self::U32,
            b"float" | b"float32" => Self::F32,
            b"double" | b"float64" => Self::F64,
            _ => return None,
        })
    }

    pub(super) const fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }

    /// The value that stands for full brightness in colours of this type.
    pub(super) const fn white(self) -> f64 {
        match self {
            Self::F32 | Self::F64 => 1.0,
            Self::U16 | Self::I16 => 65535.0,
            _ => 255.0,
        }
    }
}

#[derive(Debug)]
pub(super) struct Property {
    pub(super) name: String,
    pub(super) kind: Kind,
    /// Type of the length, if this is a list.
    pub(super) length: Option<Kind>,
}

#[derive(Debug)]
pub(super) struct Element {
    pub(super) name: String,
    pub(super) count: usize,
    pub(super) properties: Vec<Property>,
}

impl Element {
    pub(super) fn list(&self, names: &[&str]) -> Option<usize> {
        self.properties.iter().position(|p| p.length.is_some() && names.contains(&p.name.as_str()))
    }
}

#[derive(Debug)]
pub(super) struct Header {
    pub(super) encoding: Encoding,
    pub(super) elements: Vec<Element>,
    pub(super) unit: Option<String>,
    /// Number of header lines.
    pub(super) lines: usize,
}

pub(super) fn parse_header(file: &[u8]) -> Result<(Header, &[u8]), Problem> {
    let mut lines = Lines::new(file);
    let mut encoding = None;
    let mut elements: Vec<Element> = Vec::new();
    let mut unit = None;
    lines.next_line();
    while let Some((number, line)) = lines.next_line() {
        let bad = |what: &str| Problem::damaged(at_line(number), format!("{what}: {:?}", show(line)));
        let w: Vec<&[u8]> = words(line).collect();
        match w[..] {
            [b"format", name, ..] => {
                encoding = Some(match name {
                    b"ascii" => Encoding::Ascii,
                    b"binary_little_endian" => Encoding::Little,
                    b"binary_big_endian" => Encoding::Big,
                    _ => return Err(bad("the format is unknown")),
                });
            }
            [b"comment" | b"obj_info", ..] => unit = unit.or_else(|| stated_unit(&line_text(line))),
            [b"element", name, count, ..] => {
                let count =
                    std::str::from_utf8(count).ok().and_then(|c| c.parse().ok()).ok_or_else(|| bad("a count is no number"))?;
                elements.push(Element { name: line_text(name), count, properties: Vec::new() });
            }
            [b"property", ref rest @ ..] => {
                let (length, kind, name) = match *rest {
                    [b"list", length, kind, name, ..] => (Some(length), kind, name),
                    [kind, name, ..] => (None, kind, name),
                    _ => return Err(bad("a property has no type or name")),
                };
                let number = |word| Kind::named(word).ok_or_else(|| bad("a property has an unknown type"));
                let element = elements.last_mut().ok_or_else(|| bad("a property stands before every element"))?;
                let property = Property { name: line_text(name), kind: number(kind)?, length: length.map(number).transpose()? };
                element.properties.push(property);
            }
            [b"end_header", ..] => {
                let encoding = encoding.ok_or_else(|| Problem::damaged("", "the header states no format"))?;
                return Ok((Header { encoding, elements, unit, lines: number }, lines.rest()));
            }
            _ => {}
        }
    }
    Err(Problem::damaged("", "the header has no end"))
}
