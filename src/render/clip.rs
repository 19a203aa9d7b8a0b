//! Faces on the fixed-point grid: vertices snapped, and faces cut that cross the near plane or reach too far.

use super::lens::Lens;
use glam::{DVec2, DVec3};

/// Bits below one sample on the fixed-point grid.
pub(super) const SUBSAMPLE_BITS: u32 = 12;
/// Steps of the fixed-point grid per sample.
const STEPS: f64 = (1 << SUBSAMPLE_BITS) as f64;
/// Vertices farther than this many samples from the picture's corner are clipped, so that products of coordinate
/// differences fit 62 bits.
const GUARD: f64 = (1 << 17) as f64;

/// A vertex on the fixed-point grid; `x` is [`OUTSIDE`] if its faces need clipping.
#[derive(Clone, Copy)]
pub(super) struct Projected {
    pub(super) x: i32,
    pub(super) y: i32,
}

/// Marks vertices that are behind the near plane or beyond the guard band.
pub(super) const OUTSIDE: i32 = i32::MIN;

/// A vertex on the grid.
pub(super) fn project(lens: &Lens<'_>, p: DVec3) -> Projected {
    let view = lens.camera.to_view(p);
    let place = lens.project(view);
    let inside = view.z >= lens.camera.near && place.abs().max_element() <= GUARD;
    if inside {
        let [x, y] = snap(place);
        Projected { x, y }
    } else {
        Projected { x: OUTSIDE, y: 0 }
    }
}

fn snap(place: DVec2) -> [i32; 2] {
    [place.x, place.y].map(|v| (v * STEPS).round() as i32)
}

/// The part of a face before the near plane and within the guard band, on the fixed-point grid. Each cut is computed from
/// the edge's end inside to its end outside, so that two faces cut their common edge at the same place.
pub(super) fn clip(lens: &Lens<'_>, corners: [DVec3; 3]) -> Vec<[i32; 2]> {
    let near = lens.camera.near;
    let before = cut(&corners, |p| p.z - near);
    let mut outline: Vec<DVec2> = before.into_iter().map(|p| lens.project(p)).collect();
    for side in [|p: DVec2| GUARD - p.x, |p: DVec2| GUARD + p.x, |p: DVec2| GUARD - p.y, |p: DVec2| GUARD + p.y] {
        outline = cut(&outline, side);
    }
    outline.into_iter().map(|p| snap(p.clamp(DVec2::splat(-GUARD), DVec2::splat(GUARD)))).collect()
}

/// The part of a convex polygon where `inside` is not negative.
fn cut<P: Copy + std::ops::Sub<Output = P> + std::ops::Add<Output = P> + std::ops::Mul<f64, Output = P>>(
    polygon: &[P],
    inside: impl Fn(P) -> f64,
) -> Vec<P> {
    let mut out = Vec::with_capacity(polygon.len() + 1);
    for (i, &p) in polygon.iter().enumerate() {
        let q = polygon[(i + 1) % polygon.len()];
        let (at_p, at_q) = (inside(p), inside(q));
        if at_p >= 0.0 {
            out.push(p);
        }
        if (at_p >= 0.0) != (at_q >= 0.0) {
            let (kept, lost, at_kept, at_lost) = if at_p >= 0.0 { (p, q, at_p, at_q) } else { (q, p, at_q, at_p) };
            out.push(kept + (lost - kept) * (at_kept / (at_kept - at_lost)));
        }
    }
    out
}
