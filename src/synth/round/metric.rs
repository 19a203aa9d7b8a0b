//! How alike two neighbourhoods are: the adaptive similarity metric.
//!
//! Based on: Chen, Dong 2008, sec. 5.2. Every part can be switched off ([`Metric`]).
//!
//! 1. Circle by circle from the innermost, the mean squared difference of all coloured samples so far is taken; what counts is the
//!    sum of these means, so that near samples count more often than far ones.
//! 2. *Outliers.* Samples that differ by more than the mean and two standard deviations of their neighbourhood's differences are left out.
//! 3. *Deviation.* Of the candidates those stay whose mean lies below the mean of all by more than a standard deviation; from these
//!    again those with one circle more, until one is left.
//! 4. *Region.* The circle at which one is left is the last one that counts, here, for all candidates.
//!
//! What the paper leaves open. A subset may be empty, and is for one vertex in two: then all stay and the next circle decides. Sums
//! over different numbers of coloured samples are means, or candidates could not be compared. With regions the least sum up to the
//! last circle wins over all candidates; without them, whoever is left. Numbers of two places that both explain nothing
//! are equally good; the one suggested first, by the nearest neighbour, is taken.

use serde::Serialize;

/// Deviations beyond which a pair of samples is an outlier.
const OUTLIER: f32 = 2.0;

/// The parts of the metric.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct Metric {
    /// Candidates come from synthesised neighbours; without, every pixel is one.
    pub candidates: bool,
    /// Means of all sizes are summed; without, the largest one counts alone.
    pub sums: bool,
    /// Candidates are dropped that lie outside the low end of the standard deviation.
    pub deviation: bool,
    /// The size of the neighbourhood goes by where one candidate is left.
    pub region: bool,
    /// Pairs beyond two standard deviations do not count.
    pub outliers: bool,
}

impl Default for Metric {
    fn default() -> Self {
        Self { candidates: true, sums: true, deviation: true, region: true, outliers: true }
    }
}

impl Metric {
    /// A plain sum of squared differences over the largest neighbourhood.
    #[must_use]
    pub const fn plain() -> Self {
        Self { candidates: true, sums: false, deviation: false, region: false, outliers: false }
    }
}

/// A neighbourhood to compare with.
#[derive(Debug, Default)]
pub(super) struct Query {
    /// Numbers, component by component and within each sample by sample.
    pub(super) values: Vec<f32>,
    /// For each sample 1 if it is coloured, or 0.
    pub(super) coloured: Vec<f32>,
}

impl Query {
    pub(super) fn clear(&mut self, per: usize, components: usize) {
        self.values.clear();
        self.values.resize(per * components, 0.0);
        self.coloured.clear();
        self.coloured.resize(per, 0.0);
    }

    /// The squared differences to a window, sample by sample; 0 where nothing is coloured.
    #[inline]
    pub(super) fn differences(&self, window: &[f32], out: &mut [f32]) {
        let per = self.coloured.len();
        out.fill(0.0);
        for (a, b) in self.values.chunks_exact(per).zip(window.chunks_exact(per)) {
            for ((out, a), b) in out.iter_mut().zip(a).zip(b) {
                *out += (a - b) * (a - b);
            }
        }
        out.iter_mut().zip(&self.coloured).for_each(|(o, w)| *o *= w);
    }

    /// The mean squared difference over all coloured samples.
    #[inline]
    pub(super) fn mean(&self, window: &[f32]) -> f32 {
        let per = self.coloured.len();
        let mut sum = 0.0;
        let mut lanes = [0.0_f32; 4];
        for (a, b) in self.values.chunks_exact(per).zip(window.chunks_exact(per)) {
            let (a4, a_rest) = a.as_chunks::<4>();
            let (b4, b_rest) = b.as_chunks::<4>();
            let (w4, w_rest) = self.coloured.as_chunks::<4>();
            for ((a, b), w) in a4.iter().zip(b4).zip(w4) {
                for k in 0..4 {
                    lanes[k] += w[k] * (a[k] - b[k]) * (a[k] - b[k]);
                }
            }
            sum += a_rest.iter().zip(b_rest).zip(w_rest).map(|((a, b), w)| w * (a - b) * (a - b)).sum::<f32>();
        }
        let count = self.coloured.iter().sum::<f32>().max(1.0);
        (sum + lanes.iter().sum::<f32>()) / count
    }
}

/// Room for choosing, used again and again.
#[derive(Debug, Default)]
pub(super) struct Chooser {
    differences: Vec<f32>,
    /// The mean of each candidate at the size looked at, and its sum so far.
    now: Vec<f32>,
    sums: Vec<f32>,
    alive: Vec<bool>,
}

/// What was chosen.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Chosen {
    pub(super) candidate: usize,
    /// Circles that counted.
    pub(super) circles: usize,
}

impl Chooser {
    /// The best of `count` candidates, whose windows `window` writes; `ends` are one past the last sample of each circle.
    pub(super) fn choose(
        &mut self,
        query: &Query,
        ends: &[usize],
        metric: Metric,
        count: usize,
        mut window: impl FnMut(usize, &mut [f32]),
        scratch: &mut [f32],
    ) -> Chosen {
        let per = query.coloured.len();
        self.differences.resize(count * per, 0.0);
        for (c, out) in self.differences.chunks_exact_mut(per).take(count).enumerate() {
            window(c, scratch);
            query.differences(scratch, out);
        }
        self.sums.clear();
        self.sums.resize(count, 0.0);
        self.now.resize(count, 0.0);
        self.alive.clear();
        self.alive.resize(count, true);
        let mut left = count;
        let mut circles = 0;
        for (size, &end) in ends.iter().enumerate() {
            circles = size + 1;
            // Sizes that add no coloured sample say nothing new, but count again as those of all candidates do.
            for c in 0..count {
                let mean = mean_of(&self.differences[c * per..][..end], &query.coloured[..end], metric.outliers);
                self.now[c] = mean;
                self.sums[c] = if metric.sums { self.sums[c] + mean } else { mean };
            }
            if metric.deviation && left > 1 {
                left = self.keep_low(left);
            }
            if metric.region && left == 1 {
                break;
            }
        }
        let among = |c: &usize| metric.region || self.alive[*c];
        let best = (0..count).filter(among).min_by(|&a, &b| self.sums[a].total_cmp(&self.sums[b])).unwrap_or(0);
        Chosen { candidate: best, circles }
    }

    /// Keeps the candidates below the low end of the deviation, if there are any; returns how many are left.
    fn keep_low(&mut self, left: usize) -> usize {
        let living = || self.now.iter().zip(&self.alive).filter(|(_, a)| **a).map(|(n, _)| *n);
        let mean = living().sum::<f32>() / left as f32;
        let deviation = (living().map(|n| (n - mean) * (n - mean)).sum::<f32>() / left as f32).sqrt();
        let low = mean - deviation;
        let kept = living().filter(|n| *n < low).count();
        if kept == 0 {
            return left;
        }
        self.alive.iter_mut().zip(&self.now).for_each(|(a, n)| *a &= *n < low);
        kept
    }
}

/// The mean of the differences of coloured samples, without outliers on request.
#[inline]
fn mean_of(differences: &[f32], coloured: &[f32], outliers: bool) -> f32 {
    let (mut sum, mut squares, mut count) = (0.0_f32, 0.0_f32, 0.0_f32);
    for (d, w) in differences.iter().zip(coloured) {
        sum += d;
        squares += d * d;
        count += w;
    }
    if count == 0.0 {
        return 0.0;
    }
    let mean = sum / count;
    if !outliers {
        return mean;
    }
    let bound = mean + OUTLIER * (squares / count - mean * mean).max(0.0).sqrt();
    let (mut kept, mut number) = (0.0_f32, 0.0_f32);
    for (d, w) in differences.iter().zip(coloured) {
        let within = if *d <= bound { *w } else { 0.0 };
        kept += d * within;
        number += within;
    }
    kept / number.max(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two circles of two samples and one component.
    fn choose(candidates: &[[f32; 4]], metric: Metric) -> Chosen {
        let query = Query { values: vec![0.0; 4], coloured: vec![1.0; 4] };
        let window = |c: usize, out: &mut [f32]| out.copy_from_slice(&candidates[c]);
        Chooser::default().choose(&query, &[2, 4], metric, candidates.len(), window, &mut [0.0; 4])
    }

    #[test]
    fn sums_count_near_samples_again() {
        // The second is a little better over all, the first near by.
        let candidates = [[0.1, 0.1, 0.5, 0.5], [0.3, 0.3, 0.4, 0.4]];
        let sums = Metric { sums: true, ..Metric::plain() };
        assert_eq!(choose(&candidates, Metric::plain()).candidate, 1, "the largest size alone");
        assert_eq!(choose(&candidates, sums).candidate, 0, "all sizes");
    }

    #[test]
    fn regions_end_where_one_candidate_is_left() {
        let candidates = [[0.0, 0.0, 0.9, 0.9], [0.5, 0.5, 0.0, 0.0], [0.5, 0.5, 0.0, 0.0], [0.5, 0.5, 0.1, 0.0]];
        let full = choose(&candidates, Metric::default());
        assert_eq!(full, Chosen { candidate: 0, circles: 1 }, "one is far below the others at once");
        let fixed = choose(&candidates, Metric { deviation: false, ..Metric::default() });
        assert_eq!(fixed, Chosen { candidate: 1, circles: 2 }, "without dropping, all circles count");
        let left = choose(&candidates, Metric { region: false, ..Metric::default() });
        assert_eq!(left, Chosen { candidate: 0, circles: 2 }, "without regions whoever is left wins");
    }

    #[test]
    fn a_lone_difference_is_an_outlier() {
        let differences = [0.01, 0.01, 0.01, 0.01, 0.01, 0.01, 0.01, 4.0];
        let coloured = [1.0; 8];
        assert!((mean_of(&differences, &coloured, true) - 0.01).abs() < 1e-6, "seven agree");
        assert!(mean_of(&differences, &coloured, false) > 0.5, "all count");
        assert_eq!(mean_of(&differences, &[0.0; 8], true), 0.0, "nothing coloured says nothing");
    }
}
