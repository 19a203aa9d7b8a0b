//! Transitions that keep contrast.
//!
//! Where a paste fades into what lies below, two textures are averaged, and the mean of two that do not agree has less contrast than
//! either: wide transitions of gravel look like a grey smear between gravels. So what is mixed are deviations from the exemplar's
//! mean, and what their variance loses is given back.
//!
//! Based on: the variance-preserving operator of Heitz and Neyret, "High-Performance By-Example Noise using a Histogram-Preserving
//! Blending Operator", HPG 2018, section 3. It takes what is mixed to be independent; pastes are not, since windows and cuts make
//! them agree, and a transition between two that do would gain contrast that neither has. So each paste keeps how much it
//! [agrees](super::lapped::Paste::agreement) with what lies below its border (the correlation `r` of their deviations, measured by
//! [`seam`](super::seam)): at an alpha of `a` the mix of both has the variance `s^2 = 1 - 2 (1 - r) a (1 - a)` of either, and is divided
//! by `s`.
//!
//! With several pastes above each other that is done paste by paste, from below, and is still an alpha and a colour: a renderer that
//! blends in paint order needs nothing else ([`faded`]). Sums that leave the range of a channel are clipped where everything is
//! summed up, not before.

/// Alphas below this show nothing: the colour that goes with them may be a large number.
const LEAST_ALPHA: f32 = 1e-6;

/// A paste's alpha, and by how much to multiply the deviation of what it shows from its exemplar's mean, so that "over" keeps contrast.
/// `alpha` is the mask's, 0 to 1; `agreement` as in [`Paste`](super::lapped::Paste::agreement).
#[inline]
#[must_use]
pub fn faded(alpha: f32, agreement: u8) -> [f32; 2] {
    if agreement == super::lapped::AGREES || alpha >= 1.0 {
        return [alpha, 1.0];
    }
    let apart = 2.0 * f32::from(super::lapped::AGREES - agreement) / f32::from(super::lapped::AGREES);
    let spread = (1.0 - apart * alpha * (1.0 - alpha)).sqrt();
    let opaque = 1.0 - (1.0 - alpha) / spread;
    if opaque > LEAST_ALPHA { [opaque, alpha / (spread * opaque)] } else { [0.0, 1.0] }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;

    #[test]
    fn mixes_have_the_variance_and_the_mean_of_what_is_mixed() {
        for agreement in [0_u8, 64, 128, 200] {
            let r = f64::from(agreement) / 255.0;
            for alpha in [0.1_f32, 0.3, 0.5, 0.7, 0.95] {
                let mut random = Random::new(5, u64::from(agreement));
                let (mean, mut sums) = (0.4, [0.0; 2]);
                let count = 40_000;
                for _ in 0..count {
                    // Two of variance 1/12, correlated by r.
                    let [x, y] = [random.range(-0.5, 0.5), random.range(-0.5, 0.5)];
                    let (below, above) = (mean + x, mean + r * x + (1.0 - r * r).sqrt() * y);
                    let [opaque, lift] = faded(alpha, agreement).map(f64::from);
                    let shown = mean + lift * (above - mean);
                    let mixed = opaque * shown + (1.0 - opaque) * below;
                    sums = [sums[0] + mixed, sums[1] + (mixed - mean) * (mixed - mean)];
                }
                let [found, variance] = sums.map(|s| s / f64::from(count));
                assert!((found - mean).abs() < 0.01, "{agreement} {alpha}: mean {found}");
                assert!((12.0 * variance - 1.0).abs() < 0.03, "{agreement} {alpha}: variance {variance} is {:.4}", 1.0 / 12.0);
            }
        }
    }

    #[test]
    fn what_agrees_is_laid_over_as_ever_and_opaque_stays_opaque() {
        for alpha in [0.0, 0.25, 1.0] {
            assert_eq!(faded(alpha, 255), [alpha, 1.0], "{alpha}");
        }
        for agreement in 0..=254 {
            assert_eq!(faded(1.0, agreement), [1.0, 1.0], "{agreement}");
            assert_eq!(faded(0.0, agreement), [0.0, 1.0], "{agreement}");
            let alphas: Vec<f32> = (0..=100).map(|k| faded(k as f32 / 100.0, agreement)[0]).collect();
            assert!(alphas.is_sorted() && alphas.iter().all(|a| (0.0..=1.0).contains(a)), "{agreement}: {alphas:?}");
        }
    }
}
