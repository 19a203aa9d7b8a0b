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
    images.par_iter_mut().for_each(|(_, image)| {
        let n = image.components();
        let data = image.data_mut();
        for (i, &from) in nearest.iter().enumerate() {
            let from = from as usize;
            if !covered[i] && from < covered.len() {
                data.copy_within(from * n..(from + 1) * n, i * n);
            }
        }
    });
}
