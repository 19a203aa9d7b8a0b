//! Finer faces where the field turns too fast for them.
//!
//! Based on: Praun, Finkelstein, Hoppe 2000, sec. 5: "visual artifacts are caused by poor vector field sampling near these points
//! due to the presence of large faces; we reduce such artifacts by locally subdividing the mesh."
//!
//! 1. Find the field's singular vertices and the faces within two rings of one: around a singular point the direction turns by
//!    about a face's size over its distance, so that further faces turn little, however large they are.
//! 2. Of these, mark the faces that are large against the exemplar and over whose edges the field turns much; if they are more
//!    than the mesh may grow by, those that turn most over their size.
//! 3. Subdivide them and evaluate the field anew; repeat a few times.

use super::singularities::{singularities, turn};
use super::{FieldError, TangentField};
use crate::mesh::subdivide::{Subdivision, subdivide};
use crate::mesh::{Mesh, NONE};
use glam::Vec3;
use serde::Serialize;

/// When to refine.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RefineOptions {
    /// Rounds of subdivision; each halves the edges of the faces it marks.
    pub rounds: usize,
    /// A turn over an edge beyond this (radians) is too fast. 20 degrees: bricks bend visibly beyond it.
    pub turn: f64,
    /// Faces whose longest edge is below this share of the exemplar's width are small enough: their corners then lie a few
    /// texture elements apart at most.
    pub size: f64,
    /// The mesh grows by about this share of its faces at most,
    pub growth: f64,
    /// but it may always grow by this many faces, however few it has.
    pub least_growth: usize,
}

impl Default for RefineOptions {
    fn default() -> Self {
        Self { rounds: 3, turn: 20_f64.to_radians(), size: 0.1, growth: 0.5, least_growth: 4000 }
    }
}

/// Rings of faces around a singular vertex that count.
const RINGS: usize = 2;

/// New faces for a marked one when it stands alone: three of its own and one for each neighbour.
const GROWTH_OF_ONE: usize = 6;

/// What [`refine_near_singularities`] did.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
pub struct RefineStatistics {
    /// Singular vertices of the field on the mesh given.
    pub singularities: usize,
    /// Rounds that subdivided something.
    pub rounds: usize,
    /// Faces of the mesh given that were cut.
    pub cut_faces: usize,
    /// Faces before.
    pub faces_before: usize,
    /// Faces after.
    pub faces_after: usize,
    /// True if the bound on growth left faces uncut.
    pub bounded_by_growth: bool,
}

/// A mesh fine enough for its field, and the way back.
#[derive(Debug, Clone)]
pub struct Refined {
    /// The mesh, and its faces in terms of the mesh given.
    pub subdivision: Subdivision,
    /// The field on it.
    pub field: TangentField,
    /// What was done.
    pub statistics: RefineStatistics,
}

/// Subdivides around the singularities of a field. `evaluate` gives the field on a subdivision of `mesh` (at first on the mesh
/// itself, nothing cut).
///
/// # Errors
/// What `evaluate` returns, or if the mesh grows beyond what a mesh can hold.
pub fn refine_near_singularities(
    mesh: &Mesh,
    options: &RefineOptions,
    mut evaluate: impl FnMut(&Subdivision) -> Result<TangentField, FieldError>,
) -> Result<Refined, FieldError> {
    let mut subdivision = Subdivision::none(mesh);
    let mut field = evaluate(&subdivision)?;
    let before = mesh.face_count();
    let most = before.saturating_add(((before as f64 * options.growth) as usize).max(options.least_growth));
    let mut statistics = RefineStatistics { faces_before: before, ..RefineStatistics::default() };
    for round in 0..options.rounds {
        let singular: Vec<u32> = singularities(&subdivision.mesh, &field.up).iter().map(|s| s.vertex).collect();
        if round == 0 {
            statistics.singularities = singular.len();
        }
        let mut candidates = too_large(&subdivision.mesh, &field.up, &singular, options);
        let affordable = most.saturating_sub(subdivision.mesh.face_count()) / GROWTH_OF_ONE;
        if candidates.len() > affordable {
            statistics.bounded_by_growth = true;
            candidates.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
            candidates.truncate(affordable);
        }
        if candidates.is_empty() {
            break;
        }
        let mut marked = vec![false; subdivision.mesh.face_count()];
        candidates.iter().for_each(|&(f, _)| marked[f as usize] = true);
        let finer = subdivision.then(subdivide(&subdivision.mesh, &marked)?);
        field = evaluate(&finer)?;
        subdivision = finer;
        statistics.rounds = round + 1;
    }
    statistics.faces_after = subdivision.mesh.face_count();
    statistics.cut_faces = subdivision.parent.chunk_by(|a, b| a == b).filter(|children| children.len() > 1).count();
    Ok(Refined { subdivision, field, statistics })
}

/// Steps 1 and 2: faces in order, with the turn over each times its size in exemplar widths.
fn too_large(mesh: &Mesh, up: &[Vec3], singular: &[u32], options: &RefineOptions) -> Vec<(u32, f64)> {
    let first = mesh.vertex_half_edges();
    let mut near = vec![false; mesh.face_count()];
    let mut found = Vec::new();
    let mut ring: Vec<u32> = singular.to_vec();
    for _ in 0..RINGS {
        let mut next_ring = Vec::new();
        for &v in ring.iter().filter(|&&v| first[v as usize] != NONE) {
            for f in mesh.ring(first[v as usize]).map(|h| h / 3) {
                if !std::mem::replace(&mut near[f as usize], true) {
                    next_ring.extend(mesh.faces[f as usize]);
                    found.push(f);
                }
            }
        }
        ring = next_ring;
    }
    found.sort_unstable();
    let severity = |f: u32| {
        let p = mesh.corners(f);
        let longest = (0..3).map(|k| p[k].distance(p[(k + 1) % 3])).fold(0.0, f64::max);
        let size = longest / f64::from(up[f as usize].length());
        let turned = (3 * f..3 * f + 3).map(|h| turn(mesh, up, h).abs()).fold(0.0, f64::max);
        (turned > options.turn && size > options.size).then_some((f, turned * size))
    };
    found.into_iter().filter_map(severity).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::up_on;
    use crate::mesh::{shapes, transport::projected};
    use glam::DVec3;

    /// How far the field is from the true one around the pole of the unit sphere, root mean square over the surface, radians.
    fn error(mesh: &Mesh, field: &TangentField) -> f64 {
        let (mut sum, mut area) = (0.0, 0.0);
        for f in 0..mesh.face_count() as u32 {
            for k in 0..3 {
                // Each corner with a third of the face: a face's one direction is off towards its corners.
                let p = mesh.centroid(f).lerp(mesh.corners(f)[k], 0.6).normalize();
                if p.z > 0.9 {
                    let toward = projected(DVec3::Z - p * p.z, mesh.normal(f));
                    sum += mesh.area(f) * field.up[f as usize].as_dvec3().angle_between(toward).powi(2);
                    area += mesh.area(f);
                }
            }
        }
        (sum / area).sqrt()
    }

    #[test]
    fn coarse_poles_become_finer_and_the_field_truer() {
        let mesh = shapes::sphere(2);
        let evaluate = |fine: &Subdivision| up_on(&mesh, fine, DVec3::Z, 1.0).map(|(field, _)| field);
        let plain = evaluate(&Subdivision::none(&mesh)).expect("a field");
        let refined = refine_near_singularities(&mesh, &RefineOptions::default(), evaluate).expect("refines");
        let fine = &refined.subdivision;
        fine.mesh.check().expect("a mesh");
        assert_eq!(fine.mesh.euler_characteristic(), 2, "still a sphere");
        assert_eq!(refined.field.up.len(), fine.mesh.face_count(), "a vector a face");
        assert!(refined.statistics.rounds == 3 && refined.statistics.singularities == 2, "{:?}", refined.statistics);
        assert!(fine.mesh.face_count() < 8 * mesh.face_count(), "only the poles: {:?}", refined.statistics);
        let (before, after) = (error(&mesh, &plain), error(&fine.mesh, &refined.field));
        assert!(after < 0.7 * before, "direction error {before} became {after}");
    }

    #[test]
    fn small_faces_smooth_fields_and_spent_growth_stop_it() {
        let mesh = shapes::sphere(3);
        let scale_of =
            |scale: f64| move |fine: &Subdivision| up_on(&shapes::sphere(3), fine, DVec3::Z, scale).map(|(field, _)| field);
        let huge = refine_near_singularities(&mesh, &RefineOptions::default(), scale_of(100.0)).expect("refines");
        assert_eq!(huge.subdivision.mesh, mesh, "faces far smaller than the exemplar stay");
        let torus = shapes::torus(24, 12, 1.0, 0.3);
        let around = |fine: &Subdivision| {
            let round = |f: u32| DVec3::Z.cross(fine.mesh.centroid(f));
            let up = (0..fine.mesh.face_count() as u32).map(|f| projected(round(f), fine.mesh.normal(f)).as_vec3());
            Ok(TangentField::along(up.collect()))
        };
        let smooth = refine_near_singularities(&torus, &RefineOptions::default(), around).expect("refines");
        assert_eq!((smooth.statistics.singularities, smooth.statistics.rounds), (0, 0), "no singularity, no cut");
        let many = RefineOptions { rounds: 12, size: 1e-9, turn: 0.0, growth: 0.0, least_growth: 200 };
        let bounded = refine_near_singularities(&mesh, &many, scale_of(1.0)).expect("refines");
        assert!(bounded.statistics.bounded_by_growth, "{:?}", bounded.statistics);
        assert!(bounded.subdivision.mesh.face_count() <= mesh.face_count() + 300, "{:?}", bounded.statistics);
    }
}
