//! Exemplars of plants: leaves, wood, bark.

use super::noise::{cells, fractal, gradient, ridged, step, unit};
use super::portable::{cos, exp, pow, sin};
use super::relief::{Light, Matter, Pictures, Relief, pick, srgb};
use lapped::random::Random;
use std::f64::consts::TAU;

/// A thicket of leaves that point every way.
pub(crate) fn leaves() -> Pictures {
    const GREEN: [u32; 7] = [0x003F_7028, 0x0054_8A30, 0x002E_5A26, 0x006C_9A38, 0x0048_7C34, 0x0086_A640, 0x0036_662E];
    let mut relief = Relief::from_fn(384, |at| Matter {
        height: -0.12 + 0.01 * fractal(at, [20, 20], 3, 301),
        albedo: srgb(0x001C_2412),
        gloss: 0.0,
    });
    let mut random = Random::new(302, 0);
    for i in 0..420_u64 {
        // Later leaves lie higher.
        let level = i as f64 / 420.0;
        let centre = [random.unit(), random.unit()];
        let turn = random.range(0.0, TAU);
        let (c, s) = (cos(turn), sin(turn));
        let long = random.range(0.062, 0.098);
        let broad = random.range(0.5, 0.62);
        let (tilt_x, tilt_y, curl) = (random.range(-0.22, 0.22), random.range(-0.3, 0.3), random.range(0.05, 0.3));
        let bow = random.range(-0.16, 0.16);
        let mut green = pick(&GREEN, random.unit()) * random.range(0.75, 1.2) * (0.6 + 0.5 * level);
        if random.unit() < 0.06 {
            green = green.lerp(srgb(0x00C2_A83A), random.range(0.4, 0.9));
        }
        let base = -0.1 + 0.1 * level;
        relief.cover(centre, long * 1.12, |[dx, dy]| {
            // Along the midrib from stalk (-1) to tip (1), and across.
            let t = (c * dx + s * dy) / long;
            let across = (c * dy - s * dx) / long - bow * (1.0 - t * t);
            if t.abs() >= 1.0 {
                return None;
            }
            let teeth = 0.035 * (1.0 - (2.0 * (t * 9.0 - (t * 9.0).floor()) - 1.0).abs());
            let half = broad * pow(1.0 - t * t, 0.62) * (1.0 - 0.32 * t) * (1.0 - teeth) - 0.05 * step(0.6, 1.0, t);
            let side = across.abs();
            if side >= half {
                return (side < 0.028 && t < -0.7).then(|| Matter { height: base, albedo: green * 0.8, gloss: 0.1 });
            }
            let here = [centre[0] + dx, centre[1] + dy].map(|x| x.rem_euclid(1.0));
            // Side veins leave the midrib at an angle, bending towards the tip.
            let along = t - 0.62 * side - 0.25 * side * side;
            let phase = along * 3.6 - (along * 3.6).floor();
            let vein = step(0.07, 0.015, (phase - 0.5).abs() * (0.6 + side)) * step(half, half * 0.6, side);
            let rib = step(0.034 - 0.018 * t, 0.008, side);
            let net = cells([here[0], here[1]], [110, 110], 1.0, 303).border;
            let sink = 0.02 * vein + 0.07 * rib;
            let puff = 0.028 * sin(std::f64::consts::PI * phase).abs() * step(0.0, 0.2, side);
            let height =
                base + long * (0.28 * side - curl * t * t - 0.25 * side * side + tilt_x * t + tilt_y * across - sink + puff);
            let mut blade = green * (1.0 + 0.16 * fractal(here, [24, 24], 3, 304 + i % 5) - 0.12 * step(0.12, 0.0, net));
            blade = blade.lerp(srgb(0x00B4_C878), 0.3 * vein + 0.6 * rib);
            blade = blade
                .lerp(srgb(0x0088_6A2C), 0.45 * step(0.05, 0.0, half - side) * step(0.1, 0.6, fractal(here, [14, 14], 2, 305)));
            Some(Matter { height, albedo: blade, gloss: 0.4 })
        });
    }
    relief.photograph(Light { sun: 0.4, occlusion: 0.8 }, 909)
}

/// Planed wood, the grain upright.
pub(crate) fn wood() -> Pictures {
    const RINGS: f64 = 15.0;
    const KNOTS: [([f64; 2], f64); 1] = [([0.3, 0.38], 0.062)];
    let relief = Relief::from_fn(256, |at| {
        // Years run across; they wander along the trunk and part around the knots.
        let mut year = at[0] * RINGS
            + 1.7 * gradient(at, [2, 1], 321)
            + 0.5 * fractal(at, [4, 2], 3, 322)
            + 0.09 * fractal(at, [24, 5], 2, 323);
        let mut heart: f64 = 0.0;
        let mut knot_rings = 0.0;
        for (centre, radius) in KNOTS {
            let wrap = |d: f64| d - d.round();
            let (dx, dy) = (wrap(at[0] - centre[0]), wrap(at[1] - centre[1]) * 0.62);
            let d = (dx * dx + dy * dy).sqrt();
            let near = exp(-d * d / (3.2 * radius * radius));
            year -= near * 58.0 * dx * (1.0 - 0.45 * near);
            let inside = step(radius * 1.05, radius * 0.7, d * (1.0 + 0.12 * fractal(at, [12, 12], 2, 324)));
            if inside > heart {
                heart = inside;
                knot_rings = 0.5 + 0.5 * sin(d / radius * 19.0 + 2.5 * fractal(at, [10, 10], 2, 325));
            }
        }
        let phase = year - year.floor();
        // Pale early wood darkens to late wood, which ends at once.
        let late = pow(phase, 2.6) * step(1.0, 0.95, phase);
        let own = unit((year.floor() as i64).rem_euclid(RINGS as i64), 12, 326);
        let fibre = gradient(at, [150, 5], 327) + 0.7 * gradient(at, [70, 3], 328) + 0.5 * gradient(at, [250, 12], 329);
        let pores = cells([at[0], at[1]], [96, 13], 1.0, 330);
        let open = unit(pores.id as i64, 13, 331) < 0.25 + 0.45 * step(0.55, 0.0, phase);
        let pore = if open { step(0.22, 0.08, pores.offset[0].abs()) * step(0.5, 0.3, pores.offset[1].abs()) } else { 0.0 };
        let mut tone = srgb(0x00CB_9862).lerp(srgb(0x0078_4620), 0.85 * late) * (0.92 + 0.18 * own);
        tone = tone.lerp(srgb(0x00A8_6C3A), 0.4 * step(-0.3, 0.8, fractal(at, [3, 1], 3, 332)));
        tone *= 1.0 + 0.1 * fibre;
        // Rays catch the light.
        let ray = cells(at, [60, 26], 1.0, 333);
        tone *= 1.0 + 0.1 * step(0.3, 0.1, ray.offset[1].abs()) * step(0.2, 0.05, ray.offset[0].abs());
        let knot = srgb(0x007E_4A24).lerp(srgb(0x004A_2814), 0.6 * knot_rings) * (1.0 + 0.1 * fibre);
        tone = tone.lerp(knot, heart);
        tone *= 1.0 - 0.3 * pore;
        Matter { height: 0.0012 * late + 0.0005 * fibre - 0.002 * pore, albedo: tone, gloss: 0.12 }
    });
    relief.photograph(Light { sun: 0.3, occlusion: 0.9 }, 910)
}

/// Furrowed bark, the furrows upright.
pub(crate) fn bark() -> Pictures {
    let relief = Relief::from_fn(256, |at| {
        let sway = 0.05 * fractal(at, [3, 2], 3, 341);
        let warped = [at[0] + sway + 0.012 * fractal(at, [14, 7], 3, 342), at[1] + 0.03 * fractal(at, [6, 4], 2, 343)];
        let plate = cells(warped, [7, 3], 0.95, 344);
        let own = |seed: u64| unit(plate.id as i64, 14, seed);
        let crack = plate.border + 0.1 * fractal(at, [18, 9], 3, 345);
        let furrows = ridged([warped[0], warped[1]], [9, 2], 4, 346);
        let flakes = ridged(warped, [20, 12], 4, 347);
        let grain = fractal(at, [100, 60], 3, 348);
        let body = pow(step(0.0, 0.34, crack), 0.8);
        let height = 0.055 * body + 0.03 * (0.9 - furrows) * body + 0.012 * flakes + 0.003 * grain + 0.012 * own(349);
        let mut wood = srgb(0x0086_7460).lerp(srgb(0x009E_948A), own(350)) * (0.8 + 0.35 * own(351));
        wood = srgb(0x003A_281C).lerp(wood, 0.12 + 0.88 * step(0.0, 0.3, crack));
        wood = wood.lerp(srgb(0x007A_5238), 0.55 * step(0.62, 0.85, furrows));
        wood *= 1.0 + 0.3 * grain + 0.25 * (flakes - 0.6);
        let lichen = step(0.42, 0.6, fractal(at, [6, 6], 4, 352) + 0.3 * grain) * step(0.1, 0.3, crack);
        wood = wood.lerp(srgb(0x00A4_AE8A) * (1.0 + 0.25 * grain), 0.6 * lichen);
        Matter { height, albedo: wood, gloss: 0.02 }
    });
    relief.photograph(Light { sun: 0.36, occlusion: 0.9 }, 911)
}
