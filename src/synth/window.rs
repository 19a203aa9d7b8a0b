//! Neighbourhoods as Wei and Levoy write them: `7x7,2` has 7 by 7 samples on its own level and reaches over 2 levels.

use serde::{Serialize, Serializer};
use std::fmt;
use std::str::FromStr;

/// Sides longer than this are refused: rows of them would not fit into memory on any level worth it.
pub const LONGEST: u32 = 31;

/// A neighbourhood.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Window {
    /// Samples along each side on its own level; odd.
    pub side: u32,
    /// Levels it reaches over, its own and coarser ones; at least 1. On each coarser level the radius is half as large.
    pub levels: u32,
}

impl Window {
    /// A window of a side (made odd, at most [`LONGEST`]) over so many levels.
    #[must_use]
    pub const fn new(side: u32, levels: u32) -> Self {
        let side = if side > LONGEST { LONGEST } else { side };
        Self { side: side | 1, levels: if levels == 0 { 1 } else { levels } }
    }

    /// Radius on its own level: a window of radius r has 2 r + 1 samples a side.
    #[must_use]
    pub const fn radius(self) -> i32 {
        (self.side / 2) as i32
    }

    /// Radii on the coarser levels, the nearest first.
    #[must_use]
    pub fn coarser(self) -> Vec<i32> {
        (1..self.levels).map(|k| self.radius() >> k.min(31)).collect()
    }
}

impl fmt::Display for Window {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{0}x{0},{1}", self.side, self.levels)
    }
}

impl Serialize for Window {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

impl FromStr for Window {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let wrong = || format!("`{text}` is no neighbourhood: write sides (odd, at most {LONGEST}) and levels, like 7x7,2");
        let (square, levels) = text.trim().trim_matches(['{', '}']).split_once(',').ok_or_else(wrong)?;
        let (a, b) = square.split_once(['x', 'X']).ok_or_else(wrong)?;
        let number = |s: &str| s.trim().parse::<u32>().map_err(|_| wrong());
        let (a, b, levels) = (number(a)?, number(b)?, number(levels)?);
        if a != b || a.is_multiple_of(2) || a > LONGEST || !(1..=16).contains(&levels) {
            return Err(wrong());
        }
        Ok(Self { side: a, levels })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn windows_are_written_as_they_are_read() {
        for (text, radius, coarser) in [("1x1,1", 0, vec![]), ("5x5,2", 2, vec![1]), ("7x7,3", 3, vec![1, 0])] {
            let window: Window = text.parse().expect("it is one");
            assert_eq!((window.to_string().as_str(), window.radius(), window.coarser()), (text, radius, coarser), "{text}");
        }
        for text in ["", "7", "7x5,2", "6x6,1", "7x7,0", "99x99,1", "7x7"] {
            assert!(text.parse::<Window>().is_err_and(|e| e.contains("7x7,2")), "{text} is none");
        }
    }
}
