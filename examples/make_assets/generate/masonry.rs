//! Exemplars of stone and clay: bricks, a stone wall, pebbles.

use super::noise::{cells, fractal, ridged, step, unit};
use super::portable::{cos, pow, sin};
use super::relief::{Light, Matter, Pictures, Relief, pick, srgb};
use lapped::random::Random;
use std::f64::consts::TAU;

/// A running bond of old bricks.
pub(crate) fn bricks() -> Pictures {
    const COLUMNS: i64 = 3;
    const ROWS: i64 = 8;
    const CLAY: [u32; 7] = [0x00A3_5440, 0x0094_4533, 0x00B0_664A, 0x007D_382C, 0x00A8_5F48, 0x006B_352D, 0x00BC_7A5A];
    let relief = Relief::from_fn(384, |at| {
        let wobble = [fractal(at, [5, 5], 2, 1) * 0.0025, fractal(at, [5, 5], 2, 2) * 0.0025];
        let (u, v) = (at[0] + wobble[0], at[1] + wobble[1]);
        let row = (v * ROWS as f64).floor() as i64;
        let shift = if row.rem_euclid(2) == 1 { 0.5 } else { 0.0 };
        let column = (u * COLUMNS as f64 + shift).floor() as i64;
        let (r, c) = (row.rem_euclid(ROWS), column.rem_euclid(COLUMNS));
        let own = |seed: u64| unit(c, r, seed);
        let x = (u * COLUMNS as f64 + shift - column as f64 - 0.5) / COLUMNS as f64 + 0.004 * (own(3) - 0.5);
        let y = (v * ROWS as f64 - row as f64 - 0.5) / ROWS as f64 + 0.003 * (own(4) - 0.5) + x * 0.02 * (own(5) - 0.5);
        let half = [0.5 / COLUMNS as f64 - 0.0085 - 0.003 * own(6), 0.5 / ROWS as f64 - 0.0085 - 0.002 * own(7)];
        // Distance to a rounded rectangle with worn edges.
        let (qx, qy) = (x.abs() - half[0] + 0.008, y.abs() - half[1] + 0.008);
        let out = (qx.max(0.0) * qx.max(0.0) + qy.max(0.0) * qy.max(0.0)).sqrt() + qx.max(qy).min(0.0) - 0.008;
        let worn = out + 0.0035 * fractal(at, [26, 26], 3, 8) + 0.005 * step(0.35, 0.8, fractal(at, [11, 11], 2, 9));
        let grit = fractal(at, [96, 96], 2, 10);
        let mortar_height = 0.0035 + 0.0014 * fractal(at, [30, 30], 3, 11) + 0.0012 * grit;
        let pit = cells(at, [64, 64], 1.0, 12);
        let pitted = if unit(pit.id as i64, 0, 13) < 0.16 { step(0.42, 0.1, pit.nearest) } else { 0.0 };
        let face = 0.014
            + 0.004 * (own(14) - 0.5)
            + x * 0.03 * (own(15) - 0.5)
            + y * 0.06 * (own(16) - 0.5)
            + 0.0011 * fractal(at, [24, 24], 4, 17)
            + 0.0006 * grit
            - 0.0028 * pitted;
        let rise = step(0.0015, -0.011, worn);
        let brick = step(0.0012, -0.0012, worn);
        let height = mortar_height + (face - mortar_height) * rise;
        let mottle = fractal(at, [9, 9], 4, 18 + (own(19) * 5.0) as u64);
        let mut clay = pick(&CLAY, own(20)) * (0.86 + 0.3 * own(21));
        clay = clay.lerp(srgb(0x0050_2A24), 0.6 * step(0.1, 0.75, mottle));
        clay = clay.lerp(srgb(0x00C9_8D6B), 0.45 * step(0.05, 0.8, -mottle));
        // Lime bloom.
        clay =
            clay.lerp(srgb(0x00C9_B8A6), 0.4 * step(0.25, 0.9, fractal(at, [4, 6], 4, 22)) * (0.4 + 0.6 * step(-0.03, 0.0, worn)));
        let speck = unit((u * 900.0) as i64, (v * 900.0) as i64, 23);
        clay *= (1.0 + 0.16 * grit) * (1.0 - 0.35 * pitted) * if speck > 0.985 { 1.5 } else { 1.0 };
        let mut lime = srgb(0x00AD_A294) * (1.0 + 0.22 * grit + 0.14 * fractal(at, [12, 12], 3, 24));
        lime = lime.lerp(srgb(0x0074_6A5E), 0.5 * step(0.1, 0.8, fractal(at, [6, 6], 3, 25)));
        Matter { height, albedo: lime.lerp(clay, brick), gloss: 0.04 }
    });
    relief.photograph(Light { sun: 0.34, occlusion: 1.0 }, 900)
}

/// A dry wall of field stones in rough courses.
pub(crate) fn stone() -> Pictures {
    const ROCK: [u32; 8] = [0x0093_8C80, 0x00A8_9C88, 0x007C_7A76, 0x00B3_A58C, 0x0086_7B6B, 0x009C_9690, 0x006E_6C69, 0x00A1_8E74];
    let relief = Relief::from_fn(384, |at| {
        let warped = [at[0] + 0.016 * fractal(at, [5, 5], 3, 31), at[1] + 0.011 * fractal(at, [6, 6], 3, 32)];
        let cell = cells(warped, [5, 8], 0.72, 33);
        let own = |seed: u64| unit(cell.id as i64, 1, seed);
        // The lattice is finer downwards; widths are those of its wider side.
        let border = cell.border / 6.5 + 0.0035 * fractal(at, [22, 22], 3, 34) + 0.004 * fractal(at, [6, 6], 2, 30) - 0.006;
        let grit = fractal(at, [110, 110], 2, 35);
        let facets = cells([at[0] + 0.01 * fractal(at, [9, 9], 2, 36), at[1]], [17, 22], 1.0, 37);
        let facet = |seed: u64| unit(facets.id as i64, 2, seed) - 0.5;
        let chiselled = (facets.offset[0] * facet(38) + facets.offset[1] * facet(39)) * 0.006;
        let bulge = 0.034 * pow(step(0.0, 0.075, border), 0.7);
        let tilt = cell.offset[0] * 0.014 * (own(40) - 0.5) + cell.offset[1] * 0.014 * (own(41) - 0.5);
        let rough = 0.0045 * fractal(at, [14, 14], 5, 42) + 0.0035 * (ridged(at, [7, 9], 4, 43) - 0.6) + 0.0007 * grit;
        let inside = step(-0.002, 0.003, border);
        let earth = 0.006 + 0.003 * fractal(at, [40, 40], 3, 44);
        let height = earth + (bulge + tilt + chiselled + rough + 0.008 * own(45)).max(-0.001) * inside;
        let mut rock = pick(&ROCK, own(46)) * (0.78 + 0.4 * own(47));
        let bands = fractal([warped[0], warped[1]], [3, 16], 3, 48 + (own(49) * 9.0) as u64);
        rock *= 1.0 + 0.2 * bands + 0.22 * fractal(at, [16, 16], 4, 50) + 0.16 * grit;
        rock = rock.lerp(srgb(0x00A8_7B4D), 0.45 * step(0.3, 0.95, fractal(at, [6, 6], 4, 51)));
        // Lichen: pale crusts with a lobed outline.
        let lichen = step(0.5, 0.62, fractal(at, [7, 7], 4, 52) + 0.25 * fractal(at, [30, 30], 2, 53));
        rock = rock.lerp(srgb(0x00B9_BC9A) * (1.0 + 0.2 * grit), 0.65 * lichen);
        // Moss in the joints.
        let damp = step(0.05, 0.6, fractal(at, [4, 4], 3, 54)) * step(0.022, -0.004, border);
        let soil = srgb(0x0078_6C5A) * (1.0 + 0.35 * grit);
        let albedo = soil.lerp(rock, inside).lerp(srgb(0x0055_6330) * (1.0 + 0.4 * grit), 0.75 * damp);
        Matter { height: height + 0.003 * damp, albedo, gloss: 0.05 }
    });
    relief.photograph(Light { sun: 0.38, occlusion: 1.0 }, 901)
}

/// River pebbles, small between large.
pub(crate) fn pebbles() -> Pictures {
    const RIVER: [u32; 10] = [
        0x008C_8880,
        0x00A0_9078,
        0x0068_6A6C,
        0x00C4_B8A4,
        0x0086_6E58,
        0x0054_5658,
        0x00B0_9A86,
        0x0098_9C9C,
        0x007A_5A4A,
        0x00D6_D0C4,
    ];
    let mut relief = Relief::from_fn(384, |at| Matter {
        height: 0.003 * fractal(at, [40, 40], 3, 60),
        albedo: srgb(0x004A_4238) * (1.0 + 0.3 * fractal(at, [120, 120], 2, 61)),
        gloss: 0.0,
    });
    let mut random = Random::new(62, 0);
    let mut placed: Vec<([f64; 2], f64)> = Vec::new();
    for attempt in 0..6000 {
        // Large ones first, as they would be found; the last are gravel.
        let share = f64::from(attempt) / 6000.0;
        let largest = 0.088 * pow(1.0 - share, 2.2) + 0.013;
        let radius = largest * random.range(0.75, 1.0);
        let centre = [random.unit(), random.unit()];
        let apart = |a: f64, b: f64| {
            let d = (a - b).abs();
            d.min(1.0 - d)
        };
        let free = placed.iter().all(|&(c, r)| {
            let (dx, dy) = (apart(c[0], centre[0]), apart(c[1], centre[1]));
            dx * dx + dy * dy > 0.8 * (r + radius) * (r + radius)
        });
        if free {
            placed.push((centre, radius));
        }
    }
    for (i, &(centre, radius)) in placed.iter().enumerate() {
        let own = |seed: u64| unit(i as i64, 3, seed);
        let (turn, squash) = (TAU * own(63), 0.78 + 0.3 * own(64));
        let (c, s) = (cos(turn), sin(turn));
        let base = 0.008 * own(65) - 0.25 * radius * (1.0 - squash) + 0.22 * (0.03 - radius).max(0.0);
        let vein = TAU * own(66);
        let kind = own(67);
        relief.stamp(centre, radius * 1.35, |[dx, dy]| {
            let (x, y) = ((c * dx + s * dy) / radius, (c * dy - s * dx) / (radius * squash));
            let here = [centre[0] + dx, centre[1] + dy].map(|t| t.rem_euclid(1.0));
            let lump = 0.13 * fractal(here, [9, 9], 2, 68 + i as u64 % 7);
            // Between an ellipse and a rounded box.
            let rho = pow(pow(x.abs(), 2.6) + pow(y.abs(), 2.6), 1.0 / 2.6) + lump;
            if rho >= 1.0 {
                return None;
            }
            let dome = pow(1.0 - pow(rho, 2.3), 0.62);
            let grit = fractal(here, [130, 130], 2, 70);
            let mut rock = pick(&RIVER, own(71)) * (0.8 + 0.35 * own(72));
            rock *= 1.0 + 0.16 * fractal(here, [18, 18], 4, 73 + i as u64 % 5) + (0.08 + 0.3 * step(0.6, 0.9, kind)) * grit;
            // Some carry a white vein, some are banded.
            let across = x * cos(vein) + y * sin(vein) + 0.25 * fractal(here, [12, 12], 3, 74);
            if kind < 0.1 {
                rock = rock.lerp(srgb(0x00DD_D8CC), 0.6 * step(0.09, 0.02, (across - 0.2 * own(75)).abs()));
            } else if kind < 0.42 {
                rock *= 1.0 + 0.22 * sin(across * (9.0 + 10.0 * own(76)));
            }
            let height = base + radius * (0.34 + 0.2 * own(77)) * dome + 0.0005 * grit;
            Some(Matter { height, albedo: rock * (0.72 + 0.28 * dome), gloss: 0.1 + 0.2 * own(78) })
        });
    }
    relief.photograph(Light { sun: 0.36, occlusion: 1.0 }, 902)
}
