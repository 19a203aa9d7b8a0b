//! Images of 32-bit floats, one or three components a pixel, and their mip chains.

use glam::{Vec2, Vec3};
use std::sync::Arc;

/// A float image. Colour is linear light.
#[derive(Debug, Clone, PartialEq)]
pub struct Image {
    width: u32,
    height: u32,
    components: usize,
    data: Vec<f32>,
}

impl Image {
    /// An image from rows of pixels, top row first. `None` unless `data` holds `width * height * components` numbers,
    /// the size is not zero, and components are 1 or 3.
    #[must_use]
    pub fn new(width: u32, height: u32, components: usize, data: Vec<f32>) -> Option<Self> {
        let fits = data.len() == width as usize * height as usize * components;
        (fits && !data.is_empty() && matches!(components, 1 | 3)).then_some(Self { width, height, components, data })
    }

    /// An image made pixel by pixel from (x, y). Sizes of 0 are taken as 1.
    #[must_use]
    pub fn from_fn(width: u32, height: u32, mut pixel: impl FnMut(u32, u32) -> Vec3) -> Self {
        let (width, height) = (width.max(1), height.max(1));
        let mut data = Vec::with_capacity(width as usize * height as usize * 3);
        for y in 0..height {
            for x in 0..width {
                data.extend(pixel(x, y).to_array());
            }
        }
        Self { width, height, components: 3, data }
    }

    /// A one-component image made pixel by pixel from (x, y). Sizes of 0 are taken as 1.
    #[must_use]
    pub fn grey_from_fn(width: u32, height: u32, mut pixel: impl FnMut(u32, u32) -> f32) -> Self {
        let (width, height) = (width.max(1), height.max(1));
        let data = (0..height).flat_map(|y| (0..width).map(move |x| (x, y))).map(|(x, y)| pixel(x, y)).collect();
        Self { width, height, components: 1, data }
    }

    /// Width and height.
    #[must_use]
    pub const fn size(&self) -> [u32; 2] {
        [self.width, self.height]
    }

    /// Components a pixel: 1 or 3.
    #[must_use]
    pub const fn components(&self) -> usize {
        self.components
    }

    /// All numbers, rows from the top.
    #[must_use]
    pub fn data(&self) -> &[f32] {
        &self.data
    }

    /// All numbers, to change.
    pub fn data_mut(&mut self) -> &mut [f32] {
        &mut self.data
    }

    /// A pixel as three components (one component three times); coordinates are clamped.
    #[inline]
    #[must_use]
    pub fn pixel(&self, x: i64, y: i64) -> Vec3 {
        let x = x.clamp(0, i64::from(self.width) - 1) as usize;
        let y = y.clamp(0, i64::from(self.height) - 1) as usize;
        let i = (y * self.width as usize + x) * self.components;
        if self.components == 3 { Vec3::new(self.data[i], self.data[i + 1], self.data[i + 2]) } else { Vec3::splat(self.data[i]) }
    }

    /// A one-component pixel; coordinates are clamped. The first component of a colour image.
    #[inline]
    #[must_use]
    pub fn grey(&self, x: i64, y: i64) -> f32 {
        let x = x.clamp(0, i64::from(self.width) - 1) as usize;
        let y = y.clamp(0, i64::from(self.height) - 1) as usize;
        self.data[(y * self.width as usize + x) * self.components]
    }

    /// Bilinear sample at continuous pixel coordinates, edge pixels repeated outward. One component is given three times.
    #[must_use]
    pub fn bilinear(&self, at: Vec2) -> Vec3 {
        let ((x0, x1), u) = neighbours(at.x, self.width);
        let ((y0, y1), v) = neighbours(at.y, self.height);
        let (top, bottom) = (y0 * self.width as usize, y1 * self.width as usize);
        if self.components == 1 {
            let [a, b, c, d] = [top + x0, top + x1, bottom + x0, bottom + x1].map(|i| self.data[i]);
            let (ab, cd) = (a + u * (b - a), c + u * (d - c));
            return Vec3::splat(ab + v * (cd - ab));
        }
        let [a, b, c, d] = [top + x0, top + x1, bottom + x0, bottom + x1].map(|i| Vec3::from_slice(&self.data[3 * i..3 * i + 3]));
        let (ab, cd) = (a + u * (b - a), c + u * (d - c));
        ab + v * (cd - ab)
    }
}

/// The pixels whose centres lie around a coordinate, clamped to `count` of them, and how far it is from the first to the
/// second.
#[inline]
fn neighbours(at: f32, count: u32) -> ((usize, usize), f32) {
    let p = at - 0.5;
    // The saturating cast rounds towards 0; below 0 that is one too many. (`f32::floor` is a call on plain x86-64.)
    let whole = p as i32;
    let low = whole - i32::from(p < whole as f32);
    let last = count as i32 - 1;
    ((low.clamp(0, last) as usize, low.saturating_add(1).clamp(0, last) as usize), p - low as f32)
}

/// An image and its successive halvings down to one pixel. Copies share their pixels.
#[derive(Debug, Clone, PartialEq)]
pub struct MipChain {
    levels: Arc<[Image]>,
}

impl MipChain {
    /// Builds the levels by averaging 2x2 pixels (box filter; odd sizes repeat their last row or column).
    #[must_use]
    pub fn new(finest: Image) -> Self {
        Self::build(finest, false)
    }

    /// The same for an alpha mask: the border of every level finer than 2x2 is set to 0 (LT 4), so that clamped sampling
    /// outside gives 0 at every level.
    #[must_use]
    pub fn mask(finest: Image) -> Self {
        Self::build(finest, true)
    }

    fn build(finest: Image, transparent_border: bool) -> Self {
        let mut levels = vec![finest];
        loop {
            let last = levels.len() - 1;
            if transparent_border {
                clear_border(&mut levels[last]);
            }
            let [w, h] = levels[last].size();
            if w == 1 && h == 1 {
                return Self { levels: levels.into() };
            }
            levels.push(halve(&levels[last]));
        }
    }

    /// The levels, finest first.
    #[must_use]
    pub fn levels(&self) -> &[Image] {
        &self.levels
    }

    /// The finest level.
    #[must_use]
    pub fn finest(&self) -> &Image {
        &self.levels[0]
    }

    /// True if one is a copy of the other.
    #[must_use]
    pub fn shares_pixels(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.levels, &other.levels)
    }

    /// The one pixel of the coarsest level: the mean of all, if sides are powers of two; else those at the right and lower edge count
    /// for more.
    #[must_use]
    pub fn mean(&self) -> Vec3 {
        self.levels[self.levels.len() - 1].pixel(0, 0)
    }

    /// Size of the finest level.
    #[must_use]
    pub fn size(&self) -> [u32; 2] {
        self.levels[0].size()
    }

    /// Trilinear sample at pixel coordinates of the finest level; `lod` 0 is the finest level, each whole step one
    /// halving.
    #[must_use]
    pub fn sample(&self, at: Vec2, lod: f32) -> Vec3 {
        let lod = lod.clamp(0.0, (self.levels.len() - 1) as f32);
        let (low, part) = (lod.floor() as usize, lod.fract());
        let fine = self.sample_level(at, low);
        if part == 0.0 { fine } else { fine.lerp(self.sample_level(at, low + 1), part) }
    }

    fn sample_level(&self, at: Vec2, level: usize) -> Vec3 {
        if level == 0 {
            return self.levels[0].bilinear(at);
        }
        // A level halves pixels in pairs from the top left, so its scale is exact even where a size was odd.
        self.levels[level].bilinear(at * 0.5_f32.powi(level as i32))
    }
}

fn clear_border(image: &mut Image) {
    let [w, h] = image.size();
    if w <= 2 && h <= 2 {
        return;
    }
    let (w, h, n) = (w as usize, h as usize, image.components());
    for y in 0..h {
        for x in 0..w {
            if x == 0 || y == 0 || x == w - 1 || y == h - 1 {
                let i = (y * w + x) * n;
                image.data_mut()[i..i + n].fill(0.0);
            }
        }
    }
}

fn halve(image: &Image) -> Image {
    let [w, h] = image.size();
    let (w2, h2, n) = (w.div_ceil(2), h.div_ceil(2), image.components());
    let mut data = Vec::with_capacity(w2 as usize * h2 as usize * n);
    for y in 0..i64::from(h2) {
        for x in 0..i64::from(w2) {
            let at = |dx, dy| image.pixel(2 * x + dx, 2 * y + dy);
            let mean = (at(0, 0) + at(1, 0) + at(0, 1) + at(1, 1)) * 0.25;
            data.extend_from_slice(&mean.to_array()[..n]);
        }
    }
    Image { width: w2, height: h2, components: n, data }
}
