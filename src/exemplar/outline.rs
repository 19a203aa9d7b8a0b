//! Outlines: where a texture patch ends, as line segments with sub-pixel accuracy, and the depth of pixels below them.
//!
//! Based on: Praun, Finkelstein, Hoppe, "Lapped Textures" (2000), section 3.1, where the user draws them by hand or takes
//! a splotch.
//!
//! Polygons give their sides; grey images (masks, opacity) the line where they cross a level, straight within each square
//! of four pixel centres (marching squares). Depth is the exact distance to these, computed only where it is smaller than
//! the feather: the work is proportional to the outline's length.

use super::collapse::{segments_touch, signed_area};
use super::{ExemplarError, Image};
use glam::{DVec2, UVec2, Vec2};

/// Shortest and smallest an outline may be, in pixels across: below it nothing opaque remains under any feather.
const SMALLEST_OUTLINE: f64 = 4.0;
/// Most corners an outline may have. Testing it for crossings takes the square of that.
const MOST_CORNERS: usize = 20_000;
/// How far from the exemplar corners may lie, in sizes of the exemplar.
const FARTHEST_CORNER: f32 = 16.0;

/// A piece of an outline.
pub(super) type Segment = [Vec2; 2];

/// A closed outline drawn by the user.
#[derive(Debug, Clone, PartialEq)]
pub struct Outline {
    /// Its corners: fractions of the exemplar's size if all lie in 0 to 1, else pixels.
    pub points: Vec<Vec2>,
}

impl Outline {
    /// Outlines from JSON: a list of `[x, y]`, or a list of such lists. `name` is told in errors.
    ///
    /// # Errors
    /// [`ExemplarError::BadOutline`] if it is something else or empty.
    pub fn from_json(text: &str, name: &str) -> Result<Vec<Self>, ExemplarError> {
        #[derive(serde::Deserialize)]
        #[serde(untagged)]
        enum File {
            One(Vec<[f32; 2]>),
            Several(Vec<Vec<[f32; 2]>>),
        }
        let bad = |reason: String| ExemplarError::BadOutline { what: name.to_owned(), reason };
        // Parsed in two steps, so that broken JSON is told with its line and column.
        let value: serde_json::Value = serde_json::from_str(text).map_err(|e| bad(format!("is no JSON ({e})")))?;
        let file =
            serde_json::from_value(value).map_err(|_| bad("is neither a list of [x, y] nor a list of such lists".to_owned()))?;
        let lists = match file {
            File::One(points) => vec![points],
            File::Several(lists) => lists,
        };
        if lists.iter().all(Vec::is_empty) {
            return Err(bad("has no points".to_owned()));
        }
        Ok(lists.into_iter().map(|points| Self { points: points.into_iter().map(Vec2::from_array).collect() }).collect())
    }

    /// Tells whether patches of an exemplar of that size can be cut along it.
    ///
    /// # Errors
    /// [`ExemplarError::BadOutline`] with the reason why not.
    pub fn check(&self, size: [u32; 2]) -> Result<(), ExemplarError> {
        self.in_pixels(UVec2::from(size).as_vec2(), "drawn here").map(drop)
    }

    /// The corners in pixels of an exemplar of that size.
    ///
    /// # Errors
    /// [`ExemplarError::BadOutline`] if they are no simple polygon of some size that meets the exemplar.
    pub(super) fn in_pixels(&self, size: Vec2, name: &str) -> Result<Vec<Vec2>, ExemplarError> {
        let bad = |reason: String| Err(ExemplarError::BadOutline { what: name.to_owned(), reason });
        if let Some(i) = self.points.iter().position(|p| !p.is_finite()) {
            return bad(format!("has a point that is no number (number {})", i + 1));
        }
        let fractions = self.points.iter().all(|p| p.cmpge(Vec2::ZERO).all() && p.cmple(Vec2::ONE).all());
        let scale = if fractions { size } else { Vec2::ONE };
        let mut points: Vec<DVec2> = self.points.iter().map(|&p| (p * scale).as_dvec2()).collect();
        points.dedup();
        while points.len() > 1 && points.first() == points.last() {
            points.pop();
        }
        if points.len() < 3 {
            return bad(format!("has {} different points, at least 3 are needed", points.len()));
        }
        if points.len() > MOST_CORNERS {
            return bad(format!("has {} points, at most {MOST_CORNERS} are read: simplify it", points.len()));
        }
        let low = points.iter().fold(DVec2::INFINITY, |m, &p| m.min(p));
        let high = points.iter().fold(DVec2::NEG_INFINITY, |m, &p| m.max(p));
        if low.cmpge(size.as_dvec2()).any() || high.cmple(DVec2::ZERO).any() {
            return bad(format!("lies outside the exemplar of {} x {} pixels", size.x, size.y));
        }
        if points.iter().any(|p| p.abs().max_element() > f64::from(FARTHEST_CORNER * size.max_element())) {
            return bad(format!("reaches more than {FARTHEST_CORNER} exemplar sizes far: give pixels, or fractions of the size"));
        }
        if let Some([i, j]) = self_crossing(&points) {
            return bad(format!("crosses or touches itself (sides {} and {})", i + 1, j + 1));
        }
        if (high - low).min_element() < SMALLEST_OUTLINE || signed_area(&points).abs() < SMALLEST_OUTLINE * SMALLEST_OUTLINE {
            return bad(format!(
                "is too small ({:.1} x {:.1} pixels, area {:.1}): draw it larger",
                high.x - low.x,
                high.y - low.y,
                signed_area(&points).abs()
            ));
        }
        Ok(points.iter().map(|p| p.as_vec2()).collect())
    }
}

/// The first two sides that touch without being neighbours, or neighbours that run back over each other.
pub(super) fn self_crossing(points: &[DVec2]) -> Option<[usize; 2]> {
    let n = points.len();
    let side = |i: usize| [points[i], points[(i + 1) % n]];
    (0..n).find_map(|i| {
        let next = (i + 1) % n;
        let ([a, b], [_, c]) = (side(i), side(next));
        if (b - a).perp_dot(c - b) == 0.0 && (b - a).dot(c - b) < 0.0 {
            return Some([i, next]);
        }
        (i + 2..n).find(|&j| (j + 1) % n != i && segments_touch(side(i), side(j), 0.0)).map(|j| [i, j])
    })
}

/// The sides of a polygon.
pub(super) fn sides(points: &[Vec2]) -> Vec<Segment> {
    (0..points.len()).map(|i| [points[i], points[(i + 1) % points.len()]]).collect()
}

/// Which pixel centres of an image lie inside a polygon, by the even-odd rule.
pub(super) fn fill(points: &[Vec2], width: usize, height: usize) -> Vec<bool> {
    let mut crossings: Vec<Vec<f32>> = vec![Vec::new(); height];
    for [a, b] in sides(points) {
        let (low, high) = if a.y <= b.y { (a, b) } else { (b, a) };
        // Rows whose centre y lies in [low, high).
        let row = |y: f32| (y - 0.5).ceil().clamp(0.0, height as f32) as usize;
        for (y, crossing) in crossings.iter_mut().enumerate().take(row(high.y)).skip(row(low.y)) {
            let t = (f64::from(y as u32) + 0.5 - f64::from(low.y)) / f64::from(high.y - low.y);
            crossing.push((f64::from(low.x) + t * f64::from(high.x - low.x)) as f32);
        }
    }
    let mut inside = vec![false; width * height];
    for (row, crossing) in inside.chunks_exact_mut(width).zip(&mut crossings) {
        crossing.sort_by(f32::total_cmp);
        for span in crossing.chunks_exact(2) {
            let column = |x: f32| (x - 0.5).ceil().clamp(0.0, width as f32) as usize;
            row[column(span[0])..column(span[1])].fill(true);
        }
    }
    inside
}

/// The line where the first component of an image crosses a level, by marching squares between its pixel centres.
pub(super) fn level_line(image: &Image, level: f32) -> Vec<Segment> {
    let [w, h] = image.size().map(i64::from);
    let mut segments = Vec::new();
    for y in 0..h - 1 {
        for x in 0..w - 1 {
            // The square's corners in turn, and where the level crosses the side from each to the next.
            let corners = [(x, y), (x + 1, y), (x + 1, y + 1), (x, y + 1)];
            let values = corners.map(|(x, y)| image.grey(x, y) - level);
            if values.iter().all(|&v| v >= 0.0) || values.iter().all(|&v| v < 0.0) {
                continue;
            }
            let mut crossings = (0..4).filter_map(|i| {
                let (v, next) = (values[i], values[(i + 1) % 4]);
                let at = |(x, y): (i64, i64)| Vec2::new(x as f32 + 0.5, y as f32 + 0.5);
                ((v >= 0.0) != (next >= 0.0)).then(|| at(corners[i]).lerp(at(corners[(i + 1) % 4]), v / (v - next)))
            });
            // Where two opposite corners lie above, either pairing is a line between them.
            while let (Some(a), Some(b)) = (crossings.next(), crossings.next()) {
                segments.push([a, b]);
            }
        }
    }
    segments
}

/// The depth of each pixel centre: 0 unless `inside`, else the distance to the nearest segment, at most `reach`.
pub(super) fn depth_below(inside: &[bool], width: usize, segments: &[Segment], reach: f32) -> Vec<f32> {
    let mut depth: Vec<f32> = inside.iter().map(|&inside| if inside { reach } else { 0.0 }).collect();
    let Some(height) = inside.len().checked_div(width).filter(|&h| h > 0) else { return depth };
    // Long segments are cut so that the boxes around the parts hold little else than pixels within reach.
    let part_length = reach.max(4.0);
    for &[a, b] in segments {
        let parts = (a.distance(b) / part_length).ceil().max(1.0);
        for i in 0..parts as u32 {
            let (p, q) = (a.lerp(b, i as f32 / parts), a.lerp(b, (i + 1) as f32 / parts));
            let low = (p.min(q) - reach - 0.5).max(Vec2::ZERO);
            let high = (p.max(q) + reach + 0.5).min(Vec2::new(width as f32, height as f32));
            for y in low.y as usize..high.y.max(0.0) as usize {
                for x in low.x as usize..high.x.max(0.0) as usize {
                    let depth = &mut depth[y * width + x];
                    if *depth > 0.0 {
                        let centre = Vec2::new(x as f32 + 0.5, y as f32 + 0.5);
                        *depth = depth.min(segment_distance(centre, p, q));
                    }
                }
            }
        }
    }
    depth
}

fn segment_distance(p: Vec2, a: Vec2, b: Vec2) -> f32 {
    let ab = b - a;
    let length = ab.length_squared();
    let t = if length > 0.0 { ((p - a).dot(ab) / length).clamp(0.0, 1.0) } else { 0.0 };
    (a + ab * t).distance(p)
}
