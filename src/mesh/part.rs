//! Some faces of a mesh as a mesh of their own, and the way back.
//!
//! Edges to faces that are left out become boundary; a vertex whose kept faces form several fans is repeated, one a fan.

use super::clean::part_fans;
use super::{CleanReport, Mesh, NONE};

/// Part of a mesh.
#[derive(Debug, Clone, PartialEq)]
pub struct Part {
    /// The part.
    pub mesh: Mesh,
    /// For each of its faces the face of the whole, rising. Corners keep their order.
    pub faces: Vec<u32>,
}

impl Part {
    /// The faces for which `keep` holds; `None` if there are none.
    #[must_use]
    pub fn new(whole: &Mesh, keep: impl Fn(u32) -> bool) -> Option<Self> {
        let faces: Vec<u32> = (0..whole.face_count() as u32).filter(|&f| keep(f)).collect();
        if faces.is_empty() {
            return None;
        }
        let mut place = vec![NONE; whole.face_count()];
        faces.iter().enumerate().for_each(|(i, &f)| place[f as usize] = i as u32);
        let across = |h: u32| match whole.opposite[h as usize] {
            NONE => NONE,
            o if place[(o / 3) as usize] == NONE => NONE,
            o => 3 * place[(o / 3) as usize] + o % 3,
        };
        let opposite = faces.iter().flat_map(|&f| [0, 1, 2].map(|k| across(3 * f + k))).collect();
        let corners = faces.iter().map(|&f| whole.faces[f as usize]).collect();
        let (mesh, _) = part_fans(&whole.positions, corners, opposite, &mut CleanReport::default());
        Some(Self { mesh, faces })
    }
}

#[cfg(test)]
mod tests {
    use super::Part;
    use crate::mesh::shapes;

    #[test]
    fn a_part_is_a_mesh_that_keeps_places_and_parts_touching_fans() {
        let whole = shapes::sphere(2);
        // Faces that touch in points only here and there.
        let part = Part::new(&whole, |f| f % 3 == 0).expect("faces are kept");
        part.mesh.check().expect("an oriented manifold");
        assert_eq!(part.faces.len(), whole.face_count().div_ceil(3), "every third face");
        for (mine, &f) in (0..).zip(&part.faces) {
            assert_eq!(part.mesh.corners(mine), whole.corners(f), "corners of face {f}");
        }
        let all = Part::new(&whole, |_| true).expect("faces are kept");
        assert_eq!(all.mesh.opposite, whole.opposite, "the whole is its own part");
        assert_eq!(Part::new(&whole, |_| false), None, "nothing");
    }
}
