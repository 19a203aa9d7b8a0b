//! How a model's vertices move: a tree of nodes, joints that carry the vertices, morph targets, and animations of both.
//!
//! Based on: the Khronos glTF 2.0 specification, sections 3.7.3 (skins), 3.7.2.2 (morph targets) and 3.11 (animations).
//!
//! 1. A channel's [`Track`] gives a node's translation, rotation or scale, or the morph weights, at a time.
//! 2. Placements multiplied down the tree place every node.
//! 3. A vertex is moved by the morph targets, and then to the mean of the places where its joints take it.
//!
//! Where we differ: glTF has one set of these for each mesh of a scene; here the whole model is one. So a mesh that merely
//! hangs on a node is carried by one joint, and all morph targets stand in one list. Everything is in the model's own
//! coordinates; at rest, where joints are as they were bound and all weights are 0, vertices are where the model has them.

mod pose;
mod track;

pub use track::{Interpolation, Track};

use glam::{DMat4, DQuat, DVec3, Vec3};

/// How the vertices of a model move.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Motion {
    /// The tree; parents stand before their children.
    pub nodes: Vec<Node>,
    /// What carries the vertices.
    pub joints: Vec<Joint>,
    /// By what each vertex is carried: one entry a vertex in each; together a vertex's weights sum to 1.
    pub influences: Vec<Influences>,
    /// Other shapes that are mixed in.
    pub targets: Vec<Target>,
    /// What is played.
    pub animations: Vec<Animation>,
}

/// A node of the tree.
#[derive(Debug, Clone, PartialEq)]
pub struct Node {
    /// What the file calls it; may be empty.
    pub name: String,
    /// The node it hangs on.
    pub parent: Option<u32>,
    /// Where it is beneath its parent while no animation moves it.
    pub rest: Placement,
}

/// Where a node is beneath its parent.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Placement {
    /// Scaled, then turned, then moved.
    Parts {
        /// Along the parent's axes.
        translation: DVec3,
        /// A unit quaternion.
        rotation: DQuat,
        /// Along the node's own axes.
        scale: DVec3,
    },
    /// Any affine transform.
    Matrix(DMat4),
}

/// A node that carries vertices.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Joint {
    /// The node.
    pub node: u32,
    /// From the model's coordinates to the node's, as the vertices were bound to it.
    pub inverse_bind: DMat4,
}

/// Four joints of each vertex with their weights.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Influences {
    /// Which joints.
    pub joints: Vec<[u16; 4]>,
    /// How much of each, 0 to 1.
    pub weights: Vec<[f32; 4]>,
}

/// A morph target: vertices and how far each goes at weight 1.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Target {
    /// What the file calls it; may be empty.
    pub name: String,
    /// Its weight while no animation changes it.
    pub weight: f32,
    /// The vertices that it moves, rising.
    pub vertices: Vec<u32>,
    /// How far, one for each of them.
    pub shifts: Vec<Vec3>,
}

/// Channels that are played together.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Animation {
    /// What the file calls it; may be empty.
    pub name: String,
    /// What it changes.
    pub channels: Vec<Channel>,
}

/// Something that an animation changes.
#[derive(Debug, Clone, PartialEq)]
pub struct Channel {
    /// What.
    pub of: Property,
    /// How, over time.
    pub track: Track,
}

/// What a channel changes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Property {
    /// A node's translation: three numbers.
    Translation(u32),
    /// A node's rotation: a quaternion, x y z w.
    Rotation(u32),
    /// A node's scale: three numbers.
    Scale(u32),
    /// The weights of all morph targets.
    Weights,
}

/// Why a motion is none, or cannot be played.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum MotionError {
    /// It contradicts itself or the model.
    #[error("{place}: {what}")]
    Broken {
        /// Where.
        place: String,
        /// What is wrong there.
        what: String,
    },
    /// No such animation.
    #[error("there is no animation {wanted:?}; there are {there}: name one of them, or its number")]
    NoSuchAnimation {
        /// What was asked for.
        wanted: String,
        /// What there is.
        there: String,
    },
    /// Numbers run out.
    #[error("at {time} s vertex {vertex} goes beyond what numbers can hold: the animation is damaged; play another one")]
    NotFinite {
        /// When.
        time: f64,
        /// Which vertex.
        vertex: usize,
    },
}

impl Placement {
    /// No change of place.
    pub const NONE: Self = Self::Parts { translation: DVec3::ZERO, rotation: DQuat::IDENTITY, scale: DVec3::ONE };

    /// As a matrix.
    #[must_use]
    pub fn matrix(&self) -> DMat4 {
        match *self {
            Self::Matrix(matrix) => matrix,
            Self::Parts { translation, rotation, scale } => DMat4::from_scale_rotation_translation(scale, rotation, translation),
        }
    }

    /// Its translation, rotation and scale; of a matrix those that come nearest.
    #[must_use]
    pub fn parts(&self) -> (DVec3, DQuat, DVec3) {
        match *self {
            Self::Parts { translation, rotation, scale } => (translation, rotation, scale),
            Self::Matrix(matrix) => {
                let (scale, rotation, translation) = matrix.to_scale_rotation_translation();
                (translation, if rotation.is_finite() { rotation } else { DQuat::IDENTITY }, scale)
            }
        }
    }

    fn is_finite(&self) -> bool {
        self.matrix().is_finite()
    }
}

impl Property {
    /// How many numbers it has, where there are so many morph targets.
    #[must_use]
    pub const fn width(self, targets: usize) -> usize {
        match self {
            Self::Translation(_) | Self::Scale(_) => 3,
            Self::Rotation(_) => 4,
            Self::Weights => targets,
        }
    }

    /// The node it belongs to.
    #[must_use]
    pub const fn node(self) -> Option<u32> {
        match self {
            Self::Translation(node) | Self::Rotation(node) | Self::Scale(node) => Some(node),
            Self::Weights => None,
        }
    }
}

impl Animation {
    /// When its last key is, seconds.
    #[must_use]
    pub fn duration(&self) -> f64 {
        self.channels.iter().filter_map(|c| c.track.times.last()).fold(0.0, |end, &t| f64::from(t).max(end))
    }
}

impl Motion {
    /// The motion of a model whose vertices are copies of these of its own.
    #[must_use]
    pub fn at_vertices(&self, source: &[u32]) -> Self {
        let influences = |set: &Influences| Influences {
            joints: source.iter().map(|&v| set.joints[v as usize]).collect(),
            weights: source.iter().map(|&v| set.weights[v as usize]).collect(),
        };
        let target = |target: &Target| {
            let shift = |&v: &u32| target.vertices.binary_search(&v).ok().map(|k| target.shifts[k]);
            let (vertices, shifts) =
                (0..).zip(source).filter_map(|(new, v)| shift(v).map(|shift| (new, shift))).unzip::<u32, Vec3, Vec<_>, Vec<_>>();
            Target { vertices, shifts, ..target.clone() }
        };
        Self {
            influences: self.influences.iter().map(influences).collect(),
            targets: self.targets.iter().map(target).collect(),
            ..self.clone()
        }
    }

    /// The animation of a name, or of a number from 0.
    ///
    /// # Errors
    /// If there is none.
    pub fn find(&self, wanted: &str) -> Result<usize, MotionError> {
        let named = self.animations.iter().position(|a| a.name == wanted);
        let counted = || wanted.parse::<usize>().ok().filter(|&n| n < self.animations.len());
        named.or_else(counted).ok_or_else(|| self.missing(wanted))
    }

    fn missing(&self, wanted: &str) -> MotionError {
        let list = self.animations.iter().enumerate().map(|(k, a)| format!("{k} {:?}", a.name));
        let there = if self.animations.is_empty() { "none".to_owned() } else { list.collect::<Vec<_>>().join(", ") };
        MotionError::NoSuchAnimation { wanted: wanted.to_owned(), there }
    }

    /// True if two vertices always move alike.
    #[must_use]
    pub fn moves_alike(&self, a: u32, b: u32) -> bool {
        let carried = |s: &Influences| {
            (s.joints[a as usize], s.weights[a as usize].map(f32::to_bits))
                == (s.joints[b as usize], s.weights[b as usize].map(f32::to_bits))
        };
        let shift = |t: &Target, v: u32| t.vertices.binary_search(&v).map_or(Vec3::ZERO, |k| t.shifts[k]);
        self.influences.iter().all(carried) && self.targets.iter().all(|t| shift(t, a) == shift(t, b))
    }

    /// Adds a vertex, after all others, at a place of a face: it is carried as the face's corners are, weighted by how it lies
    /// between them, but by no more joints than other vertices: the heaviest.
    pub fn add_vertex(&mut self, corners: [u32; 3], bary: Vec3) {
        let mut carried: Vec<(u16, f32)> = Vec::new();
        for set in &self.influences {
            for (corner, share) in corners.into_iter().zip(bary.to_array()) {
                for k in 0..4 {
                    let (joint, weight) = (set.joints[corner as usize][k], share * set.weights[corner as usize][k]);
                    match carried.iter_mut().find(|(j, _)| *j == joint) {
                        Some((_, sum)) => *sum += weight,
                        None => carried.push((joint, weight)),
                    }
                }
            }
        }
        carried.retain(|(_, weight)| *weight > 0.0);
        carried.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
        carried.truncate(4 * self.influences.len());
        let sum: f32 = carried.iter().map(|(_, w)| w).sum();
        let mut next = carried.into_iter().map(|(joint, weight)| (joint, weight / sum));
        let mut vertex = 0;
        for set in &mut self.influences {
            vertex = set.joints.len() as u32;
            let four: [(u16, f32); 4] = std::array::from_fn(|_| next.next().unwrap_or((0, 0.0)));
            set.joints.push(four.map(|f| f.0));
            set.weights.push(four.map(|f| f.1));
        }
        for target in &mut self.targets {
            let of = |v: u32| target.vertices.binary_search(&v).map_or(Vec3::ZERO, |k| target.shifts[k]);
            let shift: Vec3 = (0..3).map(|k| of(corners[k]) * bary[k]).sum();
            if shift != Vec3::ZERO {
                target.vertices.push(vertex);
                target.shifts.push(shift);
            }
        }
    }

    /// Checks every index, length and number against each other and against a model of so many vertices.
    ///
    /// # Errors
    /// Where something is wrong, and what.
    pub fn check(&self, vertices: usize) -> Result<(), MotionError> {
        let fail = |place: String, what: String| Err(MotionError::Broken { place, what });
        for (k, node) in self.nodes.iter().enumerate() {
            if node.parent.is_some_and(|p| p as usize >= k) {
                return fail(format!("node {k}"), "its parent does not stand before it".into());
            }
            if !node.rest.is_finite() {
                return fail(format!("node {k}"), "its place is not a number".into());
            }
        }
        for (k, joint) in self.joints.iter().enumerate() {
            if joint.node as usize >= self.nodes.len() {
                return fail(format!("joint {k}"), format!("its node {} does not exist", joint.node));
            }
            if !joint.inverse_bind.is_finite() {
                return fail(format!("joint {k}"), "its inverse bind matrix has entries that are not numbers".into());
            }
        }
        if self.influences.is_empty() {
            return fail("skin".into(), "nothing carries the vertices".into());
        }
        for set in &self.influences {
            if set.joints.len() != vertices || set.weights.len() != vertices {
                let [joints, weights] = [set.joints.len(), set.weights.len()];
                let what = format!("there are joints for {joints} and weights for {weights} vertices, not for {vertices}");
                return fail("skin".into(), what);
            }
            if let Some(v) = set.joints.iter().position(|j| j.iter().any(|&j| usize::from(j) >= self.joints.len())) {
                return fail(format!("vertex {v}"), format!("it names a joint beyond the {} there are", self.joints.len()));
            }
            if let Some(v) = set.weights.iter().position(|w| w.iter().any(|w| !(*w >= 0.0 && w.is_finite()))) {
                return fail(format!("vertex {v}"), "a weight of its joints is negative or not a number".into());
            }
        }
        for (k, target) in self.targets.iter().enumerate() {
            let place = format!("morph target {k}");
            if target.vertices.len() != target.shifts.len() || !target.vertices.is_sorted_by(|a, b| a < b) {
                return fail(place, "its vertices and shifts do not go together".into());
            }
            if target.vertices.last().is_some_and(|&v| v as usize >= vertices) {
                return fail(place, format!("it moves a vertex beyond the {vertices} there are"));
            }
            if !target.weight.is_finite() || target.shifts.iter().any(|s| !s.is_finite()) {
                return fail(place, "it holds something that is not a number".into());
            }
        }
        for (k, animation) in self.animations.iter().enumerate() {
            for (c, channel) in animation.channels.iter().enumerate() {
                let place = format!("animation {k}, channel {c}");
                if channel.of.node().is_some_and(|n| n as usize >= self.nodes.len()) {
                    return fail(place, "its node does not exist".into());
                }
                if let Some(what) = channel.track.flaw(channel.of.width(self.targets.len())) {
                    return fail(place, what);
                }
            }
        }
        Ok(())
    }
}
