//! Local subdivision: marked faces are cut in four, the faces around them so that no vertex ends on an edge.
//!
//! Based on: Bank, Sherman, Weiser, "Refinement algorithms and data structures for regular local mesh refinement" (1983):
//! red faces are cut in four at their edge midpoints, green ones in two.
//!
//! 1. Marked faces are red: all their edges are cut. A face with two cut edges turns red too, which cuts its third; this is
//!    repeated until nothing changes.
//! 2. A face with one cut edge is cut in two, from the midpoint to the corner across.
//!
//! New vertices lie at edge midpoints, so the surface does not move.

use super::{MAX_FACES, Mesh, MeshError, NONE, SurfacePoint, next};
use glam::{Mat3, Vec3};

/// A subdivided mesh and the way back to the one it came from.
#[derive(Debug, Clone)]
pub struct Subdivision {
    /// The finer mesh. Its first vertices are the coarse mesh's.
    pub mesh: Mesh,
    /// The coarse face each fine face lies in. Never decreasing: children are consecutive, parents keep their order.
    pub parent: Vec<u32>,
    /// Barycentric coordinates of each fine face's corners in its parent.
    pub corners: Vec<[Vec3; 3]>,
}

impl Subdivision {
    /// A mesh as its own subdivision, nothing cut.
    #[must_use]
    pub fn none(mesh: &Mesh) -> Self {
        Self {
            mesh: mesh.clone(),
            parent: (0..mesh.face_count() as u32).collect(),
            corners: vec![[Vec3::X, Vec3::Y, Vec3::Z]; mesh.face_count()],
        }
    }

    /// True if a fine face is only part of its parent.
    #[must_use]
    pub fn is_cut(&self, face: u32) -> bool {
        let f = face as usize;
        let same = |g: Option<&u32>| g == Some(&self.parent[f]);
        same(self.parent.get(f + 1)) || f > 0 && same(self.parent.get(f - 1))
    }

    /// The fine surface point at a point of the coarse mesh.
    #[must_use]
    pub fn locate(&self, at: SurfacePoint) -> SurfacePoint {
        let first = self.parent.partition_point(|&p| p < at.face);
        let last = self.parent.partition_point(|&p| p <= at.face);
        // The child in which the point lies deepest: no rounding leaves it between children.
        let mut best = (f32::NEG_INFINITY, SurfacePoint { face: first as u32, bary: at.bary });
        for face in first..last {
            let inverse = Mat3::from_cols_array_2d(&self.corners[face].map(Into::into)).inverse();
            let bary = inverse * at.bary;
            if bary.min_element() > best.0 {
                let inside = bary.max(Vec3::ZERO);
                best = (bary.min_element(), SurfacePoint { face: face as u32, bary: inside / inside.element_sum() });
            }
        }
        best.1
    }

    /// The coarse surface point at a point of the fine mesh.
    #[must_use]
    pub fn origin(&self, at: SurfacePoint) -> SurfacePoint {
        let bary = Mat3::from_cols_array_2d(&self.corners[at.face as usize].map(Into::into)) * at.bary;
        SurfacePoint { face: self.parent[at.face as usize], bary }
    }

    /// This subdivision followed by one of its mesh, as a single one.
    #[must_use]
    pub fn then(&self, finer: Self) -> Self {
        let parent = finer.parent.iter().map(|&f| self.parent[f as usize]).collect();
        let corners = finer
            .parent
            .iter()
            .zip(&finer.corners)
            .map(|(&f, corners)| {
                let [a, b, c] = self.corners[f as usize];
                corners.map(|w| a * w.x + b * w.y + c * w.z)
            })
            .collect();
        Self { mesh: finer.mesh, parent, corners }
    }
}

/// Cuts the marked faces in four and closes the rest. Linear in the size of the mesh. `marked` holds one flag a face; faces
/// beyond its end count as not marked.
///
/// # Errors
/// If the result has more faces than a mesh can hold.
pub fn subdivide(mesh: &Mesh, marked: &[bool]) -> Result<Subdivision, MeshError> {
    let cut = cut_edges(mesh, marked);
    let (midpoint, positions) = midpoints(mesh, &cut);
    let pattern = |f: u32| pattern([0, 1, 2].map(|k| cut[(3 * f + k) as usize]));
    let faces_in = 0..mesh.face_count() as u32;
    let count: usize = faces_in.clone().map(|f| pattern(f).children.len()).sum();
    if count > MAX_FACES || positions.len() > MAX_FACES {
        return Err(MeshError::TooLarge { count: count.max(positions.len()), max: MAX_FACES });
    }
    let mut faces = Vec::with_capacity(count);
    let mut parent = Vec::with_capacity(count);
    let mut corners = Vec::with_capacity(count);
    let mut first_child = Vec::with_capacity(mesh.face_count());
    for f in faces_in.clone() {
        let m = [0, 1, 2].map(|k| midpoint[(3 * f + k) as usize]);
        let [a, b, c] = mesh.faces[f as usize];
        let vertex = [a, b, c, m[0], m[1], m[2]];
        first_child.push(faces.len() as u32);
        for child in pattern(f).children {
            faces.push(child.map(|local| vertex[local]));
            parent.push(f);
            corners.push(child.map(|local| LOCAL[local]));
        }
    }
    // The table follows from the coarse one. Matching vertices anew would not do: two edges may share both their ends.
    let mut opposite = vec![NONE; 3 * count];
    for f in faces_in {
        let base = 3 * first_child[f as usize];
        for &[g, h] in pattern(f).inner {
            opposite[(base + g) as usize] = base + h;
            opposite[(base + h) as usize] = base + g;
        }
        for k in 0..3 {
            let o = mesh.opposite[(3 * f + k) as usize];
            if o == NONE {
                continue;
            }
            // The halves of the edge beyond run the other way.
            let [first, last] = pattern(f).outer[k as usize].map(|h| base + h);
            let [there_first, there_last] = pattern(o / 3).outer[(o % 3) as usize].map(|h| 3 * first_child[(o / 3) as usize] + h);
            opposite[first as usize] = there_last;
            opposite[last as usize] = there_first;
        }
    }
    Ok(Subdivision { mesh: Mesh { positions, faces, opposite }, parent, corners })
}

/// Cuts faces of more than `largest` (world units squared) into such that are not; `None` if there are none.
///
/// # Errors
/// If the result has more faces than a mesh can hold.
pub fn cut_larger(mesh: &Mesh, largest: f64) -> Result<Option<Subdivision>, MeshError> {
    let mut fine: Option<Subdivision> = None;
    loop {
        let now = fine.as_ref().map_or(mesh, |f| &f.mesh);
        let marked: Vec<bool> = (0..now.face_count() as u32).map(|f| now.area(f) > largest).collect();
        if !marked.contains(&true) {
            return Ok(fine);
        }
        let finer = subdivide(now, &marked)?;
        fine = Some(match fine {
            Some(fine) => fine.then(finer),
            None => finer,
        });
    }
}

/// Barycentric coordinates of a face's corners and of the midpoints of the edges that start at them.
const LOCAL: [Vec3; 6] = [Vec3::X, Vec3::Y, Vec3::Z, Vec3::new(0.5, 0.5, 0.0), Vec3::new(0.0, 0.5, 0.5), Vec3::new(0.5, 0.0, 0.5)];

/// How a face is cut. Half-edges are counted through the children: half-edge `k` of child `c` is `3 c + k`.
struct Pattern {
    /// Corners of the children, in terms of [`LOCAL`].
    children: &'static [[usize; 3]],
    /// Pairs of opposite half-edges between children.
    inner: &'static [[u32; 2]],
    /// For each of the face's edges its first and its last half (the same for one that is not cut).
    outer: [[u32; 2]; 3],
}

const fn pattern(cut: [bool; 3]) -> Pattern {
    match cut {
        [false, false, false] => Pattern { children: &[[0, 1, 2]], inner: &[], outer: [[0, 0], [1, 1], [2, 2]] },
        [true, false, false] => Pattern { children: &[[0, 3, 2], [3, 1, 2]], inner: &[[1, 5]], outer: [[0, 3], [4, 4], [2, 2]] },
        [false, true, false] => Pattern { children: &[[1, 4, 0], [4, 2, 0]], inner: &[[1, 5]], outer: [[2, 2], [0, 3], [4, 4]] },
        [false, false, true] => Pattern { children: &[[2, 5, 1], [5, 0, 1]], inner: &[[1, 5]], outer: [[4, 4], [2, 2], [0, 3]] },
        // Two cut edges do not occur: such faces are red.
        _ => Pattern {
            children: &[[0, 3, 5], [3, 1, 4], [5, 4, 2], [3, 4, 5]],
            inner: &[[1, 11], [5, 9], [6, 10]],
            outer: [[0, 3], [4, 7], [8, 2]],
        },
    }
}

/// Per half-edge, whether its edge is cut; closed under "two cut edges cut the third".
fn cut_edges(mesh: &Mesh, marked: &[bool]) -> Vec<bool> {
    let mut cut = vec![false; mesh.opposite.len()];
    let mut red: Vec<u32> = (0..mesh.face_count() as u32).filter(|&f| marked.get(f as usize) == Some(&true)).collect();
    while let Some(f) = red.pop() {
        for h in 3 * f..3 * f + 3 {
            let o = mesh.opposite[h as usize];
            if std::mem::replace(&mut cut[h as usize], true) || o == NONE {
                continue;
            }
            cut[o as usize] = true;
            let (p, q) = (next(o), next(next(o)));
            if cut[p as usize] != cut[q as usize] {
                red.push(o / 3);
            }
        }
    }
    cut
}

/// The vertex at the middle of each half-edge ([`NONE`] if it is not cut), and all positions.
fn midpoints(mesh: &Mesh, cut: &[bool]) -> (Vec<u32>, Vec<Vec3>) {
    let mut midpoint = vec![NONE; cut.len()];
    let mut positions = mesh.positions.clone();
    for h in (0..cut.len() as u32).filter(|&h| cut[h as usize]) {
        let o = mesh.opposite[h as usize];
        if o != NONE && o < h {
            midpoint[h as usize] = midpoint[o as usize];
            continue;
        }
        midpoint[h as usize] = positions.len() as u32;
        positions.push(((mesh.point(mesh.origin(h)) + mesh.point(mesh.origin(next(h)))) / 2.0).as_vec3());
    }
    (midpoint, positions)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;
    use crate::random::Random;

    fn some(mesh: &Mesh, share: f64, seed: u64) -> Vec<bool> {
        let mut random = Random::new(seed, 0);
        (0..mesh.face_count()).map(|_| random.unit() < share).collect()
    }

    #[test]
    fn topology_area_and_orientation_stay() {
        for mesh in [shapes::torus(12, 9, 1.0, 0.3), shapes::uneven_square(12), shapes::sphere(2)] {
            for (seed, share) in [0.0, 0.02, 0.2, 0.7, 1.0].into_iter().enumerate() {
                let fine = subdivide(&mesh, &some(&mesh, share, seed as u64)).expect("it fits");
                fine.mesh.check().expect("a mesh without vertices on edges");
                assert_eq!(fine.mesh.euler_characteristic(), mesh.euler_characteristic(), "Euler characteristic");
                assert_eq!(fine.mesh.boundary_loop_count(), mesh.boundary_loop_count(), "boundary loops");
                let change = (fine.mesh.total_area() / mesh.total_area() - 1.0).abs();
                assert!(change < 1e-5, "area changed by {change}");
                for (f, &parent) in fine.parent.iter().enumerate() {
                    let agree = fine.mesh.normal(f as u32).dot(mesh.normal(parent));
                    assert!(agree > 0.999, "child {f} is turned against its parent: {agree}");
                }
            }
        }
    }

    #[test]
    fn marked_faces_have_four_children_and_unmarked_meshes_stay() {
        let mesh = shapes::torus(12, 9, 1.0, 0.3);
        let marked = some(&mesh, 0.1, 3);
        let fine = subdivide(&mesh, &marked).expect("it fits");
        let mut children = vec![0; mesh.face_count()];
        fine.parent.iter().for_each(|&p| children[p as usize] += 1);
        for (f, (&count, marked)) in children.iter().zip(marked).enumerate() {
            assert!(matches!(count, 1 | 2 | 4), "face {f} has {count} children");
            assert!(!marked || count == 4, "marked face {f} has {count} children");
        }
        assert!(fine.parent.is_sorted(), "children are consecutive and parents in order");
        assert_eq!(subdivide(&mesh, &[]).expect("it fits").mesh, mesh, "nothing marked, nothing changed");
        let all = subdivide(&mesh, &vec![true; mesh.face_count()]).expect("it fits");
        assert_eq!(all.mesh.face_count(), 4 * mesh.face_count(), "all marked: four times the faces");
    }

    #[test]
    fn large_faces_are_cut_until_none_is_left_and_small_ones_stay() {
        let mesh = shapes::uneven_square(8);
        let areas: Vec<f64> = (0..mesh.face_count() as u32).map(|f| mesh.area(f)).collect();
        let largest = areas.iter().copied().fold(0.0, f64::max);
        assert!(cut_larger(&mesh, largest).expect("it fits").is_none(), "nothing is larger than the largest");
        let fine = cut_larger(&mesh, 0.1 * largest).expect("it fits").expect("something is cut");
        fine.mesh.check().expect("manifold");
        for (f, &parent) in fine.parent.iter().enumerate() {
            let area = fine.mesh.area(f as u32);
            assert!(area <= 0.1 * largest, "face {f} is left at {area} of {largest}");
            // Halved beside a cut face, quartered if two are beside it; never cut for nothing.
            let quarter = 0.25 * 0.25 * 0.1 * largest;
            assert!(area >= quarter.min(0.24 * areas[parent as usize]), "face {f} was cut to {area} for nothing");
        }
    }

    #[test]
    fn edges_that_share_both_ends_stay_apart() {
        // Six faces around vertex 0, which meets vertex 1 twice on the way round; the seventh makes one fan at vertex 1 too.
        let faces = vec![[0, 1, 2], [0, 2, 3], [0, 3, 1], [0, 1, 4], [0, 4, 5], [0, 5, 1], [4, 1, 5]];
        let mut opposite = vec![NONE; 21];
        for (g, h) in [(2, 3), (5, 6), (8, 9), (11, 12), (14, 15), (17, 0), (10, 18), (16, 19), (13, 20)] {
            opposite[g as usize] = h;
            opposite[h as usize] = g;
        }
        let positions = vec![Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z, -Vec3::Y, -Vec3::Z];
        let mesh = Mesh { positions, faces, opposite };
        mesh.check().expect("manifold");
        assert!(Mesh::new(mesh.positions.clone(), mesh.faces.clone()).is_err(), "vertices alone do not tell the edges apart");
        let fine = subdivide(&mesh, &vec![true; mesh.face_count()]).expect("it fits");
        fine.mesh.check().expect("still manifold");
        assert_eq!(fine.mesh.euler_characteristic(), mesh.euler_characteristic(), "topology");
    }

    #[test]
    fn a_point_is_found_again_on_the_fine_mesh() {
        let mesh = shapes::torus(12, 9, 1.0, 0.3);
        let once = subdivide(&mesh, &some(&mesh, 0.3, 5)).expect("it fits");
        let fine = once.then(subdivide(&once.mesh, &some(&once.mesh, 0.3, 6)).expect("it fits"));
        let mut random = Random::new(9, 0);
        for face in 0..mesh.face_count() as u32 {
            let (a, b) = (random.unit() as f32, random.unit() as f32);
            let at = SurfacePoint { face, bary: Vec3::new(1.0 - a, a * (1.0 - b), a * b) };
            let there = fine.locate(at);
            assert_eq!(fine.parent[there.face as usize], face, "a child of its face");
            let apart = fine.mesh.position(there).distance(mesh.position(at));
            assert!(apart < 1e-5, "{apart} from its place");
        }
    }

    #[test]
    fn corners_lead_back_through_several_rounds() {
        let mesh = shapes::uneven_square(8);
        let mut fine = Subdivision::none(&mesh);
        for round in 0..3 {
            let finer = subdivide(&fine.mesh, &some(&fine.mesh, 0.2, round)).expect("it fits");
            fine = fine.then(finer);
        }
        assert!(fine.mesh.face_count() > 3 * mesh.face_count(), "{} faces", fine.mesh.face_count());
        for (f, (corners, &parent)) in fine.corners.iter().zip(&fine.parent).enumerate() {
            for (here, &bary) in fine.mesh.corners(f as u32).into_iter().zip(corners) {
                let there = mesh.position(SurfacePoint { face: parent, bary });
                assert!(here.distance(there) < 1e-6, "a corner of face {f}: {here} is not {there}");
            }
        }
    }
}
