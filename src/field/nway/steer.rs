//! n-way fields as what steers pasting: one direction a face.

use super::align::{creases, least_curvature};
use super::{Combed, Cut, NWayOptions, NWaySolver, NWayStatistics, Over, comb};
use crate::field::{FieldError, TangentField};
use crate::mesh::Mesh;
use crate::mesh::curvature::curvature;
use crate::progress::Progress;
use glam::DVec2;

/// How strongly [`along_curvature`] follows the surface against smoothness.
const FOLLOW: f64 = 1.0;

/// Bends sharper than this are creases to [`along_curvature`], radians.
const CREASE: f64 = 0.7;

/// What [`relaxed`] and [`along_curvature`] met.
#[derive(Debug, Clone, PartialEq)]
pub struct SteerStatistics {
    /// The field.
    pub field: NWayStatistics,
    /// The line over which the one direction chosen jumps.
    pub cut: Cut,
}

/// The smoothest field of `n` ways, one of them at each face, `scale` long.
///
/// # Errors
/// If the scale is not a usable length.
pub fn relaxed(mesh: &Mesh, n: u32, scale: f64, progress: &dyn Progress) -> Result<(TangentField, SteerStatistics), FieldError> {
    combed(mesh, &NWaySolver::new(mesh, Over::Faces, n), &[], scale, progress)
}

/// A field along the direction in which the surface bends least, and along its creases; smooth where it says nothing.
///
/// # Errors
/// If the scale is not a usable length.
pub fn along_curvature(mesh: &Mesh, scale: f64, progress: &dyn Progress) -> Result<(TangentField, SteerStatistics), FieldError> {
    let solver = NWaySolver::new(mesh, Over::Faces, 2);
    let mut wishes = vec![DVec2::ZERO; mesh.face_count()];
    least_curvature(mesh, &solver.table, 2, &mut wishes, &curvature(mesh), FOLLOW);
    creases(mesh, &solver.table, 2, &mut wishes, CREASE, FOLLOW);
    combed(mesh, &solver, &wishes, scale, progress)
}

fn combed(
    mesh: &Mesh,
    solver: &NWaySolver,
    wishes: &[DVec2],
    scale: f64,
    progress: &dyn Progress,
) -> Result<(TangentField, SteerStatistics), FieldError> {
    let (found, statistics) = solver.solve(wishes, &NWayOptions::default(), progress);
    let Combed { field, cut } = comb(mesh, solver, &found, scale)?;
    Ok((field, SteerStatistics { field: statistics, cut }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;
    use crate::progress::Silent;
    use std::f64::consts::TAU;

    #[test]
    fn on_a_cylinder_the_least_curvature_runs_along() {
        let mesh = shapes::parametric(48, 24, |u, v| [(u * TAU).cos(), (u * TAU).sin(), 4.0 * v]);
        let (field, met) = along_curvature(&mesh, 0.5, &Silent).expect("a field");
        let first = field.up[0].z.signum();
        let away = field.up.iter().filter(|t| t.z * first < 0.4).count();
        assert!(away < mesh.face_count() / 50, "{away} of {} faces", mesh.face_count());
        assert!(field.up.iter().all(|t| (t.length() - 0.5).abs() < 1e-5), "the length asked for, {met:?}");
    }

    #[test]
    fn combing_leaves_a_cut_just_where_singularities_ask_for_one() {
        let torus = shapes::torus(48, 16, 1.0, 0.25);
        let (field, met) = relaxed(&torus, 4, 1.0, &Silent).expect("a field");
        assert_eq!((met.field.singularities, met.cut.edges), (0, 0), "nothing to cut on a torus");
        assert_eq!(crate::field::singularities(&torus, &field.up), [], "nor is it singular as one direction");
        let (_, met) = relaxed(&shapes::sphere(4), 4, 1.0, &Silent).expect("a field");
        assert_eq!(met.field.singularities, 8, "eight quarter turns on a sphere");
        assert!(met.cut.edges > 8 && met.cut.edges < 400, "{} edges are cut", met.cut.edges);
    }
}
