//! Which parts of the surface are opaque under the pastes so far (LT 3.6).
//!
//! Based on: Praun, Finkelstein, Hoppe 2000, section 3.6: an offscreen buffer in which every face owns pixels.
//!
//! 1. Each face owns a [`Lattice`] of cells at most `pitch` wide; no point of the face is further than half a cell's
//!    diagonal from its cell's sample.
//! 2. A paste darkens a sample by the *least* alpha found within that distance of its image. So when a sample is opaque,
//!    its whole cell is: what lies between samples needs no second look, however coarse the lattice. (The alpha of later
//!    and earlier pastes multiplies; order does not matter.)
//! 3. Where the image of a face, or of a run of cells, lies deep inside the opaque part of the texture patch, or wholly
//!    outside of it, one distance look-up decides for all its samples.
//!
//! Where we differ: the paper counts pixels that happen to be covered. Keeping the least alpha costs a texel of overlap
//! and makes "covered" a statement about every point. A face that overlaps itself in texture space needs no several
//! passes here, because samples belong to the surface and not to the texture plane.

use super::stencil::Stencil;
use glam::{DVec2, DVec3, Vec2, Vec3};

/// Cells of a row that are tried together against the mask's depth before they are looked at one by one.
pub const RUN: u32 = 8;

/// Faces that one task looks at, where all are: a face of a coarse mesh may hold thousands of cells.
pub(super) const FACES_A_TASK: usize = 128;

/// Samples at or below this transparency, of 255, count as opaque.
const OPAQUE: u8 = 1;

/// Runs of no more cells than this are not tried together.
const SHORT_RUN: usize = 2;

/// The cells of one face: rows over its longest edge, each cut into equal cells.
#[derive(Debug, Clone, Copy)]
pub struct Lattice {
    /// Corner of the face at the origin; x runs from it along the longest edge to the next corner.
    first: usize,
    base: f64,
    apex: DVec2,
    rows: u32,
    pitch: f64,
}

impl Lattice {
    /// The lattice of a face for cells at most `pitch` (world units) wide and high.
    #[must_use]
    pub fn new(p: &[DVec3; 3], pitch: f64) -> Self {
        let length = [0, 1, 2].map(|k: usize| p[(k + 1) % 3].distance(p[k]));
        let mut first = 0;
        for k in 1..3 {
            if length[k] > length[first] {
                first = k;
            }
        }
        let base = length[first];
        let (a, b, c) = (p[first], p[(first + 1) % 3], p[(first + 2) % 3]);
        let x = (c - a).dot(b - a) / base;
        let apex = DVec2::new(x.clamp(0.0, base), (b - a).cross(c - a).length() / base);
        Self { first, base, apex, rows: (apex.y / pitch).ceil().max(1.0) as u32, pitch }
    }

    /// Number of cells.
    #[must_use]
    pub fn cells(&self) -> usize {
        (0..self.rows).map(|row| self.row_cells(row) as usize).sum()
    }

    /// Number of cells in each row.
    #[must_use]
    pub fn rows(&self) -> Vec<u32> {
        (0..self.rows).map(|row| self.row_cells(row)).collect()
    }

    /// The corner opposite the longest edge, where that runs from (0, 0) to (1, 0).
    pub(super) fn apex(&self) -> DVec2 {
        self.apex / self.base
    }

    fn row_cells(&self, row: u32) -> u32 {
        let width = self.base * (1.0 - f64::from(row) / f64::from(self.rows));
        (width / self.pitch).ceil().max(1.0) as u32
    }

    /// Half the extents of the largest cell.
    pub(super) fn half_cell(&self) -> DVec2 {
        DVec2::new(0.5 * self.base.min(self.pitch), 0.5 * self.apex.y / f64::from(self.rows))
    }

    /// Left end and cell width of a row. A row is widest at its bottom, since the base is the longest edge.
    fn row(&self, row: u32, cells: u32) -> (f64, f64) {
        let up = f64::from(row) / f64::from(self.rows);
        (self.apex.x * up, self.base * (1.0 - up) / f64::from(cells))
    }

    /// The sample of a cell: the point of the triangle nearest to the cell's middle. Being nearest in a convex set, it is
    /// no further from any point of the triangle in the cell than the middle is.
    fn sample(&self, row: u32, left: f64, width: f64, cell: u32) -> DVec2 {
        let y = (f64::from(row) + 0.5) * self.apex.y / f64::from(self.rows);
        let middle = DVec2::new(left + (f64::from(cell) + 0.5) * width, y);
        let up = y / self.apex.y;
        if middle.x < self.apex.x * up {
            nearest_on_segment(DVec2::ZERO, self.apex, middle)
        } else if middle.x > self.base + (self.apex.x - self.base) * up {
            nearest_on_segment(DVec2::new(self.base, 0.0), self.apex, middle)
        } else {
            middle
        }
    }

    /// Barycentric coordinates of a lattice point.
    pub(super) fn bary(&self, at: DVec2) -> Vec3 {
        let top = at.y / self.apex.y;
        let right = (at.x - self.apex.x * top) / self.base;
        let mut bary = [0.0; 3];
        bary[self.first] = (1.0 - top - right) as f32;
        bary[(self.first + 1) % 3] = right as f32;
        bary[(self.first + 2) % 3] = top as f32;
        Vec3::from(bary)
    }

    /// Calls `visit` with every run of up to `most` cells of a row, row by row.
    pub(super) fn for_each_run(&self, most: u32, mut visit: impl FnMut(&Run)) {
        let half_height = 0.5 * self.apex.y / f64::from(self.rows);
        for row in 0..self.rows {
            let cells = self.row_cells(row);
            let (left, width) = self.row(row, cells);
            for first in (0..cells).step_by(most as usize) {
                visit(&Run { lattice: self, row, left, width, first, cells: most.min(cells - first), half_height });
            }
        }
    }

    /// Barycentric coordinates of a sample; `index` counts row by row.
    #[must_use]
    pub fn point(&self, index: usize) -> Vec3 {
        let mut left_over = index as u32;
        for row in 0..self.rows {
            let cells = self.row_cells(row);
            if left_over < cells {
                let (left, width) = self.row(row, cells);
                return self.bary(self.sample(row, left, width, left_over));
            }
            left_over -= cells;
        }
        Vec3::splat(1.0 / 3.0)
    }
}

/// Cells of a row next to each other.
pub(super) struct Run<'a> {
    lattice: &'a Lattice,
    row: u32,
    left: f64,
    width: f64,
    first: u32,
    cells: u32,
    half_height: f64,
}

impl Run<'_> {
    /// Number of cells.
    pub(super) const fn cells(&self) -> u32 {
        self.cells
    }

    /// The middle of their rectangle.
    pub(super) fn middle(&self) -> DVec2 {
        let cells = f64::from(self.first) + 0.5 * f64::from(self.cells);
        DVec2::new(self.left + cells * self.width, (2.0 * f64::from(self.row) + 1.0) * self.half_height)
    }

    /// Half its extents.
    pub(super) fn half(&self) -> DVec2 {
        DVec2::new(0.5 * f64::from(self.cells) * self.width, self.half_height)
    }

    /// The samples.
    pub(super) fn samples(&self) -> impl Iterator<Item = DVec2> + '_ {
        (self.first..self.first + self.cells).map(|cell| self.lattice.sample(self.row, self.left, self.width, cell))
    }
}

fn nearest_on_segment(a: DVec2, b: DVec2, p: DVec2) -> DVec2 {
    let t = (p - a).dot(b - a) / (b - a).length_squared();
    a + (b - a) * t.clamp(0.0, 1.0)
}

/// How a paste's texture lies on a face: mask pixels as an affine function of lattice coordinates.
#[derive(Debug, Clone, Copy)]
pub(super) struct Image {
    origin: DVec2,
    along: DVec2,
    up: DVec2,
}

impl Image {
    /// From the mask pixels of the face's corners.
    pub(super) fn new(lattice: &Lattice, pixel: [DVec2; 3]) -> Self {
        let k = lattice.first;
        let (a, b, c) = (pixel[k], pixel[(k + 1) % 3], pixel[(k + 2) % 3]);
        let along = (b - a) / lattice.base;
        Self { origin: a, along, up: (c - a - along * lattice.apex.x) / lattice.apex.y }
    }

    /// The mask pixel of a lattice point.
    pub(super) fn at(&self, p: DVec2) -> Vec2 {
        (self.origin + self.along * p.x + self.up * p.y).as_vec2()
    }

    /// The mask pixel of the origin, and steps of mask pixels for one longest edge along it and up.
    pub(super) fn in_edges(&self, lattice: &Lattice) -> [Vec2; 3] {
        [self.origin, self.along * lattice.base, self.up * lattice.base].map(DVec2::as_vec2)
    }

    /// Radius of the image of a box of half extents `half`.
    pub(super) fn radius(&self, half: DVec2) -> f32 {
        let (a, b) = (self.along * half.x, self.up * half.y);
        (a + b).length().max((a - b).length()) as f32
    }
}

/// How much of a face a texture patch hides, as far as one look tells.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Reach {
    /// Nothing of it.
    None,
    /// All of it.
    All,
    /// Its samples must be looked at.
    Some,
}

/// What is known of a face.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub enum Tile {
    /// No paste touches it.
    #[default]
    Bare,
    /// Every point is opaque.
    Opaque,
    /// Transparency of each sample, of 255; 0 is opaque.
    Partial(Box<[u8]>),
}

impl Tile {
    /// Number of samples that are not opaque.
    #[must_use]
    pub fn uncovered(&self, cells: impl FnOnce() -> usize) -> usize {
        match self {
            Self::Bare => cells(),
            Self::Opaque => 0,
            Self::Partial(samples) => samples.iter().filter(|&&t| t > 0).count(),
        }
    }

    /// Index of the `n`-th sample that is not opaque.
    #[must_use]
    pub fn uncovered_sample(&self, n: usize) -> Option<usize> {
        match self {
            Self::Bare => Some(n),
            Self::Opaque => None,
            Self::Partial(samples) => samples.iter().enumerate().filter(|(_, t)| **t > 0).nth(n).map(|(i, _)| i),
        }
    }

    /// What is known, from the transparency of each sample.
    #[must_use]
    pub fn of_samples(samples: Box<[u8]>) -> Self {
        if samples.iter().all(|&t| t == 0) { Self::Opaque } else { Self::Partial(samples) }
    }

    /// Makes one sample opaque.
    pub fn cover_sample(&mut self, index: usize, cells: usize) {
        if let Self::Bare = self {
            *self = Self::Partial(vec![255; cells].into());
        }
        if let Self::Partial(samples) = self {
            if let Some(sample) = samples.get_mut(index) {
                *sample = 0;
            }
            if samples.iter().all(|&t| t == 0) {
                *self = Self::Opaque;
            }
        }
    }

    /// Lays a texture patch over the face: `pixel` are the mask pixels of its corners. True if anything of it may
    /// show on the part that was not opaque yet.
    pub fn cover(&mut self, lattice: &Lattice, stencil: &Stencil, pixel: [DVec2; 3]) -> bool {
        if *self == Self::Opaque {
            return false;
        }
        match stencil.reach_of_face(&pixel) {
            Reach::None => return false,
            Reach::All => {
                *self = Self::Opaque;
                return true;
            }
            Reach::Some => {}
        }
        if let Self::Bare = self {
            *self = Self::Partial(vec![255; lattice.cells()].into());
        }
        let Self::Partial(samples) = self else { return false };
        let (touched, open) = cover_samples(samples, lattice, stencil, &Image::new(lattice, pixel));
        if !open {
            *self = Self::Opaque;
        }
        touched
    }
}

/// Multiplies the samples' transparency; whether the mask reached any that was not opaque, and whether any is left.
fn cover_samples(samples: &mut [u8], lattice: &Lattice, stencil: &Stencil, image: &Image) -> (bool, bool) {
    let (mut touched, mut open, mut start) = (false, false, 0);
    let radius = image.radius(lattice.half_cell());
    lattice.for_each_run(RUN, |run| {
        let these = &mut samples[start..start + run.cells() as usize];
        start += these.len();
        if these.iter().all(|&t| t == 0) {
            return;
        }
        if these.len() > SHORT_RUN {
            match stencil.reach(image.at(run.middle()), image.radius(run.half())) {
                Reach::None => {
                    open = true;
                    return;
                }
                Reach::All => {
                    these.fill(0);
                    touched = true;
                    return;
                }
                Reach::Some => {}
            }
        }
        for (transparency, sample) in these.iter_mut().zip(run.samples()) {
            if *transparency == 0 {
                continue;
            }
            let at = image.at(sample);
            touched = touched || stencil.touches(at, radius);
            let clear = 255 - u32::from(stencil.eroded_alpha(at, radius));
            // Rounded up: a sample never counts as more opaque than it is.
            let rest = (u32::from(*transparency) * clear).div_ceil(255) as u8;
            *transparency = if rest <= OPAQUE { 0 } else { rest };
            open |= *transparency > 0;
        }
    });
    (touched, open)
}
