//! Hulls of texture patches: they hold all alpha, are simple, small, and answer segment queries like brute force.

use glam::{IVec2, Vec2};
use lapped::exemplar::hull::{HULL_EXTRA_AREA, HULL_MOST_VERTICES, HULL_VERTICES};
use lapped::exemplar::{Hull, Image};
use lapped::random::Random;
use proptest::prelude::*;

/// Random blobs of a kind: 0 round spots, 1 spikes from the middle, 2 a spiral (deeply concave), 3 ragged noise around a core.
fn blob(kind: u32, seed: u64, size: u32) -> Image {
    let mut random = Random::new(seed, u64::from(kind));
    let s = size as f32;
    let mut unit = || random.unit() as f32;
    let spots: Vec<(Vec2, f32)> =
        (0..6).map(|_| (Vec2::new(unit(), unit()) * s * 0.4 + s * 0.3, s * (0.05 + 0.15 * unit()))).collect();
    let turn = unit() * 6.0;
    let spikes = 5.0 + (unit() * 9.0).floor();
    let noise: Vec<f32> = (0..size * size).map(|_| unit()).collect();
    Image::grey_from_fn(size, size, |x, y| {
        if x < 2 || y < 2 || x + 2 >= size || y + 2 >= size {
            return 0.0;
        }
        let p = Vec2::new(x as f32, y as f32) + 0.5;
        let (d, angle) = (p.distance(Vec2::splat(s / 2.0)), (p - s / 2.0).to_angle());
        let inside = match kind {
            0 => spots.iter().any(|(c, r)| p.distance(*c) < *r || p.distance(c.lerp(Vec2::splat(s / 2.0), 0.5)) < *r),
            1 => d < s * 0.1 || (d < s * 0.48 && (spikes * angle + turn).cos() > 0.2 + d / s),
            2 => d < s * 0.46 && ((d / s * 25.0 - angle + turn).rem_euclid(std::f32::consts::TAU) < 2.5 || d < s * 0.06),
            _ => d < s * 0.3 || (d < s * 0.45 && noise[(y * size + x) as usize] > 0.55),
        };
        if inside { 1.0 } else { 0.0 }
    })
}

/// The mask's piece that the hull is of: the one of the first pixel with alpha, corner contact counted.
fn first_piece(mask: &Image) -> Vec<bool> {
    let [w, h] = mask.size().map(i64::from);
    let mut piece = vec![false; (w * h) as usize];
    let first = (0..w * h).find(|i| mask.grey(i % w, i / w) > 0.0);
    let mut open: Vec<i64> = first.into_iter().collect();
    while let Some(i) = open.pop() {
        if std::mem::replace(&mut piece[i as usize], true) {
            continue;
        }
        for (dx, dy) in [(-1, -1), (0, -1), (1, -1), (-1, 0), (1, 0), (-1, 1), (0, 1), (1, 1)] {
            let (x, y) = (i % w + dx, i / w + dy);
            if (0..w).contains(&x) && (0..h).contains(&y) && mask.grey(x, y) > 0.0 {
                open.push(y * w + x);
            }
        }
    }
    piece
}

fn cross(a: Vec2, b: Vec2, c: Vec2) -> f64 {
    (b.as_dvec2() - a.as_dvec2()).perp_dot(c.as_dvec2() - a.as_dvec2())
}

fn is_simple(points: &[Vec2]) -> bool {
    let n = points.len();
    let apart = |a: Vec2, b: Vec2, c: Vec2, d: Vec2| {
        a.max(b).cmplt(c.min(d)).any()
            || c.max(d).cmplt(a.min(b)).any()
            || cross(a, b, c) * cross(a, b, d) > 0.0
            || cross(c, d, a) * cross(c, d, b) > 0.0
    };
    (0..n).all(|i| (i + 2..n).all(|j| (j + 1) % n == i || apart(points[i], points[i + 1], points[j], points[(j + 1) % n])))
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn holds_all_alpha_within_the_budget(kind in 0_u32..4, seed in any::<u64>(), size in 12_u32..90) {
        let mask = blob(kind, seed, size);
        let piece = first_piece(&mask);
        let origin = IVec2::new(-3, 7);
        if let Some(hull) = Hull::of_mask(&mask, origin) {
            let (w, shift) = (size as usize, origin.as_vec2());
            prop_assert!(is_simple(hull.points()), "crosses itself: {:?}", hull.points());
            prop_assert!(hull.points().len() <= HULL_MOST_VERTICES, "{} vertices", hull.points().len());
            // What bilinear filtering shows: the square of two pixels around each pixel's centre.
            let reached = 1.0 - 1e-3;
            for i in (0..piece.len()).filter(|&i| piece[i]) {
                let centre = Vec2::new((i % w) as f32, (i / w) as f32) + 0.5 + shift;
                for corner in [Vec2::ZERO, Vec2::new(1.0, 1.0), Vec2::new(-1.0, 1.0), Vec2::new(1.0, -1.0), Vec2::new(-1.0, -1.0)] {
                    prop_assert!(hull.contains(centre + corner * reached), "alpha at {} lies outside", centre + corner * reached);
                }
            }
            // Counter-clockwise with y up.
            let turn: f64 = (1..hull.points().len() - 1).map(|i| cross(hull.points()[0], hull.points()[i], hull.points()[i + 1])).sum();
            prop_assert!(turn < 0.0, "clockwise with y up");
        } else {
            prop_assert!(piece.iter().all(|p| !p), "no hull although there is alpha");
        }
    }

    #[test]
    fn crossing_agrees_with_brute_force(kind in 0_u32..4, seed in any::<u64>(), lattice in any::<bool>()) {
        let Some(hull) = Hull::of_mask(&blob(kind, seed, 40), IVec2::ZERO) else { return Ok(()) };
        let mut random = Random::new(seed, 99);
        for _ in 0..60 {
            let mut point = || {
                let p = Vec2::new(random.range(-6.0, 46.0) as f32, random.range(-6.0, 46.0) as f32);
                // On the lattice of the contour many segments touch corners and run along sides.
                if lattice { p.floor() + 0.5 } else { p }
            };
            let (a, b) = (point(), point());
            // Many points along the segment; one deeper inside than rounding decides it.
            let depth = |p: Vec2| {
                let n = hull.points().len();
                let sides = (0..n).map(|i| (hull.points()[i], hull.points()[(i + 1) % n]));
                sides.map(|(s, e)| {
                    let t = ((p - s).dot(e - s) / (e - s).length_squared()).clamp(0.0, 1.0);
                    s.lerp(e, t).distance(p)
                }).fold(f32::INFINITY, f32::min)
            };
            let samples: Vec<Vec2> = (0..=600).map(|i| a.lerp(b, i as f32 / 600.0)).collect();
            let deepest = samples.iter().filter(|&&p| hull.contains(p)).map(|&p| depth(p)).fold(0.0, f32::max);
            let found = hull.crosses_interior(a, b);
            if deepest > 1e-3 {
                prop_assert!(found, "{a} to {b} passes inside {deepest} deep");
            }
            if found {
                // What lies between samples is shorter than their distance.
                let nearest = samples.iter().map(|&p| if hull.contains(p) { 0.0 } else { depth(p) }).fold(f32::INFINITY, f32::min);
                prop_assert!(nearest < 0.1, "{a} to {b} stays {nearest} away");
            }
        }
    }
}

#[test]
fn smooth_shapes_need_few_vertices_and_little_area() {
    for size in [64_u32, 256, 1024] {
        let middle = Vec2::splat(size as f32 / 2.0);
        let radius = size as f32 * 0.45;
        let disc = Image::grey_from_fn(size, size, |x, y| {
            let d = (Vec2::new(x as f32, y as f32) + 0.5).distance(middle);
            (radius - d).clamp(0.0, 1.0)
        });
        let hull = Hull::of_mask(&disc, IVec2::ZERO).expect("has alpha");
        // On the smallest the stairs of pixels are a large part of the area, so the area's budget ends first.
        let most = if size < 100 { 2 * HULL_VERTICES } else { HULL_VERTICES };
        assert!(hull.points().len() <= most, "{} vertices at {size}", hull.points().len());
        // The contour runs up to a pixel outside the disc.
        let least = std::f64::consts::PI * f64::from(radius).powi(2);
        let most = std::f64::consts::PI * f64::from(radius + 1.5).powi(2) * (1.0 + HULL_EXTRA_AREA);
        assert!((least..most).contains(&hull.area()), "area {} at {size}, not in {least}..{most}", hull.area());
    }
}

#[test]
fn holes_are_filled_and_one_pixel_is_enough() {
    let ring = Image::grey_from_fn(32, 32, |x, y| {
        let d = Vec2::new(x as f32, y as f32).distance(Vec2::splat(15.5));
        if (8.0..12.0).contains(&d) { 1.0 } else { 0.0 }
    });
    let hull = Hull::of_mask(&ring, IVec2::ZERO).expect("has alpha");
    assert!(hull.contains(Vec2::splat(16.0)), "the hole belongs to the hull");
    let pixel = Image::grey_from_fn(5, 5, |x, y| if (x, y) == (2, 2) { 0.01 } else { 0.0 });
    let hull = Hull::of_mask(&pixel, IVec2::ZERO).expect("has alpha");
    assert_eq!((hull.points().len(), hull.area()), (4, 4.0), "the square that bilinear filtering reaches");
    assert!(Hull::of_mask(&Image::grey_from_fn(5, 5, |_, _| 0.0), IVec2::ZERO).is_none(), "no alpha, no hull");
}

#[test]
fn touching_the_boundary_is_not_crossing() {
    let l = |points: &[[f32; 2]]| Hull::new(points.iter().map(|&p| Vec2::from_array(p)).collect());
    // An L, so that a line along one side meets the interior further on.
    let hull = l(&[[0.0, 0.0], [4.0, 0.0], [4.0, 2.0], [2.0, 2.0], [2.0, 4.0], [0.0, 4.0]]);
    let crosses = |a: [f32; 2], b: [f32; 2]| hull.crosses_interior(a.into(), b.into());
    assert!(!crosses([-1.0, 0.0], [5.0, 0.0]), "along a side and beyond");
    assert!(!crosses([3.0, 5.0], [5.0, 1.0]), "outside near a corner");
    assert!(!crosses([4.0, 0.0], [4.0, 2.0]), "a side itself");
    assert!(!crosses([2.0, 4.0], [4.0, 2.0]), "between two corners across the notch");
    assert!(crosses([5.0, 2.0], [-1.0, 2.0]), "along a side, then inside");
    assert!(crosses([2.0, 2.0], [0.0, 0.0]), "from corner to corner through the inside");
    assert!(crosses([1.0, 1.0], [1.5, 1.0]), "all inside");
    assert!(crosses([-1.0, 3.0], [3.0, 3.0]), "across an arm");
    assert!(!crosses([3.0, 3.0], [3.5, 3.5]), "in the notch");
    assert!(!crosses([1.0, 4.0], [1.0, 5.0]), "from a side outward");
    assert!(!crosses([3.0, 2.0], [3.0, 2.0]), "a point on a side");
    assert!(crosses([1.0, 1.0], [1.0, 1.0]), "a point inside");
}
