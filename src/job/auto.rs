//! What an exemplar's features mean on a mesh: how large they may be before thin parts bend them out of shape.

use crate::mesh::Mesh;
use crate::mesh::curvature::curvature;

/// A feature may bend by so many radians from end to end: a brick that goes around a quarter of a limb is still one.
const MOST_BENT: f64 = std::f64::consts::FRAC_PI_2;
/// The share of the surface that features must fit.
const USUAL: f64 = 0.95;

/// The length up to which features fit all but the thinnest parts of a mesh; infinite if it is flat.
#[must_use]
pub fn largest_feature(mesh: &Mesh) -> f64 {
    let bending = curvature(mesh).face_bending(mesh);
    let mut faces: Vec<(f64, f64)> = (0..).zip(&bending).map(|(f, &b)| (f64::from(b), mesh.area(f))).collect();
    faces.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut left = USUAL * mesh.total_area();
    let usual = faces.iter().find(|(_, area)| {
        left -= area;
        left <= 0.0
    });
    MOST_BENT / usual.map_or(0.0, |f| f.0)
}
