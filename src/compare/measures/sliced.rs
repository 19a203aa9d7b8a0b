//! The sliced Wasserstein distance of patches.

use super::pieces::Pieces;
use crate::random::Random;
use rayon::prelude::*;

/// Side of a patch, pixels.
const PATCH: usize = 7;
/// Projections; always the same ones, so that numbers of different results compare.
const PROJECTIONS: u64 = 256;
/// Levels, each half the size of the one before.
const LEVELS: usize = 3;

/// The mean over projections and levels of the distance between the sorted projected patches, times 100. NaN without pieces.
#[must_use]
pub fn sliced_wasserstein(a: &Pieces, b: &Pieces) -> f64 {
    if a.data.is_empty() || b.data.is_empty() {
        return f64::NAN;
    }
    let (mut a, mut b) = (a.clone(), b.clone());
    let (mut sum, mut levels) = (0.0, 0.0);
    for level in 0..LEVELS {
        if level > 0 {
            (a, b) = (a.halved(), b.halved());
        }
        if a.side < PATCH || b.side < PATCH {
            break;
        }
        let (rows, others) = (a.middles(PATCH), b.middles(PATCH));
        let one = |k: u64| {
            let mut random = Random::new(0x511CE, k);
            let mut direction: Vec<f64> = (0..rows.dims()).map(|_| normal(&mut random)).collect();
            let length = direction.iter().map(|d| d * d).sum::<f64>().sqrt();
            direction.iter_mut().for_each(|d| *d /= length);
            let project = |rows: &crate::numeric::rows::Rows| {
                let dot = |r: &[f32]| r.iter().zip(&direction).map(|(&x, d)| f64::from(x) * d).sum::<f64>();
                let mut all: Vec<f64> = rows.iter().map(dot).collect();
                all.sort_by(f64::total_cmp);
                all
            };
            apart(&project(&rows), &project(&others))
        };
        let distances: Vec<f64> = (0..PROJECTIONS).into_par_iter().map(one).collect();
        sum += distances.iter().sum::<f64>() / PROJECTIONS as f64;
        levels += 1.0;
    }
    100.0 * sum / levels
}

/// A normally distributed number (Box, Muller 1958).
fn normal(random: &mut Random) -> f64 {
    let radius = (-2.0 * (1.0 - random.unit()).ln()).sqrt();
    radius * (std::f64::consts::TAU * random.unit()).cos()
}

/// The distance of two sorted samples on a line; the quantiles of the smaller are compared.
pub(super) fn apart(a: &[f64], b: &[f64]) -> f64 {
    let count = a.len().min(b.len());
    let at = |s: &[f64], i: usize| s[(2 * i + 1) * s.len() / (2 * count)];
    (0..count).map(|i| (at(a, i) - at(b, i)).abs()).sum::<f64>() / count as f64
}
