//! Extends the opaque parts of an exemplar into its transparent ones, so that no filter ever mixes in background.
//!
//! Based on: the push-pull algorithm of Gortler et al., "The Lumigraph" (1996), section 3.4.
//!
//! 1. Push: halve the image again and again, each pixel the mean of the four below, weighted by their opacity; the weights
//!    add up and saturate at 1.
//! 2. Pull: from the coarsest level on, fill up what weight is missing in each pixel with the level above, smoothed
//!    bilinearly.
//!
//! Opaque pixels keep their values exactly. All channels but opacity itself are extended; normals are brought back to unit
//! length. Linear in the pixels.

use super::{Channel, Exemplar, ExemplarError, Image, MipChain};
use glam::{Vec2, Vec3};

/// Opacity from which a pixel is its own colour entirely.
const SOLID: f32 = 254.0 / 255.0;

/// Fills the transparent parts of all channels from the opaque ones; does nothing if the exemplar has no opacity or no
/// opaque part.
///
/// # Errors
/// None beyond those of [`Exemplar::set`], which its own channels do not meet.
pub fn extend_exemplar(exemplar: &mut Exemplar) -> Result<(), ExemplarError> {
    let Some(opacity) = exemplar.channel(Channel::Opacity).map(|chain| chain.finest().clone()) else { return Ok(()) };
    if opacity.data().iter().all(|&o| o >= SOLID) || opacity.data().iter().all(|&o| o <= 0.0) {
        return Ok(());
    }
    for channel in exemplar.channels().iter().filter(|&c| c != Channel::Opacity) {
        let Some(image) = exemplar.channel(channel).map(MipChain::finest) else { continue };
        let mut extended = extend(image, &opacity);
        if channel == Channel::Normal {
            for (normal, _) in extended.data_mut().chunks_exact_mut(3).zip(opacity.data()).filter(|&(_, &o)| o < SOLID) {
                let unit = Vec3::from_slice(normal).try_normalize().unwrap_or(Vec3::Z);
                normal.copy_from_slice(&unit.to_array());
            }
        }
        exemplar.set(channel, extended)?;
    }
    Ok(())
}

/// One image extended into the parts where `opacity`, of the same size, is below 1.
#[must_use]
pub fn extend(image: &Image, opacity: &Image) -> Image {
    let [w, h] = image.size();
    let weight = |x, y| if opacity.grey(x, y) >= SOLID { 1.0 } else { opacity.grey(x, y).max(0.0) };
    let mut levels = vec![Level {
        width: i64::from(w),
        height: i64::from(h),
        pixels: pixels(w, h).map(|(x, y)| (image.pixel(x, y), weight(x, y))).collect(),
    }];
    while let Some(coarser) = levels.last().and_then(Level::push) {
        levels.push(coarser);
    }
    while let Some(coarser) = levels.pop() {
        let Some(finer) = levels.last_mut() else {
            return finest(coarser, image.components());
        };
        finer.pull(&coarser);
    }
    image.clone()
}

fn pixels(w: u32, h: u32) -> impl Iterator<Item = (i64, i64)> {
    (0..i64::from(h)).flat_map(move |y| (0..i64::from(w)).map(move |x| (x, y)))
}

fn finest(level: Level, components: usize) -> Image {
    let [w, h] = [level.width as u32, level.height as u32];
    let at = |x: u32, y: u32| level.pixels[y as usize * w as usize + x as usize].0;
    if components == 3 { Image::from_fn(w, h, at) } else { Image::grey_from_fn(w, h, |x, y| at(x, y).x) }
}

/// Values and their weights, 0 to 1.
struct Level {
    width: i64,
    height: i64,
    pixels: Vec<(Vec3, f32)>,
}

impl Level {
    fn at(&self, x: i64, y: i64) -> (Vec3, f32) {
        let (x, y) = (x.clamp(0, self.width - 1), y.clamp(0, self.height - 1));
        self.pixels[(y * self.width + x) as usize]
    }

    /// The next coarser level; none below one pixel.
    fn push(&self) -> Option<Self> {
        if self.width == 1 && self.height == 1 {
            return None;
        }
        let (width, height) = ((self.width + 1) / 2, (self.height + 1) / 2);
        let mean = |(x, y): (i64, i64)| {
            let (mut value, mut weight) = (Vec3::ZERO, 0.0);
            // A last odd row or column has no second pixel to take part.
            for (x, y) in [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(dx, dy)| (2 * x + dx, 2 * y + dy)) {
                if x < self.width && y < self.height {
                    let (v, w) = self.at(x, y);
                    value += v * w;
                    weight += w;
                }
            }
            if weight > 0.0 { (value / weight, weight.min(1.0)) } else { (Vec3::ZERO, 0.0) }
        };
        Some(Self { width, height, pixels: pixels(width as u32, height as u32).map(mean).collect() })
    }

    /// Completes weights below 1 from the filled coarser level.
    fn pull(&mut self, coarser: &Self) {
        for y in 0..self.height {
            for x in 0..self.width {
                let pixel = &mut self.pixels[(y * self.width + x) as usize];
                if pixel.1 < 1.0 {
                    let (fill, weight) = coarser.bilinear((Vec2::new(x as f32, y as f32) + 0.5) * 0.5);
                    let rest = (1.0 - pixel.1) * weight;
                    let sum = pixel.1 + rest;
                    if sum > 0.0 {
                        *pixel = ((pixel.0 * pixel.1 + fill * rest) / sum, sum.min(1.0));
                    }
                }
            }
        }
    }

    /// Weighted bilinear mean around continuous pixel coordinates, and its weight.
    fn bilinear(&self, at: Vec2) -> (Vec3, f32) {
        let p = at - 0.5;
        let base = p.floor();
        let f = p - base;
        let (x, y) = (base.x as i64, base.y as i64);
        let corners = [(0, 0, 1.0 - f.x, 1.0 - f.y), (1, 0, f.x, 1.0 - f.y), (0, 1, 1.0 - f.x, f.y), (1, 1, f.x, f.y)];
        let (mut value, mut weight) = (Vec3::ZERO, 0.0);
        for (dx, dy, wx, wy) in corners {
            let (v, w) = self.at(x + dx, y + dy);
            value += v * (w * wx * wy);
            weight += w * wx * wy;
        }
        if weight > 0.0 { (value / weight, weight) } else { (Vec3::ZERO, 0.0) }
    }
}
