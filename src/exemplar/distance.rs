//! Exact Euclidean distance transform of a boolean image, in time linear in its pixels.
//!
//! Based on: Felzenszwalb and Huttenlocher, "Distance Transforms of Sampled Functions", Theory of Computing 8 (2012).
//!
//! 1. Down and up each column: rows to the nearest seed of the column. A seed function is 0 or infinite, so two sweeps of
//!    counting replace the first of the paper's lower envelopes.
//! 2. Along each row: the lower envelope of the parabolas `(x - q)^2 + column distance(q)^2`, read off pixel by pixel.
//!
//! Rows are independent, so they run in parallel; the result does not depend on the number of threads.

use rayon::prelude::*;

/// Stands for "no seed in this column"; small enough that adding 1 a row never overflows.
const NONE: u32 = u32::MAX / 2;

/// The squared distance from each pixel's centre to the centre of the nearest seed, in pixels; infinite everywhere if
/// there is no seed. `seeds` holds rows of `width` pixels; a partial last row is an empty result.
#[must_use]
pub fn squared_distance(seeds: &[bool], width: usize) -> Vec<f32> {
    if width == 0 || !seeds.len().is_multiple_of(width) {
        return Vec::new();
    }
    let column = column_distance(seeds, width);
    let mut squared = vec![f32::INFINITY; seeds.len()];
    squared.par_chunks_mut(width).zip(column.par_chunks(width)).for_each_init(Envelope::default, |envelope, (out, row)| {
        envelope.build(row);
        envelope.walk(width, |x, _, squared| out[x] = squared as f32);
    });
    squared
}

/// For each pixel the index of the nearest seed, the one furthest left and up of several; `u32::MAX` everywhere if there is
/// none. `seeds` holds rows of `width` pixels; a partial last row is an empty result.
#[must_use]
pub fn nearest_seed(seeds: &[bool], width: usize) -> Vec<u32> {
    if width == 0 || !seeds.len().is_multiple_of(width) {
        return Vec::new();
    }
    let column = column_distance(seeds, width);
    let mut nearest = vec![u32::MAX; seeds.len()];
    let rows = nearest.par_chunks_mut(width).zip(column.par_chunks(width)).enumerate();
    rows.for_each_init(Envelope::default, |envelope, (y, (out, row))| {
        envelope.build(row);
        envelope.walk(width, |x, from, _| {
            let away = row[from] as usize;
            let up = y.checked_sub(away).map(|y| y * width + from).filter(|&i| seeds[i]);
            out[x] = up.unwrap_or((y + away) * width + from) as u32;
        });
    });
    nearest
}

/// Rows from each pixel to the nearest seed of its column.
fn column_distance(seeds: &[bool], width: usize) -> Vec<u32> {
    let mut column: Vec<u32> = seeds.iter().map(|&seed| if seed { 0 } else { NONE }).collect();
    for i in width..column.len() {
        column[i] = column[i].min(column[i - width] + 1);
    }
    for i in (0..column.len().saturating_sub(width)).rev() {
        column[i] = column[i].min(column[i + width] + 1);
    }
    column
}

/// The distance from each pixel's centre to the centre of the nearest seed, in pixels; see [`squared_distance`].
#[must_use]
pub fn distance(seeds: &[bool], width: usize) -> Vec<f32> {
    let mut squared = squared_distance(seeds, width);
    squared.par_iter_mut().for_each(|d| *d = d.sqrt());
    squared
}

/// The lower envelope of the parabolas of one row: each one's vertex, height there, and where it takes over.
#[derive(Default)]
struct Envelope(Vec<(f64, f64, f64)>);

impl Envelope {
    fn build(&mut self, column_distance: &[u32]) {
        self.0.clear();
        for (x, &d) in column_distance.iter().enumerate().filter(|&(_, &d)| d < NONE) {
            let (x, height) = (x as f64, f64::from(d) * f64::from(d));
            let mut from = f64::NEG_INFINITY;
            while let Some(&(x0, height0, from0)) = self.0.last() {
                from = ((height + x * x) - (height0 + x0 * x0)) / (2.0 * (x - x0));
                if from > from0 {
                    break;
                }
                self.0.pop();
                from = f64::NEG_INFINITY;
            }
            self.0.push((x, height, from));
        }
    }

    /// Gives for each pixel of the row the column of its nearest seed and the squared distance.
    fn walk(&self, width: usize, mut found: impl FnMut(usize, usize, f64)) {
        let mut k = 0;
        for column in 0..width {
            let x = column as f64;
            while k + 1 < self.0.len() && self.0[k + 1].2 < x {
                k += 1;
            }
            if let Some(&(x0, height, _)) = self.0.get(k) {
                found(column, x0 as usize, (x - x0) * (x - x0) + height);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{distance, nearest_seed, squared_distance};
    use crate::random::Random;

    #[test]
    fn equals_brute_force_on_random_seeds() {
        let mut random = Random::new(7, 0);
        for (w, h, density) in [(1, 1, 0.5), (1, 40, 0.1), (40, 1, 0.1), (31, 17, 0.5), (37, 41, 0.02), (64, 48, 0.003)] {
            let seeds: Vec<bool> = (0..w * h).map(|_| random.unit() < density).collect();
            let found = squared_distance(&seeds, w);
            let nearest = nearest_seed(&seeds, w);
            for (i, &got) in found.iter().enumerate() {
                let expected = (0..w * h)
                    .filter(|&j| seeds[j])
                    .map(|j| ((j % w).abs_diff(i % w).pow(2) + (j / w).abs_diff(i / w).pow(2)) as f32)
                    .fold(f32::INFINITY, f32::min);
                assert_eq!(got, expected, "{w}x{h} density {density}, pixel {}, {}", i % w, i / w);
                let seed = nearest[i] as usize;
                let away = seeds
                    .get(seed)
                    .filter(|&&s| s)
                    .map_or(f32::INFINITY, |_| ((seed % w).abs_diff(i % w).pow(2) + (seed / w).abs_diff(i / w).pow(2)) as f32);
                assert_eq!(away, expected, "the seed named is one of the nearest");
            }
        }
    }

    #[test]
    fn without_seeds_all_is_infinitely_far() {
        assert!(distance(&[false; 12], 4).iter().all(|d| d.is_infinite()), "no seed, no distance");
        assert!(distance(&[true; 12], 4).iter().all(|&d| d == 0.0), "all seeds");
        assert_eq!(distance(&[], 0), Vec::<f32>::new(), "no pixels");
    }
}
