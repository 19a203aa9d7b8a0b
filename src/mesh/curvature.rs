//! Curvature at the vertices.
//!
//! Based on: Rusinkiewicz, "Estimating Curvatures and Their Derivatives on Triangle Meshes", 3DPVT 2004; the Gaussian
//! curvature by the angle deficit (Meyer et al., "Discrete Differential-Geometry Operators", 2002).
//!
//! 1. In each face the shape operator is fitted, by least squares, to the differences of the vertex normals along its edges.
//! 2. Each vertex takes the mean of its faces' operators, turned into its own tangent plane and weighted by the part of the
//!    face that is nearest to it.
//! 3. Its eigenvectors are the principal directions.
//!
//! Curvature is positive where the surface bends away from its normal, as a sphere seen from outside.

use super::transport::turned;
use super::{Mesh, NONE, prev};
use glam::{DMat3, DVec2, DVec3, Vec3};

/// Curvature per vertex; 1 / world units, Gaussian curvature 1 / world units squared.
#[derive(Debug, Clone, PartialEq)]
pub struct Curvature {
    /// Principal curvatures, the one of larger magnitude first.
    pub principal: Vec<[f32; 2]>,
    /// Unit tangent in which the first principal curvature bends; the second bends across it. Arbitrary where both are equal.
    pub direction: Vec<Vec3>,
    /// Gaussian curvature by angle deficit; 0 on boundaries.
    pub gaussian: Vec<f32>,
}

impl Curvature {
    /// Mean of the principal curvatures' magnitudes at a vertex: how strongly the surface bends there, whichever way.
    #[must_use]
    pub fn bending(&self, vertex: u32) -> f32 {
        let [a, b] = self.principal[vertex as usize];
        (a.abs() + b.abs()) / 2.0
    }

    /// [`Curvature::bending`] of each face, the mean over its corners.
    #[must_use]
    pub fn face_bending(&self, mesh: &Mesh) -> Vec<f32> {
        mesh.faces.iter().map(|corners| corners.iter().map(|&v| self.bending(v)).sum::<f32>() / 3.0).collect()
    }
}

/// A symmetric operator on a plane: its values on the plane's two axes, and between them.
type Form = [f64; 3];

/// Curvature of a mesh; linear in its size.
#[must_use]
pub fn curvature(mesh: &Mesh) -> Curvature {
    let normals = mesh.vertex_normals();
    let count = mesh.vertex_count();
    let mut forms = vec![[0.0; 3]; count];
    let mut areas = vec![0.0; count];
    let mut angles = vec![0.0; count];
    let mut boundary = vec![false; count];
    for (f, corners) in mesh.faces.iter().enumerate() {
        let f = f as u32;
        let p = mesh.corners(f);
        let (u, v) = frame(mesh.normal(f));
        let form = face_form(p, corners.map(|v| normals[v as usize].as_dvec3()), u, v);
        let part = corner_areas(p);
        for k in 0..3 {
            let vertex = corners[k] as usize;
            areas[vertex] += part[k];
            let (a, b) = (p[(k + 1) % 3] - p[k], p[(k + 2) % 3] - p[k]);
            angles[vertex] += a.cross(b).length().atan2(a.dot(b));
            let h = 3 * f + k as u32;
            boundary[vertex] |= mesh.opposite[h as usize] == NONE || mesh.opposite[prev(h) as usize] == NONE;
            if let Some(form) = form {
                let turned = turn(form, [u, v], normals[vertex].as_dvec3());
                for (sum, part_of) in forms[vertex].iter_mut().zip(turned) {
                    *sum += part[k] * part_of;
                }
            }
        }
    }
    let mut result = Curvature { principal: Vec::new(), direction: Vec::new(), gaussian: Vec::new() };
    for v in 0..count {
        let area = if areas[v] > 0.0 { areas[v] } else { 1.0 };
        let (principal, direction) = principal(forms[v].map(|x| x / area), normals[v].as_dvec3());
        result.principal.push(principal);
        result.direction.push(direction);
        let used = areas[v] > 0.0 && !boundary[v];
        result.gaussian.push(if used { ((std::f64::consts::TAU - angles[v]) / area) as f32 } else { 0.0 });
    }
    result
}

/// Two unit vectors that span the plane across a unit normal, right-handed with it.
fn frame(normal: DVec3) -> (DVec3, DVec3) {
    let u = if normal == DVec3::ZERO { DVec3::X } else { normal.any_orthonormal_vector() };
    (u, normal.cross(u))
}

/// Step 1: least squares over the three edges. `None` for a needle whose edges do not tell the operator.
fn face_form(p: [DVec3; 3], normals: [DVec3; 3], u: DVec3, v: DVec3) -> Option<Form> {
    let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
    let mut right = DVec3::ZERO;
    for k in 0..3 {
        let edge = p[(k + 1) % 3] - p[k];
        let bend = normals[(k + 1) % 3] - normals[k];
        let (x, y) = (edge.dot(u), edge.dot(v));
        let (a, b) = (bend.dot(u), bend.dot(v));
        xx += x * x;
        xy += x * y;
        yy += y * y;
        right += DVec3::new(x * a, y * a + x * b, y * b);
    }
    let size = xx + yy;
    let matrix = DMat3::from_cols(DVec3::new(xx, xy, 0.0), DVec3::new(xy, size, xy), DVec3::new(0.0, xy, yy)) * (1.0 / size);
    // Determinant of the scaled matrix: about the squared ratio of height to length of the face.
    (matrix.determinant() > 1e-10).then(|| ((matrix.inverse() * right) / size).into())
}

/// The operator on the plane of `axes`, on the frame of the plane across `normal`: the planes are turned into each other by
/// the shortest rotation.
fn turn(form: Form, axes: [DVec3; 2], normal: DVec3) -> Form {
    let from = axes[0].cross(axes[1]);
    let (u, v) = frame(normal);
    let [u, v] = [u, v].map(|x| {
        let back = turned(x, normal, from);
        DVec2::new(back.dot(axes[0]), back.dot(axes[1]))
    });
    let on = |a: DVec2, b: DVec2| form[0] * a.x * b.x + form[1] * (a.x * b.y + a.y * b.x) + form[2] * a.y * b.y;
    [on(u, u), on(u, v), on(v, v)]
}

/// Step 3.
fn principal([a, b, c]: Form, normal: DVec3) -> ([f32; 2], Vec3) {
    let (u, v) = frame(normal);
    let (mean, half) = ((a + c) / 2.0, (a - c) / 2.0);
    let radius = half.hypot(b);
    // The axis of the larger eigenvalue; the other lies across it.
    let angle = b.atan2(half) / 2.0;
    let (high, low) = (mean + radius, mean - radius);
    let along = u * angle.cos() + v * angle.sin();
    if high.abs() >= low.abs() {
        ([high as f32, low as f32], along.as_vec3())
    } else {
        ([low as f32, high as f32], normal.cross(along).as_vec3())
    }
}

/// The area of a face nearest to each of its corners; in an obtuse face half of it goes to the wide corner.
fn corner_areas(p: [DVec3; 3]) -> [f64; 3] {
    let area = (p[1] - p[0]).cross(p[2] - p[0]).length() / 2.0;
    let wide = (0..3).find(|&k| (p[(k + 1) % 3] - p[k]).dot(p[(k + 2) % 3] - p[k]) <= 0.0);
    if let Some(wide) = wide {
        let mut parts = [area / 4.0; 3];
        parts[wide] = area / 2.0;
        return parts;
    }
    let cotangent = |k: usize| {
        let (a, b) = (p[(k + 1) % 3] - p[k], p[(k + 2) % 3] - p[k]);
        a.dot(b) / a.cross(b).length()
    };
    [0, 1, 2].map(|k: usize| {
        let (i, j) = ((k + 1) % 3, (k + 2) % 3);
        (p[k].distance_squared(p[i]) * cotangent(j) + p[k].distance_squared(p[j]) * cotangent(i)) / 8.0
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;
    use std::f64::consts::TAU;

    fn inner(mesh: &Mesh) -> Vec<u32> {
        let mut edge = vec![false; mesh.vertex_count()];
        for h in (0..mesh.opposite.len() as u32).filter(|&h| mesh.opposite[h as usize] == NONE) {
            edge[mesh.origin(h) as usize] = true;
            edge[mesh.origin(crate::mesh::next(h)) as usize] = true;
        }
        // A ring further in: normals on the boundary see one side only.
        let mut near = edge.clone();
        for c in &mesh.faces {
            if c.iter().any(|&v| edge[v as usize]) {
                c.iter().for_each(|&v| near[v as usize] = true);
            }
        }
        (0..mesh.vertex_count() as u32).filter(|&v| !near[v as usize]).collect()
    }

    #[test]
    fn a_sphere_bends_the_same_every_way() {
        let mut mesh = shapes::sphere(4);
        mesh.positions.iter_mut().for_each(|p| *p *= 2.0);
        let c = curvature(&mesh);
        let mut mean = 0.0;
        for v in 0..mesh.vertex_count() {
            let [a, b] = c.principal[v];
            // Worst near the six vertices of four edges, whose normals the uneven fan around them pulls aside.
            assert!((a - 0.5).abs() < 0.04 && (b - 0.5).abs() < 0.04, "vertex {v}: {a} {b}");
            assert!((c.gaussian[v] - 0.25).abs() < 0.02, "vertex {v}: Gaussian {}", c.gaussian[v]);
            mean += (c.bending(v as u32) - 0.5).abs() / mesh.vertex_count() as f32;
        }
        assert!(mean < 0.0075, "mean error {mean}");
    }

    #[test]
    fn a_cylinder_bends_round_and_not_along() {
        let mesh = shapes::parametric(48, 12, |u, v| [3.0 * (u * TAU).cos(), 3.0 * (u * TAU).sin(), 4.0 * v]);
        let c = curvature(&mesh);
        for v in inner(&mesh) {
            let [a, b] = c.principal[v as usize];
            assert!((a - 1.0 / 3.0).abs() < 0.005 && b.abs() < 0.005, "vertex {v}: {a} {b}");
            assert!(c.direction[v as usize].z.abs() < 0.02, "vertex {v} bends along {}", c.direction[v as usize]);
            assert!(c.gaussian[v as usize].abs() < 1e-3, "Gaussian {}", c.gaussian[v as usize]);
        }
    }

    #[test]
    fn a_saddle_bends_both_ways_at_its_middle() {
        let mesh = shapes::parametric(41, 41, |u, v| {
            let (x, y) = (u - 0.5, v - 0.5);
            [x, y, x * x - y * y]
        });
        let c = curvature(&mesh);
        let middle = (0..mesh.vertex_count() as u32)
            .min_by(|&a, &b| mesh.point(a).length().total_cmp(&mesh.point(b).length()))
            .expect("a vertex") as usize;
        let mut pair = c.principal[middle];
        pair.sort_by(f32::total_cmp);
        // Along x the surface bends towards its normal, which counts as negative.
        assert!((pair[0] + 2.0).abs() < 0.05 && (pair[1] - 2.0).abs() < 0.05, "{pair:?}");
        assert!((c.gaussian[middle] + 4.0).abs() < 0.1, "Gaussian {}", c.gaussian[middle]);
        let along = c.direction[middle];
        assert!(along.x.abs().max(along.y.abs()) > 0.99, "a principal direction is an axis: {along}");
    }

    #[test]
    fn angle_deficits_sum_to_the_euler_characteristic() {
        for (mesh, euler) in [(shapes::torus(30, 20, 1.0, 0.3), 0.0), (shapes::sphere(3), 2.0), (shapes::cube(3), 2.0)] {
            let c = curvature(&mesh);
            let mut areas = vec![0.0; mesh.vertex_count()];
            for (f, corners) in mesh.faces.iter().enumerate() {
                let part = corner_areas(mesh.corners(f as u32));
                corners.iter().zip(part).for_each(|(&v, part)| areas[v as usize] += part);
            }
            let total: f64 = c.gaussian.iter().zip(areas).map(|(&g, area)| f64::from(g) * area).sum();
            assert!((total / TAU - euler).abs() < 1e-4, "{} for {euler}", total / TAU);
        }
    }
}
