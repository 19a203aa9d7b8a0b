//! Evening out: slow changes of light across an exemplar.
//!
//! A photograph is often lit from one side. Its pastes then differ in light where they meet, whatever their borders do, and the
//! changes come back with every paste. So the light is estimated and divided out; colours keep their hue, and whatever is
//! smaller than a quarter of the exemplar its contrast.
//!
//! 1. The light: slow changes ([`slow`](super::slow)) of luminance.
//! 2. Every pixel of the base colour times the mean light over its own.

use super::slow::{CLIPPED, Slow};
use super::{Channel, Exemplar};
use glam::Vec3;

/// Light is changed at most by this factor: what is darker is dark by itself.
const MOST: f32 = 4.0;
/// Luminance of linear colour (Rec. 709).
const LUMINANCE: Vec3 = Vec3::new(0.2126, 0.7152, 0.0722);

/// What [`equalize`] found and did.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Evened {
    /// How much the light varied: its standard deviation over its mean.
    pub varied: f32,
    /// Share of the pixels whose colour became too bright for the image and was clipped.
    pub clipped: f32,
}

impl Evened {
    /// What was done, to go on after the exemplar's name; and what it cost, if that is worth telling.
    #[must_use]
    pub fn told(&self) -> (String, Option<String>) {
        let cost = || format!("with its light evened out {:.0} % of it became too bright, and was clipped", 100.0 * self.clipped);
        let done = format!("its light varied by {:.0} %, and was evened out", 100.0 * self.varied);
        (done, (self.clipped > CLIPPED).then(cost))
    }
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
    let slow = Slow::new(exemplar, color);
    let light = slow.changes(|pixel| Vec3::from_slice(pixel).dot(LUMINANCE));
    let weight: f32 = (0..light.len()).map(|i| slow.opacity(i)).sum();
    let mean = light.iter().enumerate().map(|(i, l)| l * slow.opacity(i)).sum::<f32>() / weight;
    if !(mean > 0.0) {
        return none;
    }
    let deviation = light.iter().enumerate().map(|(i, l)| slow.opacity(i) * (l - mean) * (l - mean)).sum::<f32>() / weight;
    let gain = light.iter().map(|l| (mean / l.max(mean / MOST)).max(1.0 / MOST)).collect();
    let Some(gain) = slow.image(1, gain) else { return none };

    let mut image = color.finest().clone();
    let width = image.size()[0] as usize;
    let mut clipped = 0_usize;
    let count = image.data().len() / 3;
    for (i, pixel) in image.data_mut().chunks_exact_mut(3).enumerate() {
        let before = Vec3::from_slice(pixel);
        let after = before * gain.at([i % width, i / width]).x;
        clipped += usize::from(after.max_element() > before.max_element().max(1.0));
        after.min(before.max(Vec3::ONE)).write_to_slice(pixel);
    }
    // It has the size it had.
    let _ = exemplar.set(Channel::BaseColor, image);
    Evened { varied: deviation.sqrt() / mean, clipped: clipped as f32 / count as f32 }
}

#[cfg(test)]
mod tests {
    use super::super::{Image, MipChain, Wrap};
    use super::*;
    use crate::random::Random;
    use glam::Vec2;

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
