//! Lines and words of text formats, with line numbers for messages.

use super::error::Problem;

/// Walks over the lines of a text: `\n`, `\r\n` and `\r` all end one.
#[derive(Debug, Clone)]
pub(crate) struct Lines<'a> {
    rest: &'a [u8],
    number: usize,
}

impl<'a> Lines<'a> {
    pub(crate) fn new(text: &'a [u8]) -> Self {
        Self { rest: text.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(text), number: 0 }
    }

    /// The next line without its end, and its number from 1.
    pub(crate) fn next_line(&mut self) -> Option<(usize, &'a [u8])> {
        if self.rest.is_empty() {
            return None;
        }
        let end = self.rest.iter().position(|&b| b == b'\n' || b == b'\r').unwrap_or(self.rest.len());
        let (line, rest) = self.rest.split_at(end);
        self.rest = match rest {
            [b'\r', b'\n', rest @ ..] | [_, rest @ ..] => rest,
            [] => &[],
        };
        self.number += 1;
        Some((self.number, line))
    }

    /// What follows the last line taken.
    pub(crate) const fn rest(&self) -> &'a [u8] {
        self.rest
    }
}

/// The words of a line, parted by spaces and tabs.
pub(crate) fn words(line: &[u8]) -> impl Iterator<Item = &[u8]> {
    line.split(u8::is_ascii_whitespace).filter(|w| !w.is_empty())
}

/// Bytes as readable text, shortened, for messages.
pub(crate) fn show(word: &[u8]) -> String {
    const LONGEST: usize = 40;
    let text = String::from_utf8_lossy(&word[..word.len().min(LONGEST)]);
    let clean: String = text.chars().map(|c| if c.is_control() { '\u{FFFD}' } else { c }).collect();
    if word.len() > LONGEST { format!("{clean}...") } else { clean }
}

/// A line as text without surrounding blanks.
pub(crate) fn line_text(line: &[u8]) -> String {
    String::from_utf8_lossy(line.trim_ascii()).into_owned()
}

/// A word as a number. Words for NaN and infinity are numbers too; what they mean is for the caller.
pub(crate) fn float(word: &[u8]) -> Option<f32> {
    std::str::from_utf8(word).ok()?.parse().ok()
}

/// A word as a number, or a problem on a line.
pub(crate) fn float_at(word: Option<&[u8]>, line: usize, what: &str) -> Result<f32, Problem> {
    let word = word.ok_or_else(|| Problem::damaged(at_line(line), format!("{what} is missing")))?;
    float(word).ok_or_else(|| Problem::damaged(at_line(line), format!("{what} is {:?}, which is not a number", show(word))))
}

/// How messages name a line.
pub(crate) fn at_line(line: usize) -> String {
    format!("line {line}")
}
