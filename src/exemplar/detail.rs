//! Detail alone: an exemplar without its slow changes of colour.
//!
//! What is wider than a patch cannot come from patches: each would bring its own, and change in colour where it ends. So the base
//! colour is split into what is slow and what is left; the detail is pasted, and lies over a smooth base of the surface's own.
//!
//! 1. The slow part ([`slow`](super::slow)) of each component.
//! 2. The detail: every pixel over its slow part, times [`DETAIL`].
//!
//! A base times detail over [`DETAIL`] is the colour that is seen; over the slow part it is the exemplar.

use super::slow::{CLIPPED, Slow};
use super::{Channel, Exemplar, Image};
use glam::Vec3;

/// Detail that leaves its base as it is. Four times as bright is the brightest that an image holds.
pub const DETAIL: f32 = 0.25;
/// Slow parts are at least this share of their largest component's mean: what is black has no detail of its own.
const LEAST: f32 = 1.0 / 64.0;

/// What was taken out of an exemplar.
#[derive(Debug, Clone, PartialEq)]
pub struct Slowly {
    /// The slow part of the base colour, as large as the exemplar, linear.
    pub slow: Image,
    /// Share of the pixels whose detail is too bright for an image and was clipped.
    pub clipped: f32,
}

impl Slowly {
    /// What it cost, to go on after the exemplar's name, if that is worth telling.
    #[must_use]
    pub fn told(&self) -> Option<String> {
        let clipped = 100.0 * self.clipped;
        let text = || format!("{clipped:.0} % of its detail is over four times as bright as what lies around it, and was clipped");
        (self.clipped > CLIPPED).then(text)
    }
}

/// Leaves an exemplar the detail of its base colour, of each frame by itself; returns the slow part of the first. Its other channels
/// stay as they are.
pub fn take_detail(exemplar: &mut Exemplar) -> Slowly {
    let Ok(()) = exemplar.change_others(|other| {
        take_detail(other);
        Ok::<(), std::convert::Infallible>(())
    });
    let [width, height] = exemplar.size();
    let Some(color) = exemplar.channel(Channel::BaseColor) else {
        return Slowly { slow: Image::from_fn(width, height, |_, _| Vec3::ONE), clipped: 0.0 };
    };
    let slow = Slow::new(exemplar, color);
    let parts = [0, 1, 2].map(|k| slow.changes(|pixel| pixel[k]));
    let least = LEAST * parts.iter().map(|part| part.iter().sum::<f32>() / part.len() as f32).fold(0.0, f32::max);
    let least = if least > 0.0 { least } else { 1.0 };
    let interleaved = (0..parts[0].len()).flat_map(|i| parts.each_ref().map(|part| part[i].max(least))).collect();
    let stretched = slow.image(3, interleaved);
    let at = |x: u32, y: u32| stretched.as_ref().map_or(Vec3::splat(least), |s| s.at([x as usize, y as usize]));
    let slow = Image::from_fn(width, height, at);

    let mut image = color.finest().clone();
    let mut clipped = 0_usize;
    for (pixel, slow) in image.data_mut().chunks_exact_mut(3).zip(slow.data().chunks_exact(3)) {
        let detail = DETAIL * Vec3::from_slice(pixel) / Vec3::from_slice(slow);
        clipped += usize::from(detail.max_element() > 1.0);
        detail.min(Vec3::ONE).write_to_slice(pixel);
    }
    let clipped = clipped as f32 / (width as f32 * height as f32);
    // It has the size it had.
    let _ = exemplar.set(Channel::BaseColor, image);
    Slowly { slow, clipped }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;

    fn color(exemplar: &Exemplar) -> &Image {
        exemplar.channel(Channel::BaseColor).unwrap().finest()
    }

    /// Noise of one colour on one side, of another one on the other.
    fn two_coloured() -> Exemplar {
        let mut random = Random::new(3, 0);
        let hue = |x: u32| Vec3::new(0.6, 0.3, 0.1).lerp(Vec3::new(0.1, 0.3, 0.5), x as f32 / 150.0);
        Exemplar::new("two", Image::from_fn(150, 100, |x, _| hue(x) * random.range(0.5, 1.3) as f32))
    }

    #[test]
    fn detail_over_its_slow_part_is_the_exemplar() {
        let before = two_coloured();
        let mut detail = before.clone();
        let Slowly { slow, clipped } = take_detail(&mut detail);
        assert_eq!(clipped, 0.0, "nothing is four times as bright as what lies around it");
        let again = color(&detail).data().iter().zip(slow.data()).map(|(d, s)| d * s / DETAIL);
        let most = again.zip(color(&before).data()).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
        assert!(most < 1e-5, "it differs by {most}");
    }

    #[test]
    fn detail_is_grey_of_one_brightness_on_both_sides() {
        let mut detail = two_coloured();
        take_detail(&mut detail);
        let image = color(&detail);
        let mean = |from: u32| -> Vec3 {
            (from..from + 50)
                .flat_map(|x| (0..100).map(move |y| [x, y]))
                .map(|[x, y]| image.pixel(x.into(), y.into()))
                .sum::<Vec3>()
                / 5000.0
        };
        for side in [mean(0), mean(100)] {
            assert!((side - DETAIL).abs().max_element() < 0.01, "a side is {side}");
        }
    }

    #[test]
    fn black_has_no_detail() {
        let mut exemplar = Exemplar::new("black", Image::from_fn(20, 9, |_, _| Vec3::ZERO));
        let Slowly { slow, clipped } = take_detail(&mut exemplar);
        assert!(clipped == 0.0 && slow.data().iter().all(|s| s.is_finite() && *s > 0.0));
        assert!(color(&exemplar).data().iter().all(|&d| d == 0.0));
    }
}
