//! Mip levels of a baked page, each made from covered texels alone.
//!
//! A texel of a level is the mean of what lies under it on the level above, by area, each part counting as much as charts cover of
//! it; what no chart reaches is filled like a gutter ([`mod@super::dilate`]). So not even the smallest level has seen a gutter. Sides are
//! halved and rounded down, as graphics adapters want them; colour is averaged in linear light, normals are brought back to unit
//! length.

use super::dilate::dilate;
use crate::exemplar::{Channel, Image};
use glam::Vec3;
use rayon::prelude::*;

/// The levels below a square page, the largest first, down to one texel.
#[must_use]
pub fn mip_levels(covered: &[bool], images: &[(Channel, Image)]) -> Vec<Vec<(Channel, Image)>> {
    let mut share: Vec<f32> = covered.iter().map(|&c| f32::from(u8::from(c))).collect();
    let mut levels: Vec<Vec<(Channel, Image)>> = Vec::new();
    loop {
        let above = levels.last().map_or(images, Vec::as_slice);
        let Some(side) = above.first().map(|(_, image)| image.size()[0]).filter(|&s| s > 1) else { return levels };
        let parts = parts(side as usize);
        let coarse = side / 2;
        let mean = |(channel, image): &(Channel, Image)| {
            let data = weighted(image.data(), image.components(), &share, side as usize, &parts, *channel == Channel::Normal);
            Image::new(coarse, coarse, image.components(), data).map(|image| (*channel, image))
        };
        let mut level: Vec<(Channel, Image)> = above.par_iter().filter_map(mean).collect();
        share = under(side as usize, &parts).map(|all| all.map(|(i, area)| area * share[i]).sum()).collect();
        let inside: Vec<bool> = share.iter().map(|&s| s > 0.0).collect();
        dilate(&inside, coarse as usize, &mut level);
        levels.push(level);
    }
}

/// For each texel of a row of half as many, the first of those under it, and what share of it each of them makes up.
fn parts(side: usize) -> Vec<(usize, [f32; 3])> {
    let coarse = side / 2;
    let width = side as f64 / coarse as f64;
    (0..coarse)
        .map(|x| {
            let (low, high) = (x as f64 * width, (x + 1) as f64 * width);
            let first = low.floor() as usize;
            let part = |k: usize| {
                let (a, b) = ((first + k) as f64, (first + k + 1) as f64);
                ((b.min(high) - a.max(low)).max(0.0) / width) as f32
            };
            (first, [part(0), part(1), part(2)])
        })
        .collect()
}

/// For each texel of the coarse level the texels under it and their shares of its area, rows from the top.
fn under(side: usize, parts: &[(usize, [f32; 3])]) -> impl Iterator<Item = impl Iterator<Item = (usize, f32)>> {
    parts.iter().flat_map(move |&(top, down)| {
        parts.iter().map(move |&(left, across)| {
            (0..9).map(move |k| ((top + k / 3) * side + left + k % 3, down[k / 3] * across[k % 3])).filter(|(_, area)| *area > 0.0)
        })
    })
}

/// Means of an image's texels by area and share.
fn weighted(data: &[f32], n: usize, share: &[f32], side: usize, parts: &[(usize, [f32; 3])], unit: bool) -> Vec<f32> {
    let mut out = Vec::with_capacity(n * parts.len() * parts.len());
    for texels in under(side, parts) {
        let (mut sum, mut weight) = ([0.0; 3], 0.0);
        for (i, area) in texels {
            let w = area * share[i];
            (0..n).for_each(|c| sum[c] += w * data[n * i + c]);
            weight += w;
        }
        let mut mean = if weight > 0.0 { sum.map(|s| s / weight) } else { sum };
        if unit {
            mean = Vec3::from_array(mean).normalize_or(Vec3::Z).to_array();
        }
        out.extend_from_slice(&mean[..n]);
    }
    out
}
