//! Gutters: every texel outside the charts takes the value of the nearest texel inside one.
//!
//! The nearest is exact ([`crate::exemplar::distance`]), so each chart's colours reach half way to its neighbours, and no
//! filter at any mip level meets a colour that is on no chart.

use crate::exemplar::distance::nearest_seed;
use crate::exemplar::{Channel, Image};
use rayon::prelude::*;

/// Fills the texels that are not `covered` in each image, rows of `width` texels.
pub fn dilate(covered: &[bool], width: usize, images: &mut [(Channel, Image)]) {
    let nearest = nearest_seed(covered, width);
    if nearest.is_empty() {
        return;
    }
    for (_, image) in images {
        let n = image.components();
        let row = width * n;
        let data = image.data_mut();
        // Rows read each other's texels: all are read before any is written.
        let filled: Vec<Vec<f32>> = nearest
            .par_chunks(width)
            .zip(covered.par_chunks(width))
            .map(|(nearest, covered)| {
                let wanted = nearest.iter().zip(covered).filter(|(_, covered)| !**covered).map(|(&from, _)| from as usize);
                wanted
                    .flat_map(|from| data.get(from.saturating_mul(n)..).and_then(|d| d.get(..n)).unwrap_or(&[]))
                    .copied()
                    .collect()
            })
            .collect();
        data.par_chunks_mut(row).zip(covered.par_chunks(width)).zip(&filled).for_each(|((data, covered), filled)| {
            let empty = data.chunks_exact_mut(n).zip(covered).filter(|(_, covered)| !**covered);
            empty.zip(filled.chunks_exact(n)).for_each(|((texel, _), filled)| texel.copy_from_slice(filled));
        });
    }
}
