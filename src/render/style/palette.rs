//! Colours that tell things apart or carry numbers, mixed where equal steps look equal.
//!
//! Based on: B. Ottosson, "A perceptual color space for image processing", 2020 (Oklab).

use glam::{Mat3, Vec3};

/// What must catch the eye: bare or flipped surface. Linear light.
pub(super) const ALARM: Vec3 = Vec3::new(0.85, 0.0, 0.42);

/// Anchors of the sequential scale, from few to many: lightness, a, b of Oklab.
const SEQUENCE: [Vec3; 4] =
    [Vec3::new(0.95, -0.03, 0.06), Vec3::new(0.78, -0.11, 0.03), Vec3::new(0.55, -0.06, -0.09), Vec3::new(0.30, 0.04, -0.12)];
/// The two ends and the middle of the diverging scale.
const DIVERGING: [Vec3; 5] = [
    Vec3::new(0.42, -0.02, -0.15),
    Vec3::new(0.72, -0.04, -0.08),
    Vec3::new(0.94, 0.0, 0.0),
    Vec3::new(0.72, 0.10, 0.07),
    Vec3::new(0.45, 0.16, 0.09),
];

/// Oklab to linear sRGB, cut to what can be shown.
pub(super) fn from_oklab(lab: Vec3) -> Vec3 {
    let cone = Mat3::from_cols(
        Vec3::ONE,
        Vec3::new(0.396_337_78, -0.105_561_346, -0.089_484_18),
        Vec3::new(0.215_803_76, -0.063_854_17, -1.291_485_5),
    );
    let light = Mat3::from_cols(
        Vec3::new(4.076_741_7, -1.268_438, -0.004_196_086_3),
        Vec3::new(-3.307_711_6, 2.609_757_4, -0.703_418_6),
        Vec3::new(0.230_969_94, -0.341_319_38, 1.707_614_7),
    );
    let root = cone * lab;
    (light * (root * root * root)).clamp(Vec3::ZERO, Vec3::ONE)
}

/// The colour of the n-th of any number of things: hues a golden angle apart, so that all that are near in number differ,
/// and three lightnesses in turn. Linear light.
#[must_use]
pub fn distinct(n: u32) -> Vec3 {
    let turn = (f64::from(n) * 0.618_033_988_749_894_9).fract() * std::f64::consts::TAU;
    let lightness = 0.74 - 0.09 * (n % 3) as f32;
    let (sin, cos) = turn.sin_cos();
    from_oklab(Vec3::new(lightness, 0.125 * cos as f32, 0.125 * sin as f32))
}

/// The sequential scale at 0 (little) to 1 (much), linear light.
#[must_use]
pub fn sequential(t: f32) -> Vec3 {
    along(&SEQUENCE, t)
}

/// The diverging scale at -1 to 1, neutral at 0, linear light.
pub(super) fn diverging(t: f32) -> Vec3 {
    along(&DIVERGING, 0.5 + 0.5 * t)
}

fn along(anchors: &[Vec3], t: f32) -> Vec3 {
    let place = t.clamp(0.0, 1.0) * (anchors.len() - 1) as f32;
    let i = (place as usize).min(anchors.len() - 2);
    from_oklab(anchors[i].lerp(anchors[i + 1], place - i as f32))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn white_black_and_a_primary_come_out_right() {
        assert!((from_oklab(Vec3::X) - Vec3::ONE).length() < 2e-3, "white");
        assert_eq!(from_oklab(Vec3::ZERO), Vec3::ZERO, "black");
        let red = from_oklab(Vec3::new(0.627_96, 0.224_86, 0.125_85));
        assert!((red - Vec3::X).length() < 2e-3, "red: {red}");
    }

    #[test]
    fn numbers_near_each_other_have_colours_far_apart() {
        for n in 0..200 {
            for m in n + 1..n + 5 {
                let distance = (distinct(n) - distinct(m)).length();
                assert!(distance > 0.08, "{n} and {m} are {distance} apart");
            }
        }
    }
}
