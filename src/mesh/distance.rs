//! How far two surfaces lie apart.

use super::Mesh;
use super::nearest::Nearest;
use rayon::prelude::*;

/// A face gets at most this many samples along a side: what one face needs must not depend on how large it is.
const MOST_ALONG: f64 = 64.0;

/// Largest distance of a point of `from` from the surface `to`, world units: one side of the Hausdorff distance. Faces are sampled
/// on a lattice no wider than `spacing` (up to 64 samples a side), corners and sides included, so the true distance is at
/// most `spacing` larger. n log n; 0 if a mesh has no faces.
#[must_use]
pub fn farthest(from: &Mesh, to: &Mesh, spacing: f64) -> f64 {
    let tree = Nearest::new(to);
    let of_face = |f: u32| {
        let [a, b, c] = from.corners(f);
        let longest = a.distance(b).max(b.distance(c)).max(c.distance(a));
        let n = (longest / spacing).ceil().clamp(1.0, MOST_ALONG) as u32;
        let samples = (0..=n).flat_map(|i| (0..=n - i).map(move |j| (i, j)));
        let place = |(i, j): (u32, u32)| a + ((b - a) * f64::from(i) + (c - a) * f64::from(j)) / f64::from(n);
        samples.filter_map(|s| tree.nearest(place(s))).map(|hit| hit.distance).fold(0.0, f64::max)
    };
    (0..from.face_count() as u32).into_par_iter().map(of_face).reduce(|| 0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;

    #[test]
    fn spheres_are_as_far_apart_as_their_radii_and_not_the_same_both_ways_when_one_has_a_spike() {
        let small = shapes::sphere(4);
        let mut large = small.clone();
        large.positions.iter_mut().for_each(|p| *p *= 1.5);
        for (a, b) in [(&small, &large), (&large, &small)] {
            let found = farthest(a, b, 0.05);
            assert!((found - 0.5).abs() < 5e-3, "{found} between spheres of radius 1 and 1.5");
        }
        let mut spiked = small.clone();
        spiked.positions[0] *= 3.0;
        let (out, back) = (farthest(&spiked, &small, 0.05), farthest(&small, &spiked, 0.05));
        assert!((out - 2.0).abs() < 1e-5, "the spike is {out} away");
        assert!(back < 0.2, "nothing of the sphere is far from the spiked one: {back}");
    }
}
