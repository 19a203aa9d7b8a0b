//! What the source map of a texture tells: how it was copied, how large and which way it lies, and whether anything is bare.
//!
//! Points are drawn by area; from each, steps are walked on the surface.
//!
//! | measure | what it is | unit | good |
//! |---|---|---|---|
//! | `copied` | share of points whose neighbour [`COPY`] pixels away was copied along with them: verbatim copying (Ashikhmin, "Synthesizing natural textures", I3D 2001, has the idea of measuring what goes on from what) | share | neither: pieces keep structure, and are seen again |
//! | `copy_length` | the distance at which half of the neighbours were copied along | pixels | neither |
//! | `repeats` | autocorrelation of the source map: the largest share of points that show the same place again at one shift of a third of the exemplar's width or more | share | low; 1 is tiling |
//! | `used` | how evenly the exemplar is used: the exponential of the entropy of its sixteenths of a side, over their number | share | 1 |
//! | `scale` | mean length of a pixel on the surface over the one asked for | ratio | 1 |
//! | `stretch_l2`, `stretch_linf` | texture stretch, the root of the mean of squares over surface and directions, and the largest anywhere, against the same pixels spread evenly (Sander et al., "Texture mapping progressive meshes", SIGGRAPH 2001) | ratio | 1 |
//! | `direction_rms`, `direction_p95` | angle between texture up, turned as the exemplar looks the same, and the field | degrees | 0 |
//! | `least_alpha`, `bare` | how well the worst point is covered, and the share of points that are not opaque | share | 1 and 0 |
//!
//! Stretch and direction are of points whose surroundings were copied together (`mapped`): elsewhere there is no map to speak of.

use super::borders::Border;
use super::pieces::ByArea;
use crate::compare::source::{Origin, Plane, Sourced};
use crate::exemplar::mask::OPAQUE;
use crate::mesh::walk::Walker;
use crate::mesh::{Mesh, SurfacePoint};
use crate::random::Random;
use glam::{DVec2, DVec3};
use rayon::prelude::*;
use serde::Serialize;

/// Points that are looked at.
const POINTS: usize = 6000;
/// Distances at which neighbours are looked for, pixels.
const LENGTHS: [f64; 7] = [1.0, 2.0, 4.0, 8.0, 16.0, 32.0, 64.0];
/// Neighbours farther away than so many widths of the exemplar are not walked to: for them holds what held for the farthest of those
/// that are. A step over a tiny exemplar would lead all around the surface.
const WIDTHS: f64 = 4.0;
/// The distance of `copied`: its place among [`LENGTHS`].
const COPY: usize = 4;
/// A neighbour was copied along if it lies within this share of the distance, and a pixel, of where it would be: a copy may be stretched.
const STRETCHED: f64 = 0.25;
/// Large pieces that repeats are looked for in, the points along a side of each, and that side in widths of the exemplar.
const LARGE: usize = 12;
const ALONG: usize = 40;
const WIDE: f64 = 2.2;
/// Shifts from this share of the exemplar's width on may show that something is repeated.
const FAR: f64 = 1.0 / 3.0;
/// Shifts up to this share of a piece's side are looked at.
const REACH: f64 = 0.6;
/// Two points show the same place if those are nearer than this many steps between points.
const SAME: f64 = 0.75;
/// The exemplar's sides are cut into so many parts for `used`.
const PARTS: usize = 16;
/// Steps of a pixel that are looked at for borders.
const STEPS: usize = 30_000;
/// Borders that are kept.
const MOST_BORDERS: usize = 4000;
/// A step that leads farther than this from where a copy that goes on would be crosses a border, pixels.
const BREAK: f64 = 1.5;

/// A texture with all that its source map is measured against.
#[derive(Clone, Copy)]
pub struct Mapped<'a> {
    /// The surface.
    pub on: &'a Walker<'a>,
    /// What it shows, and from where.
    pub source: &'a dyn Sourced,
    /// The exemplar.
    pub plane: Plane,
    /// Texture up as it was asked for at a point, need not be unit; `None` without a direction.
    pub up: &'a (dyn Fn(SurfacePoint) -> Option<DVec3> + Sync),
    /// Directions at each place that are as good as each other.
    pub ways: u32,
}

/// What the source map tells.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct Mapping {
    /// Share of the points with a neighbour 16 pixels away that was copied along with them.
    pub copied: f64,
    /// Pixels at which half of the neighbours were copied along; 64 stands for that or more.
    pub copy_length: f64,
    /// The largest share of points that show the same place again at one shift.
    pub repeats: f64,
    /// How evenly the exemplar is used.
    pub used: f64,
    /// Share of the points whose surroundings were copied together.
    pub mapped: f64,
    /// Length of a pixel over the one asked for.
    pub scale: f64,
    /// Stretch, root mean square.
    pub stretch_l2: f64,
    /// Stretch, the largest.
    pub stretch_linf: f64,
    /// Angle to the field, degrees, root mean square; `None` without a field.
    pub direction_rms: Option<f64>,
    /// 95 in a hundred are below this.
    pub direction_p95: Option<f64>,
    /// The least alpha.
    pub least_alpha: f64,
    /// Share of the points that are not opaque.
    pub bare: f64,
}

/// Where a measure is worst, and how bad it is there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Extreme {
    /// The point.
    pub at: SurfacePoint,
    /// Its value.
    pub value: f64,
}

/// Where what the source map tells is worst.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Extremes {
    /// The largest stretch.
    pub stretch: Option<Extreme>,
    /// The largest angle to the field, degrees.
    pub direction: Option<Extreme>,
    /// The least alpha.
    pub alpha: Option<Extreme>,
}

/// What is known of one point.
struct Sample {
    at: SurfacePoint,
    origin: Option<Origin>,
    alpha: f64,
    /// Which neighbours were copied along, by distance; `None` without an origin.
    along: Option<[bool; LENGTHS.len()]>,
    /// Degrees.
    angle: Option<f64>,
}

/// Measures a source map; `seed` draws the points.
#[must_use]
pub fn mapping(of: &Mapped, seed: u64) -> (Mapping, Extremes) {
    let area = ByArea::new(of.on.mesh());
    let samples: Vec<Sample> = (0..POINTS as u64).into_par_iter().filter_map(|k| sample(of, &area, seed, k)).collect();
    let mut out = Mapping { least_alpha: 1.0, ..Mapping::default() };
    let mut worst = Extremes::default();
    let shown: Vec<&[bool; LENGTHS.len()]> = samples.iter().filter_map(|s| s.along.as_ref()).collect();
    let shares: [f64; LENGTHS.len()] = std::array::from_fn(|k| share(shown.iter().filter(|a| a[k]).count(), shown.len()));
    out.copied = shares[COPY];
    out.copy_length = half(&shares);
    out.repeats = repeats(of, &area, seed);
    out.used = used(&of.plane, samples.iter().filter_map(|s| s.origin));
    stretch(of, &samples, &mut out, &mut worst);
    let mut angles: Vec<f64> = samples.iter().filter_map(|s| s.angle).collect();
    angles.sort_by(f64::total_cmp);
    if let Some(last) = angles.len().checked_sub(1) {
        out.direction_rms = Some((angles.iter().map(|a| a * a).sum::<f64>() / angles.len() as f64).sqrt());
        out.direction_p95 = Some(angles[(last as f64 * 0.95).round() as usize]);
    }
    for s in &samples {
        out.least_alpha = out.least_alpha.min(s.alpha);
        extreme(&mut worst.direction, s.at, s.angle, |a, b| a > b);
        extreme(&mut worst.alpha, s.at, Some(s.alpha), |a, b| a < b);
    }
    out.bare = share(samples.iter().filter(|s| s.alpha < f64::from(OPAQUE)).count(), samples.len());
    (out, worst)
}

fn share(part: usize, whole: usize) -> f64 {
    if whole > 0 { part as f64 / whole as f64 } else { f64::NAN }
}

/// Takes a value as the worst if it is.
fn extreme(so_far: &mut Option<Extreme>, at: SurfacePoint, value: Option<f64>, worse: impl Fn(f64, f64) -> bool) {
    if let Some(value) = value.filter(|&v| so_far.is_none_or(|e| worse(v, e.value))) {
        *so_far = Some(Extreme { at, value });
    }
}

fn sample(of: &Mapped, area: &ByArea, seed: u64, k: u64) -> Option<Sample> {
    let mut random = Random::new(seed, k);
    let at = area.draw(&mut random)?;
    let origin = of.source.origin(at);
    let alpha = f64::from(of.source.texel(at, 0.0).alpha);
    let direction = tangent(of.on.mesh(), at, &mut random);
    let farthest = WIDTHS * of.plane.size.max_element();
    let along = origin.map(|origin| {
        let mut before = true;
        LENGTHS.map(|length| {
            if length > farthest {
                return before;
            }
            let step = direction * (length * of.plane.pixel);
            let there = of.source.origin(of.on.walk(at, step));
            before =
                there.is_some_and(|there| of.plane.gap(of.on.mesh(), at.face, &origin, &there, step) <= 1.0 + STRETCHED * length);
            before
        })
    });
    let angle = origin.and_then(|o| o.steps).zip((of.up)(at)).map(|([_, down], up)| {
        let normal = of.on.mesh().normal(at.face);
        let up = (up - normal * up.dot(normal)).normalize_or_zero();
        let turn = (-down).dot(up.cross(normal)).atan2((-down).dot(up));
        let way = std::f64::consts::TAU / f64::from(of.ways.max(1));
        let from_next = |turn: f64| (turn - (turn / way).round() * way).abs();
        let own = of.source.ways();
        let turned = |k: u32| turn + std::f64::consts::TAU * f64::from(k) / f64::from(own);
        (0..own).map(|k| from_next(turned(k))).fold(f64::INFINITY, f64::min).to_degrees()
    });
    Some(Sample { at, origin, alpha, along, angle })
}

/// A random unit direction in the plane of a point's face.
fn tangent(mesh: &Mesh, at: SurfacePoint, random: &mut Random) -> DVec3 {
    let (a, b) = mesh.normal(at.face).any_orthonormal_pair();
    let (sine, cosine) = random.range(0.0, std::f64::consts::TAU).sin_cos();
    a * cosine + b * sine
}

/// The distance at which a share falls below one half, between the lengths looked at; those below the first and beyond the last count as
/// these.
fn half(shares: &[f64; LENGTHS.len()]) -> f64 {
    let Some(k) = shares.iter().position(|&s| !(s >= 0.5)) else { return LENGTHS[LENGTHS.len() - 1] };
    if k == 0 {
        return LENGTHS[0];
    }
    let t = (shares[k - 1] - 0.5) / (shares[k - 1] - shares[k]);
    LENGTHS[k - 1] * (LENGTHS[k] / LENGTHS[k - 1]).powf(t)
}

/// How evenly the parts of the exemplar are used.
fn used(plane: &Plane, origins: impl Iterator<Item = Origin>) -> f64 {
    let mut counts = [0.0_f64; PARTS * PARTS];
    for origin in origins {
        let part = (plane.wrapped(origin.pixel) / plane.size * PARTS as f64).floor();
        let [x, y] = part.to_array().map(|p| (p as usize).min(PARTS - 1));
        counts[y * PARTS + x] += 1.0;
    }
    let total: f64 = counts.iter().sum();
    let entropy: f64 = counts.iter().filter(|&&c| c > 0.0).map(|c| -c / total * (c / total).ln()).sum();
    if total > 0.0 { entropy.exp() / (PARTS * PARTS) as f64 } else { f64::NAN }
}

fn stretch(of: &Mapped, samples: &[Sample], out: &mut Mapping, worst: &mut Extremes) {
    let (mut squares, mut density, mut count, mut largest) = (0.0, 0.0, 0_usize, 0.0_f64);
    for s in samples {
        let Some([right, down]) = s.origin.and_then(|o| o.steps) else { continue };
        let area = right.cross(down).length();
        if !(area > 0.0) {
            continue;
        }
        let (rr, rd, dd) = (right.length_squared(), right.dot(down), down.length_squared());
        let most = (0.5 * (rr + dd + ((rr - dd).powi(2) + 4.0 * rd * rd).sqrt())).sqrt();
        squares += 0.5 * (rr + dd);
        density += 1.0 / area;
        count += 1;
        largest = largest.max(most);
        extreme(&mut worst.stretch, s.at, Some(most / of.plane.pixel), |a, b| a > b);
    }
    let n = count as f64;
    let even = (density / n).sqrt();
    out.mapped = share(count, samples.len());
    out.scale = 1.0 / (even * of.plane.pixel);
    out.stretch_l2 = (squares / n).sqrt() * even;
    out.stretch_linf = largest * even;
}

/// The largest share of points that show the same place again at one shift, in the texture's own frame.
fn repeats(of: &Mapped, area: &ByArea, seed: u64) -> f64 {
    let apart = WIDE * of.plane.size.x / ALONG as f64;
    let middle = (ALONG as f64 - 1.0) / 2.0;
    let piece = |k: usize| -> Option<Vec<Option<DVec2>>> {
        // Streams beyond those of the points.
        let at = area.draw(&mut Random::new(seed, (POINTS + k) as u64))?;
        let normal = of.on.mesh().normal(at.face);
        let right = of.source.origin(at).map_or_else(|| normal.any_orthonormal_vector(), |o| o.right);
        let down = right.cross(normal);
        let place = |i: usize| {
            let [x, y] = [i % ALONG, i / ALONG].map(|i| (i as f64 - middle) * apart * of.plane.pixel);
            of.source.origin(of.on.walk(at, right * x + down * y)).map(|o| o.pixel)
        };
        Some((0..ALONG * ALONG).map(place).collect())
    };
    let pieces: Vec<Vec<Option<DVec2>>> = (0..LARGE).into_par_iter().filter_map(piece).collect();
    let reach = (ALONG as f64 * REACH) as i64;
    let shifts: Vec<[i64; 2]> = (0..=reach).flat_map(|dy| (-reach..=reach).map(move |dx| [dx, dy])).collect();
    let far = |&&[dx, dy]: &&[i64; 2]| ((dx * dx + dy * dy) as f64).sqrt() * apart >= FAR * of.plane.size.x;
    let shifts: Vec<&[i64; 2]> = shifts.iter().filter(far).collect();
    let one = |&&[dx, dy]: &&[i64; 2]| {
        let (mut same, mut all) = (0, 0);
        let side = ALONG as i64;
        for piece in &pieces {
            for y in 0..side - dy {
                for x in (-dx).max(0)..side.min(side - dx) {
                    let pair = (piece[(y * side + x) as usize], piece[((y + dy) * side + x + dx) as usize]);
                    if let (Some(p), Some(q)) = pair {
                        all += 1;
                        same += usize::from(of.plane.between(p, q).length() < SAME * apart);
                    }
                }
            }
        }
        share(same, all)
    };
    let all: Vec<f64> = shifts.par_iter().map(one).collect();
    all.into_iter().fold(0.0, f64::max)
}

/// Places where a step of one pixel leads out of what was copied together.
#[must_use]
pub fn breaks(of: &Mapped, seed: u64) -> Vec<Border> {
    let area = ByArea::new(of.on.mesh());
    let one = |k: u64| {
        let mut random = Random::new(seed, k);
        let at = area.draw(&mut random)?;
        let across = tangent(of.on.mesh(), at, &mut random);
        let half = across * (0.5 * of.plane.pixel);
        let from = of.on.walk(at, -half);
        let to = of.on.walk(at, half);
        let (a, b) = (of.source.origin(from)?, of.source.origin(to)?);
        // A step that was turned on its way over an edge is still about as long.
        let step = if from.face == at.face { half * 2.0 } else { of.on.mesh().position(to) - of.on.mesh().position(from) };
        (of.plane.gap(of.on.mesh(), from.face, &a, &b, step) > BREAK).then_some(Border { at, across })
    };
    let mut found: Vec<Border> = (0..STEPS as u64).into_par_iter().filter_map(one).collect();
    found.truncate(MOST_BORDERS);
    found
}
