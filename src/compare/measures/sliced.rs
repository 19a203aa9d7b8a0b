//! The sliced Wasserstein distance of patches.

use super::pieces::Pieces;
use crate::numeric::rows::{Rows, dot};
use crate::random::Random;
use pulp::Arch;
use rayon::prelude::*;
use std::sync::LazyLock;

/// Side of a patch, pixels.
const PATCH: usize = 7;
/// Projections; always the same ones, so that numbers of different results compare.
const PROJECTIONS: u64 = 256;
/// Levels, each half the size of the one before.
const LEVELS: usize = 3;

/// Pieces projected: for each level that they are large enough for and each projection, their numbers in order.
#[derive(Debug, Clone, PartialEq)]
pub struct Sliced(Vec<Vec<Vec<f32>>>);

impl Sliced {
    /// Projects pieces.
    #[must_use]
    pub fn new(pieces: &Pieces) -> Self {
        let mut levels = Vec::new();
        let mut pieces = pieces.clone();
        while levels.len() < LEVELS && pieces.side >= PATCH {
            let rows = pieces.middles(PATCH);
            levels.push(DIRECTIONS.par_iter().map(|direction| projected(&rows, direction)).collect());
            pieces = pieces.halved();
        }
        Self(levels)
    }

    /// The mean over projections and levels of the distance between the sorted projected patches, times 100. NaN without pieces.
    #[must_use]
    pub fn distance(&self, other: &Self) -> f64 {
        let levels = self.0.len().min(other.0.len());
        let of_level = |(a, b): (&Vec<Vec<f32>>, &Vec<Vec<f32>>)| -> f64 {
            a.iter().zip(b).map(|(a, b)| apart(a, b)).sum::<f64>() / PROJECTIONS as f64
        };
        100.0 * self.0.iter().zip(&other.0).map(of_level).sum::<f64>() / levels as f64
    }
}

/// The directions, unit.
static DIRECTIONS: LazyLock<Vec<Vec<f32>>> = LazyLock::new(|| {
    let one = |k| {
        let mut random = Random::new(0x511CE, k);
        let direction: Vec<f64> = (0..3 * PATCH * PATCH).map(|_| normal(&mut random)).collect();
        let length = direction.iter().map(|d| d * d).sum::<f64>().sqrt();
        direction.iter().map(|d| (d / length) as f32).collect()
    };
    (0..PROJECTIONS).map(one).collect()
});

/// Patches along one of the directions, in order.
fn projected(rows: &Rows, direction: &[f32]) -> Vec<f32> {
    let mut all: Vec<f32> = Arch::new().dispatch(|| rows.iter().map(|r| dot(r, direction)).collect());
    all.sort_unstable_by(f32::total_cmp);
    all
}

/// [`Sliced::distance`] of pieces that are compared once.
#[must_use]
pub fn sliced_wasserstein(a: &Pieces, b: &Pieces) -> f64 {
    Sliced::new(a).distance(&Sliced::new(b))
}

/// A normally distributed number (Box, Muller 1958).
fn normal(random: &mut Random) -> f64 {
    let radius = (-2.0 * (1.0 - random.unit()).ln()).sqrt();
    radius * (std::f64::consts::TAU * random.unit()).cos()
}

/// The distance of two sorted samples on a line; the quantiles of the smaller are compared.
fn apart(a: &[f32], b: &[f32]) -> f64 {
    let count = a.len().min(b.len());
    let at = |s: &[f32], i: usize| f64::from(s[(2 * i + 1) * s.len() / (2 * count)]);
    (0..count).map(|i| (at(a, i) - at(b, i)).abs()).sum::<f64>() / count as f64
}
