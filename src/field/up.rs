//! One axis projected onto every face (LT 3.2: "project the global up direction onto the surface, and then normalize").
//!
//! Where a face lies square to the axis the projection says nothing but rounding and noise. So the projections, short
//! where they mean little, are evened out over a tenth of an exemplar width, further where they are short (see
//! [`super::steady`]), and faces where directions cancel take theirs from their neighbours (see [`super::fill`]).

use super::fill::fill;
use super::steady::steady;
use super::{FieldError, TangentField, usable_scale};
use crate::mesh::Mesh;
use crate::mesh::subdivide::Subdivision;
use crate::mesh::transport::{projected, turned};
use glam::{DVec3, Vec3};
use rayon::prelude::*;
use serde::Serialize;

/// Evened out directions that cancel to less than this say nothing: on a top where all sides meet, the faces at the middle.
const CANCELLED: f64 = 0.05;

/// Exemplar widths over which projections are evened out: what is smaller than a tenth of the picture is no direction an
/// artist meant, and a patch cannot follow it.
const EVEN_OUT: f64 = 0.1;

/// A vertex normal that leans further from its face than this cosine (40 degrees) belongs to a crease. The faces of an
/// icosahedron, the coarsest thing that stands for a smooth one, are 37 degrees off.
const SMOOTH: f32 = 0.766;

/// What [`up`] met.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
pub struct UpStatistics {
    /// Faces where nothing says which way, that took their direction from neighbours.
    pub filled_faces: usize,
}

/// The axis projected into every face's plane, `scale` long.
///
/// # Errors
/// If the axis is zero or not finite, or the scale is not a usable length.
pub fn up(mesh: &Mesh, axis: DVec3, scale: f64) -> Result<(TangentField, UpStatistics), FieldError> {
    scaled(directions(mesh, axis, scale)?, scale)
}

/// [`up`] on a subdivision of a mesh. The children of a cut face all lie in its plane; so that cutting it makes the field finer,
/// they project the axis as the smooth surface would: onto the plane across the vertex normals' mean at their centroids. At
/// a crease nothing is smooth, and the face's own plane counts.
///
/// # Errors
/// As [`up`].
pub fn up_on(mesh: &Mesh, fine: &Subdivision, axis: DVec3, scale: f64) -> Result<(TangentField, UpStatistics), FieldError> {
    scaled(directions_on(mesh, fine, axis, scale)?, scale)
}

fn scaled((directions, filled_faces): (Vec<Vec3>, usize), scale: f64) -> Result<(TangentField, UpStatistics), FieldError> {
    let scale = usable_scale(scale)?;
    let up = directions.into_iter().map(|d| d * scale).collect();
    Ok((TangentField::along(up), UpStatistics { filled_faces }))
}

/// Unit directions of [`up`], and how many of them came from neighbours.
pub(super) fn directions(mesh: &Mesh, axis: DVec3, scale: f64) -> Result<(Vec<Vec3>, usize), FieldError> {
    projected_everywhere(mesh, axis, scale, |f| mesh.normal(f))
}

/// Unit directions of [`up_on`].
pub(super) fn directions_on(mesh: &Mesh, fine: &Subdivision, axis: DVec3, scale: f64) -> Result<(Vec<Vec3>, usize), FieldError> {
    let normals = mesh.vertex_normals();
    projected_everywhere(&fine.mesh, axis, scale, |f| {
        if !fine.is_cut(f) {
            return fine.mesh.normal(f);
        }
        let [a, b, c] = fine.corners[f as usize];
        let bary = (a + b + c) / 3.0;
        let parent = fine.parent[f as usize];
        let flat = mesh.normal(parent).as_vec3();
        let smooth = |v: u32| if normals[v as usize].dot(flat) > SMOOTH { normals[v as usize] } else { flat };
        let [a, b, c] = mesh.faces[parent as usize].map(smooth);
        (a * bary.x + b * bary.y + c * bary.z).as_dvec3().normalize_or(fine.mesh.normal(f))
    })
}

/// The axis projected onto the plane across `normal` at each face, turned into the face's own plane, evened out and filled.
fn projected_everywhere(
    mesh: &Mesh,
    axis: DVec3,
    scale: f64,
    normal: impl Fn(u32) -> DVec3 + Sync,
) -> Result<(Vec<Vec3>, usize), FieldError> {
    let unit = axis.try_normalize().filter(|u| u.is_finite()).ok_or(FieldError::Axis(axis))?;
    let at = |f: u32| {
        let (normal, own) = (normal(f), mesh.normal(f));
        projected(turned(projected(unit, normal), normal, own), own)
    };
    let flat: Vec<DVec3> = (0..mesh.face_count() as u32).into_par_iter().map(at).collect();
    let even = steady(mesh, &flat, EVEN_OUT * scale);
    let direction = |v: DVec3| if v.length() < CANCELLED { Vec3::ZERO } else { v.normalize().as_vec3() };
    let mut directions: Vec<Vec3> = even.into_iter().map(direction).collect();
    let filled = fill(mesh, &mut directions, stand_ins(unit));
    Ok((directions, filled))
}

/// Axes for a component that lies square to `axis` everywhere, like a floor: the axis itself, then two across it.
pub(super) fn stand_ins(axis: DVec3) -> [DVec3; 3] {
    let across = axis.any_orthonormal_vector();
    [axis, across, axis.cross(across)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::NONE;
    use crate::mesh::shapes::cube;

    #[test]
    fn the_axis_lies_in_every_plane_and_flat_tops_continue_their_sides() {
        let mesh = cube(6);
        let (field, statistics) = up(&mesh, DVec3::Z * 3.0, 0.5).expect("a field");
        assert!(statistics.filled_faces <= 2 * 8, "only the faces at the middle of top and bottom: {statistics:?}");
        for f in 0..mesh.face_count() as u32 {
            let t = field.up[f as usize].as_dvec3();
            assert!((t.length() - 0.5).abs() < 1e-6, "length {t}");
            assert!(t.dot(mesh.normal(f)).abs() < 1e-6, "in the plane {t}");
            for k in 0..3 {
                let g = mesh.neighbour(f, k);
                let turns = g != NONE && mesh.normal(f).z > 0.9 && mesh.normal(g).z < 0.1;
                if turns {
                    let carried = turned(field.up[g as usize].as_dvec3(), mesh.normal(g), mesh.normal(f));
                    assert!(carried.angle_between(t) < 0.8, "face {f} on the rim continues the side below it");
                }
                let inner = mesh.normal(f).z > 0.9 && mesh.centroid(f).truncate().length() > 0.25;
                if inner {
                    let inward = -mesh.centroid(f).truncate();
                    assert!(t.truncate().angle_to(inward).abs() < 0.9, "face {f} on top points to where the sides meet: {t}");
                }
            }
        }
    }

    #[test]
    fn a_floor_still_gets_one_direction_everywhere() {
        let p = vec![Vec3::ZERO, Vec3::X, Vec3::ONE.with_z(0.0), Vec3::Y];
        let mesh = Mesh::new(p, vec![[0, 1, 2], [0, 2, 3]]).expect("a square");
        let (field, statistics) = up(&mesh, DVec3::Z, 2.0).expect("a field");
        assert_eq!(statistics.filled_faces, 2, "both faces are square to the axis");
        assert!((field.up[0] - field.up[1]).length() < 1e-6 && (field.up[0].length() - 2.0).abs() < 1e-6, "{:?}", field.up);
    }

    #[test]
    fn turning_mesh_and_axis_turns_the_field() {
        let mesh = cube(5);
        let turn = glam::DQuat::from_euler(glam::EulerRot::XYZ, 0.3, -1.1, 2.0);
        let mut turned = mesh.clone();
        turned.positions.iter_mut().for_each(|p| *p = (turn * p.as_dvec3()).as_vec3());
        let axis = DVec3::new(0.2, 1.0, 0.4);
        let (here, _) = up(&mesh, axis, 1.0).expect("a field");
        let (there, _) = up(&turned, turn * axis, 1.0).expect("a field");
        for (f, (a, b)) in here.up.iter().zip(&there.up).enumerate() {
            assert!(((turn * a.as_dvec3()).as_vec3() - b).length() < 1e-4, "face {f}: {a} {b}");
        }
    }

    #[test]
    fn what_is_no_axis_and_no_scale_is_refused() {
        let mesh = cube(1);
        for axis in [DVec3::ZERO, DVec3::new(f64::NAN, 0.0, 1.0), DVec3::splat(f64::INFINITY)] {
            assert!(matches!(up(&mesh, axis, 1.0), Err(FieldError::Axis(_))), "axis {axis}");
        }
        for scale in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e-60] {
            assert!(matches!(up(&mesh, DVec3::Z, scale), Err(FieldError::Scale(_))), "scale {scale}");
        }
    }
}
