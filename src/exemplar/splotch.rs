//! Splotches: smooth irregular outlines that fill most of an exemplar.
//!
//! After the splotch of Praun, Finkelstein, Hoppe, "Lapped Textures" (2000), section 3.1, an irregular shape whose edge does
//! not show in irregular textures. The shape is ours:
//!
//! 1. A superellipse about the middle, so that corners of the exemplar are used too.
//! 2. Its radius is swelled and dented by a random sum of waves around it. The sum is its logarithm: dents come out blunt
//!    and never reach the middle, so the outline is simple.
//! 3. The result is stretched to fill the exemplar's rectangle, and so takes on its proportions.
//! 4. The strength of the waves is found by bisection so that the opaque share of the exemplar is the one wanted: the number
//!    of pastes is inverse to it, so it decides the cost of everything that follows.

use crate::random::Random;
use glam::{DVec2, Vec2};
use std::f64::consts::TAU;

/// How much of its exemplar a splotch fills.
#[derive(Debug, Clone, Copy)]
pub(super) struct Fill {
    /// Opaque share of the exemplar, drawn between these.
    share: [f64; 2],
    /// Exponent of the superellipse: 2 is an ellipse (79 % of its box), infinity the box.
    roundness: f64,
}

impl Fill {
    /// For outlines that are seen. Below this share pastes multiply; above, too little irregularity is left. 3 fills 88 % of the box.
    pub(super) const ROUGH: Self = Self { share: [0.62, 0.68], roundness: 3.0 };
    /// For pastes whose borders are moved to where they show least: a fifth fewer of them, and more room for a border to move in. 5
    /// fills 95 % of the box. Fuller ones save little more, and where no border can be moved their straight sides show.
    pub(super) const FULL: Self = Self { share: [0.77, 0.83], roundness: 5.0 };
}

/// Share of a smooth outline's opaque area that waves leave at most: where the feather of a small exemplar takes more than its share, two
/// splotches still differ.
const DENTED: f64 = 0.97;
/// Waves around the outline. One wave would only shift it, and finer ones than these look like teeth.
const WAVES: std::ops::RangeInclusive<u32> = 2..=8;
/// The amplitude of wave k falls as k to minus this: less is frayed, more is a bean.
const FALL: f64 = 0.9;
/// The part that is left of the longest wave's amplitude: at full strength it makes hourglasses.
const LONGEST: f64 = 0.5;
/// Strongest swelling and dent that bisection tries, as the logarithm of the radius.
const STRONGEST: f64 = 0.5;
/// Corners of the polygon: on an exemplar of 4096 pixels it stays within 0.1 pixels of the smooth curve.
const CORNERS: usize = 1024;

/// A random splotch in the rectangle from `low` to `high`; `feather` is the width of its transition.
pub(super) fn splotch(low: Vec2, high: Vec2, feather: f32, fill: Fill, random: &mut Random) -> Vec<Vec2> {
    let share = random.range(fill.share[0], fill.share[1]);
    let waves: Vec<[f64; 3]> = WAVES
        .map(|k| {
            let part = if k == *WAVES.start() { LONGEST } else { 1.0 };
            let k = f64::from(k);
            [k, part * random.range(0.4, 1.0) * k.powf(-FALL), random.range(0.0, TAU)]
        })
        .collect();
    let power: f64 = waves.iter().map(|[_, a, _]| a * a / 2.0).sum();
    let profile: Vec<DVec2> = (0..CORNERS)
        .map(|i| {
            let angle = TAU * i as f64 / CORNERS as f64;
            let wave: f64 = waves.iter().map(|[k, a, phase]| a * (k * angle + phase).cos()).sum();
            DVec2::new(angle, wave / power.sqrt())
        })
        .collect();
    let (low, size) = (low.as_dvec2(), (high - low).as_dvec2());
    let outline =
        |strength: f64| fit(profile.iter().map(|p| corner(p.x, fill.roundness, (strength * p.y).exp())).collect(), low, size);
    let area = |strength: f64| opaque_area(&outline(strength), f64::from(feather));
    let wanted = (share * size.x * size.y).min(DENTED * area(0.0));
    let (mut weak, mut strong) = (0.0, STRONGEST);
    for _ in 0..24 {
        let middle = 0.5 * (weak + strong);
        if area(middle) > wanted { weak = middle } else { strong = middle }
    }
    outline(weak).iter().map(|p| p.as_vec2()).collect()
}

/// A point of the superellipse of radius 1, moved out by a factor.
fn corner(angle: f64, roundness: f64, factor: f64) -> DVec2 {
    let (sin, cos) = angle.sin_cos();
    let radius = (sin.abs().powf(roundness) + cos.abs().powf(roundness)).powf(-1.0 / roundness);
    DVec2::new(cos, sin) * radius * factor
}

/// Moves and stretches points so that they just fill a rectangle.
fn fit(mut points: Vec<DVec2>, low: DVec2, size: DVec2) -> Vec<DVec2> {
    let from = points.iter().fold(DVec2::INFINITY, |m, &p| m.min(p));
    let to = points.iter().fold(DVec2::NEG_INFINITY, |m, &p| m.max(p));
    let scale = size / (to - from);
    for p in &mut points {
        *p = low + (*p - from) * scale;
    }
    points
}

/// The area inside a feather, by its first-order estimate.
fn opaque_area(points: &[DVec2], feather: f64) -> f64 {
    let perimeter: f64 = (0..points.len()).map(|i| points[i].distance(points[(i + 1) % points.len()])).sum();
    super::collapse::signed_area(points).abs() - feather * perimeter
}
