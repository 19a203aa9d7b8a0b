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
    exemplar.change_others(extend_exemplar)?;
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

#[cfg(test)]
mod tests {
    use super::{extend, extend_exemplar};
    use crate::exemplar::{Channel, Exemplar, Image};
    use crate::random::Random;
    use glam::{Vec2, Vec3};

    fn disc(w: u32, h: u32) -> Image {
        Image::grey_from_fn(w, h, |x, y| {
            let d = Vec2::new(x as f32, y as f32).distance(Vec2::new(w as f32, h as f32) * 0.4);
            (w.min(h) as f32 * 0.3 - d).clamp(0.0, 1.0)
        })
    }

    #[test]
    fn opaque_pixels_stay_and_all_others_come_from_them() {
        let mut random = Random::new(3, 3);
        for (w, h) in [(64, 64), (33, 70), (101, 7)] {
            let opacity = disc(w, h);
            // Blue is background only: it must vanish where nothing is opaque.
            let image = Image::from_fn(w, h, |x, y| {
                let solid = opacity.grey(x.into(), y.into()) > 0.0;
                if solid { Vec3::new(random.unit() as f32 * 0.5 + 0.5, 0.25, 0.0) } else { Vec3::Z }
            });
            let extended = extend(&image, &opacity);
            for (i, &o) in opacity.data().iter().enumerate() {
                let (x, y) = (i as i64 % i64::from(w), i as i64 / i64::from(w));
                let (before, after) = (image.pixel(x, y), extended.pixel(x, y));
                assert!(o < 1.0 || before == after, "opaque pixel {x}, {y} changed from {before} to {after}");
                assert!(after.z.abs() < 1e-6 && (after.y - 0.25).abs() < 1e-5, "background at {x}, {y}: {after}");
                assert!((0.5 - 1e-5..=1.0 + 1e-5).contains(&after.x), "out of the opaque range at {x}, {y}: {after}");
            }
        }
    }

    #[test]
    fn all_channels_are_extended_and_normals_stay_unit() {
        let opacity = disc(48, 48);
        let solid = |x: u32, y: u32| opacity.grey(x.into(), y.into()) > 0.0;
        let base = Image::from_fn(48, 48, |x, y| if solid(x, y) { Vec3::X } else { Vec3::ZERO });
        let mut exemplar = Exemplar::new("leaf", base);
        let normal = |x: u32| Vec3::new((x as f32 * 0.7).sin(), 0.3, 0.8).normalize();
        let normals = Image::from_fn(48, 48, |x, y| if solid(x, y) { normal(x) } else { Vec3::ZERO });
        let heights = Image::grey_from_fn(48, 48, |x, y| if solid(x, y) { 0.5 } else { 0.0 });
        exemplar.set(Channel::Normal, normals).expect("fits");
        exemplar.set(Channel::Height, heights).expect("fits");
        exemplar.set(Channel::Opacity, opacity.clone()).expect("fits");
        extend_exemplar(&mut exemplar).expect("same sizes");
        let finest = |channel| exemplar.channel(channel).expect("it has it").finest();
        for y in 0..48 {
            for x in 0..48 {
                assert!((finest(Channel::BaseColor).pixel(x, y) - Vec3::X).length() < 1e-5, "constant colour at {x}, {y}");
                assert!((finest(Channel::Height).grey(x, y) - 0.5).abs() < 1e-5, "constant height at {x}, {y}");
                assert!((finest(Channel::Normal).pixel(x, y).length() - 1.0).abs() < 1e-5, "unit normal at {x}, {y}");
            }
        }
        assert_eq!(finest(Channel::Opacity), &opacity, "opacity itself stays");
    }

    #[test]
    fn nothing_opaque_leaves_the_image_alone() {
        let image = Image::from_fn(9, 5, |x, y| Vec3::new(x as f32, y as f32, 0.0));
        let clear = Image::grey_from_fn(9, 5, |_, _| 0.0);
        assert_eq!(extend(&image, &clear), image, "nothing to extend from");
    }
}
