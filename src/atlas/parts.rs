//! Cutting a large mesh into parts of about equal size, which can be unwrapped side by side.
//!
//! Growing and flattening charts takes more than linear time, and one chart keeps one core busy. So a large mesh is cut along
//! planes first, halves of halves, each across the longest side of what it cuts. A plane that grazes the surface leaves islands:
//! small ones go to the part around them. Charts then end at the planes too, a few more of them for each part.

use crate::mesh::{Mesh, NONE};
use std::collections::BTreeMap;

/// An island of fewer faces than this share of a part goes to its neighbour.
const ISLAND: f64 = 1.0 / 32.0;

/// Faces of each part, rising; at most about `most` faces each. None is empty.
#[must_use]
pub fn parts(mesh: &Mesh, most: usize) -> Vec<Vec<u32>> {
    let faces = mesh.face_count();
    let count = faces.div_ceil(most.max(1)).max(1);
    if count == 1 {
        return vec![(0..faces as u32).collect()];
    }
    let mut part = vec![0; faces];
    let mut order: Vec<u32> = (0..faces as u32).collect();
    bisect(mesh, &mut order, (0, count), &mut part);
    join_islands(mesh, &mut part, (faces as f64 / count as f64 * ISLAND) as usize);
    let mut out = vec![Vec::new(); count];
    part.iter().enumerate().for_each(|(f, &p)| out[p].push(f as u32));
    out.retain(|p| !p.is_empty());
    out
}

/// Names these faces by the parts from `first` on, `count` of them.
fn bisect(mesh: &Mesh, faces: &mut [u32], (first, count): (usize, usize), part: &mut [usize]) {
    if count == 1 {
        faces.iter().for_each(|&f| part[f as usize] = first);
        return;
    }
    let (mut low, mut high) = (glam::DVec3::INFINITY, glam::DVec3::NEG_INFINITY);
    for &f in &*faces {
        let p = mesh.centroid(f);
        (low, high) = (low.min(p), high.max(p));
    }
    let sides = high - low;
    let axis = (0..3).fold(0, |best, k| if sides[k] > sides[best] { k } else { best });
    let (left, middle) = (count / 2, faces.len() * (count / 2) / count);
    if middle > 0 {
        let key = |f: u32| mesh.centroid(f)[axis];
        faces.select_nth_unstable_by(middle, |&a, &b| key(a).total_cmp(&key(b)).then(a.cmp(&b)));
    }
    let (below, above) = faces.split_at_mut(middle);
    bisect(mesh, below, (first, left), part);
    bisect(mesh, above, (first + left, count - left), part);
}

/// Gives each connected piece of a part with fewer than `least` faces to the neighbouring part it shares most edges with.
fn join_islands(mesh: &Mesh, part: &mut [usize], least: usize) {
    let mut seen = vec![false; part.len()];
    let (mut island, mut edges): (Vec<u32>, BTreeMap<usize, usize>) = (Vec::new(), BTreeMap::new());
    for start in 0..part.len() as u32 {
        if seen[start as usize] {
            continue;
        }
        seen[start as usize] = true;
        island.clear();
        edges.clear();
        island.push(start);
        let mut next = 0;
        while let Some(&f) = island.get(next) {
            next += 1;
            for o in (0..3).map(|k| mesh.opposite[(3 * f + k) as usize]).filter(|&o| o != NONE) {
                let neighbour = o / 3;
                if part[neighbour as usize] != part[start as usize] {
                    *edges.entry(part[neighbour as usize]).or_default() += 1;
                } else if !seen[neighbour as usize] {
                    seen[neighbour as usize] = true;
                    island.push(neighbour);
                }
            }
        }
        // The first of those with most edges.
        let most = edges.iter().fold(None, |most: Option<(usize, usize)>, (&p, &n)| most.filter(|m| m.1 >= n).or(Some((p, n))));
        if let (true, Some((to, _))) = (island.len() < least, most) {
            island.iter().for_each(|&f| part[f as usize] = to);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;

    #[test]
    fn parts_hold_every_face_once_and_are_of_like_size() {
        let mesh = shapes::sphere(5);
        let faces = mesh.face_count();
        for count in [1, 2, 3, 7, 20] {
            let parts = parts(&mesh, faces.div_ceil(count));
            assert_eq!(parts.len(), count, "parts of {faces} faces");
            let mut all: Vec<u32> = parts.concat();
            all.sort_unstable();
            assert_eq!(all, (0..faces as u32).collect::<Vec<_>>(), "every face is in one part");
            let [least, most] = [parts.iter().map(Vec::len).min(), parts.iter().map(Vec::len).max()].map(Option::unwrap_or_default);
            assert!(most as f64 <= 1.3 * least as f64, "{least} to {most} faces in {count} parts");
        }
    }

    #[test]
    fn small_islands_go_to_the_part_around_them() {
        let mesh = shapes::sphere(4);
        let mut part = vec![0; mesh.face_count()];
        let far = (0..mesh.face_count()).filter(|&f| mesh.centroid(f as u32).x > 0.3).collect::<Vec<_>>();
        far.iter().for_each(|&f| part[f] = 1);
        let whole = part.clone();
        part[far[far.len() / 2]] = 2;
        join_islands(&mesh, &mut part, 10);
        assert_eq!(part, whole, "one face of another part");
        let mut alone = vec![0; mesh.face_count()];
        alone[far[0]] = 1;
        join_islands(&mesh, &mut alone, 1);
        assert_eq!(alone[far[0]], 1, "what is not small stays");
    }
}
