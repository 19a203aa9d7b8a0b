//! What turns leave an exemplar looking the same, and which way its lines run: read off the exemplar itself.
//!
//! 1. Spectrum: the power spectrum (the transform of the autocorrelation) gathered by angle says whether the exemplar has lines
//!    and which way they run.
//! 2. Turned against itself: for each turn in question, windows of the exemplar are turned and searched for in the whole. Where a
//!    turned window is found nearly as well as an unturned one elsewhere, the turn leaves the exemplar looking the same. That is
//!    just what synthesis and pasting do with an n-way field.
//! 3. Slopes: brightness that rises gently and falls sharply towards one side, at several sizes alike, gives an exemplar an up and a
//!    down, as scales and roof tiles have (the third moment of its derivative, which half a turn negates).
//! 4. The largest n of which all turns fit is the symmetry; if turns that belong to no small n fit as well, the exemplar looks
//!    the same every way.

use super::image::MipChain;
use super::{Channel, Exemplar, Image};
use glam::{DVec2, Vec3};
use rayon::prelude::*;
use serde::Serialize;
use std::borrow::Cow;
use std::f64::consts::{PI, TAU};
use std::sync::{Arc, OnceLock};

/// Side of the square that the spectrum is taken of, pixels.
const SPECTRUM: usize = 256;
/// Periods per side below which the spectrum tells of shading rather than texture.
const LOWEST: f64 = 4.0;
/// Bins of angle over half a turn.
const BINS: usize = 180;

/// Longer side of the image that windows are searched in, pixels: a window spans an eighth of it.
const SEARCHED: usize = 96;
/// Radius of a window, pixels of that image.
const RADIUS: i64 = 6;
/// Windows along each side.
const WINDOWS: usize = 8;
/// An unturned window is looked for at least this far from where it was taken.
const APART: i64 = 8;

/// Turns looked at, degrees: those of small symmetries, and some that belong to none.
const TURNS: [f64; 8] = [180.0, 90.0, 60.0, 120.0, 45.0, 23.0, 137.0, 251.0];
/// Turns of [`TURNS`] that belong to no symmetry in question.
const ODD: [usize; 4] = [4, 5, 6, 7];

/// A turn fits if what its windows miss is below this, on a scale from 0 (as good as unturned) to 1 (no better than grey).
const FITS: f64 = 0.25;

/// Share of the spectrum's energy in its second angular harmonic above which the exemplar has lines.
const LINES: f64 = 0.3;
const NARROW: f64 = 0.1;

/// The same of its fourth harmonic for squares, which must also be this many times the second's.
const GRID: f64 = 0.35;
const GRID_OVER_LINES: f64 = 1.7;

/// Above this fourth harmonic an exemplar is built of something even if windows are found at any angle, as among scales; and the second's
/// share of it from which that is layers rather than cells.
const BUILT: f64 = 0.22;
const LAYERS: f64 = 0.8;
/// So is one above this sixth harmonic.
const SIX: f64 = 0.35;

/// An exemplar with no more than this in any harmonic has no direction at all; turned windows may then miss this much, for want of
/// others to be found among.
const NO_HARMONIC: f64 = 0.2;
const FITS_LOOSELY: f64 = 0.34;

/// Sides of the squares at which slopes are looked at, pixels; the skewness that all must show, and how far (cosine) their directions
/// may differ.
const SLOPE_SIDES: [usize; 3] = [64, 128, 256];
const SKEWED: f64 = 0.5;
const SAME_WAY: f64 = 0.86;
/// A slope within 30 degrees of the lines (the sine) runs along them.
const ALONG: f64 = 0.5;
/// Directions that skewness is looked for in.
const SLOPES: usize = 36;

/// Lines are looked for within this many degrees of where the second harmonic puts them, in so many rounds.
const NARROWED: f64 = 25.0;
const NARROWINGS: usize = 12;

/// An exemplar that is brighter than this (linear) on the mean lies over black, else over white.
const BRIGHT: f32 = 0.2;

/// How an exemplar looks when it is turned.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct Symmetry {
    /// Turning by a full turn over n leaves it looking the same; 1 if only a full turn does.
    pub n: u32,
    /// It looks the same every way; `n` then means nothing.
    pub isotropic: bool,
    /// The way its lines run, degrees counter-clockwise from right, 0 to 180; `None` if it has none.
    pub direction: Option<f64>,
    /// How sure the answer is, 0 to 1: how far the nearest turn is from fitting otherwise.
    pub confidence: f64,
    /// What windows turned by 180, 90, 60, 120 and 45 degrees, and by odd angles, miss: 0 nothing, 1 everything.
    pub misses: [f64; 8],
    /// Shares of the spectrum's energy in its angular harmonics 2, 4 and 6: stripes, checks, hexagons.
    pub harmonics: [f64; 3],
}

impl std::fmt::Display for Symmetry {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match (self.isotropic, self.n) {
            (true, _) => write!(out, "it looks the same every way")?,
            (false, 1) => write!(out, "it has one way up")?,
            (false, n) => write!(out, "it looks the same {n} ways")?,
        }
        write!(out, " ({:.0} % sure)", 100.0 * self.confidence)?;
        self.direction.map_or(Ok(()), |d| write!(out, ", its lines run at {d:.0} degrees"))
    }
}

/// The symmetry of an exemplar once it was found; copies of the exemplar share it. It says nothing that the channels do not, so all are
/// equal.
#[derive(Debug, Clone, Default)]
pub(super) struct Remembered(Arc<OnceLock<Option<Symmetry>>>);

impl PartialEq for Remembered {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

/// Finds the symmetry of an exemplar by its colour, over black or white where it has opacity; `None` without a colour. It is found once and
/// then remembered until a channel changes.
#[must_use]
pub fn exemplar_symmetry(exemplar: &Exemplar) -> Option<Symmetry> {
    let known = &exemplar.symmetry.0;
    if let Some(found) = known.get() {
        return found.clone();
    }
    // Nobody waits for the first who asks: a thread that works for it might ask again.
    let found = over_grey(exemplar).map(|image| symmetry(&image));
    known.get_or_init(|| found).clone()
}

fn over_grey(exemplar: &Exemplar) -> Option<Cow<'_, Image>> {
    let color = exemplar.channel(Channel::BaseColor)?.finest();
    let Some(opacity) = exemplar.channel(Channel::Opacity).map(MipChain::finest) else { return Some(Cow::Borrowed(color)) };
    let [width, height] = color.size();
    let alpha = |x: u32, y: u32| opacity.grey(x.into(), y.into());
    let pixels = || (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
    // Of one colour on nothing: what lies behind is lighter or darker.
    let (sum, count) = pixels().fold((0.0, 0.0_f32), |(sum, count), (x, y)| {
        (sum + color.pixel(x.into(), y.into()).element_sum() / 3.0 * alpha(x, y), count + alpha(x, y))
    });
    let behind = Vec3::splat(if sum > BRIGHT * count { 0.0 } else { 1.0 });
    Some(Cow::Owned(Image::from_fn(width, height, |x, y| behind.lerp(color.pixel(x.into(), y.into()), alpha(x, y)))))
}

/// What the spectrum alone says of an image.
struct Shape {
    spectrum: Vec<f64>,
    harmonics: [f64; 3],
    /// The way across its lines, if it has any.
    across: f64,
    /// What windows are searched in.
    searched: Grey,
}

impl Shape {
    fn new(grey: &Grey) -> Self {
        let spectrum = by_angle(&flattened(&square(grey, SPECTRUM)));
        let harmonic = |m: f64| -> DVec2 {
            let total: f64 = spectrum.iter().sum::<f64>().max(f64::MIN_POSITIVE);
            let at = |(i, e): (usize, &f64)| DVec2::from_angle(m * (i as f64 + 0.5) * PI / BINS as f64) * (e / total);
            spectrum.iter().enumerate().map(at).sum()
        };
        let harmonics = [2.0, 4.0, 6.0].map(|m| harmonic(m).length());
        let across = harmonic(2.0).to_angle() / 2.0;
        Self { spectrum, harmonics, across, searched: softened(&fitted(grey, SEARCHED)) }
    }

    /// Broad maxima of the spectrum are chance; lines, or one set of a grid's, are narrow ones.
    fn is_narrow(&self) -> bool {
        self.harmonics[0] > LINES && self.harmonics[1] > NARROW
    }

    fn is_built(&self) -> bool {
        self.harmonics[1] > BUILT || self.harmonics[2] > SIX
    }

    /// What odd turns may miss on the mean if it is to look the same every way.
    fn most_missed(&self) -> f64 {
        let shapeless = self.harmonics.iter().all(|&h| h < NO_HARMONIC);
        if shapeless { FITS_LOOSELY } else { FITS }
    }
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// Finds the symmetry of an image.
#[must_use]
pub fn symmetry(image: &Image) -> Symmetry {
    let grey = grey(image);
    let shape = Shape::new(&grey);
    let misses: [f64; 8] = std::array::from_fn({
        let found = misses(&shape.searched, &TURNS);
        move |k| found[k]
    });
    let fits = |turn: usize| misses[turn] < FITS;
    let odd = mean(&ODD.map(|k| misses[k]));
    let harmonics = shape.harmonics;
    let [two, four, _] = harmonics;
    // Squares: two sets of lines, whose windows fit a quarter of a turn on far better than in between.
    let between = (misses[2] + misses[3] + misses[4]) / 3.0;
    let grid = four > GRID && four > GRID_OVER_LINES * two && (fits(1) || misses[1] < 0.5 * between);
    let lines = !grid && shape.is_narrow();
    let built = shape.is_built();
    let isotropic = !grid && !lines && !built && odd < shape.most_missed();
    // Lines run across the waves they are made of.
    let across = narrowed(&shape.spectrum, shape.across);
    // That one flank of a line is the steeper is common and hurts nobody; along lines a slope means an up.
    let has_up = !grid
        && match slope(&grey) {
            Some(way) if lines => way.dot(DVec2::from_angle(across)).abs() < ALONG,
            way => way.is_some() && built,
        };
    let n = match () {
        () if has_up => 1,
        () if lines => {
            if misses[0] < 2.0 * FITS {
                2
            } else {
                1
            }
        }
        () if grid => 4,
        () if four > BUILT && two > LAYERS * four => 2,
        () if fits(2) && fits(3) && fits(0) && misses[1] > misses[2] => 6,
        () if fits(1) && fits(0) => 4,
        () if fits(0) => 2,
        () if fits(3) => 3,
        () => 1,
    };
    let margin = if isotropic { FITS - odd } else { misses.iter().map(|m| (m - FITS).abs()).fold(1.0, f64::min) };
    // The image's y points down.
    let direction = lines.then(|| (-(across + PI / 2.0)).to_degrees().rem_euclid(180.0));
    Symmetry { n, isotropic, direction, confidence: (margin / FITS).clamp(0.0, 1.0), misses, harmonics }
}

/// The angle, radians, about which the spectrum lies near another one: other features than the lines pull the harmonic aside.
fn narrowed(spectrum: &[f64], from: f64) -> f64 {
    let width = NARROWED.to_radians();
    (0..NARROWINGS).fold(from, |at, _| {
        let near = |(i, e): (usize, &f64)| {
            let off = ((i as f64 + 0.5) * PI / BINS as f64 - at + PI / 2.0).rem_euclid(PI) - PI / 2.0;
            let weight = e * (1.0 - (off / width).powi(2)).max(0.0).powi(2);
            DVec2::new(weight * off, weight)
        };
        let sum: DVec2 = spectrum.iter().enumerate().map(near).sum();
        at + if sum.y > 0.0 { sum.x / sum.y } else { 0.0 }
    })
}

/// The way in which brightness is skewed at several sizes alike.
fn slope(grey: &Grey) -> Option<DVec2> {
    let found = SLOPE_SIDES.map(|side| skewness(&softened(&flattened(&square(grey, side)))));
    let way = found.iter().sum::<DVec2>().normalize_or_zero();
    found.iter().all(|s| s.length() > SKEWED && s.dot(way) > SAME_WAY * s.length()).then_some(way)
}

/// The direction in which the derivative is most skewed, as long as that skewness.
fn skewness(grey: &Grey) -> DVec2 {
    let (w, h) = (grey.width as i64, grey.height as i64);
    let slope = |(x, y): (i64, i64)| {
        DVec2::new((grey.at(x + 1, y) - grey.at(x - 1, y)).into(), (grey.at(x, y + 1) - grey.at(x, y - 1)).into())
    };
    // The second and third moments of x and y give those of every way between.
    let (mut squares, mut cubes) = ([0.0; 3], [0.0; 4]);
    let mut count = 0_usize;
    for DVec2 { x, y } in (1..h - 1).flat_map(|y| (1..w - 1).map(move |x| (x, y))).map(slope) {
        squares = [squares[0] + x * x, squares[1] + x * y, squares[2] + y * y];
        cubes = [cubes[0] + x * x * x, cubes[1] + x * x * y, cubes[2] + x * y * y, cubes[3] + y * y * y];
        count += 1;
    }
    let count = count.max(1) as f64;
    let of = |k: usize| {
        let way = DVec2::from_angle(k as f64 * TAU / SLOPES as f64);
        let (c, s) = (way.x, way.y);
        let second = (c * c * squares[0] + 2.0 * c * s * squares[1] + s * s * squares[2]) / count;
        let third = (c * c * c * cubes[0] + 3.0 * c * c * s * cubes[1] + 3.0 * c * s * s * cubes[2] + s * s * s * cubes[3]) / count;
        way * (third / second.max(0.0).powf(1.5).max(f64::MIN_POSITIVE)).max(0.0)
    };
    (0..SLOPES).map(of).fold(DVec2::ZERO, |best, s| if s.length() > best.length() { s } else { best })
}

/// Perceived lightness, rows of pixels.
struct Grey {
    width: usize,
    height: usize,
    data: Vec<f32>,
}

impl Grey {
    fn at(&self, x: i64, y: i64) -> f32 {
        let x = x.clamp(0, self.width as i64 - 1) as usize;
        self.data[y.clamp(0, self.height as i64 - 1) as usize * self.width + x]
    }

    fn bilinear(&self, x: f64, y: f64) -> f32 {
        let (x0, y0) = (x.floor(), y.floor());
        let (fx, fy) = ((x - x0) as f32, (y - y0) as f32);
        let (x0, y0) = (x0 as i64, y0 as i64);
        let row = |y: i64| self.at(x0, y) * (1.0 - fx) + self.at(x0 + 1, y) * fx;
        row(y0) * (1.0 - fy) + row(y0 + 1) * fy
    }
}

fn grey(image: &Image) -> Grey {
    let [width, height] = image.size().map(|s| s as usize);
    let light = |i: usize| {
        let c: Vec3 = image.pixel((i % width) as i64, (i / width) as i64);
        // A square root is near enough to how light looks.
        c.dot(Vec3::new(0.2126, 0.7152, 0.0722)).max(0.0).sqrt()
    };
    Grey { width, height, data: (0..width * height).map(light).collect() }
}

/// The middle square, as a square of another size; larger ones are averaged.
fn square(grey: &Grey, side: usize) -> Grey {
    let from = grey.width.min(grey.height);
    let corner = [(grey.width - from) / 2, (grey.height - from) / 2];
    resampled(grey, corner, [from, from], [side, side])
}

/// The whole image, its longer side no longer than `side`.
fn fitted(grey: &Grey, side: usize) -> Grey {
    let longer = grey.width.max(grey.height);
    let to = |n: usize| if longer > side { (n * side / longer).max(1) } else { n };
    resampled(grey, [0, 0], [grey.width, grey.height], [to(grey.width), to(grey.height)])
}

fn resampled(grey: &Grey, corner: [usize; 2], from: [usize; 2], to: [usize; 2]) -> Grey {
    let step = [from[0] as f64 / to[0] as f64, from[1] as f64 / to[1] as f64];
    let samples = step.map(|s| s.ceil().max(1.0) as usize);
    let value = |i: usize| {
        let (x, y) = ((i % to[0]) as f64, (i / to[0]) as f64);
        let mut sum = 0.0;
        for v in 0..samples[1] {
            for u in 0..samples[0] {
                let share = |k: usize, n: usize| (k as f64 + 0.5) / n as f64;
                let px = corner[0] as f64 + (x + share(u, samples[0])) * step[0] - 0.5;
                let py = corner[1] as f64 + (y + share(v, samples[1])) * step[1] - 0.5;
                sum += grey.bilinear(px, py);
            }
        }
        sum / (samples[0] * samples[1]) as f32
    };
    Grey { width: to[0], height: to[1], data: (0..to[0] * to[1]).map(value).collect() }
}

/// Blurred by a pixel, so that turned windows, whose pixels fall between those of the image, are no softer than it.
fn softened(grey: &Grey) -> Grey {
    let pass = |from: &Grey, across: bool| {
        let one = |i: usize| {
            let (x, y) = ((i % from.width) as i64, (i / from.width) as i64);
            let at = |d: i64| if across { from.at(x + d, y) } else { from.at(x, y + d) };
            (at(-2) + 4.0 * at(-1) + 6.0 * at(0) + 4.0 * at(1) + at(2)) / 16.0
        };
        Grey { width: from.width, height: from.height, data: (0..from.data.len()).map(one).collect() }
    };
    pass(&pass(grey, true), false)
}

/// Without shading: less its mean over a quarter of a side, and fading to nothing at the edges.
fn flattened(grey: &Grey) -> Grey {
    let n = grey.width;
    let radius = (n / 8) as i64;
    // Along rows by running sums; the result lies the other way round, so that the next goes along columns.
    let blur = |data: &[f32]| -> Vec<f32> {
        let mut out = vec![0.0; n * n];
        let rows: Vec<Vec<f32>> = data
            .par_chunks(n)
            .map(|row| {
                let at = |x: i64| f64::from(row[x.clamp(0, n as i64 - 1) as usize]);
                let mut sum: f64 = (-radius - 1..radius).map(at).sum();
                let mut next = |x: i64| {
                    sum += at(x + radius) - at(x - radius - 1);
                    (sum / (2 * radius + 1) as f64) as f32
                };
                (0..n as i64).map(&mut next).collect()
            })
            .collect();
        rows.iter().enumerate().for_each(|(y, row)| row.iter().enumerate().for_each(|(x, &value)| out[x * n + y] = value));
        out
    };
    let mean = blur(&blur(&grey.data));
    let fade = |k: usize| 0.5 - 0.5 * (TAU * (k as f64 + 0.5) / n as f64).cos();
    let data = (0..n * n).map(|i| (grey.data[i] - mean[i]) * (fade(i % n) * fade(i / n)) as f32).collect();
    Grey { width: n, height: n, data }
}

/// Energy of the spectrum by the angle of its waves, over half a turn.
fn by_angle(grey: &Grey) -> Vec<f64> {
    let n = grey.width;
    let mut data: Vec<DVec2> = grey.data.iter().map(|&x| DVec2::new(f64::from(x), 0.0)).collect();
    let turns = turns(n);
    data.par_chunks_mut(n).for_each(|row| transform(row, &turns));
    let mut turned: Vec<DVec2> = (0..n * n).map(|i| data[i % n * n + i / n]).collect();
    turned.par_chunks_mut(n).for_each(|column| transform(column, &turns));
    let mut out = vec![0.0; BINS];
    let signed = |k: usize| if k < n / 2 { k as f64 } else { k as f64 - n as f64 };
    for (i, value) in turned.iter().enumerate() {
        let wave = DVec2::new(signed(i / n), signed(i % n));
        if wave.length() >= LOWEST && wave.length() < n as f64 / 2.0 {
            let angle = wave.y.atan2(wave.x).rem_euclid(PI);
            out[((angle / PI * BINS as f64) as usize).min(BINS - 1)] += value.length_squared();
        }
    }
    out
}

/// What [`transform`] turns by, for one length.
fn turns(n: usize) -> Vec<DVec2> {
    (0..n / 2).map(|k| DVec2::from_angle(-TAU * k as f64 / n as f64)).collect()
}

/// The discrete Fourier transform in place, for lengths that are powers of two (Cooley, Tukey 1965).
fn transform(data: &mut [DVec2], turns: &[DVec2]) {
    let n = data.len();
    let bits = n.trailing_zeros();
    for i in 0..n {
        let j = i.reverse_bits() >> (usize::BITS - bits);
        if i < j {
            data.swap(i, j);
        }
    }
    let mut half = 1;
    while half < n {
        for block in data.chunks_mut(2 * half) {
            let (low, high) = block.split_at_mut(half);
            for ((a, b), turn) in low.iter_mut().zip(high).zip(turns.iter().step_by(n / (2 * half))) {
                let turned = b.rotate(*turn);
                (*a, *b) = (*a + turned, *a - turned);
            }
        }
        half *= 2;
    }
}

/// What windows miss when they are turned by each of these, degrees: 0 nothing, 1 everything.
fn misses(grey: &Grey, turns: &[f64]) -> Vec<f64> {
    let (w, h) = (grey.width as i64, grey.height as i64);
    // A turned window must lie within the image whole.
    let margin = RADIUS + 1;
    if w < 2 * margin + APART || h < 2 * margin + APART {
        return vec![1.0; turns.len()];
    }
    let place = |i: usize, n: i64| margin + (n - 1 - 2 * margin) * (2 * i as i64 + 1) / (2 * WINDOWS as i64);
    let places: Vec<(i64, i64)> = (0..WINDOWS * WINDOWS).map(|i| (place(i % WINDOWS, w), place(i / WINDOWS, h))).collect();
    // Rows of a window, the longest first: they tell most.
    let mut rows: Vec<(i64, i64)> = (-RADIUS..=RADIUS)
        .map(|dy| (dy, (0..=RADIUS).rev().find(|dx| dx * dx + dy * dy <= RADIUS * RADIUS).unwrap_or(0)))
        .collect();
    rows.sort_by_key(|&(dy, half)| (-half, dy));
    // Per window: how much there is to match, the best match unturned elsewhere, and each turn's.
    let window = |&(cx, cy): &(i64, i64)| -> Vec<f64> {
        let best = |turn: f64| {
            let (sine, cosine) = turn.to_radians().sin_cos();
            let turned = |dx: i64, dy: i64| {
                let (x, y) = (dx as f64, dy as f64);
                // Every template lies between pixels alike, so that none is sharper than the others.
                grey.bilinear(cx as f64 + 0.35 + cosine * x - sine * y, cy as f64 + 0.35 + sine * x + cosine * y)
            };
            let template: Vec<Vec<f32>> =
                rows.iter().map(|&(dy, half)| (-half..=half).map(|dx| turned(dx, dy)).collect()).collect();
            let mut best = f32::INFINITY;
            let mut sums = vec![0.0; (w - 2 * margin) as usize];
            for y in margin..h - margin {
                // All places of a row at a time.
                sums.fill(0.0);
                for (&(dy, half), told) in rows.iter().zip(&template) {
                    let row = &grey.data[((y + dy) * w) as usize..][..w as usize];
                    for (dx, &told) in (-half..=half).zip(told) {
                        let found = &row[(margin + dx) as usize..];
                        sums.iter_mut().zip(found).for_each(|(sum, &value)| *sum += (value - told) * (value - told));
                    }
                    if sums.iter().all(|&sum| sum >= best) {
                        break;
                    }
                }
                let near = |x: usize| (x as i64 + margin - cx).abs() < APART && (y - cy).abs() < APART;
                best = (0..sums.len()).filter(|&x| !near(x)).map(|x| sums[x]).fold(best, f32::min);
            }
            f64::from(best)
        };
        let values = || rows.iter().flat_map(|&(dy, half)| (-half..=half).map(move |dx| f64::from(grey.at(cx + dx, cy + dy))));
        let mean = values().sum::<f64>() / values().count() as f64;
        let spread = values().map(|v| (v - mean).powi(2)).sum();
        [spread, best(0.0)].into_iter().chain(turns.iter().map(|&turn| best(turn))).collect()
    };
    let found: Vec<Vec<f64>> = places.par_iter().map(window).collect();
    let sum = |k: usize| found.iter().map(|f| f[k]).sum::<f64>();
    let (spread, unturned) = (sum(0), sum(1));
    let miss = |k: usize| ((sum(k + 2) - unturned) / (spread - unturned).max(1e-9 + 0.1 * spread)).clamp(0.0, 1.0);
    (0..turns.len()).map(miss).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;

    fn picture(of: impl Fn(f32, f32) -> f32) -> Image {
        Image::from_fn(160, 160, |x, y| Vec3::splat(of(x as f32, -(y as f32)).clamp(0.0, 1.0)))
    }

    /// A wave across lines that run at an angle, degrees counter-clockwise from right.
    fn wave(x: f32, y: f32, degrees: f32, period: f32) -> f32 {
        let (sine, cosine) = degrees.to_radians().sin_cos();
        0.5 + 0.5 * ((y * cosine - x * sine) * std::f32::consts::TAU / period).sin()
    }

    #[test]
    fn stripes_are_two_way_and_their_direction_is_told() {
        for degrees in [0.0, 25.0, 90.0, 141.0, 168.0] {
            let found = symmetry(&picture(|x, y| wave(x, y, degrees, 11.0)));
            assert_eq!((found.n, found.isotropic), (2, false), "{degrees} degrees: {found:?}");
            let direction = found.direction.expect("stripes have one");
            let off = (direction - f64::from(degrees) + 90.0).rem_euclid(180.0) - 90.0;
            assert!(off.abs() < 3.0, "{direction} for {degrees} degrees");
        }
    }

    #[test]
    fn checks_are_four_way_and_hexagons_six_way() {
        for degrees in [0.0, 20.0] {
            let checks =
                symmetry(&picture(|x, y| (wave(x, y, degrees, 13.0) - 0.5) * (wave(x, y, degrees + 90.0, 13.0) - 0.5) * 2.0 + 0.5));
            assert_eq!((checks.n, checks.isotropic), (4, false), "checks at {degrees} degrees: {checks:?}");
            let hexagons = symmetry(&picture(|x, y| {
                // Crests must meet, or turning by 60 degrees swaps bright and dark.
                let (sine, cosine) = degrees.to_radians().sin_cos();
                let (x, y) = (x * cosine + y * sine, y * cosine - x * sine);
                [0.0, 60.0, 120.0]
                    .map(|turn: f32| wave(x - 3.75 * turn.to_radians().sin(), y + 3.75 * turn.to_radians().cos(), turn, 15.0))
                    .iter()
                    .sum::<f32>()
                    / 3.0
            }));
            assert_eq!((hexagons.n, hexagons.isotropic), (6, false), "hexagons at {degrees} degrees: {hexagons:?}");
        }
    }

    #[test]
    fn dots_at_random_look_the_same_every_way() {
        let mut random = Random::new(4, 0);
        let dots: Vec<[f32; 2]> = (0..700).map(|_| [random.range(0.0, 160.0) as f32, random.range(-160.0, 0.0) as f32]).collect();
        let found =
            symmetry(&picture(|x, y| dots.iter().map(|d| (-((x - d[0]).powi(2) + (y - d[1]).powi(2)) / 6.0).exp()).sum::<f32>()));
        assert!(found.isotropic && found.direction.is_none(), "{found:?}");
    }

    #[test]
    fn what_is_remembered_is_forgotten_with_the_channel_it_was_read_off() {
        let mut exemplar = Exemplar::new("stripes", picture(|x, y| wave(x, y, 30.0, 11.0)));
        let found = exemplar_symmetry(&exemplar);
        assert_eq!(exemplar_symmetry(&exemplar.clone()), found, "a copy remembers");
        let turned = picture(|x, y| wave(x, y, 120.0, 11.0));
        exemplar.set(Channel::BaseColor, turned.clone()).expect("the same size");
        let direction = |found: Option<Symmetry>| found.and_then(|s| s.direction).expect("stripes have one");
        assert!((direction(exemplar_symmetry(&exemplar)) - 120.0).abs() < 3.0, "the new stripes'");
        let mut dark = Exemplar::new("stripes", turned);
        dark.set(Channel::Opacity, Image::grey_from_fn(160, 160, |x, y| wave(x as f32, -(y as f32), 30.0, 11.0)))
            .expect("one component");
        let with = exemplar_symmetry(&dark);
        dark.remove(Channel::Opacity);
        assert_ne!(exemplar_symmetry(&dark), with, "holes are gone");
    }

    #[test]
    fn tiny_and_empty_pictures_have_an_answer() {
        for side in [1, 2, 7, 20] {
            let found = symmetry(&Image::from_fn(side, side, |_, _| Vec3::splat(0.5)));
            assert!(found.n >= 1 && found.confidence.is_finite(), "{side}: {found:?}");
        }
    }
}
