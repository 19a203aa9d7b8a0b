//! Convolution on a mesh: blurring, sharpening and halving what its vertices hold.
//!
//! Based on: Wei, Levoy 2001, sec. 5, which leaves it to the future: the neighbourhoods of synthesis, with weights instead of a
//! search, make any image filter a filter on a surface. Samples that nothing covers are left out.

use super::levels::Levels;
use super::neighbourhood::Values;
use super::window::Window;
use crate::mesh::SurfacePoint;
use crate::mesh::pyramid::parents;
use rayon::prelude::*;

/// Standard deviation of the pyramid's kernel 1 3 3 1, samples.
const PYRAMID: f64 = 0.866;

/// A blur wider than this many samples is done in several rounds of smaller ones.
const WIDEST: f64 = 2.0;

/// Samples are taken as far out as this many standard deviations.
const REACH: f64 = 2.0;

/// Convolves `components` numbers a vertex of the finest level with a Gaussian of standard deviation `sigma`, world units.
#[must_use]
pub fn blur(levels: &Levels, components: usize, values: &[f32], sigma: f64) -> Vec<f32> {
    let components = components.max(1);
    blurred(levels, 0, components, values, sigma / levels.finest().spacing)
}

/// Adds to each number `amount` times what a Gaussian blur takes away.
#[must_use]
pub fn sharpen(levels: &Levels, components: usize, values: &[f32], sigma: f64, amount: f32) -> Vec<f32> {
    let soft = blur(levels, components, values, sigma);
    values.iter().zip(soft).map(|(v, s)| v + amount * (v - s)).collect()
}

fn blurred(levels: &Levels, level: usize, components: usize, values: &[f32], sigma: f64) -> Vec<f32> {
    let count = levels.levels()[level].mesh.vertex_count();
    if !(sigma > 0.0) || values.len() != count * components {
        return values.to_vec();
    }
    // Variances of rounds add up.
    let rounds = (sigma / WIDEST).powi(2).ceil().clamp(1.0, 10_000.0);
    let sigma = sigma / rounds.sqrt();
    let radius = (REACH * sigma).ceil().max(1.0) as i32;
    let around = levels.neighbourhoods(level, Window::new(2 * radius as u32 + 1, 1), true);
    let side = 2 * radius + 1;
    let weight = |i: i32| {
        let (x, y) = (f64::from(i % side - radius), f64::from(i / side - radius));
        (-(x * x + y * y) / (2.0 * sigma * sigma)).exp() as f32
    };
    let weights: Vec<f32> = (0..side * side).map(weight).collect();
    let mut values = values.to_vec();
    for _ in 0..rounds as usize {
        let mut next = vec![0.0; values.len()];
        next.par_chunks_exact_mut(components).enumerate().with_min_len(256).for_each(|(v, out)| {
            let mut sum = 0.0;
            for (blend, &w) in around.own.of(v as u32).iter().zip(&weights) {
                for (corner, share) in
                    blend.vertices.into_iter().zip(blend.shares).filter(|(c, s)| (*c as usize) < count && *s > 0.0)
                {
                    let w = w * share;
                    sum += w;
                    out.iter_mut().zip(&values[corner as usize * components..]).for_each(|(o, x)| *o += w * x);
                }
            }
            out.iter_mut().for_each(|o| *o /= sum.max(f32::MIN_POSITIVE));
        });
        values = next;
    }
    values
}

/// The numbers on all levels: each is blurred, and read where the next one's vertices lie on it.
pub(super) fn pyramid(levels: &Levels, components: usize, finest: &[f32]) -> Vec<Values> {
    let mut data = finest.to_vec();
    data.resize(levels.finest().mesh.vertex_count() * components, 0.0);
    let mut out: Vec<Values> = Vec::with_capacity(levels.len());
    for level in 0..levels.len() {
        if level > 0 {
            let (fine, coarse) = (&levels.levels()[level - 1].mesh, &levels.levels()[level].mesh);
            let soft = blurred(levels, level - 1, components, &data, PYRAMID);
            let read = |p: SurfacePoint| -> Vec<f32> {
                let corners = fine.faces[p.face as usize].map(|v| &soft[v as usize * components..][..components]);
                (0..components).map(|k| (0..3).map(|c| p.bary[c] * corners[c][k]).sum()).collect()
            };
            data = parents(coarse, fine).into_iter().flat_map(|p| read(p.at)).collect();
        }
        let count = (data.len() / components).max(1);
        let mean: Vec<f32> = (0..components).map(|k| data.iter().skip(k).step_by(components).sum::<f32>() / count as f32).collect();
        out.push(Values { components, data: data.iter().copied().chain(mean).collect() });
    }
    out
}
