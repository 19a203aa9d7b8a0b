//! What coverage is told about masks never promises more than bilinear alpha holds, and not much less.

use glam::Vec2;
use lapped::exemplar::mask::ERODED_RADII;
use lapped::exemplar::{CoverageMask, Image};
use lapped::random::Random;
use proptest::prelude::*;

/// A soft blob with a hole and some noise, 0 at the border.
fn mask(seed: u64, width: u32, height: u32, feather: f32, noise: f64) -> Image {
    let mut random = Random::new(seed, 0);
    let size = Vec2::new(width as f32, height as f32);
    let mut spot = |least: f32, most: f32| {
        let at = Vec2::new(random.unit() as f32, random.unit() as f32) * size;
        (at, random.range(f64::from(least), f64::from(most)) as f32)
    };
    let discs: Vec<(Vec2, f32)> = (0..3).map(|_| spot(6.0, 20.0)).collect();
    let hole = spot(0.0, 5.0);
    Image::grey_from_fn(width, height, |x, y| {
        if x == 0 || y == 0 || x + 1 == width || y + 1 == height {
            return 0.0;
        }
        let p = Vec2::new(x as f32, y as f32) + 0.5;
        let depth = discs.iter().map(|(c, r)| r - p.distance(*c)).fold(f32::NEG_INFINITY, f32::max);
        let depth = depth.min(p.distance(hole.0) - hole.1);
        let alpha = (depth / feather).clamp(0.0, 1.0);
        let alpha = if random.unit() < noise { random.unit() as f32 } else { alpha };
        (alpha * 255.0).round() / 255.0
    })
}

fn true_alpha(image: &Image, at: Vec2) -> f32 {
    image.bilinear(at).x
}

/// Points over the disc, its rim included.
fn disc(at: Vec2, radius: f32) -> impl Iterator<Item = Vec2> {
    (0..=10).flat_map(move |ring| {
        let r = radius * ring as f32 / 10.0;
        (0..48).map(move |i| at + Vec2::from_angle(i as f32 * std::f32::consts::TAU / 48.0) * r)
    })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 48, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn never_promises_more_than_alpha_holds(
        seed in any::<u64>(), width in 3_u32..60, height in 3_u32..60, feather in 0.5_f32..8.0, noisy in any::<bool>(),
    ) {
        let image = mask(seed, width, height, feather, if noisy { 0.02 } else { 0.0 });
        let coverage = CoverageMask::of_image(&image);
        let mut random = Random::new(seed, 1);
        for _ in 0..150 {
            let at = Vec2::new(
                random.range(-8.0, f64::from(width) + 8.0) as f32,
                random.range(-8.0, f64::from(height) + 8.0) as f32,
            );
            prop_assert!((coverage.alpha(at) - true_alpha(&image, at)).abs() < 1e-5, "alpha at {at}");
            let depth = coverage.depth(at);
            for p in disc(at, depth.abs() * 0.9999) {
                let alpha = true_alpha(&image, p);
                prop_assert!(depth <= 0.0 || alpha >= 254.0 / 255.0 - 1e-5, "depth {depth} at {at}, alpha {alpha} at {p}");
                prop_assert!(depth >= 0.0 || alpha <= 1e-5, "depth {depth} at {at}, alpha {alpha} at {p}");
            }
            let radius = random.range(0.0, 14.0) as f32;
            for radius in [radius, radius * 0.1, ERODED_RADII[0]] {
                let (least, most) = disc(at, radius)
                    .map(|p| true_alpha(&image, p))
                    .fold((f32::INFINITY, 0.0_f32), |(least, most), a| (least.min(a), most.max(a)));
                let eroded = coverage.eroded_alpha(at, radius);
                prop_assert!(f32::from(eroded) <= least * 255.0 + 1e-2, "{eroded} at {at} within {radius}, alpha is {least}");
                prop_assert!(coverage.touches(at, radius) || most <= 1e-5, "alpha {most} within {radius} of {at}");
            }
        }
    }
}

#[test]
fn promises_are_nearly_as_much_as_alpha_holds() {
    // A disc of radius 40 with a feather of 4: true depth is known everywhere.
    let (middle, radius, feather) = (Vec2::splat(48.0), 40.0, 4.0);
    let image = Image::grey_from_fn(96, 96, |x, y| {
        let depth = radius - (Vec2::new(x as f32, y as f32) + 0.5).distance(middle);
        ((depth / feather).clamp(0.0, 1.0) * 255.0).round() / 255.0
    });
    let coverage = CoverageMask::of_image(&image);
    let mut random = Random::new(5, 0);
    for _ in 0..2000 {
        let at = Vec2::new(random.range(0.0, 96.0) as f32, random.range(0.0, 96.0) as f32);
        let depth = radius - at.distance(middle);
        // A square between pixel centres is opaque or not as a whole, and a cell answers for its worst point: each at
        // most a diagonal; steps of depth and the ramp's last half level add a little.
        let lost = 2.0 * std::f32::consts::SQRT_2 + 0.1;
        assert!(coverage.depth(at) >= depth - feather - lost, "depth {} at {at}, truly {}", coverage.depth(at), depth - feather);
        assert!(-coverage.depth(at) >= -depth - lost, "depth {} at {at}, truly {depth}", coverage.depth(at));
        for (level, r) in ERODED_RADII.into_iter().enumerate() {
            // A cell answers for its worst point, a diagonal away; a lattice square reaches a diagonal of its own too far;
            // and between pixels the ramp's bend is cut.
            let lost = std::f32::consts::SQRT_2 * (1.0 + [0.25, 0.25, 0.5, 1.0, 1.0][level]) + 0.3;
            let least = ((depth - r - lost) / feather).clamp(0.0, 1.0) * 255.0;
            let eroded = coverage.eroded_alpha(at, r);
            assert!(f32::from(eroded) >= least.min(254.0) - 1.5, "{eroded} at {at} within {r}, at least {least} should be known");
        }
        let far = coverage.eroded_alpha(at, 20.0);
        assert_eq!(far >= 254, coverage.depth(at) >= 20.0, "beyond the kept radii only depth knows");
    }
}

#[test]
fn nothing_is_opaque_in_tiny_or_empty_masks() {
    for (w, h) in [(1, 1), (2, 2), (1, 9), (5, 5)] {
        let coverage = CoverageMask::of_image(&Image::grey_from_fn(w, h, |_, _| 0.0));
        for at in [Vec2::ZERO, Vec2::splat(0.7), Vec2::new(-3.0, 80.0), Vec2::NAN, Vec2::INFINITY] {
            assert_eq!((coverage.alpha(at), coverage.eroded_alpha(at, 0.1)), (0.0, 0), "empty {w} x {h} at {at}");
            assert!(!coverage.touches(at, 1e3) || at.is_nan(), "nothing to touch in {w} x {h} at {at}");
        }
    }
    let full = CoverageMask::of_image(&Image::grey_from_fn(2, 2, |_, _| 1.0));
    assert_eq!(full.alpha(Vec2::ONE), 0.0, "a border is transparent");
}
