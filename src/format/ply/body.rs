//! The numbers of a PLY file, one after the other, in each encoding.

use super::header::{Element, Kind};
use crate::format::text::Lines;

/// The numbers after the header.
pub(super) trait Body {
    /// Bytes that a row of the element has at least.
    fn smallest_row(element: &Element) -> usize;
    /// Moves to the next row. `None` at the end of the file.
    fn next_row(&mut self) -> Option<()>;
    /// The next number of the row. `None` if there is none.
    fn number(&mut self, kind: Kind) -> Option<f64>;
    /// Bytes left.
    fn left(&self) -> usize;
    /// Where in the file: `", line 12"`, or nothing.
    fn place(&self) -> String;
}

pub(super) struct BinaryBody<'a, const LITTLE: bool> {
    rest: &'a [u8],
}

impl<'a, const LITTLE: bool> BinaryBody<'a, LITTLE> {
    pub(super) const fn new(rest: &'a [u8]) -> Self {
        Self { rest }
    }

    #[inline]
    fn take<const N: usize>(&mut self) -> Option<[u8; N]> {
        let (bytes, rest) = self.rest.split_first_chunk::<N>()?;
        self.rest = rest;
        let mut bytes = *bytes;
        if !LITTLE {
            bytes.reverse();
        }
        Some(bytes)
    }
}

impl<const LITTLE: bool> Body for BinaryBody<'_, LITTLE> {
    fn smallest_row(element: &Element) -> usize {
        element.properties.iter().map(|p| p.length.unwrap_or(p.kind).size()).sum()
    }

    #[inline]
    fn next_row(&mut self) -> Option<()> {
        Some(())
    }

    #[inline]
    fn number(&mut self, kind: Kind) -> Option<f64> {
        Some(match kind {
            Kind::I8 => f64::from(i8::from_le_bytes(self.take()?)),
            Kind::U8 => f64::from(u8::from_le_bytes(self.take()?)),
            Kind::I16 => f64::from(i16::from_le_bytes(self.take()?)),
            Kind::U16 => f64::from(u16::from_le_bytes(self.take()?)),
            Kind::I32 => f64::from(i32::from_le_bytes(self.take()?)),
            Kind::U32 => f64::from(u32::from_le_bytes(self.take()?)),
            Kind::F32 => f64::from(f32::from_le_bytes(self.take()?)),
            Kind::F64 => f64::from_le_bytes(self.take()?),
        })
    }

    fn left(&self) -> usize {
        self.rest.len()
    }

    fn place(&self) -> String {
        String::new()
    }
}

/// One row a line; empty lines do not count.
pub(super) struct AsciiBody<'a> {
    lines: Lines<'a>,
    row: &'a [u8],
    /// Line of the row within the body, and lines before the body.
    line: usize,
    header: usize,
}

impl<'a> AsciiBody<'a> {
    pub(super) fn new(body: &'a [u8], header: usize) -> Self {
        Self { lines: Lines::new(body), row: &[], line: 0, header }
    }
}

impl Body for AsciiBody<'_> {
    fn smallest_row(element: &Element) -> usize {
        // A digit and what parts it from the next; the last may end the file.
        (2 * element.properties.len()).saturating_sub(1)
    }

    fn next_row(&mut self) -> Option<()> {
        loop {
            let (number, line) = self.lines.next_line()?;
            let line = line.trim_ascii();
            if !line.is_empty() {
                (self.line, self.row) = (number, line);
                return Some(());
            }
        }
    }

    fn number(&mut self, _kind: Kind) -> Option<f64> {
        let end = self.row.iter().position(u8::is_ascii_whitespace).unwrap_or(self.row.len());
        let (word, rest) = self.row.split_at(end);
        self.row = rest.trim_ascii_start();
        std::str::from_utf8(word).ok()?.parse().ok()
    }

    fn left(&self) -> usize {
        self.lines.rest().len() + self.row.len()
    }

    fn place(&self) -> String {
        format!(", line {}", self.header + self.line)
    }
}
