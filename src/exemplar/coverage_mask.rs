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
use std::sync::Arc;

/// Radii, in pixels, for which eroded alpha is kept.
pub const ERODED_RADII: [f32; 5] = [0.75, 1.5, 3.0, 6.0, 12.0];
/// Lattice points per pixel with which each is found: what the lattice overshoots the region is lost as opaque area.
const LATTICE: [i32; 5] = [4, 4, 2, 1, 1];
/// Pixels of 0 around alpha while it is eroded: more than any region reaches.
const PADDING: usize = 16;
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

/// A mask prepared for coverage; copies share its pixels. Positions are continuous pixels of the mask; (0, 0) is its top left corner.
#[derive(Debug, Clone, PartialEq)]
pub struct CoverageMask {
    width: u32,
    height: u32,
    size: Vec2,
    cells: Arc<[Cell]>,
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
        let padded = w + 2 * PADDING;
        let mut surrounded = vec![0; padded * (h + 2 * PADDING)];
        for (y, row) in alpha.chunks_exact(w).enumerate() {
            surrounded[(y + PADDING) * padded + PADDING..][..w].copy_from_slice(row);
        }
        let regions: Vec<Region> = ERODED_RADII.iter().zip(LATTICE).map(|(&r, q)| Region::new(r, q, padded)).collect();
        let cell = |i: usize| {
            let mut cell = Cell { depth: depth[i], alpha: alpha[i], ..Cell::default() };
            for (eroded, region) in cell.eroded.iter_mut().zip(&regions) {
                *eroded = if f32::from(cell.depth) >= region.radius * DEPTH_STEPS {
                    OPAQUE_BYTE
                } else if cell.depth < 0 {
                    0
                } else {
                    region.minimum(&surrounded, (i / w + PADDING) * padded + i % w + PADDING)
                };
                if *eroded == 0 {
                    break;
                }
            }
            cell
        };
        let cells = (0..w * h).into_par_iter().map(cell).collect::<Vec<_>>().into();
        Self { width, height, size: Vec2::new(width as f32, height as f32), cells }
    }

    /// Width and height in pixels.
    #[must_use]
    pub const fn size(&self) -> [u32; 2] {
        [self.width, self.height]
    }

    /// All that is known of each pixel, rows from the top, for whoever looks it up elsewhere. First word: depth in sixteenths
    /// of a pixel as 16 bits with sign, alpha, and eroded alpha of the first radius; second word: that of the others.
    #[must_use]
    pub fn words(&self) -> Vec<[u32; 2]> {
        let word = |cell: &Cell| {
            let [e0, e1, e2, e3, e4] = cell.eroded;
            let [low, high] = cell.depth.to_le_bytes();
            [u32::from_le_bytes([low, high, cell.alpha, e0]), u32::from_le_bytes([e1, e2, e3, e4])]
        };
        self.cells.iter().map(word).collect()
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
        // Nothing is left of alpha at the centres of border pixels.
        if !(p.cmpge(Vec2::ZERO) & p.cmplt(self.size - 1.0)).all() {
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
    // it nearest to another pixel centre is a corner, so distances to the corners of such squares are exact. These corners
    // are the pixels with such a pixel among their eight neighbours and themselves.
    let rows: Vec<&[u8]> = alpha.chunks_exact(width).collect();
    let (mut below, mut touched) = (vec![false; alpha.len()], vec![false; alpha.len()]);
    below.par_chunks_mut(width).zip(touched.par_chunks_mut(width)).enumerate().for_each(|(y, (below, touched))| {
        let (above, here, under) = (rows[y.saturating_sub(1)], rows[y], rows[(y + 1).min(rows.len() - 1)]);
        let least: Vec<u8> = (0..width).map(|x| above[x].min(here[x]).min(under[x])).collect();
        let most: Vec<u8> = (0..width).map(|x| above[x].max(here[x]).max(under[x])).collect();
        for x in 0..width {
            let (left, right) = (x.saturating_sub(1), (x + 1).min(width - 1));
            below[x] = least[left].min(least[x]).min(least[right]) < OPAQUE_BYTE;
            touched[x] = most[left].max(most[x]).max(most[right]) > 0;
        }
    });
    // Casts saturate: no depth is told beyond what 16 bits hold.
    let steps = |squared: f32| ((squared.sqrt() - FRAC_1_SQRT_2) * (1.0 - 1e-6) * DEPTH_STEPS).max(0.0) as i16;
    let (below, touched) = (squared_distance(&below, width), squared_distance(&touched, width));
    below.par_iter().zip(&touched).map(|(&below, &touched)| if below > 0.0 { steps(below) } else { -steps(touched) }).collect()
}

/// The lattice points whose squares cover a cell and all points within a radius of it.
struct Region {
    radius: f32,
    /// Lattice points per pixel.
    per_pixel: i32,
    /// Relative to the cell's pixel: the index of the pixel left and above the point, and the point's bilinear weights for
    /// it and its neighbours right, below and both, in units of `per_pixel` to the power of -2.
    points: Vec<(isize, [i32; 4])>,
    width: usize,
}

impl Region {
    fn new(radius: f32, per_pixel: i32, width: usize) -> Self {
        let (q, step) = (per_pixel, 1.0 / per_pixel as f32);
        // A point matters if a square that it is a corner of comes closer to the cell than the radius.
        let gap = |k: i32| (k.abs() as f32 * step - step - 0.5).max(0.0);
        let reach = ((radius + 0.5 + step) * q as f32).ceil() as i32;
        let mut points: Vec<[i32; 2]> = (-reach..=reach)
            .flat_map(|y| (-reach..=reach).map(move |x| [x, y]))
            .filter(|&[x, y]| gap(x).hypot(gap(y)) < radius)
            .collect();
        // From outside in: where alpha falls off, 0 is found at once.
        points.sort_by_key(|[x, y]| -(x * x + y * y));
        let prepared = |[x, y]: [i32; 2]| {
            let (fx, fy) = (x.rem_euclid(q), y.rem_euclid(q));
            let offset = y.div_euclid(q) as isize * width as isize + x.div_euclid(q) as isize;
            (offset, [(q - fx) * (q - fy), fx * (q - fy), (q - fx) * fy, fx * fy])
        };
        Self { radius, per_pixel, points: points.into_iter().map(prepared).collect(), width }
    }

    /// The minimum of alpha over the lattice points around pixel `i` of padded alpha, rounded down.
    fn minimum(&self, alpha: &[u8], i: usize) -> u8 {
        if self.per_pixel == 1 {
            // Its points are pixels.
            let mut least = 255;
            for &(offset, _) in &self.points {
                least = alpha[i.wrapping_add_signed(offset)].min(least);
                if least == 0 {
                    break;
                }
            }
            return least;
        }
        let one = self.per_pixel * self.per_pixel;
        let mut least = 255 * one;
        for &(offset, weights) in &self.points {
            let first = i.wrapping_add_signed(offset);
            let below = first + self.width;
            let corners = [alpha[first], alpha[first + 1], alpha[below], alpha[below + 1]];
            least = least.min(corners.iter().zip(weights).map(|(&a, w)| i32::from(a) * w).sum());
            if least == 0 {
                break;
            }
        }
        (least / one) as u8
    }
}
