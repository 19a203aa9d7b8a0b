//! Slow changes across an exemplar: what is wider than about a quarter of it.
//!
//! Based on: local linear regression (Cleveland, "Robust Locally Weighted Regression and Smoothing Scatterplots", JASA 1979),
//! without the robust steps: a plain blur would flatten towards the edges, where a light from one side is strongest.
//!
//! 1. The exemplar on a level of a few dozen pixels a side, weighed by opacity.
//! 2. At each pixel the plane that fits best under a Gaussian window; its height there is the slow part. Of an exemplar that tiles
//!    the window goes on at the other side.

use super::stack::tiles;
use super::{Channel, Exemplar, Image, MipChain, Wrap};
use glam::{DMat3, DVec3, Vec2, Vec3};
use rayon::prelude::*;

/// Longest side of the level that is looked at: several pixels to a standard deviation of the window.
const SIDE: u32 = 48;
/// Standard deviation of the window, as a share of each side: waves of half a side lose a twentieth of what waves of two sides lose.
const WINDOW: f64 = 0.2;
/// A window ends after so many standard deviations.
const END: f64 = 3.0;
/// How much a plane is held level, as a share of the window's weight: decides where the window holds too few pixels for one.
const LEVEL: f64 = 1e-6;

/// Share of clipped pixels from which on it is worth telling.
pub(super) const CLIPPED: f32 = 0.005;

/// The level of an image of an exemplar whose slow changes are looked for.
pub(super) struct Slow<'a> {
    small: &'a Image,
    opacity: Option<&'a Image>,
    /// The image at its full size.
    full: [u32; 2],
    wrap: Wrap,
}

/// An image of slow changes, to be asked at the pixels of the full one.
pub(super) struct Stretched {
    image: Image,
    scale: Vec2,
    wrap: Wrap,
}

impl<'a> Slow<'a> {
    /// Of one of the exemplar's channels.
    pub(super) fn new(exemplar: &'a Exemplar, channel: &'a MipChain) -> Self {
        let level = channel.levels().iter().position(|image| image.size().into_iter().max() <= Some(SIDE)).unwrap_or(0);
        Self {
            small: &channel.levels()[level],
            opacity: exemplar.channel(Channel::Opacity).map(|o| &o.levels()[level]),
            full: channel.size(),
            wrap: if tiles(exemplar) { Wrap::Repeat } else { exemplar.wrap },
        }
    }

    /// How much a pixel of the level counts.
    pub(super) fn opacity(&self, pixel: usize) -> f32 {
        self.opacity.map_or(1.0, |o| o.data()[pixel])
    }

    /// The slow part of what `value` makes of each pixel's components, one number a pixel of the level.
    pub(super) fn changes(&self, value: impl Fn(&[f32]) -> f32 + Sync) -> Vec<f32> {
        let [w, h] = self.small.size().map(|s| s as usize);
        let kernels = [w, h].map(Kernel::new);
        let n = self.small.components();
        let value = |i: usize| f64::from(value(&self.small.data()[n * i..n * (i + 1)]));
        // Along rows: sums of 1, x, x x, v, x v under the window.
        let rows: Vec<[f64; 5]> = (0..w * h)
            .into_par_iter()
            .map(|i| {
                let mut sums = [0.0; 5];
                kernels[0].each(i % w, w, self.wrap, |x, d, k| {
                    let j = i - i % w + x;
                    let k = k * f64::from(self.opacity(j));
                    let v = value(j);
                    sums = [sums[0] + k, sums[1] + k * d, sums[2] + k * d * d, sums[3] + k * v, sums[4] + k * d * v];
                });
                sums
            })
            .collect();
        (0..w * h)
            .into_par_iter()
            .map(|i| {
                let (mut moments, mut right) = (DMat3::ZERO, DVec3::ZERO);
                kernels[1].each(i / w, h, self.wrap, |y, d, k| {
                    let [one, x, xx, v, xv] = rows[y * w + i % w].map(|s| s * k);
                    moments += DMat3::from_cols_array(&[one, x, one * d, x, xx, x * d, one * d, x * d, one * d * d]);
                    right += DVec3::new(v, xv, v * d);
                });
                let whole = moments.x_axis.x;
                if !(whole > 0.0) {
                    return 0.0;
                }
                moments.y_axis.y += LEVEL * whole;
                moments.z_axis.z += LEVEL * whole;
                (moments.inverse() * right).x as f32
            })
            .collect()
    }

    /// Numbers of the level's pixels as an image over the full one; `None` if they are not as many.
    pub(super) fn image(&self, components: usize, data: Vec<f32>) -> Option<Stretched> {
        let [w, h] = self.small.size();
        let size = |s: [u32; 2]| Vec2::from(s.map(|s| s as f32));
        Some(Stretched { image: Image::new(w, h, components, data)?, scale: size([w, h]) / size(self.full), wrap: self.wrap })
    }
}

impl Stretched {
    /// Its value at a pixel of the full image, bilinear; beyond the edges of an exemplar that tiles lies its other side.
    pub(super) fn at(&self, pixel: [usize; 2]) -> Vec3 {
        let at = (Vec2::from(pixel.map(|p| p as f32)) + 0.5) * self.scale;
        if self.wrap == Wrap::Clamp {
            return self.image.bilinear(at);
        }
        let size = self.image.size().map(i64::from);
        let low = (at - 0.5).floor();
        let t = at - 0.5 - low;
        let value =
            |x: i64, y: i64| self.image.pixel((low.x as i64 + x).rem_euclid(size[0]), (low.y as i64 + y).rem_euclid(size[1]));
        let [top, bottom] = [0, 1].map(|y| value(0, y) + t.x * (value(1, y) - value(0, y)));
        top + t.y * (bottom - top)
    }
}

/// A Gaussian window along one side.
struct Kernel(Vec<f64>);

impl Kernel {
    fn new(side: usize) -> Self {
        let sigma = WINDOW * side as f64;
        Self((0..=(END * sigma).ceil() as usize).map(|d| (-0.5 * (d as f64 / sigma).powi(2)).exp()).collect())
    }

    /// Names the places within the window around one, how far they lie from it, and their weight.
    fn each(&self, at: usize, side: usize, wrap: Wrap, mut place: impl FnMut(usize, f64, f64)) {
        let reach = self.0.len() as i64 - 1;
        for d in -reach..=reach {
            let x = at as i64 + d;
            let x = match wrap {
                Wrap::Repeat => x.rem_euclid(side as i64),
                Wrap::Clamp if (0..side as i64).contains(&x) => x,
                Wrap::Clamp => continue,
            };
            place(x as usize, d as f64, self.0[d.unsigned_abs() as usize]);
        }
    }
}
