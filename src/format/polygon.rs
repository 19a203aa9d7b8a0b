//! Cutting polygons into triangles.
//!
//! 1. The polygon is laid on the plane of its Newell normal.
//! 2. If every corner is convex it is cut as a fan from its first corner, as every exporter expects.
//! 3. Otherwise ears are clipped: a corner is an ear if it is convex and no other corner that is reflex or straight lies
//!    in its triangle. Those are kept sorted along x, so that a test looks at few of them. Straight corners (points on
//!    an edge) thus become corners of real triangles, not of slivers that would leave a crack when dropped.
//!
//! Every polygon of `n` corners gives `n - 2` triangles that use its corners only, whatever its shape: where no ear is
//! left (self-intersecting outlines), the rest is cut as it comes.

use glam::{DVec2, DVec3, Vec3};

/// Corner triples of a polygon's triangles, in `out`, which is cleared first. `corners` are its positions in order.
pub(crate) fn triangulate(corners: &[Vec3], out: &mut Vec<[u32; 3]>) {
    out.clear();
    let n = corners.len();
    let fan = |out: &mut Vec<[u32; 3]>| out.extend((1..n.saturating_sub(1) as u32).map(|k| [0, k, k + 1]));
    if n <= 3 {
        fan(out);
        return;
    }
    let flat = lay_flat(corners);
    let reflex: Vec<bool> = (0..n).map(|k| !convex(flat[(k + n - 1) % n], flat[k], flat[(k + 1) % n])).collect();
    if !reflex.contains(&true) {
        fan(out);
        return;
    }
    clip_ears(&flat, reflex, out);
}

/// Positions in the plane of the polygon's Newell normal, counter-clockwise, about its first corner.
fn lay_flat(corners: &[Vec3]) -> Vec<DVec2> {
    let origin = corners[0].as_dvec3();
    let p: Vec<DVec3> = corners.iter().map(|c| c.as_dvec3() - origin).collect();
    let n = p.len();
    let normal: DVec3 = (0..n).map(|k| p[k].cross(p[(k + 1) % n])).sum();
    let normal = normal.normalize_or(DVec3::Z);
    let (x, y) = normal.any_orthonormal_pair();
    // `x, y, normal` is right-handed up to the library's choice of signs.
    let y = if x.cross(y).dot(normal) < 0.0 { -y } else { y };
    p.iter().map(|q| DVec2::new(q.dot(x), q.dot(y))).collect()
}

/// Twice the signed area of a triangle.
fn turn(a: DVec2, b: DVec2, c: DVec2) -> f64 {
    (b - a).perp_dot(c - a)
}

/// True if the outline turns left at `b`, by more than the rounding of 32-bit positions on a straight line.
fn convex(a: DVec2, b: DVec2, c: DVec2) -> bool {
    turn(a, b, c) > STRAIGHT * (b.distance_squared(a) + c.distance_squared(b))
}

/// Below this share of the squared edge lengths a turn is none: the same bound by which cleaning calls a face degenerate.
const STRAIGHT: f64 = 1e-9;

fn clip_ears(p: &[DVec2], mut reflex: Vec<bool>, out: &mut Vec<[u32; 3]>) {
    let n = p.len();
    let mut before: Vec<usize> = (0..n).map(|k| (k + n - 1) % n).collect();
    let mut after: Vec<usize> = (0..n).map(|k| (k + 1) % n).collect();
    let mut along_x: Vec<usize> = (0..n).filter(|&k| reflex[k]).collect();
    along_x.sort_by(|&a, &b| p[a].x.total_cmp(&p[b].x));

    let mut at = 0;
    let mut left = n;
    // Corners looked at since the last ear; once round without one means that the outline crosses itself.
    let mut fruitless = 0;
    while left > 3 {
        let (a, b, c) = (before[at], at, after[at]);
        let stuck = fruitless > left;
        if stuck || !reflex[b] && is_ear(p, [a, b, c], &reflex, &along_x) {
            out.push([a as u32, b as u32, c as u32]);
            after[a] = c;
            before[c] = a;
            reflex[b] = false;
            for k in [a, c] {
                // Clipping a neighbour can only make a corner convex, never reflex.
                reflex[k] = reflex[k] && !convex(p[before[k]], p[k], p[after[k]]);
            }
            left -= 1;
            fruitless = 0;
        } else {
            fruitless += 1;
        }
        at = c;
    }
    let (a, c) = (before[at], after[at]);
    out.push([a as u32, at as u32, c as u32]);
}

/// True if no reflex or straight corner lies in the triangle (its border counts, its own corners and points equal to them do not).
fn is_ear(p: &[DVec2], triangle: [usize; 3], reflex: &[bool], along_x: &[usize]) -> bool {
    let [a, b, c] = triangle.map(|k| p[k]);
    let (low, high) = (a.x.min(b.x).min(c.x), a.x.max(b.x).max(c.x));
    let first = along_x.partition_point(|&k| p[k].x < low);
    along_x[first..].iter().take_while(|&&k| p[k].x <= high).all(|&k| {
        let q = p[k];
        let outside = turn(a, b, q) < 0.0 || turn(b, c, q) < 0.0 || turn(c, a, q) < 0.0;
        !reflex[k] || outside || q == a || q == b || q == c
    })
}

#[cfg(test)]
mod tests {
    use super::triangulate;
    use glam::Vec3;

    fn area(corners: &[Vec3], triangles: &[[u32; 3]]) -> (f64, f64) {
        let mut signed = glam::DVec3::ZERO;
        let mut absolute = 0.0;
        for t in triangles {
            let [a, b, c] = t.map(|k| corners[k as usize].as_dvec3());
            signed += (b - a).cross(c - a) * 0.5;
            absolute += (b - a).cross(c - a).length() * 0.5;
        }
        (signed.length(), absolute)
    }

    fn check_simple(corners: &[Vec3], expected_area: f64, what: &str) {
        let mut out = Vec::new();
        triangulate(corners, &mut out);
        assert_eq!(out.len(), corners.len() - 2, "{what}: n - 2 triangles");
        let (signed, absolute) = area(corners, &out);
        assert!((absolute - expected_area).abs() < 1e-5 * expected_area, "{what}: area {absolute}, not {expected_area}");
        assert!((signed - absolute).abs() < 1e-5 * expected_area, "{what}: all triangles face the same way");
    }

    #[test]
    fn a_convex_quad_is_a_fan_from_its_first_corner() {
        let mut out = Vec::new();
        triangulate(&[Vec3::ZERO, Vec3::X, Vec3::new(1.0, 1.0, 0.0), Vec3::Y], &mut out);
        assert_eq!(out, [[0, 1, 2], [0, 2, 3]], "fan");
    }

    #[test]
    fn a_concave_quad_is_cut_along_its_inner_diagonal() {
        let arrow = [[0.0, 0.0], [2.0, -1.0], [0.5, 0.0], [2.0, 1.0]].map(|[x, y]| Vec3::new(x, y, 3.0));
        // A fan from corner 0 is right here, one from corner 1 would leave the arrow: try every start.
        for shift in 0..4 {
            let mut turned = arrow;
            turned.rotate_left(shift);
            check_simple(&turned, 0.5, "arrow head");
        }
    }

    #[test]
    fn a_spiral_and_a_comb_keep_their_area_in_any_plane() {
        // A comb of 200 teeth: half of its corners are reflex or on long thin teeth.
        let teeth = 200;
        let mut comb = vec![Vec3::new(0.0, -1.0, 0.0), Vec3::new(teeth as f32, -1.0, 0.0)];
        for k in (0..teeth).rev() {
            comb.push(Vec3::new(k as f32 + 1.0, 0.0, 0.0));
            comb.push(Vec3::new(k as f32 + 0.5, 5.0, 0.0));
        }
        comb.push(Vec3::ZERO);
        let expected = teeth as f64 * (1.0 + 2.5);
        for turn in 0..5 {
            let r = glam::Quat::from_euler(glam::EulerRot::XYZ, turn as f32, 2.0 * turn as f32, 0.3);
            let turned: Vec<Vec3> = comb.iter().map(|&p| r * p).collect();
            check_simple(&turned, expected, "comb");
        }
    }

    #[test]
    fn points_on_an_edge_become_corners_of_real_triangles() {
        let square = [[0.0, 0.0], [0.3, 0.0], [0.6, 0.0], [1.0, 0.0], [1.0, 0.7], [1.0, 1.0], [0.0, 1.0]];
        let corners = square.map(|[x, y]| Vec3::new(x, y, 0.0));
        let mut out = Vec::new();
        triangulate(&corners, &mut out);
        for t in &out {
            assert!(area(&corners, &[*t]).1 > 0.01, "triangle {t:?} has area");
        }
        check_simple(&corners, 1.0, "square");
    }

    #[test]
    fn hopeless_outlines_still_give_all_their_triangles() {
        for corners in [vec![Vec3::ZERO; 7], vec![Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::new(1.0, 1.0, 0.0), Vec3::X]] {
            let mut out = Vec::new();
            triangulate(&corners, &mut out);
            assert_eq!(out.len(), corners.len() - 2, "n - 2 triangles");
        }
    }
}
