//! From a line drawn by hand, or along pixels, to an outline that pasting takes: a simple polygon of few corners.
//!
//! 1. Where the line comes back to a place where it was, the smaller of the two loops is left out: so go the spurs that remain
//!    where two pieces of a live wire run over the same edge.
//! 2. Corners that lie within a tolerance of a straight line are left out (Ramer 1972; Douglas, Peucker 1973).
//! 3. What still crosses itself is cut at the crossing, and the smaller loop left out, until nothing crosses.

use super::collapse::signed_area;
use super::outline::{Outline, self_crossing};
use glam::{DVec2, Vec2};
use std::collections::HashMap;

/// How far an outline may leave the line it was made of, pixels: less than what a feather of one pixel shows.
pub const TOLERANCE: f32 = 0.6;

impl Outline {
    /// The outline that a closed line means, in pixels; the last point is joined to the first. It may have too few corners to be
    /// used ([`Outline::check`] tells), but never crosses itself.
    #[must_use]
    pub fn untangled(line: &[Vec2], tolerance: f32) -> Self {
        let finite = line.iter().copied().filter(|p| p.is_finite());
        let points = without_crossings(simplified(&without_returns(finite), tolerance));
        Self { points }
    }

    /// Outlines as the text of an outlines file, in the form that [`Outline::from_json`] reads.
    #[must_use]
    pub fn to_json(outlines: &[Self]) -> String {
        let point = |p: &Vec2| format!("[{}, {}]", p.x, p.y);
        let list = |o: &Self| format!("  [{}]", o.points.iter().map(point).collect::<Vec<_>>().join(", "));
        format!("[\n{}\n]\n", outlines.iter().map(list).collect::<Vec<_>>().join(",\n"))
    }
}

/// The line without the loops that end where they began.
fn without_returns(line: impl Iterator<Item = Vec2>) -> Vec<Vec2> {
    let mut kept: Vec<Vec2> = Vec::new();
    let mut place: HashMap<[u32; 2], usize> = HashMap::new();
    for p in line {
        let key = p.to_array().map(f32::to_bits);
        let Some(&before) = place.get(&key) else {
            place.insert(key, kept.len());
            kept.push(p);
            continue;
        };
        // Out of the loop and the line before it the larger stays.
        if area(&kept[before..]) <= area(&kept[..=before]) || before == 0 && kept.len() < 3 {
            let gone = kept.split_off(before + 1);
            for p in gone {
                place.remove(&p.to_array().map(f32::to_bits));
            }
        } else if before > 0 {
            kept.drain(..before);
            place = kept.iter().enumerate().map(|(i, p)| (p.to_array().map(f32::to_bits), i)).collect();
        }
    }
    kept
}

fn area(points: &[Vec2]) -> f64 {
    let points: Vec<DVec2> = points.iter().map(|p| p.as_dvec2()).collect();
    if points.len() < 3 { 0.0 } else { signed_area(&points).abs() }
}

/// The closed line with fewer corners.
fn simplified(points: &[Vec2], tolerance: f32) -> Vec<Vec2> {
    if points.len() < 4 {
        return points.to_vec();
    }
    // Two corners that stay anyway: the first one and the farthest from it.
    let far = (0..points.len()).max_by(|&a, &b| points[0].distance(points[a]).total_cmp(&points[0].distance(points[b])));
    let far = far.unwrap_or(0);
    let mut keep = vec![false; points.len() + 1];
    (keep[0], keep[far]) = (true, true);
    let at = |i: usize| points[i % points.len()];
    let mut stack = vec![(0, far), (far, points.len())];
    while let Some((a, b)) = stack.pop() {
        let (p, way) = (at(a), at(b) - at(a));
        let off = |i: usize| {
            let t = ((at(i) - p).dot(way) / way.length_squared().max(f32::MIN_POSITIVE)).clamp(0.0, 1.0);
            at(i).distance(p + way * t)
        };
        let Some(worst) = (a + 1..b).max_by(|&i, &j| off(i).total_cmp(&off(j))) else { continue };
        if off(worst) > tolerance {
            keep[worst] = true;
            stack.extend([(a, worst), (worst, b)]);
        }
    }
    (0..points.len()).filter(|&i| keep[i]).map(at).collect()
}

/// The polygon without the smaller loops of its crossings. Every cut takes a corner at least, so it ends.
fn without_crossings(points: Vec<Vec2>) -> Vec<Vec2> {
    let mut points: Vec<DVec2> = points.into_iter().map(Vec2::as_dvec2).collect();
    points.dedup();
    while points.len() > 3 {
        let Some([i, j]) = self_crossing(&points) else { break };
        let (i, j) = (i.min(j), i.max(j));
        let n = points.len();
        let met = crossing([points[i], points[i + 1]], [points[j], points[(j + 1) % n]]);
        let inner: Vec<DVec2> = met.into_iter().chain(points[i + 1..=j].iter().copied()).collect();
        let outer: Vec<DVec2> = points[..=i].iter().copied().chain(met).chain(points[j + 1..].iter().copied()).collect();
        let large = |p: &[DVec2]| if p.len() < 3 { 0.0 } else { signed_area(p).abs() };
        let mut rest = if large(&inner) > large(&outer) { inner } else { outer };
        rest.dedup();
        if rest.len() >= n {
            // A corner that touches a side: the touch itself is what must go.
            rest = points;
            rest.remove((i + 1) % n);
        }
        points = rest;
    }
    points.into_iter().map(DVec2::as_vec2).collect()
}

/// Where two sides cross, if in one point inside both.
fn crossing([a, b]: [DVec2; 2], [p, q]: [DVec2; 2]) -> Option<DVec2> {
    let (ab, pq) = (b - a, q - p);
    let across = ab.perp_dot(pq);
    let t = (p - a).perp_dot(pq) / across;
    (across != 0.0 && t > 0.0 && t < 1.0).then(|| a + ab * t)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;

    fn circle(middle: Vec2, radius: f32, from: f32, to: f32) -> Vec<Vec2> {
        (0..=80).map(|i| middle + Vec2::from_angle(from + (to - from) * i as f32 / 80.0) * radius).collect()
    }

    fn simple(points: &[Vec2]) -> bool {
        self_crossing(&points.iter().map(|p| p.as_dvec2()).collect::<Vec<_>>()).is_none()
    }

    #[test]
    fn a_round_line_keeps_its_shape_with_fewer_corners() {
        let line = circle(Vec2::splat(50.0), 40.0, 0.0, 6.2);
        let outline = Outline::untangled(&line, TOLERANCE);
        assert!(outline.points.len() < 45, "{} corners", outline.points.len());
        assert!((area(&outline.points) - area(&line)).abs() < 0.03 * area(&line), "area {}", area(&outline.points));
        assert_eq!(outline.check([100, 100]), Ok(()), "usable");
    }

    #[test]
    fn spurs_and_small_loops_go() {
        let spur = [[10.0, 10.0], [60.0, 10.0], [80.0, 10.0], [90.0, 10.0], [80.0, 10.0], [60.0, 10.0], [60.0, 60.0], [10.0, 60.0]];
        let outline = Outline::untangled(&spur.map(Vec2::from_array), TOLERANCE);
        assert_eq!(outline.points.len(), 4, "the square without its spur: {:?}", outline.points);
        // A figure of eight whose second loop is the smaller one.
        let mut eight = circle(Vec2::new(50.0, 50.0), 30.0, 0.4, 5.9);
        eight.extend(circle(Vec2::new(95.0, 50.0), 12.0, 2.6, -2.6));
        let outline = Outline::untangled(&eight, TOLERANCE);
        assert!(simple(&outline.points), "{:?}", outline.points);
        let disc = area(&circle(Vec2::ZERO, 30.0, 0.0, 6.2));
        assert!((0.9..1.2).contains(&(area(&outline.points) / disc)), "the large loop is left: {}", area(&outline.points));
    }

    #[test]
    fn no_scribble_ever_crosses_itself() {
        let mut random = Random::new(5, 1);
        for round in 0..200 {
            let count = 3 + random.below(60);
            // Whole numbers, so that sides overlap and corners meet.
            let mut coordinate = || random.below(12) as f32;
            let line: Vec<Vec2> = (0..count).map(|_| Vec2::new(coordinate(), coordinate())).collect();
            let outline = Outline::untangled(&line, 0.0);
            assert!(outline.points.len() < 4 || simple(&outline.points), "round {round}: {line:?} became {:?}", outline.points);
        }
    }

    #[test]
    fn outlines_survive_their_file() {
        let outlines = [circle(Vec2::splat(0.5), 0.3, 0.0, 6.0), circle(Vec2::splat(50.0), 30.0, 0.0, 6.0)]
            .map(|line| Outline::untangled(&line, 0.0));
        let again = Outline::from_json(&Outline::to_json(&outlines), "test");
        assert_eq!(again.as_deref(), Ok(&outlines[..]), "to the last bit");
    }
}
