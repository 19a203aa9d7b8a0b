//! Smooth lines drawn over a picture: letters, arrows, rings.

use super::picture::Picture;
use glam::{Vec2, Vec3};

/// Lines that are drawn as one shape: where they cross they do not add up.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Strokes {
    /// Start and end of each round-ended piece and its half widths there, pixels.
    pieces: Vec<(Vec2, Vec2, f32, f32)>,
}

impl Strokes {
    /// Adds a piece from `a` to `b`, `width` pixels wide.
    pub fn line(&mut self, a: Vec2, b: Vec2, width: f32) {
        self.taper(a, b, width, width);
    }

    /// Adds a piece whose width changes from one end to the other.
    pub fn taper(&mut self, a: Vec2, b: Vec2, width_a: f32, width_b: f32) {
        if a.is_finite() && b.is_finite() {
            self.pieces.push((a, b, 0.5 * width_a, 0.5 * width_b));
        }
    }

    /// Adds a circle.
    pub fn ring(&mut self, centre: Vec2, radius: f32, width: f32) {
        /// Enough for the sizes at which marks are drawn.
        const SIDES: usize = 24;
        let at = |i: usize| centre + radius * Vec2::from_angle(std::f32::consts::TAU * i as f32 / SIDES as f32);
        for i in 0..SIDES {
            self.line(at(i), at(i + 1), width);
        }
    }

    /// The same lines, each `extra` pixels wider: an outline to draw below.
    #[must_use]
    pub fn widened(&self, extra: f32) -> Self {
        Self { pieces: self.pieces.iter().map(|&(a, b, u, v)| (a, b, u + 0.5 * extra, v + 0.5 * extra)).collect() }
    }

    /// Draws all pieces in one colour (sRGB, 0 to 1).
    pub fn draw(&self, picture: &mut Picture, colour: Vec3, opacity: f32) {
        let mut low = Vec2::INFINITY;
        let mut high = Vec2::NEG_INFINITY;
        for &(a, b, u, v) in &self.pieces {
            let margin = Vec2::splat(u.max(v) + 1.0);
            low = low.min(a.min(b) - margin);
            high = high.max(a.max(b) + margin);
        }
        let size = Vec2::new(picture.width as f32, picture.height as f32);
        let (low, high) = (low.max(Vec2::ZERO).floor(), high.min(size).ceil());
        if !(low.cmplt(high).all()) {
            return;
        }
        let (left, top) = (low.x as usize, low.y as usize);
        let (width, height) = (high.x as usize - left, high.y as usize - top);
        let mut cover = vec![0.0_f32; width * height];
        for &(a, b, u, v) in &self.pieces {
            let margin = Vec2::splat(u.max(v) + 1.0);
            let from = (a.min(b) - margin - low).max(Vec2::ZERO);
            let to = (a.max(b) + margin - low).min(Vec2::new(width as f32, height as f32));
            for y in from.y as usize..to.y.max(0.0).ceil() as usize {
                for x in from.x as usize..to.x.max(0.0).ceil() as usize {
                    let p = low + Vec2::new(x as f32 + 0.5, y as f32 + 0.5);
                    let along = (b - a).dot(p - a) / (b - a).length_squared().max(1e-12);
                    let along = along.clamp(0.0, 1.0);
                    let half = u + (v - u) * along;
                    let distance = p.distance(a + (b - a) * along);
                    let c = &mut cover[y * width + x];
                    // Lines thinner than a pixel fade instead of breaking up.
                    *c = c.max((half + 0.5 - distance).clamp(0.0, 1.0).min(2.0 * half));
                }
            }
        }
        for y in 0..height {
            for x in 0..width {
                picture.blend((left + x) as i64, (top + y) as i64, colour, opacity * cover[y * width + x]);
            }
        }
    }
}
