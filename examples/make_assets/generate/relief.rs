//! From a relief of matter (height, albedo, gloss at each point of the unit torus) to the pictures of an exemplar.
//!
//! Colour is albedo under a soft sky with a touch of sun, so that it looks like a photograph taken on a bright day and
//! still tolerates being turned on a surface. Everything is made at twice the size and averaged in linear light.

use super::noise::{fractal, unit};
use super::portable::pow;
use glam::DVec3;
use rayon::prelude::*;

/// Samples along a pixel's side.
const SUPERSAMPLING: usize = 2;

/// Matter at a point.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Matter {
    /// Outward, in widths of the exemplar.
    pub(crate) height: f64,
    /// Linear light.
    pub(crate) albedo: DVec3,
    /// Strength of the highlight, 0 to 1.
    pub(crate) gloss: f64,
}

/// How a relief is photographed.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Light {
    /// Share of the light that comes from the sun, from the upper left; the rest is sky.
    pub(crate) sun: f64,
    /// How much crevices darken: 1 as in nature.
    pub(crate) occlusion: f64,
}

/// A square of matter, sampled.
#[derive(Debug, Clone)]
pub(crate) struct Relief {
    side: usize,
    matter: Vec<Matter>,
}

/// The pictures of an exemplar, 8 bits a component, top row first.
#[derive(Debug, Clone)]
pub(crate) struct Pictures {
    /// Pixels along a side.
    pub(crate) size: usize,
    /// sRGB.
    pub(crate) color: Vec<u8>,
    /// Tangent-space normals, y up.
    pub(crate) normal: Vec<u8>,
    /// Height, stretched to 0 to 255.
    pub(crate) height: Vec<u8>,
}

/// Linear light of an sRGB colour written as 0xRRGGBB.
pub(crate) fn srgb(hex: u32) -> DVec3 {
    let part = |shift: u32| {
        let c = f64::from(hex >> shift & 0xFF) / 255.0;
        if c <= 0.04045 { c / 12.92 } else { pow((c + 0.055) / 1.055, 2.4) }
    };
    DVec3::new(part(16), part(8), part(0))
}

/// A colour from a palette: two neighbours mixed, `t` in [0, 1) running through all of it.
pub(crate) fn pick(palette: &[u32], t: f64) -> DVec3 {
    let at = t * palette.len() as f64;
    let i = at as usize % palette.len();
    srgb(palette[i]).lerp(srgb(palette[(i + 1) % palette.len()]), 0.6 * (at - at.floor()))
}

fn to_byte(x: f64) -> u8 {
    (x * 255.0).round().clamp(0.0, 255.0) as u8
}

fn encode(c: f64) -> u8 {
    to_byte(if c <= 0.003_130_8 { 12.92 * c } else { 1.055 * pow(c, 1.0 / 2.4) - 0.055 })
}

impl Relief {
    /// Samples a formula over the unit torus for an exemplar of `size` pixels; v runs downwards.
    pub(crate) fn from_fn(size: usize, matter: impl Fn([f64; 2]) -> Matter + Sync) -> Self {
        let side = size * SUPERSAMPLING;
        let at = |i: usize| [((i % side) as f64 + 0.5) / side as f64, ((i / side) as f64 + 0.5) / side as f64];
        Self { side, matter: (0..side * side).into_par_iter().map(|i| matter(at(i))).collect() }
    }

    /// Lays a thing on the relief where it rises above what is there: `matter` gets the offset from `centre` in widths, and
    /// is asked within `reach` of it.
    pub(crate) fn stamp(&mut self, centre: [f64; 2], reach: f64, matter: impl Fn([f64; 2]) -> Option<Matter>) {
        self.put(centre, reach, matter, |old, new| new.height > old.height);
    }

    /// Lays a thing on top of all that is there, whatever its height.
    pub(crate) fn cover(&mut self, centre: [f64; 2], reach: f64, matter: impl Fn([f64; 2]) -> Option<Matter>) {
        self.put(centre, reach, matter, |_, _| true);
    }

    fn put(
        &mut self,
        centre: [f64; 2],
        reach: f64,
        matter: impl Fn([f64; 2]) -> Option<Matter>,
        wins: impl Fn(&Matter, &Matter) -> bool,
    ) {
        let n = self.side as f64;
        let low = centre.map(|c| ((c - reach) * n).floor() as i64);
        let high = centre.map(|c| ((c + reach) * n).ceil() as i64);
        for y in low[1]..=high[1] {
            for x in low[0]..=high[0] {
                let offset = [(x as f64 + 0.5) / n - centre[0], (y as f64 + 0.5) / n - centre[1]];
                if let Some(new) = matter(offset) {
                    let side = self.side as i64;
                    let old = &mut self.matter[(y.rem_euclid(side) * side + x.rem_euclid(side)) as usize];
                    if wins(old, &new) {
                        *old = new;
                    }
                }
            }
        }
    }

    fn height(&self, x: i64, y: i64) -> f64 {
        let side = self.side as i64;
        self.matter[(y.rem_euclid(side) * side + x.rem_euclid(side)) as usize].height
    }

    /// Share of the sky that a sample sees.
    fn openness(&self, x: i64, y: i64) -> f64 {
        const DIRECTIONS: [[f64; 2]; 8] =
            [[1.0, 0.0], [0.7, 0.7], [0.0, 1.0], [-0.7, 0.7], [-1.0, 0.0], [-0.7, -0.7], [0.0, -1.0], [0.7, -0.7]];
        /// Distances looked at, in samples of a 512-sample relief.
        const STEPS: [f64; 7] = [1.0, 2.0, 4.0, 7.0, 12.0, 20.0, 32.0];
        let here = self.height(x, y);
        let scale = self.side as f64 / 512.0;
        let open = DIRECTIONS.iter().map(|d| {
            let steepest = STEPS.iter().map(|s| {
                let far = s * scale;
                let (dx, dy) = ((d[0] * far).round(), (d[1] * far).round());
                let run = (dx * dx + dy * dy).sqrt().max(1.0) / self.side as f64;
                (self.height(x + dx as i64, y + dy as i64) - here) / run
            });
            let slope = steepest.fold(0.0, f64::max);
            1.0 - slope / (1.0 + slope * slope).sqrt()
        });
        open.sum::<f64>() / DIRECTIONS.len() as f64
    }

    /// Share of the sun that reaches a sample, its disc widened to soften the shadow.
    fn sunlit(&self, x: i64, y: i64, toward: DVec3) -> f64 {
        let here = self.height(x, y);
        let (dx, dy) = (toward.x / toward.z, -toward.y / toward.z);
        let mut hidden: f64 = 0.0;
        for step in 1..=24 {
            // In samples, farther apart with distance.
            let far = f64::from(step) * (1.0 + f64::from(step) * 0.06) * self.side as f64 / 512.0;
            let run = far / self.side as f64;
            let plane = (toward.x * toward.x + toward.y * toward.y).sqrt() / toward.z;
            let (sx, sy) = ((dx / plane * far).round() as i64, (dy / plane * far).round() as i64);
            let over = self.height(x + sx, y + sy) - here - run / plane;
            hidden = hidden.max(over / (0.25 * run + 0.002));
        }
        1.0 - hidden.clamp(0.0, 1.0)
    }

    fn normal(&self, x: i64, y: i64) -> DVec3 {
        let scale = 0.5 * self.side as f64;
        let slope_x = (self.height(x + 1, y) - self.height(x - 1, y)) * scale;
        let slope_down = (self.height(x, y + 1) - self.height(x, y - 1)) * scale;
        DVec3::new(-slope_x, slope_down, 1.0).normalize()
    }

    /// Takes the pictures. `seed` is for the grain.
    pub(crate) fn photograph(&self, light: Light, seed: u64) -> Pictures {
        let sun = DVec3::new(-0.45, 0.75, 0.85).normalize();
        let half = (sun + DVec3::Z).normalize();
        let size = self.side / SUPERSAMPLING;
        let lit: Vec<(DVec3, DVec3)> = (0..self.side * self.side)
            .into_par_iter()
            .map(|i| {
                let (x, y) = ((i % self.side) as i64, (i / self.side) as i64);
                let matter = self.matter[i];
                let normal = self.normal(x, y);
                let open = pow(self.openness(x, y), light.occlusion);
                let clear = self.sunlit(x, y, sun);
                let direct = clear * normal.dot(sun).max(0.0) / sun.z;
                let facing = 0.75 + 0.25 * normal.z;
                let shine = matter.gloss * (0.25 + 0.75 * clear) * open * pow(normal.dot(half).max(0.0), 28.0) * 0.35;
                // Light that has bounced about in a crevice has taken on the colour of its walls.
                let bounced = matter.albedo * (1.0 - open) * 0.35;
                let sky = (matter.albedo * open + matter.albedo * bounced) * facing * (1.0 - light.sun);
                (sky + matter.albedo * direct * light.sun + DVec3::splat(shine), normal)
            })
            .collect();
        let (low, high) =
            self.matter.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), m| (l.min(m.height), h.max(m.height)));
        let pixels: Vec<([u8; 3], [u8; 3], u8)> = (0..size * size)
            .into_par_iter()
            .map(|i| {
                let (x, y) = (i % size, i / size);
                let (mut color, mut normal, mut height) = (DVec3::ZERO, DVec3::ZERO, 0.0);
                for k in 0..SUPERSAMPLING * SUPERSAMPLING {
                    let j = (y * SUPERSAMPLING + k / SUPERSAMPLING) * self.side + x * SUPERSAMPLING + k % SUPERSAMPLING;
                    color += lit[j].0;
                    normal += lit[j].1;
                    height += self.matter[j].height;
                }
                let count = (SUPERSAMPLING * SUPERSAMPLING) as f64;
                let at = [x as f64 / size as f64, y as f64 / size as f64];
                let grain = 1.0 + 0.035 * (unit(x as i64, y as i64, seed) + unit(x as i64, y as i64, seed + 1) - 1.0);
                let blotch = 1.0 + 0.05 * fractal(at, [3, 3], 2, seed + 2);
                let color = (color / count * grain * blotch).to_array().map(encode);
                let normal = normal.normalize().to_array().map(|c| to_byte(0.5 + 0.5 * c));
                (color, normal, to_byte((height / count - low) / (high - low).max(1e-12)))
            })
            .collect();
        Pictures {
            size,
            color: pixels.iter().flat_map(|p| p.0).collect(),
            normal: pixels.iter().flat_map(|p| p.1).collect(),
            height: pixels.iter().map(|p| p.2).collect(),
        }
    }
}
