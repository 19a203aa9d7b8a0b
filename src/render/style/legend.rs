//! The strip below a sheet that says what its colours mean.

use super::super::picture::{Picture, to_byte};
use super::super::text;
use crate::exemplar::srgb;
use glam::{Vec2, Vec3};

/// A colour bar with labels, or separate swatches.
#[derive(Debug, Clone, PartialEq)]
pub struct Legend {
    /// What is measured.
    pub title: &'static str,
    /// Colours (linear light) and labels from left to right; an empty label leaves the colour without one.
    pub entries: Vec<(Vec3, String)>,
}

/// Colour of text, sRGB.
const INK: Vec3 = Vec3::new(0.2, 0.2, 0.22);
/// Colour of the strip, sRGB.
const PAPER: [u8; 4] = [246, 246, 247, 255];

impl Legend {
    /// The sheet with the legend below it.
    pub(super) fn below(&self, sheet: &Picture) -> Picture {
        let letter = (0.011 * f64::from(sheet.width.max(400))).clamp(7.0, 20.0) as f32;
        let strip = (4.4 * letter).ceil() as u32;
        let mut out = Picture::filled(sheet.width, sheet.height + strip, PAPER);
        out.paste(sheet, 0, 0);
        let top = sheet.height as f32 + 0.9 * letter;
        let text_top = top + 0.1 * letter;
        text::write(&mut out, self.title, Vec2::new(1.2 * letter, text_top), letter, INK, 1.0);
        let left = 1.2 * letter + text::width(self.title, letter) + 2.0 * letter;
        let room = (sheet.width as f32 - left - 1.5 * letter).max(1.0);
        let widest = self.entries.iter().map(|(_, label)| text::width(label, letter)).fold(0.0, f32::max);
        let step = (room / self.entries.len().max(1) as f32).min((widest + letter).max(2.0 * letter));
        for (i, (colour, label)) in self.entries.iter().enumerate() {
            let x = left + i as f32 * step;
            let [r, g, b] = colour.to_array().map(|c| to_byte(srgb::encode(c)));
            let swatch = Picture::filled((x + step).round() as u32 - x.round() as u32, (1.2 * letter) as u32, [r, g, b, 255]);
            out.paste(&swatch, x.round() as u32, top as u32);
            let at = Vec2::new(x + 0.5 * (step - text::width(label, letter)), top + 1.9 * letter);
            text::write(&mut out, label, at, letter, INK, 1.0);
        }
        out
    }
}
