//! Whether the colours are there at all, and in the right amounts, wherever they lie.

use super::pieces::Pieces;
use super::sliced::apart;
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

/// The distance between the distributions of colours, in steps of eight bits: the mean over fixed directions of how far colours must
/// be moved along each (sliced Wasserstein distance of single pixels). NaN without pieces.
#[must_use]
pub fn histogram_distance(a: &Pieces, b: &Pieces) -> f64 {
    if a.data.is_empty() || b.data.is_empty() {
        return f64::NAN;
    }
    let one = |direction: &[f64; 3]| {
        let length = direction.iter().map(|d| d * d).sum::<f64>().sqrt();
        let project = |pieces: &Pieces| {
            let dot = |p: &[f32; 3]| (0..3).map(|k| f64::from(p[k]) * direction[k]).sum::<f64>() / length;
            let mut all: Vec<f64> = pieces.data.iter().flatten().map(dot).collect();
            all.sort_by(f64::total_cmp);
            all
        };
        apart(&project(a), &project(b))
    };
    let distances: Vec<f64> = DIRECTIONS.par_iter().map(one).collect();
    255.0 * distances.iter().sum::<f64>() / DIRECTIONS.len() as f64
}
