//! Skins, morph targets and animations of a glTF document as one [`Motion`] of one model.
//!
//! 1. Every mesh that is shown is a [`Part`]: some vertices of the model, and how its own coordinates lie in the model's.
//! 2. A skinned part is carried by its skin's joints, any other by the node it hangs on; joints met twice are one.
//! 3. The morph targets of all parts stand in one list, so their weights are one track; where several nodes have weights
//!    that are keyed at different times, the tracks are laid side by side.
//! 4. Of the nodes those stay that carry something, and what they hang on.

use super::accessor::Data;
use super::document::{Animation as Played, Channel as Changed, Document, Node as Given};
use crate::format::error::Problem;
use crate::format::motion::{
    Animation, Channel, Influences, Interpolation, Joint, Motion, Node, Placement, Property, Target, Track,
};
use glam::{DMat3, DMat4, DQuat, DVec3, Vec3};
use std::collections::BTreeMap;
use std::ops::Range;

/// Keys a second where weights that go along different curves are laid side by side.
const SAMPLES_PER_SECOND: f64 = 60.0;

/// A transform this close to none, for its size, is none: what is left of multiplying a matrix with its inverse.
const SAME: f64 = 1e-5;

/// All nodes with their parents, and where they are while nothing moves.
#[derive(Debug)]
pub(crate) struct Tree {
    parent: Vec<Option<usize>>,
    /// Parents before their children. Nodes that are their own ancestors are missing.
    order: Vec<usize>,
    world: Vec<Option<DMat4>>,
}

impl Tree {
    pub(crate) fn new(document: &Document) -> Self {
        let count = document.nodes.len();
        let mut parent = vec![None; count];
        for (k, node) in document.nodes.iter().enumerate() {
            for &child in &node.children {
                if let Some(p) = parent.get_mut(child) {
                    *p = Some(k);
                }
            }
        }
        let mut order: Vec<usize> = (0..count).filter(|&k| parent[k].is_none()).collect();
        let mut world = vec![None; count];
        let mut next = 0;
        while let Some(&k) = order.get(next) {
            next += 1;
            let above: Option<DMat4> = parent[k].map_or(Some(DMat4::IDENTITY), |p: usize| world[p]);
            world[k] = above.map(|above| above * placement(&document.nodes[k]).matrix());
            order.extend(document.nodes[k].children.iter().filter(|&&c| parent.get(c) == Some(&Some(k))));
        }
        Self { parent, order, world }
    }

    /// Where a node is.
    pub(crate) fn world(&self, node: usize) -> Option<DMat4> {
        self.world.get(node).copied().flatten()
    }
}

/// Where a node is beneath its parent.
pub(crate) fn placement(node: &Given) -> Placement {
    if let Some(matrix) = node.matrix {
        return Placement::Matrix(DMat4::from_cols_array(&matrix));
    }
    let rotation = node.rotation.map_or(DQuat::IDENTITY, |q| {
        let q = DQuat::from_array(q);
        if q.length_squared() > 0.0 { q.normalize() } else { DQuat::IDENTITY }
    });
    let translation = node.translation.map_or(DVec3::ZERO, DVec3::from_array);
    Placement::Parts { translation, rotation, scale: node.scale.map_or(DVec3::ONE, DVec3::from_array) }
}

/// How a skinned mesh lies in the model: where the first joint of its skin takes it while nothing moves. A mesh that was
/// bound as it stands is then where every program shows it, however its own coordinates lie.
pub(crate) fn bound(data: &Data<'_>, tree: &Tree, skin: usize) -> Result<DMat4, Problem> {
    let joints = read_skin(data, tree, skin)?;
    let first = joints.first().and_then(|&(node, inverse)| Some(tree.world(node)? * inverse));
    let place = first.filter(|m| m.is_finite() && m.determinant() != 0.0).unwrap_or(DMat4::IDENTITY);
    let size = place.w_axis.truncate().abs().max_element().max(1.0);
    Ok(if place.abs_diff_eq(DMat4::IDENTITY, SAME * size) { DMat4::IDENTITY } else { place })
}

/// A skin's joints: nodes with their inverse bind matrices.
fn read_skin(data: &Data<'_>, tree: &Tree, skin: usize) -> Result<Vec<(usize, DMat4)>, Problem> {
    let place = format!("skin {skin}");
    let given = data.document.skins.get(skin).ok_or_else(|| Problem::damaged(&place, "there is no such skin"))?;
    if let Some(&joint) = given.joints.iter().find(|&&j| tree.world(j).is_none()) {
        return Err(Problem::damaged(place, format!("its joint is node {joint}, which does not exist or is its own ancestor")));
    }
    let matrices = match given.inverse_bind_matrices {
        Some(accessor) => data.floats::<16>(accessor)?,
        None => vec![DMat4::IDENTITY.as_mat4().to_cols_array(); given.joints.len()],
    };
    if matrices.len() < given.joints.len() || given.joints.is_empty() {
        let what = format!("it has {} joints and {} inverse bind matrices", given.joints.len(), matrices.len());
        return Err(Problem::damaged(place, what));
    }
    if matrices.as_flattened().iter().any(|v| !v.is_finite()) {
        return Err(Problem::damaged(place, "an inverse bind matrix holds something that is not a number"));
    }
    Ok(given.joints.iter().copied().zip(matrices.iter().map(|m| DMat4::from_cols_array(&m.map(f64::from)))).collect())
}

/// A primitive's vertices in the model.
#[derive(Debug, Clone)]
pub(crate) struct Part {
    /// The node it hangs on.
    pub(crate) node: usize,
    /// Its mesh, and its place there.
    pub(crate) mesh: usize,
    pub(crate) primitive: usize,
    /// Its vertices.
    pub(crate) vertices: Range<usize>,
    /// From its own coordinates to the model's.
    pub(crate) to_model: DMat4,
}

/// The motion of a model of so many vertices that these parts make up; `None` if nothing can move. What had to be left out
/// is told in `notes`.
pub(crate) fn read_motion(
    data: &Data<'_>,
    tree: &Tree,
    parts: &[Part],
    vertices: usize,
    notes: &mut Vec<String>,
) -> Result<Option<Motion>, Problem> {
    let document = data.document;
    let skin_of = |part: &Part| document.nodes[part.node].skin;
    let morphs = |part: &&Part| !document.meshes[part.mesh].primitives[part.primitive].targets.is_empty();
    let moves = document.animations.iter().any(|a| !a.channels.is_empty());
    if !(moves || parts.iter().any(|p| skin_of(p).is_some()) || parts.iter().any(|p| morphs(&p))) {
        return Ok(None);
    }
    let mut gather =
        Gather { data, tree, joints: Vec::new(), numbers: BTreeMap::new(), influences: Vec::new(), targets: Vec::new() };
    let mut first_target: BTreeMap<usize, Range<usize>> = BTreeMap::new();
    for part in parts {
        gather.carry(part, skin_of(part), vertices)?;
        let range = gather.morph(part, first_target.get(&part.node))?;
        if !range.is_empty() {
            first_target.insert(part.node, range);
        }
    }
    let Gather { joints, influences, targets, .. } = gather;
    let (nodes, number) = kept_nodes(document, tree, &joints);
    let mut animations = Vec::with_capacity(document.animations.len());
    for (k, animation) in document.animations.iter().enumerate() {
        animations.push(read_animation(data, k, animation, &number, &targets, &first_target, notes)?);
    }
    if animations.iter().all(|a| a.channels.is_empty()) && targets.is_empty() && parts.iter().all(|p| skin_of(p).is_none()) {
        return Ok(None);
    }
    let joints = joints.iter().map(|&(node, inverse_bind)| Joint { node: number[&node], inverse_bind }).collect();
    let motion = Motion { nodes, joints, influences, targets, animations };
    motion.check(vertices).map_err(|e| Problem::damaged("", e.to_string()))?;
    Ok(Some(motion))
}

/// What carries a vertex: the node and the bits of its inverse bind matrix.
type JointKey = (usize, [u64; 16]);

struct Gather<'a> {
    data: &'a Data<'a>,
    tree: &'a Tree,
    joints: Vec<(usize, DMat4)>,
    numbers: BTreeMap<JointKey, u16>,
    influences: Vec<Influences>,
    targets: Vec<Target>,
}

impl Gather<'_> {
    /// The number of a joint, new or known.
    fn joint(&mut self, node: usize, inverse: DMat4) -> Result<u16, Problem> {
        // As exact as a file holds it.
        let inverse = inverse.as_mat4().as_dmat4();
        let key = (node, inverse.to_cols_array().map(f64::to_bits));
        if let Some(&known) = self.numbers.get(&key) {
            return Ok(known);
        }
        let number = u16::try_from(self.joints.len())
            .map_err(|_| Problem::new("", "more than 65,536 nodes carry vertices", "split the scene into several files"))?;
        self.joints.push((node, inverse));
        self.numbers.insert(key, number);
        Ok(number)
    }

    /// Lets a part's vertices be carried.
    fn carry(&mut self, part: &Part, skin: Option<usize>, vertices: usize) -> Result<(), Problem> {
        let primitive = &self.data.document.meshes[part.mesh].primitives[part.primitive];
        let place = format!("mesh {}, primitive {}", part.mesh, part.primitive);
        let set = |k: usize, name: &str| primitive.attributes.get(&format!("{name}_{k}")).copied();
        let sets = skin.map_or(0, |_| (0..).take_while(|&k| set(k, "JOINTS").is_some() && set(k, "WEIGHTS").is_some()).count());
        while self.influences.len() < sets.max(1) {
            let empty = Influences { joints: vec![[0; 4]; vertices], weights: vec![[0.0; 4]; vertices] };
            self.influences.push(empty);
        }
        let from_model = part.to_model.inverse();
        let from_model = if from_model.is_finite() { from_model } else { DMat4::IDENTITY };
        let Some(skin) = skin.filter(|_| sets > 0) else {
            let rigid = self.joint(part.node, from_model)?;
            for v in part.vertices.clone() {
                self.influences[0].joints[v][0] = rigid;
                self.influences[0].weights[v][0] = 1.0;
            }
            return Ok(());
        };
        let mut numbers = Vec::new();
        for (node, inverse) in read_skin(self.data, self.tree, skin)? {
            numbers.push(self.joint(node, if part.to_model == DMat4::IDENTITY { inverse } else { inverse * from_model })?);
        }
        let mut sums = vec![0.0_f32; part.vertices.len()];
        for k in 0..sets {
            let (Some(joints), Some(weights)) = (set(k, "JOINTS"), set(k, "WEIGHTS")) else { continue };
            let (joints, weights) = (self.data.whole::<4>(joints)?, self.data.floats::<4>(weights)?);
            if joints.len() != part.vertices.len() || weights.len() != part.vertices.len() {
                let what =
                    format!("it has {} positions, but joints for {} and weights for {}", sums.len(), joints.len(), weights.len());
                return Err(Problem::damaged(place, what));
            }
            for (v, (joints, weights)) in joints.iter().zip(&weights).enumerate() {
                for i in 0..4 {
                    if !(weights[i] >= 0.0 && weights[i].is_finite()) {
                        return Err(Problem::damaged(place, format!("a weight of vertex {v} is negative or not a number")));
                    }
                    let Some(&number) = numbers.get(joints[i] as usize) else {
                        let what = format!("vertex {v} names joint {}, but skin {skin} has {}", joints[i], numbers.len());
                        return Err(Problem::damaged(place, what));
                    };
                    if weights[i] > 0.0 {
                        let at = part.vertices.start + v;
                        self.influences[k].joints[at][i] = number;
                        self.influences[k].weights[at][i] = weights[i];
                        sums[v] += weights[i];
                    }
                }
            }
        }
        for (v, sum) in part.vertices.clone().zip(sums) {
            if sum > 0.0 && sum.is_finite() {
                self.influences.iter_mut().for_each(|s| s.weights[v] = s.weights[v].map(|w| w / sum));
            } else {
                // Nothing says what carries it: the first joint does.
                self.influences[0].joints[v] = [numbers[0], 0, 0, 0];
                self.influences[0].weights[v] = [1.0, 0.0, 0.0, 0.0];
            }
        }
        Ok(())
    }

    /// Adds a part's morph targets, to those that other parts of its node have brought if there are any; returns which.
    fn morph(&mut self, part: &Part, known: Option<&Range<usize>>) -> Result<Range<usize>, Problem> {
        let document = self.data.document;
        let mesh = &document.meshes[part.mesh];
        let targets = &mesh.primitives[part.primitive].targets;
        if known.is_some_and(|range| range.len() != targets.len()) {
            let place = format!("mesh {}", part.mesh);
            return Err(Problem::damaged(place, "its primitives have different numbers of morph targets"));
        }
        let start = known.map_or(self.targets.len(), |range| range.start);
        let turn = DMat3::from_mat4(part.to_model);
        for (k, attributes) in targets.iter().enumerate() {
            let place = format!("mesh {}, primitive {}, morph target {k}", part.mesh, part.primitive);
            if start + k == self.targets.len() {
                let weights = document.nodes[part.node].weights.as_ref().unwrap_or(&mesh.weights);
                let name = mesh.extras.pointer(&format!("/targetNames/{k}")).and_then(serde_json::Value::as_str);
                let weight = weights.get(k).copied().unwrap_or(0.0);
                self.targets.push(Target { name: name.unwrap_or_default().to_owned(), weight, ..Target::default() });
            }
            let target = &mut self.targets[start + k];
            let Some(&accessor) = attributes.get("POSITION") else { continue };
            let shifts = self.data.floats::<3>(accessor)?;
            if shifts.len() != part.vertices.len() {
                let what = format!("it moves {} vertices of {}", shifts.len(), part.vertices.len());
                return Err(Problem::damaged(place, what));
            }
            for (v, shift) in part.vertices.clone().zip(shifts) {
                let shift = Vec3::from_array(shift);
                if !shift.is_finite() {
                    return Err(Problem::damaged(place, "a shift is not a number"));
                }
                if shift != Vec3::ZERO {
                    target.vertices.push(v as u32);
                    let same = part.to_model == DMat4::IDENTITY;
                    target.shifts.push(if same { shift } else { (turn * shift.as_dvec3()).as_vec3() });
                }
            }
        }
        Ok(start..start + targets.len())
    }
}

/// The nodes that carry something and their ancestors, and the new number of each.
fn kept_nodes(document: &Document, tree: &Tree, joints: &[(usize, DMat4)]) -> (Vec<Node>, BTreeMap<usize, u32>) {
    let mut keep = vec![false; document.nodes.len()];
    for &(node, _) in joints {
        let mut at = Some(node);
        while let Some(k) = at.filter(|&k| !std::mem::replace(&mut keep[k], true)) {
            at = tree.parent[k];
        }
    }
    let (mut nodes, mut number) = (Vec::new(), BTreeMap::new());
    for &k in tree.order.iter().filter(|&&k| keep[k]) {
        number.insert(k, nodes.len() as u32);
        let given = &document.nodes[k];
        let parent = tree.parent[k].and_then(|p| number.get(&p).copied());
        nodes.push(Node { name: given.name.clone().unwrap_or_default(), parent, rest: placement(given) });
    }
    (nodes, number)
}

/// An animation's channels as far as they change something that is there.
fn read_animation(
    data: &Data<'_>,
    index: usize,
    given: &Played,
    number: &BTreeMap<usize, u32>,
    targets: &[Target],
    ranges: &BTreeMap<usize, Range<usize>>,
    notes: &mut Vec<String>,
) -> Result<Animation, Problem> {
    let mut animation = Animation { name: given.name.clone().unwrap_or_default(), channels: Vec::new() };
    let mut weights: BTreeMap<usize, Track> = BTreeMap::new();
    for (c, channel) in given.channels.iter().enumerate() {
        let place = format!("animation {index}, channel {c}");
        let Some(node) = channel.target.node else { continue };
        if node >= data.document.nodes.len() {
            return Err(Problem::damaged(place, format!("it changes node {node}, which does not exist")));
        }
        let of = match (channel.target.path.as_str(), number.get(&node)) {
            ("weights", _) => {
                if let Some(range) = ranges.get(&node) {
                    weights.insert(range.start, read_track(data, given, channel, range.len(), &place)?);
                }
                continue;
            }
            ("translation", Some(&node)) => Property::Translation(node),
            ("rotation", Some(&node)) => Property::Rotation(node),
            ("scale", Some(&node)) => Property::Scale(node),
            // Cameras and lamps may move too, and extensions change what is not known here.
            _ => continue,
        };
        let track = read_track(data, given, channel, of.width(targets.len()), &place)?;
        animation.channels.push(Channel { of, track });
    }
    if !weights.is_empty() {
        // One track over all targets; those that nothing changes stay as they are.
        let like = weights.values().next().cloned().unwrap_or_default();
        for range in ranges.values() {
            let rest = || targets[range.clone()].iter().map(|t| t.weight).collect::<Vec<f32>>();
            weights.entry(range.start).or_insert_with(|| like.still(&rest()));
        }
        let (track, exact) = Track::beside(&weights.values().collect::<Vec<_>>(), SAMPLES_PER_SECOND);
        if !exact {
            notes.push(format!("the morph weights of animation {index} go along different curves and were sampled together"));
        }
        animation.channels.push(Channel { of: Property::Weights, track });
    }
    Ok(animation)
}

/// The numbers of a channel, `width` at a time.
fn read_track(data: &Data<'_>, given: &Played, channel: &Changed, width: usize, place: &str) -> Result<Track, Problem> {
    let sampler = given.samplers.get(channel.sampler);
    let sampler = sampler.ok_or_else(|| Problem::damaged(place, format!("its sampler {} does not exist", channel.sampler)))?;
    let interpolation = match sampler.interpolation.as_deref() {
        None | Some("LINEAR") => Interpolation::Linear,
        Some("STEP") => Interpolation::Step,
        Some("CUBICSPLINE") => Interpolation::CubicSpline,
        Some(other) => return Err(Problem::damaged(place, format!("it is interpolated by {other:?}, which does not exist"))),
    };
    let times = data.floats::<1>(sampler.input)?.into_iter().map(|[t]| t).collect();
    let values = match channel.target.path.as_str() {
        "rotation" => data.floats::<4>(sampler.output)?.into_flattened(),
        "weights" => data.floats::<1>(sampler.output)?.into_flattened(),
        _ => data.floats::<3>(sampler.output)?.into_flattened(),
    };
    let track = Track { interpolation, times, values };
    match track.flaw(width) {
        Some(what) => Err(Problem::damaged(place, what)),
        None => Ok(track),
    }
}
