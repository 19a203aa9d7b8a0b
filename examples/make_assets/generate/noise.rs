//! Noise: lattice noise and cells. In the plane all of it lives on the unit torus, so that whatever is made of it tiles:
//! `u` and `v` have period 1, and a frequency is a whole number of lattice cells around.

use glam::DVec3;

/// A hash of lattice coordinates with all bits well mixed.
pub(crate) fn hash(x: i64, y: i64, seed: u64) -> u64 {
    let mut h = (x as u64).wrapping_mul(0x9E37_79B9_7F4A_7C15) ^ (y as u64).wrapping_mul(0xC2B2_AE3D_27D4_EB4F);
    h ^= seed.wrapping_mul(0x1656_67B1_9E37_79F9).wrapping_add(0x27D4_EB2F_1656_67C5);
    for _ in 0..2 {
        h = (h ^ (h >> 31)).wrapping_mul(0x7FB5_D329_728E_A185);
    }
    h ^ (h >> 29)
}

/// Uniform in [0, 1).
pub(crate) fn unit(x: i64, y: i64, seed: u64) -> f64 {
    (hash(x, y, seed) >> 11) as f64 / (1_u64 << 53) as f64
}

/// Hermite step from 0 at `low` to 1 at `high`; falls if they are given the other way round.
pub(crate) fn step(low: f64, high: f64, x: f64) -> f64 {
    let t = ((x - low) / (high - low)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

fn fade(t: f64) -> f64 {
    t * t * t * (t * (t * 6.0 - 15.0) + 10.0)
}

fn mix(a: f64, b: f64, t: f64) -> f64 {
    a + t * (b - a)
}

/// Gradient noise of the plane, about -1 to 1, with its own frequency in either direction.
pub(crate) fn gradient([u, v]: [f64; 2], frequency: [i64; 2], seed: u64) -> f64 {
    /// Brings the values' range near -1 to 1.
    const GAIN: f64 = 1.5;
    let (x, y) = (u * frequency[0] as f64, v * frequency[1] as f64);
    let (bx, by) = (x.floor(), y.floor());
    let (fx, fy) = (x - bx, y - by);
    let slope = |dx: i64, dy: i64| {
        let (cx, cy) = ((bx as i64 + dx).rem_euclid(frequency[0]), (by as i64 + dy).rem_euclid(frequency[1]));
        // A gradient from the square's middle ring: no direction is preferred much and no trigonometry is needed.
        let h = hash(cx, cy, seed);
        let (gx, gy) = ((h & 0xFFFF) as f64 / 32767.5 - 1.0, (h >> 16 & 0xFFFF) as f64 / 32767.5 - 1.0);
        let length = (gx * gx + gy * gy).sqrt().max(0.05);
        (gx * (fx - dx as f64) + gy * (fy - dy as f64)) / length
    };
    let (tx, ty) = (fade(fx), fade(fy));
    GAIN * mix(mix(slope(0, 0), slope(1, 0), tx), mix(slope(0, 1), slope(1, 1), tx), ty)
}

/// Octaves of gradient noise, each of twice the frequency and half the strength; about -1 to 1.
pub(crate) fn fractal(at: [f64; 2], frequency: [i64; 2], octaves: u32, seed: u64) -> f64 {
    let (mut sum, mut weight, mut total) = (0.0, 1.0, 0.0);
    for octave in 0..octaves {
        let scale = 1 << octave;
        sum += weight * gradient(at, frequency.map(|f| f * scale), seed.wrapping_add(u64::from(octave) * 101));
        total += weight;
        weight *= 0.5;
    }
    sum / total * 1.3
}

/// The same with ridges where the noise changes sign: 0 to 1, 1 on the ridges.
pub(crate) fn ridged(at: [f64; 2], frequency: [i64; 2], octaves: u32, seed: u64) -> f64 {
    let (mut sum, mut weight, mut total) = (0.0, 1.0, 0.0);
    for octave in 0..octaves {
        let scale = 1 << octave;
        let n = gradient(at, frequency.map(|f| f * scale), seed.wrapping_add(u64::from(octave) * 103));
        sum += weight * (1.0 - n.abs()).max(0.0);
        total += weight;
        weight *= 0.5;
    }
    sum / total
}

/// What [`cells`] finds.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Cell {
    /// Distance to the nearest seed, in lattice cells.
    pub(crate) nearest: f64,
    /// Distance to the border with the next cell, in lattice cells.
    pub(crate) border: f64,
    /// A number that names the cell.
    pub(crate) id: u64,
    /// From the seed to the point, in lattice cells.
    pub(crate) offset: [f64; 2],
}

/// Worley noise: the jittered seeds of a lattice and their Voronoi cells. `jitter` 0 is a regular lattice, 1 the full cell.
pub(crate) fn cells([u, v]: [f64; 2], frequency: [i64; 2], jitter: f64, seed: u64) -> Cell {
    let (x, y) = (u * frequency[0] as f64, v * frequency[1] as f64);
    let (bx, by) = (x.floor() as i64, y.floor() as i64);
    let place = |cx: i64, cy: i64| {
        let (wx, wy) = (cx.rem_euclid(frequency[0]), cy.rem_euclid(frequency[1]));
        let at = |c: i64, s: u64| c as f64 + 0.5 + jitter * (unit(wx, wy, s) - 0.5);
        ([at(cx, seed), at(cy, seed ^ 0xABCD)], hash(wx, wy, seed ^ 0x1234))
    };
    let mut best = (f64::INFINITY, [0.0; 2], 0);
    for cy in by - 1..=by + 1 {
        for cx in bx - 1..=bx + 1 {
            let (p, id) = place(cx, cy);
            let d = (x - p[0]) * (x - p[0]) + (y - p[1]) * (y - p[1]);
            if d < best.0 {
                best = (d, p, id);
            }
        }
    }
    let mut border = f64::INFINITY;
    for cy in by - 2..=by + 2 {
        for cx in bx - 2..=bx + 2 {
            let (p, _) = place(cx, cy);
            let (dx, dy) = (p[0] - best.1[0], p[1] - best.1[1]);
            let apart = (dx * dx + dy * dy).sqrt();
            if apart > 1e-9 {
                let (mx, my) = (0.5 * (p[0] + best.1[0]) - x, 0.5 * (p[1] + best.1[1]) - y);
                border = border.min((mx * dx + my * dy) / apart);
            }
        }
    }
    Cell { nearest: best.0.sqrt(), border, id: best.2, offset: [x - best.1[0], y - best.1[1]] }
}

/// Value noise of space in octaves, about -1 to 1.
pub(crate) fn fractal3(p: DVec3, octaves: u32, seed: u64) -> f64 {
    let (mut sum, mut weight, mut total) = (0.0, 1.0, 0.0);
    for octave in 0..octaves {
        let q = p * f64::from(1_u32 << octave) + f64::from(octave) * 17.3;
        let base = q.floor();
        let f = (q - base).to_array().map(fade);
        let value = |dx: i64, dy: i64, dz: i64| {
            let z = hash(base.z as i64 + dz, 0, seed + u64::from(octave));
            2.0 * unit(base.x as i64 + dx, base.y as i64 + dy, z) - 1.0
        };
        let plane = |dz| mix(mix(value(0, 0, dz), value(1, 0, dz), f[0]), mix(value(0, 1, dz), value(1, 1, dz), f[0]), f[1]);
        sum += weight * mix(plane(0), plane(1), f[2]);
        total += weight;
        weight *= 0.5;
    }
    sum / total * 1.5
}
