//! Exemplars of hide: a reptile's scales and a fox's fur.

use super::noise::{cells, fractal, step, unit};
use super::portable::{cos, exp, pow, sin};
use super::relief::{Light, Matter, Pictures, Relief, pick, srgb};
use lapped::random::Random;
use std::f64::consts::TAU;

/// Keeled scales in offset rows, each lying over the row below it.
pub(crate) fn scales() -> Pictures {
    const COLUMNS: i64 = 9;
    const ROWS: i64 = 14;
    const JADE: [u32; 6] = [0x002F_6B4C, 0x003E_7F55, 0x0025_5C52, 0x0058_8A48, 0x0034_7467, 0x0048_7A3C];
    /// Length of a scale in rows, and its width in columns.
    const LENGTH: f64 = 2.55;
    const WIDTH: f64 = 1.22;
    let relief = Relief::from_fn(384, |at| {
        let bent = [at[0] + 0.006 * fractal(at, [4, 4], 2, 101), at[1] + 0.006 * fractal(at, [4, 4], 2, 102)];
        let (x, y) = (bent[0] * COLUMNS as f64, bent[1] * ROWS as f64);
        let grit = fractal(at, [110, 110], 2, 103);
        let mut found = Matter { height: -0.01, albedo: srgb(0x0018_241C), gloss: 0.0 };
        // The highest row that reaches down to here lies on top.
        for row in (y.floor() as i64 - 3)..=(y.floor() as i64) {
            let shift = 0.5 * row.rem_euclid(2) as f64;
            let column = (x - shift).round() as i64;
            let (r, c) = (row.rem_euclid(ROWS), column.rem_euclid(COLUMNS));
            let own = |seed: u64| unit(c, r, seed);
            let t = (y - row as f64 - 0.2 * (own(104) - 0.5)) / (LENGTH * (0.97 + 0.06 * own(105)));
            let side = (x - shift - column as f64 - 0.05 * (own(106) - 0.5)) / (0.5 * WIDTH);
            // Straight-sided at the root, then drawn to a blunt point.
            let s = ((t - 0.36) / 0.64).max(0.0);
            let reach = pow((1.0 - pow(s, 1.75)).max(0.0), 0.68) * (0.88 + 0.12 * step(0.0, 0.4, t));
            if !(0.0..1.0).contains(&t) || side.abs() >= reach {
                continue;
            }
            // Distance to the rim: sideways, and towards the tip.
            let rim = (reach - side.abs()).min((1.0 - t) * 1.7);
            let keel = exp(-side * side / 0.012) * step(0.0, 0.25, t) * step(1.0, 0.72, t);
            let rings = sin(rim * 42.0 + 2.0 * fractal(at, [20, 20], 2, 107)) * step(0.0, 0.12, rim) * step(0.55, 0.2, rim);
            let height = 0.052 * (t - 0.9) - 0.012 * side * side + 0.0045 * keel + 0.0006 * rings + 0.0003 * grit
                - 0.012 * pow(step(0.24, 0.0, rim), 1.6)
                + 0.004 * (own(108) - 0.5);
            let patch = fractal(at, [3, 3], 3, 109) + 0.5 * (own(110) - 0.5);
            let mut skin = pick(&JADE, own(111)) * (0.8 + 0.4 * own(112));
            skin = skin.lerp(srgb(0x00B0_9440), 0.7 * step(0.12, 0.75, patch));
            skin = skin.lerp(srgb(0x0020_4A50), 0.55 * step(0.15, 0.75, -patch));
            // Dark at the root, pale along rim and keel.
            skin *= 0.62 + 0.5 * step(0.25, 0.8, t);
            skin = skin.lerp(srgb(0x00CF_C67E), 0.42 * step(0.2, 0.03, rim) + 0.22 * keel);
            let mottle = cells(at, [70, 70], 1.0, 113);
            skin *= 1.0 + 0.1 * grit + 0.1 * fractal(at, [36, 36], 3, 114) - 0.12 * step(0.3, 0.1, mottle.nearest) + 0.05 * rings;
            found = Matter { height, albedo: skin, gloss: 0.55 };
            break;
        }
        found
    });
    relief.photograph(Light { sun: 0.36, occlusion: 0.9 }, 903)
}

/// A strand of hair: a bent, tapered line that rises from root to tip.
struct Strand {
    root: [f64; 2],
    /// From root to tip, widths.
    run: [f64; 2],
    /// Sideways bulge of the middle, widths.
    bend: f64,
    width: f64,
    low: f64,
    rise: f64,
}

impl Strand {
    /// Lays it down; `colour` gets the position along it, 0 to 1.
    fn lay(&self, relief: &mut Relief, colour: impl Fn(f64) -> glam::DVec3, gloss: f64) {
        let length = (self.run[0] * self.run[0] + self.run[1] * self.run[1]).sqrt();
        let steps = (length / 0.0018).ceil().max(2.0) as usize;
        for i in 0..=steps {
            let t = i as f64 / steps as f64;
            let bow = self.bend * 4.0 * t * (1.0 - t);
            let centre = [
                self.root[0] + self.run[0] * t - self.run[1] / length * bow,
                self.root[1] + self.run[1] * t + self.run[0] / length * bow,
            ];
            let half = 0.5 * self.width * (1.0 - 0.75 * t * t);
            let (height, albedo) = (self.low + self.rise * t, colour(t));
            relief.stamp(centre, half, |[dx, dy]| {
                let across = (dx * dx + dy * dy) / (half * half);
                (across < 1.0).then(|| Matter {
                    height: height + half * 0.6 * (1.0 - across).sqrt(),
                    albedo: albedo * (1.0 - 0.25 * across),
                    gloss,
                })
            });
        }
    }
}

/// Thick fur, combed downwards.
pub(crate) fn fur() -> Pictures {
    const COAT: [u32; 5] = [0x00B8_7438, 0x00C8_8A48, 0x009A_5A28, 0x00D8_A060, 0x00A8_6830];
    let mut relief = Relief::from_fn(256, |_| Matter { height: 0.0, albedo: srgb(0x0050_3018), gloss: 0.0 });
    let mut random = Random::new(120, 0);
    for i in 0..15_000_u64 {
        let root = [random.unit(), random.unit()];
        // Hairs of one lock lean together: towards the middle of their cell, and with the flow of the coat.
        let lock = cells(root, [9, 6], 1.0, 121);
        let flow = 0.5 * fractal(root, [3, 3], 2, 122);
        let length = random.range(0.13, 0.22);
        let lean = flow + random.range(-0.11, 0.11);
        let gather = -0.045 * lock.offset[0] + 0.02 * (unit(lock.id as i64, 4, 123) - 0.5);
        let run = [length * sin(lean) + gather, length * cos(lean)];
        let tone = random.unit();
        let patch = fractal(root, [4, 3], 3, 124);
        let mut coat = pick(&COAT, tone) * random.range(0.88, 1.08);
        coat = coat.lerp(srgb(0x005A_3018), 0.5 * step(0.0, 0.8, patch)) * 1.1;
        coat = coat.lerp(srgb(0x00E4_C090), 0.45 * step(0.1, 0.8, -patch));
        coat *= 0.86 + 0.3 * unit(lock.id as i64, 5, 125);
        let tip = if i % 17 == 0 { srgb(0x0048_2C18) } else { coat.lerp(srgb(0x00F0_D4A4), 0.3) };
        let strand = Strand {
            root,
            run,
            bend: random.range(-0.012, 0.012),
            width: random.range(0.0042, 0.007),
            low: 0.008 * random.unit() - 0.035 * (lock.nearest - 0.4),
            rise: 0.03 + 0.012 * random.unit(),
        };
        strand.lay(&mut relief, |t| (coat * (0.5 + 0.62 * t.min(0.8))).lerp(tip, step(0.7, 1.0, t)), 0.12);
    }
    relief.photograph(Light { sun: 0.22, occlusion: 0.4 }, 904)
}

/// A cushion of moss: short shoots that lean every way.
pub(crate) fn moss() -> Pictures {
    const GREEN: [u32; 5] = [0x0058_7A20, 0x006E_8E2C, 0x0046_681C, 0x0082_9E38, 0x003C_5A22];
    let cushion = |at: [f64; 2]| {
        let clump = cells([at[0] + 0.03 * fractal(at, [5, 5], 2, 131), at[1]], [6, 6], 1.0, 132);
        0.075 * step(0.0, 0.5, clump.border) + 0.025 * fractal(at, [9, 9], 3, 133)
    };
    let mut relief = Relief::from_fn(256, |at| Matter { height: cushion(at) - 0.012, albedo: srgb(0x0034_4216), gloss: 0.0 });
    let mut random = Random::new(134, 0);
    for _ in 0..7_000 {
        let root = [random.unit(), random.unit()];
        let low = cushion(root);
        let tone = random.unit();
        let dry = fractal(root, [4, 4], 3, 135);
        let bright = random.range(0.8, 1.2) * (0.75 + 6.0 * low.clamp(0.0, 0.09));
        let lift = 0.004 * random.unit();
        // A shoot is a small star of leaves.
        let turn = random.range(0.0, TAU);
        for leaf in 0..5 {
            let a = turn + f64::from(leaf) * TAU / 5.0 + random.range(-0.3, 0.3);
            let length = random.range(0.011, 0.019);
            let mut green = pick(&GREEN, tone) * bright;
            green = green.lerp(srgb(0x00B0_A444), 0.6 * step(0.1, 0.8, dry));
            let strand = Strand {
                root,
                run: [length * cos(a), length * sin(a)],
                bend: random.range(-0.003, 0.003),
                width: 0.0062,
                low: low + lift + 0.006,
                rise: -0.007,
            };
            strand.lay(&mut relief, |t| green * (1.35 - 0.75 * t), 0.05);
        }
    }
    relief.photograph(Light { sun: 0.32, occlusion: 0.5 }, 905)
}
