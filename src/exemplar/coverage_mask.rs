//! What coverage asks of a mask: lower bounds of its alpha over a neighbourhood, in a few nanoseconds.
//!
//! Alpha is the bilinear interpolation between pixel centres, 0 outside. One cell of eight bytes per pixel holds all that
//! is ever asked, so that each question costs one cache line:
//!
//! - depth: how far the cell's points are from the nearest point that is not opaque, or, negative, from the nearest point
//!   with alpha. Exact distance transforms of the squares between pixel centres, less the largest distance between a cell's
//!   point and its centre, rounded towards 0.
//! - eroded alpha: the minimum of alpha over the cell and all points within a radius, for a few radii. The minimum over a
//!   lattice whose squares cover that region: within a lattice square alpha is bilinear, so its corners bound it.
//!
//! Both only ever err on the safe side: less deep, less opaque.

use super::distance::squared_distance;
use super::mask::OPAQUE;
use super::{Image, TexturePatch};
use glam::Vec2;
use rayon::prelude::*;
use std::f32::consts::FRAC_1_SQRT_2;

/// Radii, in pixels, for which eroded alpha is kept.
pub const ERODED_RADII: [f32; 5] = [0.75, 1.5, 3.0, 6.0, 12.0];
/// Lattice points per pixel with which each is found: what the lattice overshoots the region is lost as opaque area.
const LATTICE: [i32; 5] = [4, 4, 2, 1, 1];
/// Steps per pixel of stored depths.
const DEPTH_STEPS: f32 = 16.0;
/// Alpha in 8 bits from which a point is opaque.
const OPAQUE_BYTE: u8 = (OPAQUE * 255.0) as u8;

#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
struct Cell {
    depth: i16,
    alpha: u8,
    eroded: [u8; ERODED_RADII.len()],
}

/// A mask prepared for coverage. Positions are continuous pixels of the mask; (0, 0) is its top left corner.
#[derive(Debug, Clone, PartialEq)]
pub struct CoverageMask {
    width: u32,
    height: u32,
    size: Vec2,
    cells: Vec<Cell>,
}

impl CoverageMask {
    /// Prepares the finest level of a patch's mask.
    #[must_use]
    pub fn new(patch: &TexturePatch) -> Self {
        Self::of_image(patch.mask.finest())
    }

    /// Prepares the first component of an image. Its border is taken as transparent, and alpha is rounded down to 8 bits.
    #[must_use]
    pub fn of_image(mask: &Image) -> Self {
        let [width, height] = mask.size();
        let (w, h) = (width as usize, height as usize);
        let alpha: Vec<u8> = (0..w * h)
            .map(|i| {
                let (x, y) = (i % w, i / w);
                let border = x == 0 || y == 0 || x == w - 1 || y == h - 1;
                // Rounding up a hair recovers what was exact in 8 bits.
                if border { 0 } else { (mask.grey(x as i64, y as i64) * 255.0 + 1e-3) as u8 }
            })
            .collect();
        let depth = depths(&alpha, w);
        let regions: Vec<Region> = ERODED_RADII.iter().zip(LATTICE).map(|(&r, q)| Region::new(r, q)).collect();
        let cell = |i: usize| {
            let mut cell = Cell { depth: depth[i], alpha: alpha[i], ..Cell::default() };
            for (eroded, region) in cell.eroded.iter_mut().zip(&regions) {
                *eroded = if f32::from(cell.depth) >= region.radius * DEPTH_STEPS {
                    OPAQUE_BYTE
                } else if cell.depth < 0 {
                    0
                } else {
                    region.minimum(&alpha, w, i)
                };
                if *eroded == 0 {
                    break;
                }
            }
            cell
        };
        let cells = (0..w * h).into_par_iter().map(cell).collect();
        Self { width, height, size: Vec2::new(width as f32, height as f32), cells }
    }

    /// Width and height in pixels.
    #[must_use]
    pub const fn size(&self) -> [u32; 2] {
        [self.width, self.height]
    }

    /// The cell a position lies in; for one outside, the nearest.
    #[inline]
    fn cell(&self, at: Vec2) -> Cell {
        // Casts saturate, so what lies left or above is 0, and so is NaN.
        let x = (at.x as u32).min(self.width - 1) as usize;
        let y = (at.y as u32).min(self.height - 1) as usize;
        self.cells[y * self.width as usize + x]
    }

    /// Positive: every point closer than this is opaque (alpha at least 254/255). Negative: every point closer than minus
    /// this has alpha 0. Pixels.
    #[inline]
    #[must_use]
    pub fn depth(&self, at: Vec2) -> f32 {
        let depth = f32::from(self.cell(at).depth) * (1.0 / DEPTH_STEPS);
        let outside = at - at.clamp(Vec2::ZERO, self.size);
        // All alpha lies within the rectangle, so from its nearest point on the way there turns by a right angle or less.
        if outside == Vec2::ZERO { depth } else { -depth.hypot(outside.length()) }
    }

    /// A lower bound of alpha * 255 at all points within `radius` of `at`. Radii above the largest of [`ERODED_RADII`] give
    /// 0 unless everything is opaque.
    #[inline]
    #[must_use]
    pub fn eroded_alpha(&self, at: Vec2, radius: f32) -> u8 {
        let cell = self.cell(at);
        let level = ERODED_RADII.iter().filter(|&&r| r < radius).count();
        let eroded = cell.eroded.get(level).copied().unwrap_or(0);
        if eroded < OPAQUE_BYTE && f32::from(cell.depth) >= radius * DEPTH_STEPS { OPAQUE_BYTE } else { eroded }
    }

    /// False only if alpha is 0 at all points within `radius` of `at`.
    #[inline]
    #[must_use]
    pub fn touches(&self, at: Vec2, radius: f32) -> bool {
        self.depth(at) > -radius
    }

    /// Alpha at a position, 0 to 1.
    #[inline]
    #[must_use]
    pub fn alpha(&self, at: Vec2) -> f32 {
        let p = at - 0.5;
        // Between the first and the last pixel centres; further out the border is transparent.
        if !(p.cmpge(Vec2::ZERO).all() && p.cmplt(self.size - 1.0).all()) {
            return 0.0;
        }
        let (x, y) = (p.x as u32, p.y as u32);
        let first = y as usize * self.width as usize + x as usize;
        let (top, bottom) = (&self.cells[first..first + 2], &self.cells[first + self.width as usize..][..2]);
        let f = Vec2::new(p.x - x as f32, p.y - y as f32);
        let mix = |row: &[Cell]| f32::from(row[0].alpha) + f.x * (f32::from(row[1].alpha) - f32::from(row[0].alpha));
        let (top, bottom) = (mix(top), mix(bottom));
        (top + f.y * (bottom - top)) * (1.0 / 255.0)
    }
}

/// The depth of each cell in steps; see [`CoverageMask::depth`].
fn depths(alpha: &[u8], width: usize) -> Vec<i16> {
    // A square between four pixel centres holds points without a property if one of its corners is without; the point of
    // it nearest to another pixel centre is a corner, so distances to the corners of such squares are exact.
    let to_squares_with = |has: &dyn Fn(u8) -> bool| {
        let mut corners = vec![false; alpha.len()];
        for i in (0..alpha.len()).filter(|&i| has(alpha[i])) {
            let (x, y) = (i % width, i / width);
            for ny in y.saturating_sub(1)..=(y + 1).min(alpha.len() / width - 1) {
                corners[ny * width + x.saturating_sub(1)..=ny * width + (x + 1).min(width - 1)].fill(true);
            }
        }
        squared_distance(&corners, width)
    };
    // Casts saturate: no depth is told beyond what 16 bits hold.
    let steps = |squared: f32| ((squared.sqrt() - FRAC_1_SQRT_2) * (1.0 - 1e-6) * DEPTH_STEPS).max(0.0) as i16;
    let below = to_squares_with(&|a| a < OPAQUE_BYTE);
    let touched = to_squares_with(&|a| a > 0);
    below.iter().zip(&touched).map(|(&below, &touched)| if below > 0.0 { steps(below) } else { -steps(touched) }).collect()
}

/// The lattice points whose squares cover a cell and all points within a radius of it.
struct Region {
    radius: f32,
    /// Lattice points per pixel.
    per_pixel: i32,
    /// Relative to the cell's pixel: the pixel left and above the lattice point, and the lattice steps from its centre.
    points: Vec<[i32; 4]>,
}

impl Region {
    fn new(radius: f32, per_pixel: i32) -> Self {
        let step = 1.0 / per_pixel as f32;
        // A point matters if a square that it is a corner of comes closer to the cell than the radius.
        let gap = |k: i32| (k.abs() as f32 * step - step - 0.5).max(0.0);
        let reach = ((radius + 0.5 + step) * per_pixel as f32).ceil() as i32;
        let mut points: Vec<[i32; 2]> = (-reach..=reach)
            .flat_map(|y| (-reach..=reach).map(move |x| [x, y]))
            .filter(|&[x, y]| gap(x).hypot(gap(y)) < radius)
            .collect();
        // From outside in: where alpha falls off, 0 is found at once.
        points.sort_by_key(|[x, y]| -(x * x + y * y));
        let split =
            |[x, y]: [i32; 2]| [x.div_euclid(per_pixel), y.div_euclid(per_pixel), x.rem_euclid(per_pixel), y.rem_euclid(per_pixel)];
        Self { radius, per_pixel, points: points.into_iter().map(split).collect() }
    }

    /// The minimum of alpha over the lattice points around pixel `i`, rounded down.
    fn minimum(&self, alpha: &[u8], width: usize, i: usize) -> u8 {
        let (x, y) = ((i % width) as i32, (i / width) as i32);
        let (w, h) = (width as i32, (alpha.len() / width) as i32);
        let at = |x: i32, y: i32| {
            if (0..w).contains(&x) && (0..h).contains(&y) { i32::from(alpha[(y * w + x) as usize]) } else { 0 }
        };
        let q = self.per_pixel;
        let mut least = 255 * q * q;
        for &[dx, dy, fx, fy] in &self.points {
            let (x, y) = (x + dx, y + dy);
            let top = (q - fx) * at(x, y) + fx * at(x + 1, y);
            let bottom = (q - fx) * at(x, y + 1) + fx * at(x + 1, y + 1);
            least = least.min((q - fy) * top + fy * bottom);
            if least == 0 {
                break;
            }
        }
        (least / (q * q)) as u8
    }
}
