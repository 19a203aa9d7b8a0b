//! Constraints: what the user asks for at some places of the surface (LT 3.2).
//!
//! The file is JSON:
//!
//! ```json
//! { "version": 1, "up": [0, 1, 0], "baseWeight": 0,
//!   "constraints": [
//!     { "face": 120, "direction": [0, 0, 1], "scale": 0.5 },
//!     { "position": [0.1, 0.4, -0.2], "angle": 45, "extentShare": 0.1, "weight": 2 } ] }
//! ```
//!
//! A [`Constraint`] is what is written there; an [`Anchor`] is the same thing checked and tied to a point of a mesh.

use super::{ConstraintProblem, FieldError};
use crate::mesh::clean::UserFace;
use crate::mesh::nearest::Nearest;
use crate::mesh::subdivide::Subdivision;
use crate::mesh::transport::projected;
use crate::mesh::{Mesh, NONE, SurfacePoint};
use glam::{DQuat, DVec3, Vec3};
use serde::{Deserialize, Serialize};

/// The version of the constraints file.
pub const CONSTRAINTS_VERSION: u32 = 1;

/// Extent of a constraint that gives none, as a share of the bounding box's diagonal. Wider ones make the field no smoother
/// (measured on five meshes with 2 to 64 constraints), narrower ones leave sharp borders between constraints. Where constraints
/// stand closer, their mean spacing (the square root of the surface each one has) takes its place: what lies beyond its neighbours
/// is theirs, and a hundred wide constraints would cost a hundred searches of the whole surface.
pub const DEFAULT_EXTENT_SHARE: f64 = 0.2;

/// A vector shorter than this share of its length once laid into the face's plane stands square to it.
const SQUARE: f64 = 1e-4;

/// A constraints file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct Constraints {
    /// [`CONSTRAINTS_VERSION`].
    pub version: u32,
    /// The axis that angles are measured against and the base field follows; without it the caller's axis.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub up: Option<[f64; 3]>,
    /// Weight of the base field (the projected axis, relative scale 1), the same everywhere; constraints have weight 1 at
    /// their place. 0: the constraints alone decide, however far away.
    #[serde(default)]
    pub base_weight: f64,
    /// The constraints.
    pub constraints: Vec<Constraint>,
}

impl Default for Constraints {
    fn default() -> Self {
        Self { version: CONSTRAINTS_VERSION, up: None, base_weight: 0.0, constraints: Vec::new() }
    }
}

/// One wish at one place. `face` or `position` is needed, and at least one thing wished for.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(rename_all = "camelCase", deny_unknown_fields, default)]
pub struct Constraint {
    /// A face as the user counts them, from 0: its centroid is the place.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub face: Option<u32>,
    /// A point in space: the nearest point of the surface is the place.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub position: Option<[f64; 3]>,
    /// Texture up, laid into the surface there; its length does not matter.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub direction: Option<[f64; 3]>,
    /// Texture up as an angle against the projected axis, degrees, counter-clockwise seen from outside.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub angle: Option<f64>,
    /// Scale relative to the base scale: 2 makes the texture twice as large.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub scale: Option<f64>,
    /// Standard deviation of the Gaussian over distance along the surface, world units; see [`DEFAULT_EXTENT_SHARE`].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub extent: Option<f64>,
    /// The same as a share of the bounding box's diagonal.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub extent_share: Option<f64>,
    /// Height of the Gaussian, 1 if absent.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub weight: Option<f64>,
    /// Texture right, laid into the surface, measured against `direction`: as long and square to it changes nothing.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub right: Option<[f64; 3]>,
    /// Width of the texture over its height, relative to the exemplar's: 2 makes it twice as wide.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stretch: Option<f64>,
    /// How far texture right leans towards texture up: S = stretch (T x N) + shear T.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub shear: Option<f64>,
}

/// A checked constraint at a point of a mesh.
#[derive(Debug, Clone, PartialEq)]
pub struct Anchor {
    /// The place.
    pub at: SurfacePoint,
    /// Distance from the position asked for to the place, world units; 0 for a face.
    pub snapped: f64,
    /// Unit direction of texture up in the face's plane.
    pub direction: Option<DVec3>,
    /// Natural logarithm of the relative scale.
    pub ln_scale: Option<f64>,
    /// Natural logarithm of the stretch.
    pub ln_stretch: Option<f64>,
    /// Shear.
    pub shear: Option<f64>,
    /// Standard deviation, world units.
    pub extent: f64,
    /// Weight, above 0.
    pub weight: f64,
}

impl Anchor {
    /// The same anchor on a subdivision of its mesh.
    #[must_use]
    pub fn on(&self, fine: &Subdivision) -> Self {
        Self { at: fine.locate(self.at), ..self.clone() }
    }
}

impl Constraints {
    /// Reads a constraints file's text.
    ///
    /// # Errors
    /// If it is no JSON, has unknown or missing keys (line and column are told), or another version.
    pub fn from_json(text: &str) -> Result<Self, FieldError> {
        const WHAT: &str = "constraints file";
        let syntax = |e: serde_json::Error| FieldError::Syntax { what: WHAT, reason: e.to_string() };
        let read: Self = serde_json::from_str(text).map_err(syntax)?;
        if read.version != CONSTRAINTS_VERSION {
            return Err(FieldError::Version { what: WHAT, found: read.version, expected: CONSTRAINTS_VERSION });
        }
        Ok(read)
    }

    /// The text of a constraints file.
    ///
    /// # Errors
    /// Never for finite numbers; JSON has no others.
    pub fn to_json(&self) -> Result<String, FieldError> {
        serde_json::to_string_pretty(self).map_err(|e| FieldError::Syntax { what: "constraints file", reason: e.to_string() })
    }

    /// The axis of the base field and of angles: the file's, or else `otherwise`.
    #[must_use]
    pub fn axis(&self, otherwise: DVec3) -> DVec3 {
        self.up.map_or(otherwise, DVec3::from)
    }

    /// Checks every constraint and ties it to the mesh. `user_faces` leads from the user's face numbers to the mesh's (see
    /// [`crate::mesh::Cleaned`]); without it they are the mesh's own. `axis` is what angles are measured against, evened out for exemplars `scale` wide (see [`super::up()`]).
    ///
    /// # Errors
    /// The first constraint that cannot be used, and why.
    pub fn anchors(
        &self,
        mesh: &Mesh,
        user_faces: Option<&[UserFace]>,
        axis: DVec3,
        scale: f64,
    ) -> Result<Vec<Anchor>, FieldError> {
        let tree = self.constraints.iter().any(|c| c.position.is_some()).then(|| Nearest::new(mesh));
        self.anchors_near(mesh, tree.as_ref(), user_faces, axis, scale)
    }

    /// [`Constraints::anchors`] where the tree over the mesh is there already; only positions need it.
    ///
    /// # Errors
    /// The first constraint that cannot be used, and why.
    pub fn anchors_near(
        &self,
        mesh: &Mesh,
        tree: Option<&Nearest<'_>>,
        user_faces: Option<&[UserFace]>,
        axis: DVec3,
        scale: f64,
    ) -> Result<Vec<Anchor>, FieldError> {
        if !(self.base_weight.is_finite() && self.base_weight >= 0.0) {
            return Err(FieldError::BaseWeight(self.base_weight));
        }
        let axis = self.axis(axis);
        let unit = axis.try_normalize().filter(|u| u.is_finite()).ok_or(FieldError::Axis(axis))?;
        // Only angles need the whole projected field, for its filled faces.
        let angles = self.constraints.iter().any(|c| c.angle.is_some());
        let ups = if angles { super::up::directions(mesh, unit, scale)?.0 } else { Vec::new() };
        let (low, high) = mesh.bounds();
        let diagonal = low.as_dvec3().distance(high.as_dvec3());
        let spacing = (mesh.total_area() / self.constraints.len().max(1) as f64).sqrt();
        let extent = spacing.min(DEFAULT_EXTENT_SHARE * diagonal);
        let ground = Ground { mesh, user_faces, ups, tree, diagonal, extent };
        let tie = |(index, constraint): (usize, &Constraint)| {
            constraint.anchor(&ground).map_err(|problem| FieldError::Constraint { index, problem })
        };
        self.constraints.iter().enumerate().map(tie).collect()
    }
}

/// What constraints are tied to.
struct Ground<'a> {
    mesh: &'a Mesh,
    user_faces: Option<&'a [UserFace]>,
    ups: Vec<Vec3>,
    tree: Option<&'a Nearest<'a>>,
    diagonal: f64,
    /// Extent of constraints that give none.
    extent: f64,
}

impl Constraint {
    fn anchor(&self, ground: &Ground<'_>) -> Result<Anchor, ConstraintProblem> {
        let shape = [self.right.is_some(), self.stretch.is_some(), self.shear.is_some()];
        let says = [self.direction.is_some(), self.angle.is_some(), self.scale.is_some()];
        if !says.into_iter().chain(shape).any(|given| given) {
            return Err(ConstraintProblem::Empty);
        }
        exclude(self.direction.is_some() && self.angle.is_some(), "direction", "angle")?;
        exclude(self.extent.is_some() && self.extent_share.is_some(), "extent", "extentShare")?;
        exclude(shape[0] && shape[1], "right", "stretch")?;
        exclude(shape[0] && shape[2], "right", "shear")?;
        let (at, snapped) = self.place(ground)?;
        let normal = ground.mesh.normal(at.face);
        let direction = match (self.direction, self.angle) {
            (Some(direction), _) => Some(laid("direction", direction, normal)?.normalize()),
            (_, Some(degrees)) => {
                let turn = DQuat::from_axis_angle(normal, finite("angle", degrees)?.to_radians());
                Some(turn * ground.ups[at.face as usize].as_dvec3())
            }
            _ => None,
        };
        let (stretch, shear) = match (self.right, self.direction) {
            (None, _) => (positive("stretch", self.stretch)?, self.shear.map(|s| finite("shear", s)).transpose()?),
            (Some(right), Some(up)) => {
                let up = laid("direction", up, normal)?;
                let right = laid("right", right, normal)? / up.length();
                let up = up.normalize();
                let stretch = right.dot(up.cross(normal));
                if stretch <= SQUARE * right.length() {
                    return Err(ConstraintProblem::Mirrored);
                }
                (Some(stretch), Some(right.dot(up)))
            }
            (Some(_), None) => return Err(ConstraintProblem::RightAlone),
        };
        let extent = match positive("extentShare", self.extent_share)? {
            Some(share) => share * ground.diagonal,
            None => positive("extent", self.extent)?.unwrap_or(ground.extent),
        };
        Ok(Anchor {
            at,
            snapped,
            direction,
            ln_scale: positive("scale", self.scale)?.map(f64::ln),
            ln_stretch: stretch.map(f64::ln),
            shear,
            extent,
            weight: positive("weight", self.weight)?.unwrap_or(1.0),
        })
    }

    fn place(&self, ground: &Ground<'_>) -> Result<(SurfacePoint, f64), ConstraintProblem> {
        let centroid = |face| (SurfacePoint { face, bary: Vec3::splat(1.0 / 3.0) }, 0.0);
        match (self.face, self.position) {
            (Some(face), None) => {
                let count = ground.user_faces.map_or(ground.mesh.face_count(), <[UserFace]>::len);
                if face as usize >= count {
                    return Err(ConstraintProblem::Face { face, count });
                }
                match ground.user_faces.map_or(face, |to| to[face as usize].face) {
                    NONE => Err(ConstraintProblem::DroppedFace(face)),
                    mine => Ok(centroid(mine)),
                }
            }
            (None, Some(position)) => {
                let value = DVec3::from(position);
                let hit = ground.tree.and_then(|tree| tree.nearest(value));
                let hit = hit.ok_or(ConstraintProblem::Vector { name: "position", value })?;
                Ok((hit.at, hit.distance))
            }
            _ => Err(ConstraintProblem::Place),
        }
    }
}

fn exclude(both: bool, one: &'static str, other: &'static str) -> Result<(), ConstraintProblem> {
    if both { Err(ConstraintProblem::Both(one, other)) } else { Ok(()) }
}

fn finite(name: &'static str, value: f64) -> Result<f64, ConstraintProblem> {
    let problem = ConstraintProblem::Number { name, value, wanted: "a finite number" };
    if value.is_finite() { Ok(value) } else { Err(problem) }
}

fn positive(name: &'static str, value: Option<f64>) -> Result<Option<f64>, ConstraintProblem> {
    match value {
        Some(v) if !(v.is_normal() && v > 0.0) => {
            Err(ConstraintProblem::Number { name, value: v, wanted: "a finite number above zero" })
        }
        usable => Ok(usable),
    }
}

/// A vector laid into the plane across `normal`.
fn laid(name: &'static str, vector: [f64; 3], normal: DVec3) -> Result<DVec3, ConstraintProblem> {
    let value = DVec3::from(vector);
    let unit = value.try_normalize().filter(|u| u.is_finite()).ok_or(ConstraintProblem::Vector { name, value })?;
    if projected(unit, normal).length() < SQUARE {
        return Err(ConstraintProblem::Square { name, value });
    }
    Ok(projected(value, normal))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;

    fn at_face(face: u32) -> Constraint {
        Constraint { face: Some(face), ..Constraint::default() }
    }

    fn problem(constraint: Constraint) -> ConstraintProblem {
        let mesh = shapes::torus(12, 8, 1.0, 0.3);
        let file = Constraints { constraints: vec![at_face_scaled(), constraint], ..Constraints::default() };
        match file.anchors(&mesh, None, DVec3::Z, 0.1) {
            Err(FieldError::Constraint { index: 1, problem }) => problem,
            other => panic!("expected a problem with constraint 1, got {other:?}"),
        }
    }

    fn at_face_scaled() -> Constraint {
        Constraint { scale: Some(2.0), ..at_face(0) }
    }

    #[test]
    fn each_mistake_is_told_with_its_constraint() {
        use ConstraintProblem as P;
        let one = |change: fn(&mut Constraint)| {
            let mut c = at_face_scaled();
            change(&mut c);
            problem(c)
        };
        assert_eq!(one(|c| c.face = None), P::Place, "no place");
        assert_eq!(one(|c| c.position = Some([0.0; 3])), P::Place, "two places");
        assert_eq!(one(|c| c.face = Some(192)), P::Face { face: 192, count: 192 }, "face out of range");
        assert_eq!(one(|c| c.scale = None), P::Empty, "says nothing");
        assert!(matches!(one(|c| c.scale = Some(0.0)), P::Number { name: "scale", .. }), "scale 0");
        assert!(matches!(one(|c| c.extent = Some(-1.0)), P::Number { name: "extent", .. }), "negative extent");
        assert!(matches!(one(|c| c.weight = Some(f64::NAN)), P::Number { name: "weight", .. }), "NaN weight");
        assert!(matches!(one(|c| c.angle = Some(f64::INFINITY)), P::Number { name: "angle", .. }), "infinite angle");
        assert!(matches!(one(|c| c.direction = Some([0.0; 3])), P::Vector { name: "direction", .. }), "zero direction");
        let nowhere = |c: &mut Constraint| (c.face, c.position) = (None, Some([f64::NAN, 0.0, 0.0]));
        assert!(matches!(one(nowhere), P::Vector { name: "position", .. }), "NaN position");
        let both = |c: &mut Constraint| (c.angle, c.direction) = (Some(1.0), Some([1.0, 0.0, 0.0]));
        assert_eq!(one(both), P::Both("direction", "angle"), "direction twice");
        assert_eq!(one(|c| c.right = Some([1.0, 0.0, 0.0])), P::RightAlone, "right without direction");
        let normal = shapes::torus(12, 8, 1.0, 0.3).normal(0);
        let square = problem(Constraint { direction: Some(normal.into()), ..at_face(0) });
        assert!(matches!(square, P::Square { name: "direction", .. }), "{square:?}");
        let left = -DVec3::Z.cross(normal);
        let mirrored = problem(Constraint { direction: Some([0.0, 0.0, 1.0]), right: Some(left.into()), ..at_face(0) });
        assert_eq!(mirrored, P::Mirrored, "right points left");
    }

    #[test]
    fn the_file_is_read_strictly_and_written_back() {
        let text = r#"{ "version": 1, "constraints": [
            { "face": 3, "direction": [0, 1, 0], "extentShare": 0.2 },
            { "position": [1, 0, 0], "angle": 30, "scale": 0.5, "weight": 2 } ] }"#;
        let file = Constraints::from_json(text).expect("a good file");
        assert_eq!(file.constraints[1].scale, Some(0.5), "{file:?}");
        let again = Constraints::from_json(&file.to_json().expect("finite")).expect("its own text");
        assert_eq!(again, file, "written and read");
        let told = |text: &str| Constraints::from_json(text).unwrap_err().to_string();
        assert!(told(r#"{"version":1,"constraints":[{"face":1,"sclae":2}]}"#).contains("`sclae`"), "a misspelt key is named");
        assert!(told(r#"{"version":1,"#).contains("line 1"), "the place of a broken text is named");
        assert!(told(r#"{"version":7,"constraints":[]}"#).contains("version 7"), "another version is named");
        assert!(told(r#"{"version":1,"constraints":[{"face":-1}]}"#).contains("-1"), "a negative face is named");
    }

    #[test]
    fn an_angle_turns_the_projected_axis_counter_clockwise() {
        let mesh = shapes::parametric(2, 2, |x, y| [x, y, 0.0]);
        let file = Constraints { constraints: vec![Constraint { angle: Some(90.0), ..at_face(0) }], ..Constraints::default() };
        let anchors = file.anchors(&mesh, None, DVec3::Y, 0.1).expect("good");
        assert!((anchors[0].direction.expect("given") + DVec3::X).length() < 1e-6, "{anchors:?}");
    }

    #[test]
    fn right_becomes_stretch_and_shear() {
        let mesh = shapes::parametric(2, 2, |x, y| [x, y, 0.0]);
        let basis = Constraint { direction: Some([0.0, 2.0, 0.0]), right: Some([6.0, 1.0, 0.0]), ..at_face(0) };
        let file = Constraints { constraints: vec![basis], ..Constraints::default() };
        let anchor = &file.anchors(&mesh, None, DVec3::Y, 0.1).expect("good")[0];
        assert!((anchor.ln_stretch.expect("given") - 3.0_f64.ln()).abs() < 1e-6, "{anchor:?}");
        assert!((anchor.shear.expect("given") - 0.5).abs() < 1e-6, "{anchor:?}");
    }

    #[test]
    fn the_users_face_numbers_lead_to_the_mesh() {
        let mesh = shapes::torus(12, 8, 1.0, 0.3);
        let to = |face| UserFace { face, corners: [0, 1, 2] };
        let file = Constraints { constraints: vec![Constraint { scale: Some(2.0), ..at_face(1) }], ..Constraints::default() };
        let anchors = file.anchors(&mesh, Some(&[to(5), to(9)]), DVec3::Z, 0.1).expect("good");
        assert_eq!(anchors[0].at.face, 9, "face 1 of the user");
        let dropped = file.anchors(&mesh, Some(&[to(5), to(NONE)]), DVec3::Z, 0.1).unwrap_err();
        let problem = ConstraintProblem::DroppedFace(1);
        assert_eq!(dropped, FieldError::Constraint { index: 0, problem }, "a face without area");
    }
}
