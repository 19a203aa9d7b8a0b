//! Fields from constraints: directions, scale and, where asked for, a full tangential basis.
//!
//! Directions that cancel where anchors disagree are taken from the neighbours (see [`super::fill`]), so that every face has one.

use super::constraints::Anchor;
use super::fill::fill;
use super::spread::{Base, Carry, spread};
use super::up::{directions as up_directions, directions_on, stand_ins};
use super::{FieldError, Guide, TangentField, usable_scale};
use crate::mesh::Mesh;
use crate::mesh::subdivide::Subdivision;
use glam::{DVec3, Vec3};
use serde::Serialize;

/// Where the blended unit directions sum to less than this share of their weights they cancel: what is left of them is the
/// rounding and the roughness of the mesh.
const CANCELLED: f32 = 0.02;

/// How to make a field of constraints.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FieldOptions {
    /// World length of one exemplar width at relative scale 1.
    pub scale: f64,
    /// The axis of the base field, and of the whole field if no anchor has a direction.
    pub axis: DVec3,
    /// Weight of the base field against the anchors; see [`super::Constraints::base_weight`].
    pub base_weight: f64,
    /// How directions travel.
    pub carry: Carry,
}

impl Default for FieldOptions {
    fn default() -> Self {
        Self { scale: 1.0, axis: DVec3::Y, base_weight: 0.0, carry: Carry::default() }
    }
}

/// What [`constrained`] met.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct ConstrainedStatistics {
    /// Anchors used.
    pub anchors: usize,
    /// Largest distance of a position asked for from the surface, world units.
    pub farthest_position: f64,
    /// Faces that took their direction from neighbours.
    pub filled_faces: usize,
    /// Smallest and largest relative scale.
    pub relative_scale: [f32; 2],
}

/// A tangent field through anchors.
///
/// # Errors
/// If the axis or the scale is unusable, or becomes so by the anchors' relative scale.
pub fn constrained(
    mesh: &Mesh,
    anchors: &[Anchor],
    options: &FieldOptions,
) -> Result<(TangentField, ConstrainedStatistics), FieldError> {
    through_anchors(mesh, anchors, options, || up_directions(mesh, options.axis, options.scale))
}

/// [`constrained`] on a subdivision of the mesh that the anchors are tied to.
///
/// # Errors
/// As [`constrained`].
pub fn constrained_on(
    mesh: &Mesh,
    fine: &Subdivision,
    anchors: &[Anchor],
    options: &FieldOptions,
) -> Result<(TangentField, ConstrainedStatistics), FieldError> {
    let anchors: Vec<Anchor> = anchors.iter().map(|a| a.on(fine)).collect();
    through_anchors(&fine.mesh, &anchors, options, || directions_on(mesh, fine, options.axis, options.scale))
}

fn through_anchors(
    mesh: &Mesh,
    anchors: &[Anchor],
    options: &FieldOptions,
    base: impl Fn() -> Result<(Vec<Vec3>, usize), FieldError>,
) -> Result<(TangentField, ConstrainedStatistics), FieldError> {
    check(mesh, anchors, options)?;
    let directed = anchors.iter().any(|a| a.direction.is_some());
    let (base, base_filled) = if directed && options.base_weight == 0.0 { (Vec::new(), 0) } else { base()? };
    let of_base = Base { weight: options.base_weight, directions: &base };
    let spread = spread(mesh, anchors, &of_base, options.carry);
    let (scales, mut statistics) = scales(mesh, anchors, options, spread.ln_scale)?;
    let directions = match spread.directions {
        Some(blended) => {
            let settled = |d: Vec3| if d.length() < CANCELLED { Vec3::ZERO } else { d.normalize() };
            let mut directions = blended.into_iter().map(settled).collect::<Vec<_>>();
            statistics.filled_faces = fill(mesh, &mut directions, stand_ins(options.axis.normalize_or(DVec3::Y)));
            directions
        }
        None => {
            statistics.filled_faces = base_filled;
            base
        }
    };
    let up: Vec<Vec3> = directions.iter().zip(&scales).map(|(&d, &scale)| d * scale).collect();
    let right = spread.shape.map(|shape| {
        let of = |(f, &[ln_stretch, shear]): (usize, &[f32; 2])| {
            let t = up[f].as_dvec3();
            let s = t.cross(mesh.normal(f as u32)) * f64::from(ln_stretch).exp() + t * f64::from(shear);
            s.as_vec3()
        };
        shape.iter().enumerate().map(of).collect()
    });
    Ok((TangentField { up, right, ways: 1 }, statistics))
}

/// The same scale at every face, and no direction.
///
/// # Errors
/// If the scale is not a usable length.
pub fn isotropic(mesh: &Mesh, scale: f64) -> Result<Guide, FieldError> {
    constrained_scale(mesh, &[], &FieldOptions { scale, ..FieldOptions::default() }).map(|(guide, _)| guide)
}

/// A scale from the anchors' relative scales, and no direction.
///
/// # Errors
/// If the scale is unusable, or becomes so by the anchors' relative scale.
pub fn constrained_scale(
    mesh: &Mesh,
    anchors: &[Anchor],
    options: &FieldOptions,
) -> Result<(Guide, ConstrainedStatistics), FieldError> {
    check(mesh, anchors, options)?;
    let base = Base { weight: options.base_weight, directions: &[] };
    let alone: Vec<Anchor> =
        anchors.iter().map(|a| Anchor { direction: None, ln_stretch: None, shear: None, ..a.clone() }).collect();
    let ln_scale = spread(mesh, &alone, &base, options.carry).ln_scale;
    let (scale, statistics) = scales(mesh, anchors, options, ln_scale)?;
    Ok((Guide::Isotropic { scale }, statistics))
}

/// Anchors and options can come from anywhere; what the spreading relies on is tested here.
fn check(mesh: &Mesh, anchors: &[Anchor], options: &FieldOptions) -> Result<(), FieldError> {
    if !(options.base_weight.is_finite() && options.base_weight >= 0.0) {
        return Err(FieldError::BaseWeight(options.base_weight));
    }
    let count = mesh.face_count();
    let length = |x: f64| x.is_normal() && x > 0.0;
    let usable = |a: &Anchor| (a.at.face as usize) < count && a.at.bary.is_finite() && length(a.extent) && length(a.weight);
    match anchors.iter().position(|a| !usable(a)) {
        Some(index) => Err(FieldError::Anchor { index, face: anchors[index].at.face, count }),
        None => Ok(()),
    }
}

/// World length of one exemplar width per face.
fn scales(
    mesh: &Mesh,
    anchors: &[Anchor],
    options: &FieldOptions,
    ln_scale: Option<Vec<f32>>,
) -> Result<(Vec<f32>, ConstrainedStatistics), FieldError> {
    let plain = usable_scale(options.scale)?;
    let relative = ln_scale.unwrap_or_default();
    let extreme = |of: fn(f32, f32) -> f32| relative.iter().copied().reduce(of).unwrap_or(0.0).exp();
    let statistics = ConstrainedStatistics {
        anchors: anchors.len(),
        farthest_position: anchors.iter().map(|a| a.snapped).fold(0.0, f64::max),
        filled_faces: 0,
        relative_scale: [extreme(f32::min), extreme(f32::max)],
    };
    if relative.is_empty() {
        return Ok((vec![plain; mesh.face_count()], statistics));
    }
    let scales: Result<Vec<f32>, _> = relative.iter().map(|&ln| usable_scale(options.scale * f64::from(ln).exp())).collect();
    Ok((scales?, statistics))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::{Constraint, Constraints};
    use crate::mesh::{shapes, transport::turned};
    use crate::random::Random;

    fn file(constraints: Vec<Constraint>) -> Constraints {
        Constraints { constraints, ..Constraints::default() }
    }

    fn point(position: DVec3) -> Constraint {
        Constraint { position: Some(position.into()), ..Constraint::default() }
    }

    fn anchors(mesh: &Mesh, constraints: Vec<Constraint>) -> Vec<Anchor> {
        file(constraints).anchors(mesh, None, DVec3::Y, 0.1).expect("good constraints")
    }

    fn square() -> Mesh {
        shapes::uneven_square(24)
    }

    #[test]
    fn one_constraint_on_a_plane_gives_a_constant_field() {
        let mesh = square();
        let wish = Constraint { direction: Some([2.0, 1.0, 5.0]), scale: Some(0.5), ..point(DVec3::new(0.2, 0.9, 0.3)) };
        for carry in [Carry::Transport, Carry::Project] {
            let options = FieldOptions { scale: 3.0, carry, ..FieldOptions::default() };
            let (field, statistics) = constrained(&mesh, &anchors(&mesh, vec![wish.clone()]), &options).expect("a field");
            let wanted = Vec3::new(2.0, 1.0, 0.0).normalize() * 1.5;
            for (f, t) in field.up.iter().enumerate() {
                assert!((t - wanted).length() < 1e-5, "face {f}: {t}");
            }
            assert!((statistics.farthest_position - 0.3).abs() < 1e-6, "{statistics:?}");
            assert_eq!(field.right, None, "no shear was asked for");
        }
    }

    #[test]
    fn every_constraint_is_met_however_they_overlap() {
        let mesh = shapes::torus(60, 30, 1.0, 0.35);
        let mut random = Random::new(8, 0);
        let mut wishes = Vec::new();
        for _ in 0..12 {
            let at = DVec3::new(random.range(-1.3, 1.3), random.range(-1.3, 1.3), random.range(-0.3, 0.3));
            let (angle, scale) = (random.range(-90.0, 90.0), random.range(0.5, 2.0));
            wishes.push(Constraint { angle: Some(angle), scale: Some(scale), extent: Some(1.0), ..point(at) });
        }
        let anchors = anchors(&mesh, wishes);
        let (field, _) = constrained(&mesh, &anchors, &FieldOptions::default()).expect("a field");
        for anchor in &anchors {
            // The faces around as well: the field passes through its constraint, it does not jump to it.
            for k in 0..3 {
                for face in [anchor.at.face, mesh.neighbour(anchor.at.face, k)] {
                    let t = field.up[face as usize].as_dvec3();
                    let wanted = turned(anchor.direction.expect("given"), mesh.normal(anchor.at.face), mesh.normal(face));
                    assert!(t.angle_between(wanted) < 0.3, "direction off by {} at face {face}", t.angle_between(wanted));
                    let scale = (t.length().ln() - anchor.ln_scale.expect("given")).abs();
                    assert!(scale < 0.2, "scale off by {scale} at face {face}");
                }
            }
        }
    }

    #[test]
    fn constraints_apart_are_met_and_the_nearest_rules_far_away() {
        let mesh = shapes::torus(60, 30, 1.0, 0.35);
        let (east, west) = (DVec3::X * 1.35, DVec3::X * -1.35);
        let wishes = vec![
            Constraint { direction: Some([0.0, 1.0, 0.3]), scale: Some(2.0), extent: Some(0.2), ..point(east) },
            Constraint { direction: Some([0.0, 0.2, 1.0]), scale: Some(0.25), extent: Some(0.2), ..point(west) },
        ];
        let anchors = anchors(&mesh, wishes);
        let (field, _) = constrained(&mesh, &anchors, &FieldOptions::default()).expect("a field");
        for (anchor, scale) in anchors.iter().zip([2.0, 0.25]) {
            let t = field.up[anchor.at.face as usize].as_dvec3();
            assert!((t.length() / scale - 1.0).abs() < 1e-3, "scale {} at {:?}", t.length(), anchor.at);
            assert!(t.normalize().dot(anchor.direction.expect("given")) > 0.99999, "direction {t} at {:?}", anchor.at);
        }
        // Six to eight extents away from both, still on one's side.
        for f in 0..mesh.face_count() as u32 {
            let c = mesh.centroid(f);
            if c.y.abs() > 0.9 && c.x.abs() > 0.4 {
                let wanted = if c.x > 0.0 { 2.0 } else { 0.25 };
                let scale = f64::from(field.up[f as usize].length());
                assert!((scale / wanted).ln().abs() < 0.05, "face {f} at {c}: {scale}");
            }
        }
    }

    #[test]
    fn blending_weighs_by_gaussians_of_the_distance() {
        let mesh = square();
        let (left, right) = (DVec3::new(0.1, 0.5, 0.0), DVec3::new(0.9, 0.5, 0.0));
        let wishes = vec![
            Constraint { scale: Some(2.0), extent: Some(0.5), ..point(left) },
            Constraint { scale: Some(0.5), extent: Some(0.3), weight: Some(3.0), ..point(right) },
        ];
        let anchors = anchors(&mesh, wishes);
        let (guide, statistics) = constrained_scale(&mesh, &anchors, &FieldOptions::default()).expect("a scale");
        for f in 0..mesh.face_count() as u32 {
            let c = mesh.centroid(f);
            let weight = |at: DVec3, extent: f64| 1.0 / (0.5 * (c.distance(at) / extent).powi(2)).exp_m1();
            let (a, b) = (weight(left, 0.5), 3.0 * weight(right, 0.3));
            let wanted = 2.0_f64.powf((a - b) / (a + b));
            // Weights fade to nothing at a hundredth, and faces average their corners.
            assert!((f64::from(guide.scale(f)) / wanted).ln().abs() < 0.02, "face {f}: {} for {wanted}", guide.scale(f));
        }
        assert!(statistics.relative_scale[0] < 0.6 && statistics.relative_scale[1] > 1.2, "{statistics:?}");
    }

    #[test]
    fn a_base_field_rules_where_no_constraint_reaches() {
        let mesh = square();
        let wish = Constraint { direction: Some([1.0, 0.0, 0.0]), scale: Some(4.0), extent: Some(0.1), ..point(DVec3::ZERO) };
        let options = FieldOptions { base_weight: 0.01, ..FieldOptions::default() };
        let (field, _) = constrained(&mesh, &anchors(&mesh, vec![wish]), &options).expect("a field");
        for f in 0..mesh.face_count() as u32 {
            let t = field.up[f as usize];
            if mesh.centroid(f).length() > 0.5 {
                assert!((t - Vec3::Y).length() < 1e-2, "far away the axis rules: {t}");
            }
            if mesh.centroid(f).length() < 0.05 {
                assert!((t - Vec3::X * 4.0).length() < 0.15, "near the constraint it rules: {t}");
            }
        }
    }

    #[test]
    fn scale_alone_keeps_the_axis_and_direction_alone_keeps_the_scale() {
        let mesh = shapes::torus(24, 16, 1.0, 0.4);
        let scale_only = anchors(&mesh, vec![Constraint { scale: Some(3.0), ..point(DVec3::X) }]);
        let (field, _) = constrained(&mesh, &scale_only, &FieldOptions::default()).expect("a field");
        let (plain, _) = crate::field::up(&mesh, DVec3::Y, FieldOptions::default().scale).expect("a field");
        assert!(
            field.up.iter().zip(&plain.up).all(|(a, b)| (a - 3.0 * b).length() < 1e-5),
            "the axis everywhere, three times as large"
        );
        let direction_only = anchors(&mesh, vec![Constraint { direction: Some([0.0, 1.0, 0.0]), ..point(DVec3::X * 1.4) }]);
        let (field, _) = constrained(&mesh, &direction_only, &FieldOptions::default()).expect("a field");
        assert!(field.up.iter().all(|t| (t.length() - 1.0).abs() < 1e-5), "scale 1 everywhere");
    }

    #[test]
    fn anchors_of_another_mesh_are_refused() {
        let mesh = square();
        let strangers = anchors(&shapes::torus(60, 30, 1.0, 0.4), vec![Constraint { scale: Some(2.0), ..point(DVec3::X) }]);
        let stranger = Anchor { at: crate::mesh::SurfacePoint { face: 2000, ..strangers[0].at }, ..strangers[0].clone() };
        let refused = constrained(&mesh, &[stranger], &FieldOptions::default());
        assert_eq!(refused.map(|_| ()), Err(FieldError::Anchor { index: 0, face: 2000, count: 1152 }), "a face beyond the mesh");
        let flat = Anchor { extent: 0.0, ..anchors(&mesh, vec![Constraint { scale: Some(2.0), ..point(DVec3::X) }])[0].clone() };
        assert!(constrained_scale(&mesh, &[flat], &FieldOptions::default()).is_err(), "no extent");
        let options = FieldOptions { base_weight: f64::NAN, ..FieldOptions::default() };
        assert!(matches!(constrained(&mesh, &[], &options), Err(FieldError::BaseWeight(_))), "no weight");
    }

    #[test]
    fn a_basis_is_sheared_and_stretched_as_asked() {
        let mesh = square();
        let wish = Constraint { stretch: Some(2.0), shear: Some(0.5), ..point(DVec3::ZERO) };
        let (field, _) = constrained(&mesh, &anchors(&mesh, vec![wish]), &FieldOptions::default()).expect("a field");
        for f in 0..mesh.face_count() as u32 {
            let (s, t) = field.basis(&mesh, f);
            assert!((t - DVec3::Y).length() < 1e-5 && (s - DVec3::new(2.0, 0.5, 0.0)).length() < 1e-5, "face {f}: {s} {t}");
        }
    }

    #[test]
    fn a_component_without_constraints_follows_the_nearest_through_space() {
        let near = shapes::torus(24, 16, 1.0, 0.4);
        let mut positions = near.positions.clone();
        positions.extend(near.positions.iter().map(|&p| p + Vec3::X * 4.0));
        let offset = near.vertex_count() as u32;
        let other = near.faces.iter().map(|f| f.map(|v| v + offset));
        let mesh = Mesh::new(positions, near.faces.iter().copied().chain(other).collect()).expect("two tori");
        let wish = Constraint { direction: Some([0.0, 1.0, 0.2]), scale: Some(0.5), ..point(DVec3::X * -1.4) };
        let (field, _) = constrained(&mesh, &anchors(&mesh, vec![wish]), &FieldOptions::default()).expect("a field");
        for f in near.face_count()..mesh.face_count() {
            let t = field.up[f].as_dvec3();
            assert!((t.length() - 0.5).abs() < 1e-5, "face {f} has length {}", t.length());
            assert!(t.dot(mesh.normal(f as u32)).abs() < 1e-5, "face {f}: {t} leaves its plane");
        }
    }

    #[test]
    fn moving_everything_moves_the_field_and_threads_change_nothing() {
        let mesh = shapes::torus(30, 20, 1.0, 0.4);
        let mut random = Random::new(21, 0);
        let mut any = || DVec3::new(random.range(-1.0, 1.0), random.range(-1.0, 1.0), random.range(-1.0, 1.0));
        let wishes: Vec<(DVec3, DVec3)> = (0..7).map(|_| (any(), any())).collect();
        let turn = glam::DQuat::from_euler(glam::EulerRot::XYZ, 0.7, 0.4, -1.9);
        let field = |move_by: &dyn Fn(DVec3) -> DVec3, rotate: glam::DQuat, size: f64| {
            let mut mesh = mesh.clone();
            mesh.positions.iter_mut().for_each(|p| *p = move_by(p.as_dvec3()).as_vec3());
            let wish = |&(p, d): &(DVec3, DVec3)| Constraint {
                direction: Some((rotate * d).into()),
                extent: Some(0.4 * size),
                ..point(move_by(p))
            };
            let anchors = anchors(&mesh, wishes.iter().map(wish).collect());
            constrained(&mesh, &anchors, &FieldOptions { scale: size, ..FieldOptions::default() }).expect("a field").0
        };
        let here = field(&|p| p, glam::DQuat::IDENTITY, 1.0);
        let there = field(&|p| turn * p * 50.0 + DVec3::splat(7.0), turn, 50.0);
        for (f, (a, b)) in here.up.iter().zip(&there.up).enumerate() {
            let moved = (turn * a.as_dvec3() * 50.0).as_vec3();
            assert!((moved - b).length() < 0.02 * 50.0, "face {f}: {moved} {b}");
        }
        for threads in [1, 3] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
            let again = pool.install(|| field(&|p| p, glam::DQuat::IDENTITY, 1.0));
            assert_eq!(again, here, "with {threads} threads");
        }
    }

    #[test]
    fn a_vector_carried_round_a_limb_stays_along_it_where_projection_fails() {
        // A wish across a cylinder's front: carried, it runs round and round; projected, it vanishes at the sides.
        let mesh = shapes::parametric(48, 24, |u, v| {
            let a = u * std::f64::consts::TAU;
            [a.cos(), a.sin(), 4.0 * v]
        });
        let wish = Constraint { direction: Some([0.0, 1.0, 0.0]), ..point(DVec3::new(1.0, 0.0, 2.0)) };
        let anchors = anchors(&mesh, vec![wish]);
        let (field, statistics) = constrained(&mesh, &anchors, &FieldOptions::default()).expect("a field");
        assert_eq!(statistics.filled_faces, 0, "nothing vanishes");
        for f in 0..mesh.face_count() as u32 {
            // Behind, both ways round arrive with opposite meanings of neither: the direction is the same.
            let round = DVec3::Z.cross(mesh.centroid(f)).normalize();
            assert!(field.up[f as usize].as_dvec3().dot(round) > 0.99, "face {f}: {} for {round}", field.up[f as usize]);
        }
        let paper = FieldOptions { carry: Carry::Project, ..FieldOptions::default() };
        let (_, statistics) = constrained(&mesh, &anchors, &paper).expect("a field");
        assert!(statistics.filled_faces > 0, "the paper's sum vanishes somewhere: {statistics:?}");
    }
}
