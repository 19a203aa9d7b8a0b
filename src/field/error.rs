//! What can be wrong with a field's description, in sentences that say where and what to do.

use glam::DVec3;

/// Why a field cannot be made.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FieldError {
    /// The scale is no usable length.
    #[error("the scale (world length of one exemplar width) is {0}: give a finite length above zero")]
    Scale(f64),
    /// The axis has no direction.
    #[error("the up axis is {0}: give three finite numbers that are not all zero")]
    Axis(DVec3),
    /// The weight of the base field is no weight.
    #[error("baseWeight is {0}: give a finite number, 0 or more")]
    BaseWeight(f64),
    /// One constraint is unusable.
    #[error("constraint {index} (counting from 0): {problem}")]
    Constraint {
        /// Its place in the list.
        index: usize,
        /// What is wrong.
        problem: ConstraintProblem,
    },
    /// An anchor that was not made for this mesh.
    #[error(
        "anchor {index} (counting from 0) lies on face {face} of {count} or has no usable extent or weight: make the anchors anew for this mesh"
    )]
    Anchor {
        /// Its place in the list.
        index: usize,
        /// The face it names.
        face: u32,
        /// Faces of the mesh.
        count: usize,
    },
    /// The text is not what was expected.
    #[error("not a valid {what}: {reason}")]
    Syntax {
        /// Which kind of file.
        what: &'static str,
        /// Where and what, from the parser.
        reason: String,
    },
    /// A file of another version.
    #[error("the {what} has version {found}, but this program reads version {expected}: save it again with a matching program")]
    Version {
        /// Which kind of file.
        what: &'static str,
        /// Its version.
        found: u32,
        /// The version read here.
        expected: u32,
    },
    /// A field of no usable number of directions.
    #[error("the field file has {0} `ways`: give how many turns leave the texture looking the same, 1 to 12")]
    Ways(u32),
    /// A field for another mesh.
    #[error("the field has {found} vectors `{which}`, but the mesh has {faces} faces: use the mesh that the field was made for")]
    Length {
        /// Which vectors.
        which: &'static str,
        /// How many there are.
        found: usize,
        /// How many there should be.
        faces: usize,
    },
    /// A vector of a given field is unusable.
    #[error("the field's vector `{which}` at face {face} is {vector}: {reason}")]
    Vector {
        /// Which of the two.
        which: &'static str,
        /// Where.
        face: usize,
        /// What it is.
        vector: DVec3,
        /// What is wrong and what to do.
        reason: &'static str,
    },
    /// The mesh cannot take the faces that refinement wants.
    #[error("while refining near singularities: {0}")]
    Mesh(#[from] crate::mesh::MeshError),
}

/// What is wrong with a constraint.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ConstraintProblem {
    /// Neither or both of `face` and `position`.
    #[error("it needs a place: give either \"face\" or \"position\"")]
    Place,
    /// No such face.
    #[error("face {face} does not exist, the mesh has {count} faces (counting from 0): use a smaller number or a \"position\"")]
    Face {
        /// The number given.
        face: u32,
        /// How many there are.
        count: usize,
    },
    /// The face has no area and was left out of the mesh.
    #[error("face {0} has no area: choose a face beside it or give a \"position\"")]
    DroppedFace(u32),
    /// It says nothing.
    #[error("it says nothing: give at least one of \"direction\", \"angle\", \"scale\", \"right\", \"stretch\", \"shear\"")]
    Empty,
    /// Two ways of saying the same.
    #[error("\"{0}\" and \"{1}\" exclude each other: give one of them")]
    Both(&'static str, &'static str),
    /// A number that is not finite, or not positive where it must be.
    #[error("\"{name}\" is {value}: give {wanted}")]
    Number {
        /// Which number.
        name: &'static str,
        /// What it is.
        value: f64,
        /// What it should be.
        wanted: &'static str,
    },
    /// A vector that is not finite or zero.
    #[error("\"{name}\" is {value}: give three finite numbers that are not all zero")]
    Vector {
        /// Which vector.
        name: &'static str,
        /// What it is.
        value: DVec3,
    },
    /// The vector has no part in the face's plane.
    #[error("\"{name}\" {value} stands square to the surface there: give one that lies along it")]
    Square {
        /// Which vector.
        name: &'static str,
        /// What it is.
        value: DVec3,
    },
    /// The two basis vectors mirror the texture or have no area.
    #[error(
        "\"right\" does not point to the right of \"direction\" seen from outside, which would mirror the texture: turn it round"
    )]
    Mirrored,
    /// `right` needs a direction beside it.
    #[error("\"right\" needs \"direction\" beside it: its length and angle are measured against that")]
    RightAlone,
}
