//! A blind look: crops of a textured surface, each with a border in its middle, among crops of the exemplar.
//!
//! Who cannot tell which are which cannot see the borders. All crops are unrolled and lit evenly at one pixel of the exemplar a pixel,
//! cut as the pieces are that fidelity is measured on, so that nothing but the texture tells them apart. Where the surface bends so much
//! that unrolling tears a crop, none is taken: there the tear would tell.

use super::measures::{Border, Pieces, Placed, around, of_image, unrolls};
use crate::exemplar::Exemplar;
use crate::random::Random;
use crate::render::picture::{Picture, to_byte};
use crate::render::text;
use glam::{Vec2, Vec3};
use serde::Serialize;

/// Largest side of a crop, as a share of the exemplar's shorter one, and in pixels: of a larger exemplar crops show different parts, and
/// are not told by what they have in common.
const SHARE: f64 = 0.5;
const MOST: f64 = 96.0;
/// Crops in a row.
const COLUMNS: u32 = 8;
/// Each pixel of a crop is shown as so many along each side.
const ZOOM: u32 = 2;
/// Pixels between crops; there the numbers stand.
const GAP: u32 = 20;
/// Height of the numbers, pixels.
const NUMBER: f32 = 12.0;
/// Random streams of the crops and of their order; those of the measures lie below.
const STREAM: u64 = 0x424C_494E_4400_0000;

/// A sheet of crops.
#[derive(Debug, Clone)]
pub struct Blind {
    /// The crops, numbered from 1, row by row.
    pub sheet: Picture,
    /// Which is which.
    pub key: BlindKey,
}

/// Which crops of a sheet are of the surface.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct BlindKey {
    /// Number of crops.
    pub crops: usize,
    /// Side of each, pixels of the exemplar.
    pub side: usize,
    /// Numbers of those of the surface, the others are the exemplar's.
    pub surface: Vec<usize>,
}

/// So many crops around borders, or as many as there are, and as many of the exemplar, shuffled. `None` where there is no border that
/// unrolls, or the exemplar is too small.
#[must_use]
pub fn blind(at: &Placed, borders: &[Border], exemplar: &Exemplar, count: usize, seed: u64) -> Option<Blind> {
    let side = (exemplar.size().into_iter().min().map_or(0.0, f64::from) * SHARE).min(MOST) as usize;
    let mut random = Random::new(seed, STREAM);
    if borders.is_empty() || side < 8 || count == 0 {
        return None;
    }
    let mut places: Vec<usize> = (0..borders.len()).collect();
    random.shuffle(&mut places);
    let points: Vec<_> = places.into_iter().map(|i| borders[i].at).filter(|&p| unrolls(at, side, p)).take(count).collect();
    if points.is_empty() {
        return None;
    }
    let count = points.len();
    let surface = around(at, side, &points);
    let own = of_image(exemplar, side, count, seed ^ STREAM, [0.0, 1.0]);
    let mut crops: Vec<(bool, &Vec<[f32; 3]>)> =
        surface.data.iter().map(|crop| (true, crop)).chain(own.data.iter().map(|crop| (false, crop))).collect();
    for i in (1..crops.len()).rev() {
        crops.swap(i, random.below(i as u64 + 1) as usize);
    }
    let key = crops.iter().enumerate().filter(|(_, crop)| crop.0).map(|(i, _)| i + 1).collect();
    let key = BlindKey { crops: crops.len(), side, surface: key };
    let all = Pieces { side, data: crops.into_iter().map(|(_, crop)| crop.clone()).collect() };
    Some(Blind { sheet: sheet(&all), key })
}

fn sheet(crops: &Pieces) -> Picture {
    let (count, side) = (crops.data.len() as u32, crops.side as u32 * ZOOM);
    let columns = COLUMNS.min(count).max(1);
    let step = side + GAP;
    let mut out = Picture::filled(columns * step, count.div_ceil(columns) * step, [255, 255, 255, 255]);
    for (i, crop) in crops.data.iter().enumerate() {
        let (x, y) = (i as u32 % columns * step, i as u32 / columns * step);
        let mut one = Picture::filled(side, side, [0, 0, 0, 255]);
        for (k, pixel) in one.rgba.as_chunks_mut::<4>().0.iter_mut().enumerate() {
            let (px, py) = (k % side as usize / ZOOM as usize, k / side as usize / ZOOM as usize);
            pixel[..3].copy_from_slice(&crop[py * crops.side + px].map(to_byte));
        }
        out.paste(&one, x, y + GAP);
        text::write(&mut out, &(i + 1).to_string(), Vec2::new(x as f32 + 2.0, y as f32 + 3.0), NUMBER, Vec3::ZERO, 1.0);
    }
    out
}
