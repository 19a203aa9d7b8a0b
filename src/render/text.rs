//! Short captions in a small font of our own, drawn with strokes, so that it is smooth at every size.
//!
//! A glyph is a list of strokes on a grid: digits are x and y of their points, capitals reach from y = 0 to the baseline
//! at y = 6, small letters from 2, tails to 8. A stroke that begins with `~` is a quadratic spline of its points.

use super::picture::Picture;
use super::stroke::Strokes;
use glam::{Vec2, Vec3};

/// Grid units between two letters.
const GAP: f32 = 2.0;
/// Width of a blank, grid units.
const BLANK: f32 = 2.0;
/// Grid units from the top of a capital to its baseline.
const CAPITAL: f32 = 6.0;
/// Pen width, grid units.
const PEN: f32 = 0.8;

/// Width of a text whose capitals are `height` pixels high.
#[must_use]
pub fn width(text: &str, height: f32) -> f32 {
    let units: f32 = text.chars().map(|c| advance(c) + GAP).sum();
    (units - GAP).max(0.0) * height / CAPITAL
}

/// Writes a text with capitals `height` pixels high; `at` is the top left corner of its first capital.
pub fn write(picture: &mut Picture, text: &str, at: Vec2, height: f32, colour: Vec3, opacity: f32) {
    let unit = height / CAPITAL;
    let mut x = at.x;
    let mut strokes = Strokes::default();
    for c in text.chars() {
        for stroke in glyph(c).split('|') {
            let points = points(stroke);
            for pair in points.windows(2) {
                let place = |p: Vec2| Vec2::new(x, at.y) + p * unit;
                strokes.line(place(pair[0]), place(pair[1]), (PEN * unit).max(1.0));
            }
        }
        x += (advance(c) + GAP) * unit;
    }
    strokes.draw(picture, colour, opacity);
}

fn advance(c: char) -> f32 {
    let right = glyph(c).split('|').flat_map(controls).map(|p| p.x).fold(0.0, f32::max);
    if glyph(c).is_empty() { BLANK } else { right }
}

fn controls(stroke: &str) -> Vec<Vec2> {
    let digits: Vec<f32> = stroke.chars().filter_map(|c| c.to_digit(10)).map(|d| d as f32).collect();
    digits.as_chunks::<2>().0.iter().map(|&p| Vec2::from(p)).collect()
}

/// The points of a stroke's polyline.
fn points(stroke: &str) -> Vec<Vec2> {
    let c = controls(stroke);
    if !stroke.starts_with('~') || c.len() < 3 {
        return c;
    }
    // Quadratic pieces between the middles of the control polygon's sides; the outer sides count in full.
    let mut out = vec![c[0]];
    for i in 1..c.len() - 1 {
        let from = if i == 1 { c[0] } else { 0.5 * (c[i - 1] + c[i]) };
        let to = if i + 2 == c.len() { c[i + 1] } else { 0.5 * (c[i] + c[i + 1]) };
        /// Straight pieces per spline piece.
        const PIECES: usize = 6;
        for step in 1..=PIECES {
            let t = step as f32 / PIECES as f32;
            out.push(from.lerp(c[i], t).lerp(c[i].lerp(to, t), t));
        }
    }
    out
}

const fn glyph(c: char) -> &'static str {
    match c {
        'a' => "~42 02 06 46|42 46",
        'b' => "00 06|~02 42 46 06",
        'c' => "~43 42 02 06 46 45",
        'd' => "40 46|~42 02 06 46",
        'e' => "04 44|~44 42 02 06 46 45",
        'f' => "~30 10 12 16|02 32",
        'g' => "~42 02 06 46|~42 46 48 08",
        'h' => "00 06|~04 02 42 46",
        'i' => "02 06|00 00",
        'j' => "~22 26 28 08|20 20",
        'k' => "00 06|32 04 36",
        'l' => "00 06",
        'm' => "02 06|~04 02 32 36|~34 32 62 66",
        'n' => "02 06|~04 02 42 46",
        'o' => "~22 42 46 06 02 22",
        'p' => "02 08|~02 42 46 06",
        'q' => "42 48|~42 02 06 46",
        'r' => "02 06|~04 02 32",
        's' => "~42 02 04 44 46 06",
        't' => "~10 13 16 36|02 32",
        'u' => "~02 06 46 44|42 46",
        'v' => "02 26 42",
        'w' => "02 16 33 56 62",
        'x' => "02 46|42 06",
        'y' => "02 26|42 18",
        'z' => "02 42 06 46",
        '0' | 'O' => "~20 40 46 06 00 20",
        '1' => "01 20 26",
        '2' => "~01 00 40 43 06|06 46",
        '3' => "~00 40 43 23|~13 43 46 06",
        '4' => "36 30 04 44",
        '5' => "40 00 03|~03 43 46 06",
        '6' => "~40 00 06 46 43 03",
        '7' => "00 40 16",
        '8' => "~20 40 43 03 00 20|~23 43 46 06 03 23",
        '9' => "~43 03 00 40 46 06",
        'A' => "06 20 46|14 34",
        'B' => "00 06|~00 40 43 03|~03 43 46 06",
        'C' => "~41 40 00 06 46 45",
        'D' => "00 06|~00 40 46 06",
        'E' => "40 00 06 46|03 33",
        'F' => "40 00 06|03 33",
        'G' => "~41 40 00 06 46 43|43 23",
        'H' => "00 06|40 46|03 43",
        'I' => "00 06",
        'J' => "~40 46 06 05",
        'K' => "00 06|40 03 46",
        'L' => "00 06 46",
        'M' => "06 00 33 60 66",
        'N' => "06 00 46 40",
        'P' => "06 00|~00 40 43 03",
        'Q' => "~20 40 46 06 00 20|34 47",
        'R' => "06 00|~00 40 43 03|23 46",
        'S' => "~41 40 00 03 43 46 06 05",
        'T' => "00 40|20 26",
        'U' => "~00 06 46 40",
        'V' => "00 26 40",
        'W' => "00 16 32 56 60",
        'X' => "00 46|40 06",
        'Y' => "00 23 40|23 26",
        'Z' => "00 40 06 46",
        '.' => "06 06",
        ',' => "06 07",
        ':' => "03 03|06 06",
        ';' => "03 03|06 07",
        '-' => "04 34",
        '+' => "04 44|22 26",
        '/' => "07 30",
        '%' => "06 40|00 00|46 46",
        '(' => "~10 00 07 17",
        ')' => "~00 10 17 07",
        '=' => "03 43|05 45",
        '<' => "32 04 36",
        '>' => "02 34 06",
        '_' => "07 47",
        '!' => "00 04|06 06",
        '?' => "~00 40 43 24|26 26",
        '\'' => "00 01",
        '"' => "00 01|20 21",
        '\u{b0}' => "~10 20 22 02 00 10",
        '\u{d7}' => "03 36|33 06",
        ' ' => "",
        _ => "00 40 46 06 00",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_printable_letter_and_digit_has_a_shape_of_its_own() {
        // In plain hands O and 0, and I and l, are the same stroke.
        let letters = ('0'..='9').chain('A'..='Z').chain('a'..='z').filter(|c| !"OI".contains(*c));
        let mut shapes: Vec<_> = letters.map(glyph).collect();
        let count = shapes.len();
        shapes.sort_unstable();
        shapes.dedup();
        assert_eq!(shapes.len(), count, "no two look the same");
        assert!(!shapes.contains(&glyph('~')), "none is the box of an unknown letter");
    }

    #[test]
    fn text_stays_within_the_width_it_announces() {
        let mut picture = Picture::filled(200, 40, [255; 4]);
        write(&mut picture, "Wide 0.75%", Vec2::new(10.0, 10.0), 14.0, Vec3::ZERO, 1.0);
        let dark: Vec<u32> = (0..200).filter(|&x| (0..40).any(|y| picture.pixel(x, y)[0] < 128)).collect();
        let (first, last) = (dark[0] as f32, dark[dark.len() - 1] as f32);
        assert!((first - 10.0).abs() < 2.0, "starts at {first}");
        assert!((last - 10.0 - width("Wide 0.75%", 14.0)).abs() < 2.5, "ends at {last}");
    }
}
