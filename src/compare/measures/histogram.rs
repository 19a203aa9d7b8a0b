//! Whether the colours are there at all, and in the right amounts, wherever they lie.

use super::pieces::Pieces;
use rayon::prelude::*;

/// Directions in the space of colours: the axes, and the diagonals of their planes and of the cube.
const DIRECTIONS: [[f64; 3]; 13] = [
    [1.0, 0.0, 0.0],
    [0.0, 1.0, 0.0],
    [0.0, 0.0, 1.0],
    [1.0, 1.0, 0.0],
    [1.0, -1.0, 0.0],
    [1.0, 0.0, 1.0],
    [1.0, 0.0, -1.0],
    [0.0, 1.0, 1.0],
    [0.0, 1.0, -1.0],
    [1.0, 1.0, 1.0],
    [1.0, 1.0, -1.0],
    [1.0, -1.0, 1.0],
    [-1.0, 1.0, 1.0],
];

/// Bins along a direction, and a bin's width: an eighth of a step of eight bits. They reach from -2 to 2, farther than any colour.
const BINS: usize = 8192;
const WIDTH: f64 = 4.0 / BINS as f64;

/// How colours are spread along each direction.
#[derive(Debug, Clone, PartialEq)]
pub struct Histogram(Vec<Vec<u32>>);

impl Histogram {
    /// Counts the pixels of pieces.
    #[must_use]
    pub fn new(pieces: &Pieces) -> Self {
        let counts = |direction: &[f64; 3]| {
            let length = direction.iter().map(|d| d * d).sum::<f64>().sqrt();
            let mut counts = vec![0_u32; BINS];
            for p in pieces.data.iter().flatten() {
                let dot = (0..3).map(|k| f64::from(p[k]) * direction[k]).sum::<f64>() / length;
                counts[((dot + 2.0) / WIDTH).clamp(0.0, BINS as f64 - 1.0) as usize] += 1;
            }
            counts
        };
        Self(DIRECTIONS.par_iter().map(counts).collect())
    }

    /// The distance between the distributions of colours, in steps of eight bits: the mean over fixed directions of how far colours
    /// must be moved along each (sliced Wasserstein distance of single pixels). NaN without pieces.
    #[must_use]
    pub fn distance(&self, other: &Self) -> f64 {
        let one = |(a, b): (&Vec<u32>, &Vec<u32>)| {
            let [all, others] = [a, b].map(|counts| f64::from(counts.iter().sum::<u32>()));
            // What lies below each bin in one and not in the other has to cross it.
            let below = |sum: &mut f64, (&p, &q): (&u32, &u32)| {
                *sum += f64::from(p) / all - f64::from(q) / others;
                Some(sum.abs())
            };
            a.iter().zip(b).scan(0.0, below).sum::<f64>() * WIDTH
        };
        255.0 * self.0.iter().zip(&other.0).map(one).sum::<f64>() / DIRECTIONS.len() as f64
    }
}

/// [`Histogram::distance`] of pieces that are compared once.
#[must_use]
pub fn histogram_distance(a: &Pieces, b: &Pieces) -> f64 {
    Histogram::new(a).distance(&Histogram::new(b))
}
