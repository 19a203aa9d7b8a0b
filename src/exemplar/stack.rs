//! All channels of an exemplar side by side, as numbers that can be matched, and their Gaussian pyramid.
//!
//! Colours are encoded as sRGB, in which equal steps look about equal; every channel is weighted by how much it shows.
//! The pyramid is made with the kernel 1 3 3 1, so that a pixel of a level lies in the middle of the four it came from.

use super::{Channel, ChannelSet, Exemplar, Image, Wrap, srgb};
use glam::{Vec2, Vec3};
use std::borrow::Cow;

/// How much a step of a channel's numbers counts against the same step of encoded colour. A normal's components run from -1 to
/// 1, and what it shows colour and height mostly show too.
const fn weight(channel: Channel) -> f32 {
    match channel {
        Channel::BaseColor | Channel::Height | Channel::Opacity => 1.0,
        Channel::Normal | Channel::Roughness | Channel::Metallic | Channel::Emissive => 0.5,
        Channel::Occlusion => 0.25,
    }
}

/// Numbers at each pixel.
#[derive(Debug, Clone, PartialEq)]
pub struct Stack {
    /// Width and height.
    pub size: [usize; 2],
    /// Numbers a pixel.
    pub components: usize,
    /// What lies beyond the edge.
    pub wrap: Wrap,
    /// Rows of pixels from the top.
    pub data: Vec<f32>,
}

/// The numbers to match of one pixel's channel, appended.
pub fn matched(channel: Channel, value: [f32; 3], out: &mut Vec<f32>) {
    let weight = weight(channel);
    let encoded = matches!(channel, Channel::BaseColor | Channel::Emissive);
    out.extend(value.iter().take(channel.components()).map(|&v| weight * if encoded { srgb::encode(v) } else { v }));
}

impl Stack {
    /// The stack of an exemplar's channels; of all of them, or of those in a set.
    #[must_use]
    pub fn new(exemplar: &Exemplar, channels: Option<ChannelSet>) -> Self {
        let [w, h] = exemplar.size().map(|s| s as usize);
        let chosen = |c: &Channel| channels.is_none_or(|set| set.has(*c));
        let images: Vec<_> = exemplar.channels().iter().filter(chosen).filter_map(|c| Some((c, exemplar.channel(c)?))).collect();
        let mut data = Vec::new();
        for y in 0..h as i64 {
            for x in 0..w as i64 {
                images.iter().for_each(|(c, image)| matched(*c, image.finest().pixel(x, y).to_array(), &mut data));
            }
        }
        Self { size: [w, h], components: data.len() / (w * h), wrap: exemplar.wrap, data }
    }

    /// A pixel; what lies beyond the edge is as the stack's wrap says.
    #[inline]
    #[must_use]
    pub fn pixel(&self, x: i64, y: i64) -> &[f32] {
        let [w, h] = self.size.map(|s| s as i64);
        let (x, y) = match self.wrap {
            Wrap::Clamp => (x.clamp(0, w - 1), y.clamp(0, h - 1)),
            Wrap::Repeat => (x.rem_euclid(w), y.rem_euclid(h)),
        };
        &self.data[(y * w + x) as usize * self.components..][..self.components]
    }

    /// Adds a bilinear sample to `out`; the middle of the first pixel is (0.5, 0.5).
    #[inline]
    pub fn sample(&self, at: [f32; 2], out: &mut [f32]) {
        let p = at.map(|a| a - 0.5);
        let low = p.map(f32::floor);
        let ([u, v], [x, y]) = ([p[0] - low[0], p[1] - low[1]], low.map(|l| l as i64));
        for (dx, dy, share) in [(0, 0, (1.0 - u) * (1.0 - v)), (1, 0, u * (1.0 - v)), (0, 1, (1.0 - u) * v), (1, 1, u * v)] {
            if share > 0.0 {
                out.iter_mut().zip(self.pixel(x + dx, y + dy)).for_each(|(o, &c)| *o += share * c);
            }
        }
    }

    /// The mean of all pixels.
    #[must_use]
    pub fn mean(&self) -> Vec<f32> {
        let mut sums = vec![0.0_f64; self.components];
        self.data.chunks_exact(self.components.max(1)).for_each(|p| sums.iter_mut().zip(p).for_each(|(s, &x)| *s += f64::from(x)));
        sums.iter().map(|s| (s / (self.size[0] * self.size[1]) as f64) as f32).collect()
    }

    /// Every pixel the mean of its neighbourhood with weights `kernel` along each axis, the middle one at `kernel.len() / 2`;
    /// pixels are taken `step` apart, and the first lies at pixel 0.
    fn filtered(&self, kernel: &[f32], first: i64, step: usize) -> Self {
        let along = |from: &Self, axis: usize| {
            let mut size = from.size;
            size[axis] = size[axis].div_ceil(step);
            let mut data = vec![0.0; size[0] * size[1] * from.components];
            for (i, out) in data.chunks_exact_mut(from.components).enumerate() {
                let mut at = [(i % size[0]) as i64, (i / size[0]) as i64];
                let start = at[axis] * step as i64 + first;
                for (k, &w) in kernel.iter().enumerate() {
                    at[axis] = start + k as i64;
                    out.iter_mut().zip(from.pixel(at[0], at[1])).for_each(|(o, &c)| *o += w * c);
                }
            }
            Self { size, components: from.components, wrap: from.wrap, data }
        };
        along(&along(self, 0), 1)
    }

    /// The Gaussian pyramid: `levels` levels, the finest first; fewer if a level of one pixel is reached.
    #[must_use]
    pub fn pyramid(&self, levels: usize) -> Vec<Self> {
        let mut out = vec![self.clone()];
        while let Some(last) = out.last().filter(|l| out.len() < levels && l.size != [1, 1]) {
            let next = last.filtered(&[0.125, 0.375, 0.375, 0.125], -1, 2);
            out.push(next);
        }
        out
    }

    /// Blurred by a Gaussian of so many pixels, cut off at `reach` times that.
    pub(super) fn blurred(&self, width: f32, reach: f32) -> Self {
        let radius = (width * reach).ceil().max(1.0) as i64;
        let weight = |i: i64| (-0.5 * (i as f32 / width).powi(2)).exp();
        let sum: f32 = (-radius..=radius).map(weight).sum();
        let kernel: Vec<f32> = (-radius..=radius).map(|i| weight(i) / sum).collect();
        self.filtered(&kernel, -radius, 1)
    }

    /// As soft as bilinear samples between pixels are on average: 1/8, 3/4, 1/8 along each axis.
    #[must_use]
    pub fn softened(&self) -> Self {
        self.filtered(&[0.125, 0.75, 0.125], -1, 1)
    }
}

/// Neighbouring columns and rows differ this many times less than the opposite edges of an exemplar that does not tile.
const SEAM: f32 = 1.6;

/// True if an exemplar goes on over its own edges: opposite edges differ hardly more than neighbouring rows and columns do.
#[must_use]
pub fn tiles(exemplar: &Exemplar) -> bool {
    let stack = Stack::new(exemplar, None);
    let [w, h] = stack.size.map(|s| s as i64);
    if w < 8 || h < 8 {
        return false;
    }
    let apart = |a: &[f32], b: &[f32]| a.iter().zip(b).map(|(a, b)| (a - b).abs()).sum::<f32>();
    let column = |a: i64, b: i64| (0..h).map(|y| apart(stack.pixel(a, y), stack.pixel(b, y))).sum::<f32>();
    let row = |a: i64, b: i64| (0..w).map(|x| apart(stack.pixel(x, a), stack.pixel(x, b))).sum::<f32>();
    let usual = |n: i64, of: &dyn Fn(i64, i64) -> f32| (0..n - 1).map(|i| of(i, i + 1)).sum::<f32>() / (n - 1) as f32;
    column(w - 1, 0) <= SEAM * usual(w, &column) && row(h - 1, 0) <= SEAM * usual(h, &row)
}

/// An exemplar in another size, averaged or interpolated; its own if the size is the same.
#[must_use]
pub fn resized(exemplar: &Exemplar, size: [u32; 2]) -> Cow<'_, Exemplar> {
    if exemplar.size() == size || size.contains(&0) {
        return Cow::Borrowed(exemplar);
    }
    let of = |channel: Channel| exemplar.channel(channel).map(|chain| resampled(chain.finest(), size));
    let base = of(Channel::BaseColor).unwrap_or_else(|| Image::from_fn(size[0], size[1], |_, _| Vec3::ZERO));
    let mut out = Exemplar::new(exemplar.name.clone(), base);
    out.wrap = exemplar.wrap;
    for channel in exemplar.channels().iter().filter(|&c| c != Channel::BaseColor) {
        // Size and components are those of the channel itself.
        let _fits = of(channel).map(|image| out.set(channel, image));
    }
    if let Some(frames) = exemplar.frames() {
        let others = frames.others().iter().map(|other| resized(other, size).into_owned()).collect();
        // They fitted before, and all are of one size again.
        let _fits = out.set_frames(frames.by(), others, frames.seconds().to_vec());
    }
    Cow::Owned(out)
}

/// The mean over each new pixel of bilinear samples at most a pixel apart.
fn resampled(image: &Image, size: [u32; 2]) -> Image {
    let step = Vec2::new(image.size()[0] as f32 / size[0] as f32, image.size()[1] as f32 / size[1] as f32);
    let [across, down] = step.to_array().map(|s| s.ceil().max(1.0) as u32);
    let value = |x: u32, y: u32| {
        let mut sum = Vec3::ZERO;
        for v in 0..down {
            for u in 0..across {
                let part = Vec2::new((u as f32 + 0.5) / across as f32, (v as f32 + 0.5) / down as f32);
                sum += image.bilinear((Vec2::new(x as f32, y as f32) + part) * step);
            }
        }
        sum / (across * down) as f32
    };
    if image.components() == 3 {
        Image::from_fn(size[0], size[1], value)
    } else {
        Image::grey_from_fn(size[0], size[1], |x, y| value(x, y).x)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn exemplar(side: u32, of: impl Fn(f32, f32) -> f32) -> Exemplar {
        Exemplar::new("test", Image::from_fn(side, side, |x, y| Vec3::splat(srgb::decode(of(x as f32, y as f32)))))
    }

    #[test]
    fn levels_keep_a_ramp_and_the_mean() {
        let ramp = Stack::new(&exemplar(32, |x, y| (x + 2.0 * y) / 100.0), None);
        for (k, level) in ramp.pyramid(4).iter().enumerate() {
            let [w, h] = level.size;
            assert_eq!((w, h), (32 >> k, 32 >> k), "level {k}");
            let scale = (1 << k) as f32;
            for (x, y) in [(w / 2, h / 2), (w / 2 - 1, h / 2)] {
                // The middle of a coarse pixel, in pixels of the finest level.
                let [fx, fy] = [x, y].map(|i| (i as f32 + 0.5) * scale - 0.5);
                let (is, was) = (level.pixel(x as i64, y as i64)[0], (fx + 2.0 * fy) / 100.0);
                assert!((is - was).abs() < 1e-5, "level {k} at {x}, {y}: {is} for {was}");
            }
        }
        let tiled = Stack { wrap: Wrap::Repeat, ..ramp };
        for level in tiled.pyramid(6) {
            assert!((level.mean()[0] - tiled.mean()[0]).abs() < 1e-5, "periodic filters keep the mean");
        }
    }

    #[test]
    fn waves_that_close_tile_and_others_do_not() {
        let wave = |x: f32, period: f32| 0.5 + 0.5 * (x * std::f32::consts::TAU / period).sin();
        assert!(tiles(&exemplar(48, |x, y| wave(x, 16.0) * wave(y, 24.0))), "48 is a multiple of both periods");
        assert!(!tiles(&exemplar(48, |x, y| wave(x, 36.0) * wave(y, 24.0))), "a period and a third");
        assert!(!tiles(&exemplar(4, |_, _| 0.5)), "four pixels tell nothing");
    }
}
