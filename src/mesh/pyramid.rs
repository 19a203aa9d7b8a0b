//! A pyramid of meshes: each level has a quarter of the vertices of the one below it, and all are re-tiled.
//!
//! Based on: Wei, Levoy, "Texture synthesis over arbitrary manifold surfaces", SIGGRAPH 2001, sec. 3.1: "The retiling progresses
//! from higher to lower resolutions, and we retile each lower resolution mesh with one quarter of the number of vertices of the
//! immediate higher resolution."
//!
//! A vertex's parent is the point where the line along its normal meets the coarser level, on whichever side that is nearer.
//! Where the line misses, which happens beside boundaries and over sharp tips, the nearest point stands in and is told apart.

use super::nearest::Nearest;
use super::retile::{RetileError, RetileOptions, Retiled, retile};
use super::{Mesh, SurfacePoint};
use crate::progress::Progress;
use rayon::prelude::*;

/// Each level has this share of the vertices of the one below.
pub const RATIO: usize = 4;

/// A line along the normal is followed for this many mean edges of the coarser level; what it meets farther away is another part
/// of the surface.
const REACH: f64 = 2.0;

/// A place on a coarser level.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Parent {
    /// Where.
    pub at: SurfacePoint,
    /// Found along the normal; otherwise it is the nearest point, since the normal misses.
    pub along_normal: bool,
}

/// Levels of a mesh, the finest first.
#[derive(Debug, Clone)]
pub struct Pyramid {
    /// The levels. Surface points of the first lie on the mesh given, those of the others on the level before.
    pub levels: Vec<Retiled>,
    /// For each level but the last, the parent of each of its vertices on the next.
    pub parents: Vec<Vec<Parent>>,
}

/// Builds `levels` levels; `options.vertices` is the number of vertices of the finest.
///
/// # Errors
/// If a level has too few vertices for the surface (`levels` is then too large), or `progress` cancels.
pub fn pyramid(mesh: &Mesh, options: &RetileOptions, levels: usize, progress: &dyn Progress) -> Result<Pyramid, RetileError> {
    let mut out = Pyramid { levels: Vec::with_capacity(levels), parents: Vec::new() };
    let mut vertices = options.vertices;
    for level in 0..levels.max(1) {
        let finer = out.levels.last().map_or(mesh, |l: &Retiled| &l.mesh);
        let made = retile(finer, &RetileOptions { vertices, seed: options.seed + level as u64, ..*options }, progress)?;
        if level > 0 {
            out.parents.push(parents(finer, &made.mesh));
        }
        out.levels.push(made);
        vertices = vertices.div_ceil(RATIO);
    }
    Ok(out)
}

/// The parent on `coarse` of each vertex of `fine`.
#[must_use]
pub fn parents(fine: &Mesh, coarse: &Mesh) -> Vec<Parent> {
    let tree = Nearest::new(coarse);
    let normals = fine.vertex_normals();
    let edges = 3.0 * coarse.face_count() as f64;
    let length = |h: u32| coarse.point(coarse.origin(h)).distance(coarse.point(coarse.origin(super::next(h))));
    let reach = REACH * (0..coarse.opposite.len() as u32).map(length).sum::<f64>() / edges;
    let one = |v: u32| {
        let (from, normal) = (fine.point(v), normals[v as usize].as_dvec3());
        let out = tree.ray(from, normal, reach);
        let within = out.map_or(reach, |hit| hit.distance);
        let hit = tree.ray(from, -normal, within).filter(|hit| hit.distance < within || out.is_none()).or(out);
        match hit {
            Some(hit) => Parent { at: hit.at, along_normal: true },
            None => {
                let nowhere = SurfacePoint { face: 0, bary: glam::Vec3::X };
                Parent { at: tree.nearest(from).map_or(nowhere, |hit| hit.at), along_normal: false }
            }
        }
    };
    (0..fine.vertex_count() as u32).into_par_iter().map(one).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;
    use crate::progress::Silent;

    #[test]
    fn levels_have_a_quarter_of_the_vertices_and_parents_lie_below_their_children() {
        for mesh in [shapes::sphere(4), shapes::torus(60, 30, 1.0, 0.4)] {
            let options = RetileOptions { vertices: 3000, ..RetileOptions::default() };
            let made = pyramid(&mesh, &options, 3, &Silent).expect("enough vertices");
            let counts: Vec<usize> = made.levels.iter().map(|l| l.mesh.vertex_count()).collect();
            assert!(counts.iter().zip([3000, 750, 188]).all(|(&n, m)| n.abs_diff(m) <= m / 100 + 1), "{counts:?}");
            for k in 0..2 {
                let (fine, coarse) = (&made.levels[k].mesh, &made.levels[k + 1].mesh);
                assert_eq!(fine.euler_characteristic(), mesh.euler_characteristic(), "level {k}");
                let normals = fine.vertex_normals();
                let edge = made.levels[k + 1].statistics.evenness.mean_edge;
                assert!(made.parents[k].iter().all(|p| p.along_normal), "closed smooth surfaces are never missed");
                for (v, parent) in made.parents[k].iter().enumerate() {
                    let way = coarse.position(parent.at) - fine.point(v as u32);
                    assert!(way.length() < 0.3 * edge, "vertex {v} of level {k}: {} edges away", way.length() / edge);
                    let aside = way.cross(normals[v].as_dvec3()).length();
                    assert!(aside < 1e-5, "vertex {v}: {aside} beside its normal");
                }
            }
        }
    }

    #[test]
    fn beyond_a_boundary_the_nearest_point_is_told_apart() {
        let fine = shapes::uneven_square(10);
        let mut coarse = shapes::uneven_square(4);
        coarse.positions.iter_mut().for_each(|p| *p = *p * 0.5 + glam::Vec3::new(0.0, 0.0, 0.01));
        let found = parents(&fine, &coarse);
        for (v, parent) in found.iter().enumerate() {
            let p = fine.point(v as u32);
            let inside = p.x <= 0.5 && p.y <= 0.5;
            assert_eq!(parent.along_normal, inside, "vertex {v} at {p}");
        }
    }
}
