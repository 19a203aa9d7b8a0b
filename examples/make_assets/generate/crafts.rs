//! Exemplars of made things: striped cloth, a woven basket, rusting paint.

use super::noise::{cells, fractal, gradient, ridged, step, unit};
use super::portable::{pow, sin};
use super::relief::{Light, Matter, Pictures, Relief, pick, srgb};
use std::f64::consts::PI;

/// A plain-woven cotton with stripes along the warp.
pub(crate) fn stripes() -> Pictures {
    const THREADS: f64 = 64.0;
    /// Threads of each colour from left to right.
    const PATTERN: [(i64, u32); 11] = [
        (8, 0x00E6_DCC6),
        (2, 0x00B0_3A2E),
        (2, 0x00E6_DCC6),
        (10, 0x0028_3C62),
        (2, 0x00E6_DCC6),
        (2, 0x00B0_3A2E),
        (8, 0x00E6_DCC6),
        (2, 0x0028_3C62),
        (12, 0x00C8_9440),
        (2, 0x0028_3C62),
        (14, 0x004E_7C78),
    ];
    let relief = Relief::from_fn(256, |at| {
        // Threads wander a little.
        let (u, v) = (at[0] + 0.0016 * fractal(at, [7, 5], 3, 201), at[1] + 0.0018 * fractal(at, [5, 7], 3, 202));
        let (x, y) = (u * THREADS, v * THREADS);
        let (i, j) = (x.floor() as i64, y.floor() as i64);
        let (wi, wj) = (i.rem_euclid(64), j.rem_euclid(64));
        let over = if (i + j).rem_euclid(2) == 0 { 1.0 } else { -1.0 };
        let slub = |k: i64, seed: u64, along: f64| {
            0.86 + 0.16 * unit(k, 6, seed) + 0.1 * gradient([along, 0.37 + k as f64 / 64.0], [14, 64], seed)
        };
        let profile = |t: f64, width: f64| (1.0 - pow((t / width).abs(), 2.4)).max(0.0).sqrt();
        let (tx, ty) = (2.0 * (x - i as f64) - 1.0, 2.0 * (y - j as f64) - 1.0);
        // The warp bulges out over the weft, and under it in the next row; it is the thicker of the two.
        let wave = |t: f64| sin(PI * (t + 1.0) * 0.5);
        let warp = 0.55 * profile(tx, slub(wi, 203, v)) + 0.45 * over * wave(ty) + 0.3;
        let weft = 0.5 * profile(ty, slub(wj, 204, u)) - 0.5 * over * wave(tx);
        let mut left = wi;
        let mut dye = 0x00E6_DCC6;
        for (count, colour) in PATTERN {
            if left < count {
                dye = colour;
                break;
            }
            left -= count;
        }
        let on_warp = warp >= weft;
        let twist = if on_warp { sin(6.0 * (ty * 0.8 + tx) + f64::from(wi as i32)) } else { sin(6.0 * (tx * 0.8 + ty)) };
        let fade = 1.0 + 0.1 * fractal(at, [5, 5], 4, 205);
        let thread =
            if on_warp { srgb(dye) * (0.88 + 0.24 * unit(wi, 7, 206)) } else { srgb(dye).lerp(srgb(0x00D8_CCB4), 0.16) * 0.85 };
        let fuzz = 1.0 + 0.14 * fractal(at, [120, 120], 2, 207) + 0.05 * twist;
        let folds = 0.01 * fractal(at, [2, 2], 2, 208);
        Matter { height: 0.0062 * warp.max(weft) + 0.0004 * twist + folds, albedo: thread * fade * fuzz, gloss: 0.02 }
    });
    relief.photograph(Light { sun: 0.32, occlusion: 0.8 }, 906)
}

/// A basket of flat reeds, over one and under one.
pub(crate) fn weave() -> Pictures {
    const REEDS: i64 = 8;
    const STRAW: [u32; 6] = [0x00C8_9F62, 0x00B4_864A, 0x00D6_B47C, 0x009E_733C, 0x00C2_9556, 0x00AA_8048];
    let relief = Relief::from_fn(256, |at| {
        let (u, v) = (at[0] + 0.004 * fractal(at, [4, 4], 2, 221), at[1] + 0.004 * fractal(at, [4, 4], 2, 222));
        // A reed runs along `along`; `across` tells which and where in it.
        let reed = |across: f64, along: f64, upright: bool| {
            let k = (across * REEDS as f64).floor() as i64;
            let w = k.rem_euclid(REEDS);
            let kind = if upright { 300 } else { 400 };
            let own = |seed: u64| unit(w, 8, seed + kind);
            let t = 2.0 * (across * REEDS as f64 - k as f64) - 1.0;
            let width = 0.9 + 0.05 * own(1) + 0.03 * gradient([along, across], [6, REEDS], 223 + kind);
            let edge = 1.0 - (t / width).abs();
            if edge <= 0.0 {
                return None;
            }
            let j = (along * REEDS as f64).floor() as i64;
            let over = if (k + j).rem_euclid(2) == i64::from(upright) { 1.0 } else { -1.0 };
            let wave = over * pow(sin(PI * (along * REEDS as f64 - j as f64)), 0.7);
            // Split stems: each reed is three or four ribs of fibres.
            let stretch = |fine: i64, long: i64| if upright { [fine, long] } else { [long, fine] };
            let fibre = gradient(at, stretch(170, 7), 224 + w as u64) + 0.6 * gradient(at, stretch(90, 4), 225 + w as u64);
            let ribs = sin(t * PI * 2.5 + 0.6 * fractal(at, [6, 6], 2, 226));
            let height = 0.0135 * wave + 0.011 * pow(1.0 - pow((t / width).abs(), 3.0), 0.5) + 0.0009 * fibre + 0.0011 * ribs;
            let stain = fractal(at, stretch(10, 3), 3, 227 + w as u64);
            let mut straw = pick(&STRAW, own(2)) * (0.82 + 0.32 * own(3));
            straw = straw.lerp(srgb(0x0070_4A24), 0.5 * step(0.15, 0.9, stain));
            straw = straw.lerp(srgb(0x00E2_CC9C), 0.35 * step(0.1, 0.9, -stain));
            straw *= 1.0 + 0.2 * fibre + 0.06 * ribs;
            // Worn pale on top, dark where it dives under.
            straw *= 0.8 + 0.28 * step(-0.6, 0.9, wave);
            straw *= 0.7 + 0.3 * step(0.0, 0.18, edge);
            Some(Matter { height, albedo: straw, gloss: 0.16 })
        };
        let bottom = Matter { height: -0.008, albedo: srgb(0x0026_180C), gloss: 0.0 };
        let (upright, level) = (reed(u, v, true), reed(v, u, false));
        [upright, level].into_iter().flatten().fold(bottom, |top, m| if m.height > top.height { m } else { top })
    });
    relief.photograph(Light { sun: 0.34, occlusion: 0.95 }, 907)
}

/// Old paint that flakes off rusting steel.
pub(crate) fn rust() -> Pictures {
    let relief = Relief::from_fn(256, |at| {
        let warped = [at[0] + 0.03 * fractal(at, [4, 4], 3, 241), at[1] + 0.03 * fractal(at, [4, 4], 3, 242)];
        let chips = cells(warped, [16, 16], 1.0, 243);
        let decay =
            fractal(warped, [3, 3], 5, 244) + 0.14 * (unit(chips.id as i64, 9, 245) - 0.5) + 0.07 * fractal(at, [40, 40], 2, 246);
        let paint = step(0.035, 0.065, decay);
        let grain = fractal(at, [90, 90], 3, 247);
        let crust = fractal(at, [22, 22], 4, 248);
        let scale = ridged(warped, [9, 9], 4, 249);
        let mut iron = srgb(0x0084_421E).lerp(srgb(0x00B8_692C), step(-0.4, 0.7, fractal(at, [8, 8], 4, 250)));
        iron = iron.lerp(srgb(0x0042_2216), 0.85 * step(0.05, 0.7, crust));
        iron = iron.lerp(srgb(0x00D4_8C48), 0.6 * step(0.2, 0.8, -crust) * step(0.45, 0.75, scale));
        iron = iron.lerp(srgb(0x0034_2A28), 0.7 * step(0.3, 0.85, fractal(at, [5, 5], 4, 251)));
        iron *= 1.0 + 0.34 * grain;
        let pits = cells(at, [38, 38], 1.0, 252);
        let pitted = if unit(pits.id as i64, 10, 253) < 0.4 { step(0.4, 0.12, pits.nearest) } else { 0.0 };
        // The paint: chalky, scratched, stained brown towards the flakes' edges and below blisters.
        let mut coat = srgb(0x005C_8C86) * (1.0 + 0.1 * fractal(at, [6, 6], 4, 254) + 0.07 * grain);
        coat = coat.lerp(srgb(0x0096_B4AA), 0.4 * step(0.1, 0.9, fractal(at, [10, 10], 4, 255)));
        let near = step(0.3, 0.05, decay);
        coat = coat.lerp(srgb(0x009A_5E30), 0.62 * near * step(-0.5, 0.6, fractal(at, [14, 14], 4, 256)));
        let blister = cells(at, [13, 13], 1.0, 257);
        let raised = if unit(blister.id as i64, 11, 258) < 0.35 { step(0.34, 0.0, blister.nearest) } else { 0.0 };
        coat = coat.lerp(srgb(0x008A_4A22), 0.75 * step(0.45, 0.95, raised) * step(-0.3, 0.4, crust));
        let edge = step(0.035, 0.05, decay) * step(0.11, 0.05, decay);
        coat = coat.lerp(srgb(0x00C8_D2C4), 0.4 * edge);
        let bare = 0.0024 * crust + 0.0026 * (scale - 0.6) + 0.0013 * grain - 0.003 * pitted;
        let painted = 0.0062 + 0.0035 * edge + 0.005 * raised + 0.0003 * grain;
        Matter {
            height: bare + (painted - bare * 0.7) * paint,
            albedo: (iron * (1.0 - 0.45 * pitted)).lerp(coat, paint),
            gloss: 0.03 + 0.14 * paint,
        }
    });
    relief.photograph(Light { sun: 0.4, occlusion: 1.0 }, 908)
}
