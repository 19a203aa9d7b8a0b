//! Where the new vertices start: spread over the faces by area, component by component.
//!
//! Faces are visited along a space-filling curve (Morton 1966) and each takes the whole part of the density summed so far; so
//! neighbouring faces share what none of them has room for, and the points are even from the start. Within a face
//! they follow the additive sequence of Roberts (2018), which is even for any number of them.

use crate::mesh::{Mesh, SurfacePoint};
use crate::random::Random;
use glam::{DVec3, Vec3};

/// Points keep this share of the way to the face's middle away from its sides: at the sides they would make slivers.
const INSET: f64 = 0.06;

/// Roberts' sequence: powers of the inverse of the plastic number.
const STEPS: [f64; 2] = [0.754_877_666_246_692_7, 0.569_840_290_998_053_3];

/// How many vertices each component gets of `count`, by area but no fewer than `least`.
pub(super) fn shares(areas: &[f64], least: &[usize], count: usize) -> Vec<usize> {
    let total: f64 = areas.iter().sum();
    let wish = |c: usize| count as f64 * areas[c] / total;
    let mut shares: Vec<usize> = (0..areas.len()).map(|c| least[c].max(wish(c) as usize)).collect();
    let mut sum: usize = shares.iter().sum();
    let mut order: Vec<usize> = (0..areas.len()).collect();
    // What is missing goes where the whole number cut off most.
    order.sort_by(|&a, &b| wish(b).fract().total_cmp(&wish(a).fract()).then(a.cmp(&b)));
    for &c in order.iter().cycle().take(count.saturating_sub(sum)) {
        shares[c] += 1;
        sum += 1;
    }
    // What the least numbers took too much is taken from those that have most to spare.
    order.sort_by_key(|&c| std::cmp::Reverse(shares[c]));
    for &c in &order {
        let spare = (shares[c] - least[c]).min(sum.saturating_sub(count));
        let fair = ((sum - count.min(sum)) as f64 * areas[c] / total).ceil() as usize;
        let taken = spare.min(fair);
        shares[c] -= taken;
        sum -= taken;
    }
    for &c in &order {
        let taken = (shares[c] - least[c]).min(sum.saturating_sub(count));
        shares[c] -= taken;
        sum -= taken;
    }
    shares
}

/// A component of so few vertices is all corners: it keeps vertices of its own rather than points spread over it, which might
/// lie in one plane.
const SMALL: usize = 24;

/// Gives small components vertices of the original, far apart from each other, in place of sites: adds them to `kept` and takes them
/// off `shares`.
pub(super) fn keep_small(mesh: &Mesh, component: &[u32], shares: &mut [usize], kept: &mut Vec<u32>) {
    let mut of: Vec<Vec<u32>> = vec![Vec::new(); shares.len()];
    let mut seen = vec![false; mesh.vertex_count()];
    kept.iter().for_each(|&v| seen[v as usize] = true);
    for (f, corners) in mesh.faces.iter().enumerate() {
        let c = component[f] as usize;
        if (1..=SMALL).contains(&shares[c]) {
            for &v in corners {
                if !std::mem::replace(&mut seen[v as usize], true) {
                    of[c].push(v);
                }
            }
        }
    }
    for (c, vertices) in of.iter().enumerate().filter(|(_, v)| !v.is_empty()) {
        let mut distance = vec![f64::INFINITY; vertices.len()];
        let mut at = 0;
        for _ in 0..shares[c].min(vertices.len()) {
            let chosen = mesh.point(vertices[at]);
            kept.push(vertices[at]);
            shares[c] -= 1;
            for (d, &v) in distance.iter_mut().zip(vertices) {
                *d = d.min(mesh.point(v).distance_squared(chosen));
            }
            at = (0..distance.len()).fold(0, |best, i| if distance[i] > distance[best] { i } else { best });
        }
    }
}

/// Points in the faces of each component, `shares[c]` in component `c`, in the order of their faces.
pub(super) fn sites(mesh: &Mesh, component: &[u32], shares: &[usize], areas: &[f64], seed: u64) -> Vec<SurfacePoint> {
    let order = along_curve((0..mesh.face_count() as u32).collect(), |f| mesh.centroid(f).as_vec3());
    let mut sums = vec![0.5; shares.len()];
    let mut left = shares.to_vec();
    let mut counts = vec![0_u32; mesh.face_count()];
    let mut last = vec![0_u32; shares.len()];
    for &f in &order {
        let c = component[f as usize] as usize;
        sums[c] += mesh.area(f) * shares[c] as f64 / areas[c];
        let here = (sums[c] as usize).min(left[c]);
        sums[c] -= here as f64;
        left[c] -= here;
        counts[f as usize] = here as u32;
        if mesh.area(f) >= mesh.area(last[c]) || component[last[c] as usize] != component[f as usize] {
            last[c] = f;
        }
    }
    // Rounding may leave one.
    for (c, left) in left.into_iter().enumerate() {
        counts[last[c] as usize] += left as u32;
    }
    let mut random = Random::new(seed, 0x5173);
    let mut out = Vec::with_capacity(shares.iter().sum());
    for (face, &count) in counts.iter().enumerate() {
        let shift = [random.unit(), random.unit()];
        for i in 0..count {
            let [mut u, mut v] = [0, 1].map(|k: usize| (shift[k] + STEPS[k] * f64::from(i)).fract());
            if u + v > 1.0 {
                (u, v) = (1.0 - u, 1.0 - v);
            }
            let bary = DVec3::new(1.0 - u - v, u, v).lerp(DVec3::splat(1.0 / 3.0), INSET);
            out.push(SurfacePoint { face: face as u32, bary: bary.as_vec3() });
        }
    }
    out
}

/// Elements in the order of a space-filling curve through their places.
pub(super) fn along_curve(elements: Vec<u32>, place: impl Fn(u32) -> Vec3) -> Vec<u32> {
    let bounds = (Vec3::INFINITY, Vec3::NEG_INFINITY);
    let (low, high) = elements.iter().map(|&e| place(e)).fold(bounds, |(low, high), p| (low.min(p), high.max(p)));
    let size = (high - low).max_element().max(f32::MIN_POSITIVE);
    let spread = |x: f32| {
        let mut bits = u64::from((x.clamp(0.0, 1.0) * 1_048_575.0) as u32);
        bits = (bits | bits << 32) & 0x001F_0000_0000_FFFF;
        bits = (bits | bits << 16) & 0x001F_0000_FF00_00FF;
        bits = (bits | bits << 8) & 0x100F_00F0_0F00_F00F;
        bits = (bits | bits << 4) & 0x10C3_0C30_C30C_30C3;
        (bits | bits << 2) & 0x1249_2492_4924_9249
    };
    let key = |e: u32| {
        let at = (place(e) - low) / size;
        spread(at.x) | spread(at.y) << 1 | spread(at.z) << 2
    };
    let mut order: Vec<(u64, u32)> = elements.into_iter().map(|e| (key(e), e)).collect();
    order.sort_unstable();
    order.into_iter().map(|(_, e)| e).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;

    #[test]
    fn shares_follow_area_keep_the_least_and_add_up() {
        assert_eq!(shares(&[3.0, 1.0], &[4, 4], 100), [75, 25], "by area");
        assert_eq!(shares(&[1000.0, 1.0, 1.0], &[4, 4, 4], 100), [92, 4, 4], "the least is kept");
        let areas: Vec<f64> = (0..500).map(|i| 1.0 + f64::from(i % 7)).collect();
        let least = vec![4; 500];
        for count in [2000, 2001, 3333, 99_999] {
            let found = shares(&areas, &least, count);
            assert_eq!(found.iter().sum::<usize>(), count, "sum for {count}");
            assert!(found.iter().all(|&n| n >= 4), "least for {count}");
        }
    }

    #[test]
    fn sites_are_as_many_as_asked_and_as_dense_everywhere() {
        let mesh = shapes::uneven_square(40);
        let (component, _) = mesh.components();
        for count in [300, 20_000] {
            let found = sites(&mesh, &component, &[count], &[mesh.total_area()], 1);
            assert_eq!(found.len(), count, "as many as asked");
            let mut cells = [0.0_f64; 16];
            for &s in &found {
                let p = mesh.position(s);
                cells[(p.x * 4.0).min(3.0) as usize * 4 + (p.y * 4.0).min(3.0) as usize] += 16.0 / count as f64;
            }
            // At random the cells of 300 points would differ by a quarter of their number.
            assert!(cells.iter().all(|c| (c - 1.0).abs() < 0.25), "{count}: {cells:?}");
        }
    }
}
