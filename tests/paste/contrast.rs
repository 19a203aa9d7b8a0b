//! Where pastes fade into each other, what shows has the contrast of the exemplar.

#![allow(clippy::unwrap_used, reason = "a test may fail by panicking")]

use crate::common::{Points, sheet};
use glam::{Vec2, Vec3};
use lapped::exemplar::{Channel, Exemplar, Image};
use lapped::job::{ExemplarInput, PasteJob, Pasted, Scale, paste_model};
use lapped::paste::{AGREES, Composite, PasteOptions};
use lapped::progress::Silent;
use lapped::random::Random;
use lapped::surface::SurfaceTexture;

/// Blobs of all greys between `low` and `high`, six pixels wide; no two places of it agree.
fn gravel(low: f64, high: f64) -> Exemplar {
    let mut random = Random::new(3, 0);
    let greys: Vec<f32> = (0..32 * 32).map(|_| random.range(low, high) as f32).collect();
    Exemplar::new("gravel", Image::from_fn(192, 192, |x, y| Vec3::splat(greys[(y / 6 * 32 + x / 6) as usize])))
}

/// With a feather of `feather` pixels, as the paper has it but for the contrast.
fn pasted(exemplar: Exemplar, feather: f32, paste: PasteOptions) -> Pasted {
    let job = PasteJob { scale: Scale::World(0.5), feather: Some(feather), paste, ..PasteJob::default() };
    let input = ExemplarInput { exemplar, weight: 1.0, patches: Vec::new() };
    paste_model(&sheet(24, 2.0), vec![input], &job, &Silent).unwrap()
}

/// Mean and variance of what shows.
fn spread(pasted: &Pasted) -> [f64; 2] {
    let composite = Composite::new(&pasted.mesh, &pasted.lapped);
    let shown: Vec<f64> =
        Points::new(&pasted.mesh).list(60_000).into_iter().map(|at| f64::from(composite.texel(at, 0.0).base_color.x)).collect();
    moments(&shown)
}

/// Mean and variance.
fn moments(values: &[f64]) -> [f64; 2] {
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    [mean, values.iter().map(|v| (v - mean) * (v - mean)).sum::<f64>() / count]
}

#[test]
fn wide_transitions_keep_the_variance_that_a_plain_mix_loses() {
    let exemplar = gravel(0.3, 0.7);
    // Between pixels the exemplar has less contrast than at them.
    let image = exemplar.channel(Channel::BaseColor).unwrap().finest();
    let mut random = Random::new(9, 0);
    let at: Vec<Vec2> = (0..60_000).map(|_| Vec2::new(random.range(8.0, 184.0) as f32, random.range(8.0, 184.0) as f32)).collect();
    let [mean, own] = moments(&at.into_iter().map(|at| f64::from(image.bilinear(at).x)).collect::<Vec<_>>());
    let made = |contrast| pasted(exemplar.clone(), 30.0, PasteOptions { contrast, ..PasteOptions::default().plain() });
    let [plain, kept] = [false, true].map(|contrast| spread(&made(contrast)));
    assert!(plain[1] < 0.88 * own, "a plain mix has the variance {} of {own}", plain[1]);
    assert!((kept[1] / own - 1.0).abs() < 0.05, "it is kept: {} of {own}; plain {}", kept[1], plain[1]);
    assert!((kept[0] - mean).abs() < 0.01, "and the mean is {} as ever, {mean}", kept[0]);
}

#[test]
fn pastes_that_agree_are_laid_over_as_ever() {
    // Stripes agree wherever windows bring them to.
    let stripes = Image::from_fn(128, 128, |x, _| Vec3::splat(0.5 + 0.3 * (x as f32 / 8.0 * std::f32::consts::TAU).sin()));
    let options = |windows| PasteOptions { windows, contrast: true, ..PasteOptions::default().plain() };
    let [blind, chosen] =
        [false, true].map(|windows| pasted(Exemplar::new("stripes", stripes.clone()), 6.0, options(windows)).report.paste.contrast);
    assert!(chosen.agreement > 0.8, "{chosen:?}: stripes lie on stripes");
    assert!(blind.agreement < 0.6, "{blind:?}: and did not before");
    let plain = pasted(gravel(0.3, 0.7), 6.0, PasteOptions::default());
    assert!(plain.lapped.pastes.iter().all(|p| p.agreement == AGREES), "nobody asked");
}

#[test]
fn what_leaves_the_range_is_clipped_once_everything_is_summed_up() {
    let made = pasted(gravel(0.0, 1.0), 30.0, PasteOptions { contrast: true, ..PasteOptions::default().plain() });
    let composite = Composite::new(&made.mesh, &made.lapped);
    let shown: Vec<f32> =
        Points::new(&made.mesh).list(60_000).into_iter().map(|at| composite.texel(at, 0.0).base_color.x).collect();
    assert!(shown.iter().all(|v| (0.0..=1.0).contains(v)), "nothing is darker than black or brighter than white");
    assert!(shown.contains(&0.0) && shown.contains(&1.0), "and both are reached");
}
