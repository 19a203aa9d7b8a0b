//! Evening out: slow changes of light across an exemplar.
//!
//! A photograph is often lit from one side. Its pastes then differ in light where they meet, whatever their borders do, and the
//! changes come back with every paste. So the light is estimated and divided out; colours keep their hue, and whatever is
//! smaller than a quarter of the exemplar its contrast.
//!
//! Based on: local linear regression (Cleveland, "Robust Locally Weighted Regression and Smoothing Scatterplots", JASA 1979),
//! without the robust steps: a plain blur would flatten towards the edges, where a light from one side is strongest.
//!
//! 1. Luminance on a level of a few dozen pixels a side, weighed by opacity.
//! 2. At each pixel the plane that fits best under a Gaussian window; its height there is the light. Of an exemplar that tiles the
//!    window goes on at the other side.
//! 3. Every pixel of the base colour times the mean light over its own.

use super::stack::tiles;
use super::{Channel, Exemplar, Image, Wrap};
use glam::{DMat3, DVec3, Vec2, Vec3};
use rayon::prelude::*;

/// Longest side of the level on which light is estimated: several pixels to a standard deviation of the window.
const SIDE: u32 = 48;
/// Standard deviation of the window, as a share of each side: waves of half a side lose a twentieth of what waves of two sides lose.
const WINDOW: f64 = 0.2;
/// A window ends after so many standard deviations.
const END: f64 = 3.0;
/// Light is changed at most by this factor: what is darker is dark by itself.
const MOST: f32 = 4.0;
/// Luminance of linear colour (Rec. 709).
const LUMINANCE: Vec3 = Vec3::new(0.2126, 0.7152, 0.0722);
/// How much a plane is held level, as a share of the window's weight: decides where the window holds too few pixels for one.
const LEVEL: f64 = 1e-6;

/// What [`equalize`] found and did.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Evened {
    /// How much the light varied: its standard deviation over its mean.
    pub varied: f32,
    /// Share of the pixels whose colour became too bright for the image and was clipped.
    pub clipped: f32,
}

/// Takes slow changes of light out of an exemplar's base colour, of each frame by itself. Its other channels stay as they are, and what
/// is told is of the first frame.
pub fn equalize(exemplar: &mut Exemplar) -> Evened {
    let Ok(()) = exemplar.change_others(|other| {
        equalize(other);
        Ok::<(), std::convert::Infallible>(())
    });
    let none = Evened { varied: 0.0, clipped: 0.0 };
    let Some(color) = exemplar.channel(Channel::BaseColor) else { return none };
    let level = color.levels().iter().position(|image| image.size().into_iter().max() <= Some(SIDE)).unwrap_or(0);
    let small = &color.levels()[level];
    let opacity = exemplar.channel(Channel::Opacity).map(|o| &o.levels()[level]);
    let wrap = if tiles(exemplar) { Wrap::Repeat } else { exemplar.wrap };
    let light = light(small, opacity, wrap);
    let opaque = |i: usize| opacity.map_or(1.0, |o| o.data()[i]);
    let weight: f32 = (0..light.len()).map(opaque).sum();
    let mean = light.iter().enumerate().map(|(i, l)| l * opaque(i)).sum::<f32>() / weight;
    if !(mean > 0.0) {
        return none;
    }
    let deviation = light.iter().enumerate().map(|(i, l)| opaque(i) * (l - mean) * (l - mean)).sum::<f32>() / weight;
    let gain = light.iter().map(|l| (mean / l.max(mean / MOST)).max(1.0 / MOST)).collect();
    let [w, h] = small.size();
    let Some(gain) = Image::new(w, h, 1, gain) else { return none };

    let mut image = color.finest().clone();
    let width = image.size()[0] as usize;
    let scale = Vec2::new(w as f32, h as f32) / Vec2::from(image.size().map(|s| s as f32));
    let at = |i: usize| wrapped(&gain, (Vec2::new((i % width) as f32, (i / width) as f32) + 0.5) * scale, wrap);
    let mut clipped = 0_usize;
    let count = image.data().len() / 3;
    for (i, pixel) in image.data_mut().chunks_exact_mut(3).enumerate() {
        let before = Vec3::from_slice(pixel);
        let after = before * at(i);
        clipped += usize::from(after.max_element() > before.max_element().max(1.0));
        after.min(before.max(Vec3::ONE)).write_to_slice(pixel);
    }
    // It has the size it had.
    let _ = exemplar.set(Channel::BaseColor, image);
    Evened { varied: deviation.sqrt() / mean, clipped: clipped as f32 / count as f32 }
}

/// A bilinear sample; beyond the edges of an exemplar that tiles lies its other side.
fn wrapped(image: &Image, at: Vec2, wrap: Wrap) -> f32 {
    if wrap == Wrap::Clamp {
        return image.bilinear(at).x;
    }
    let size = image.size().map(i64::from);
    let low = (at - 0.5).floor();
    let t = at - 0.5 - low;
    let grey = |x: i64, y: i64| image.grey((low.x as i64 + x).rem_euclid(size[0]), (low.y as i64 + y).rem_euclid(size[1]));
    let [top, bottom] = [0, 1].map(|y| grey(0, y) + t.x * (grey(1, y) - grey(0, y)));
    top + t.y * (bottom - top)
}

/// The light at each pixel.
fn light(image: &Image, opacity: Option<&Image>, wrap: Wrap) -> Vec<f32> {
    let [w, h] = image.size().map(|s| s as usize);
    let kernels = [w, h].map(Kernel::new);
    let value = |i: usize| f64::from(Vec3::from_slice(&image.data()[3 * i..3 * i + 3]).dot(LUMINANCE));
    let weight = |i: usize| opacity.map_or(1.0, |o| f64::from(o.data()[i]));
    // Along rows: sums of 1, x, x x, v, x v under the window.
    let rows: Vec<[f64; 5]> = (0..w * h)
        .into_par_iter()
        .map(|i| {
            let mut sums = [0.0; 5];
            kernels[0].each(i % w, w, wrap, |x, d, k| {
                let j = i - i % w + x;
                let k = k * weight(j);
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
            kernels[1].each(i / w, h, wrap, |y, d, k| {
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

#[cfg(test)]
mod tests {
    use super::super::MipChain;
    use super::*;
    use crate::random::Random;

    /// Noise under a light.
    fn lit(size: [u32; 2], light: impl Fn(Vec2) -> f32) -> (Exemplar, Image) {
        let mut random = Random::new(5, 0);
        let even = Image::from_fn(size[0], size[1], |_, _| Vec3::new(0.5, 0.3, 0.2) * random.range(0.6, 1.0) as f32);
        let place = |x: u32, y: u32| (Vec2::new(x as f32, y as f32) + 0.5) / Vec2::from(size.map(|s| s as f32));
        let image = Image::from_fn(size[0], size[1], |x, y| even.pixel(i64::from(x), i64::from(y)) * light(place(x, y)));
        (Exemplar::new("lit", image), even)
    }

    fn color(exemplar: &Exemplar) -> &Image {
        exemplar.channel(Channel::BaseColor).map(MipChain::finest).unwrap_or_else(|| panic!("exemplars have a colour"))
    }

    /// Largest difference of two images but for one factor, as a share of their mean.
    fn difference(a: &Image, b: &Image) -> f32 {
        let sum = |i: &Image| i.data().iter().sum::<f32>();
        let factor = sum(b) / sum(a);
        let most = a.data().iter().zip(b.data()).map(|(a, b)| (a * factor - b).abs()).fold(0.0, f32::max);
        most * b.data().len() as f32 / sum(b)
    }

    #[test]
    fn a_light_from_one_side_is_taken_out_up_to_the_edges() {
        let (mut exemplar, even) = lit([200, 150], |p| 0.6 + 0.5 * p.x + 0.2 * p.y);
        let before = difference(color(&exemplar), &even);
        let evened = equalize(&mut exemplar);
        let after = difference(color(&exemplar), &even);
        assert!(before > 0.4 && after < 0.08, "{before}, then {after}");
        assert!((evened.varied - 0.16).abs() < 0.03, "it varied by {}", evened.varied);
        let again = equalize(&mut exemplar);
        assert!(again.varied < 0.01, "and then by {}", again.varied);
    }

    #[test]
    fn what_is_smaller_than_a_quarter_keeps_its_contrast() {
        let (mut exemplar, _) = lit([160, 160], |p| 1.0 + 0.3 * (p.x * 8.0 * std::f32::consts::TAU).sin());
        let before = color(&exemplar).clone();
        equalize(&mut exemplar);
        assert!(difference(color(&exemplar), &before) < 0.05, "{}", difference(color(&exemplar), &before));
    }

    #[test]
    fn an_exemplar_that_tiles_still_does() {
        let (mut exemplar, even) = lit([128, 128], |p| 1.0 + 0.3 * (p.x * std::f32::consts::TAU).sin());
        exemplar.wrap = Wrap::Repeat;
        equalize(&mut exemplar);
        let gain = |x: i64, y: i64| color(&exemplar).grey(x, y) / even.grey(x, y);
        let step = |a: i64, b: i64| (0..128).map(|y| (gain(a, y) / gain(b, y) - 1.0).abs()).fold(0.0, f32::max);
        assert!(step(0, 127) < 0.02, "light steps by {} over the edge, by {} beside it", step(0, 127), step(1, 0));
        let range = (0..128).map(|x| gain(x, 64)).fold([f32::INFINITY, 0.0_f32], |[a, b], g| [a.min(g), b.max(g)]);
        assert!(range[1] / range[0] < 1.45, "light varied by 1.86 to 1, now by {}", range[1] / range[0]);
    }

    #[test]
    fn black_and_single_pixels_come_through() {
        for image in [Image::from_fn(9, 5, |_, _| Vec3::ZERO), Image::from_fn(1, 1, |_, _| Vec3::splat(0.4))] {
            let mut exemplar = Exemplar::new("plain", image.clone());
            assert_eq!(equalize(&mut exemplar).clipped, 0.0);
            assert_eq!(color(&exemplar), &image);
        }
    }
}
