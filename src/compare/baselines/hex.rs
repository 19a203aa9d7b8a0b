//! Tiling by hexagons: the plane without visible repetition, in three reads.
//!
//! Based on: M. Mikkelsen, "Practical Real-Time Hex-Tiling", Journal of Computer Graphics Techniques 11(2), 2022, after Heitz and
//! Neyret, "High-performance by-example noise using a histogram-preserving blending operator", HPG 2018.
//!
//! 1. The plane is cut into triangles; each corner stands for a hexagon around it, which shows the exemplar from a random place and,
//!    if asked, turned at random.
//! 2. A point is blended from the hexagons of its triangle's corners, by barycentric weights brought to a power, so that mostly one
//!    is seen.
//! 3. Where they are mixed the brighter one wins: weights are multiplied by luminance ("contrast-sharpened"), which keeps contrast
//!    that plain blending would take away.

use super::tile::{Tile, mean};
use crate::random::Random;
use crate::surface::Texel;
use glam::{Vec2, Vec3};

/// Sides of the triangles to an exemplar width: the paper's grid.
const SIDE: f32 = 0.288_675_13;

/// How hexagons are blended.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HexOptions {
    /// Power of the barycentric weights; the paper's 7.
    pub power: f32,
    /// How much luminance counts, 0 to 1; the paper's 0.6.
    pub contrast: f32,
    /// The largest turn of a hexagon, radians; 0 keeps the exemplar's direction.
    pub turn: f32,
    /// Where the random places begin.
    pub seed: u64,
}

impl Default for HexOptions {
    fn default() -> Self {
        Self { power: 7.0, contrast: 0.6, turn: 0.0, seed: 0 }
    }
}

/// The corners of the triangle that a point lies in, and its barycentric weights; lengths in triangle sides.
fn triangle(p: Vec2) -> [([i32; 2], f32); 3] {
    // Along one side of the triangles, and along another at 60 degrees.
    let skewed = Vec2::new(p.x - p.y / 3.0_f32.sqrt(), 2.0 * p.y / 3.0_f32.sqrt());
    let corner = skewed.floor();
    let [u, v] = (skewed - corner).to_array();
    let at = |x: i32, y: i32| [corner.x as i32 + x, corner.y as i32 + y];
    if u + v < 1.0 {
        [(at(0, 0), 1.0 - u - v), (at(1, 0), u), (at(0, 1), v)]
    } else {
        [(at(1, 1), u + v - 1.0), (at(0, 1), 1.0 - u), (at(1, 0), 1.0 - v)]
    }
}

/// Where a corner of the grid lies; lengths in triangle sides.
fn place(corner: [i32; 2]) -> Vec2 {
    let [x, y] = corner.map(|c| c as f32);
    Vec2::new(x + 0.5 * y, 0.5 * 3.0_f32.sqrt() * y)
}

/// What one hexagon shows at a pixel: its weight, the pixel of the exemplar, and the texel.
type Part = (f32, Vec2, Texel);

/// What the hexagons around a pixel show.
fn parts(tile: &Tile<'_>, pixel: Vec2, lod: f32, options: &HexOptions) -> [Part; 3] {
    let size = tile.size();
    let side = SIDE * size.x;
    triangle(pixel / side).map(|(corner, weight)| {
        let stream = u64::from(corner[0].cast_unsigned()) << 32 | u64::from(corner[1].cast_unsigned());
        let mut random = Random::new(options.seed, stream);
        let shift = Vec2::new(random.unit() as f32, random.unit() as f32) * size;
        let turn = Vec2::from_angle(options.turn * (2.0 * random.unit() as f32 - 1.0));
        let middle = place(corner) * side;
        let place = turn.rotate(pixel - middle) + middle + shift;
        let mut texel = tile.texel(place, lod);
        // Pixels count downward, so what is read turned one way is shown turned the other.
        texel.normal = turn.rotate(texel.normal.truncate()).extend(texel.normal.z);
        let luminance = texel.base_color.dot(Vec3::new(0.2126, 0.7152, 0.0722));
        let bright = 1.0 + (luminance - 1.0) * options.contrast;
        (bright.max(1e-4) * weight.max(0.0).powf(options.power), place, texel)
    })
}

/// The texture at a pixel; the normal is in the tile's own frame.
#[must_use]
pub fn hex_texel(tile: &Tile<'_>, pixel: Vec2, lod: f32, options: &HexOptions) -> Texel {
    let parts = parts(tile, pixel, lod, options);
    let total: f32 = parts.iter().map(|(w, ..)| w).sum();
    mean(&parts.map(|(w, _, t)| (w / total.max(f32::MIN_POSITIVE), t)))
}

/// The pixel of the exemplar that weighs most at a pixel.
#[must_use]
pub fn hex_place(tile: &Tile<'_>, pixel: Vec2, options: &HexOptions) -> Vec2 {
    let [a, b, c] = parts(tile, pixel, 0.0, options);
    [b, c].into_iter().fold(a, |most, part| if part.0 > most.0 { part } else { most }).1
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_say_where_a_point_lies_in_its_triangle() {
        let mut random = Random::new(3, 0);
        for _ in 0..2000 {
            let p = Vec2::new(random.range(-9.0, 9.0) as f32, random.range(-9.0, 9.0) as f32);
            let corners = triangle(p);
            let sum: f32 = corners.iter().map(|(_, w)| w).sum();
            assert!((sum - 1.0).abs() < 1e-4 && corners.iter().all(|(_, w)| *w > -1e-4), "{corners:?} at {p}");
            let back: Vec2 = corners.iter().map(|(c, w)| place(*c) * *w).sum();
            assert!((back - p).length() < 1e-4, "{p} is found again at {back}");
            for k in 0..3 {
                let apart = (place(corners[k].0) - place(corners[(k + 1) % 3].0)).length();
                assert!((apart - 1.0).abs() < 1e-4, "sides of one: {apart}");
            }
        }
    }
}
