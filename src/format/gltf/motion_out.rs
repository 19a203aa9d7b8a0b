//! A motion as glTF has it: nodes beside the mesh's own, a skin, sparse morph targets, animations. Every glTF tool plays it.

use super::accessor::MOST_IMPLICIT;
use super::build::{Builder, F32, Shape, U16, U32, VERTICES};
use crate::format::motion::{Animation, Interpolation, Motion, Placement, Property, Target, Track};
use glam::Vec3;
use serde_json::{Map, Value, json};

/// The node of the mesh; those of the motion follow it.
const MESH_NODE: usize = 0;

/// Parts of a document that a motion adds to.
pub(super) struct Moving {
    /// All nodes but the mesh's own.
    nodes: Vec<Value>,
    /// The node that all others hang on.
    root: usize,
    skin: Value,
    animations: Vec<Value>,
    /// Morph targets of the primitive, their weights and their names.
    targets: Vec<Value>,
    weights: Vec<f32>,
    names: Vec<String>,
}

/// Lets the mesh of a document move: adds to the primitive's attributes, and returns what [`finish`] puts into the document.
pub(super) fn begin<'a>(
    tables: &mut Builder<'a>,
    motion: &'a Motion,
    vertices: usize,
    attributes: &mut Map<String, Value>,
) -> Moving {
    tables.motion(motion, vertices, attributes)
}

/// Puts a motion into the parts of a document whose node 0 shows the mesh. All meshes there lie on the same vertices.
pub(super) fn finish(parts: &mut Value, moving: Moving) {
    let Moving { nodes, root, skin, animations, targets, weights, names } = moving;
    parts["scenes"][0]["nodes"] = json!([MESH_NODE, root]);
    parts["nodes"][MESH_NODE]["skin"] = json!(0);
    if let Some(list) = parts["nodes"].as_array_mut() {
        list.extend(nodes);
    }
    parts["skins"] = json!([skin]);
    if !animations.is_empty() {
        parts["animations"] = animations.into();
    }
    if targets.is_empty() {
        return;
    }
    for mesh in parts["meshes"].as_array_mut().into_iter().flatten() {
        for primitive in mesh["primitives"].as_array_mut().into_iter().flatten() {
            primitive["targets"] = targets.clone().into();
        }
        mesh["weights"] = json!(weights);
        mesh["extras"] = json!({ "targetNames": names });
    }
}

impl<'a> Builder<'a> {
    /// Adds a motion's numbers. Joints go into the primitive's attributes.
    fn motion(&mut self, motion: &'a Motion, vertices: usize, attributes: &mut Map<String, Value>) -> Moving {
        for (k, set) in motion.influences.iter().enumerate() {
            let shape = Shape { name: "VEC4", component: U16, target: Some(VERTICES) };
            let joints = self.accessor(shape, vertices, |out| {
                set.joints.iter().try_for_each(|j| out.write_all(j.map(u16::to_le_bytes).as_flattened()))
            });
            let weights = self.vectors(Some(VERTICES), vertices, |v| set.weights[v]);
            for (name, accessor) in [("JOINTS", joints), ("WEIGHTS", weights)] {
                if let Some(accessor) = accessor {
                    attributes.insert(format!("{name}_{k}"), accessor.into());
                }
            }
        }
        let mut nodes = Nodes::new(motion);
        let joints: Vec<usize> = motion.joints.iter().map(|j| nodes.joint(j.node as usize)).collect();
        let matrices = self.vectors(None, motion.joints.len(), |k| motion.joints[k].inverse_bind.as_mat4().to_cols_array());
        let skin = json!({ "joints": joints, "inverseBindMatrices": matrices });
        Moving {
            animations: motion.animations.iter().filter(|a| !a.channels.is_empty()).map(|a| self.animation(a)).collect(),
            targets: motion.targets.iter().map(|t| json!({ "POSITION": self.target(t, vertices) })).collect(),
            weights: motion.targets.iter().map(|t| t.weight).collect(),
            names: motion.targets.iter().map(|t| t.name.clone()).collect(),
            root: nodes.root,
            nodes: nodes.list,
            skin,
        }
    }

    /// A morph target's shifts: of those vertices alone that it moves, where that takes less room.
    fn target(&mut self, target: &'a Target, vertices: usize) -> Option<usize> {
        let bounds = |shifts: &mut dyn Iterator<Item = Vec3>| {
            shifts.fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(lo, hi), s| (lo.min(s), hi.max(s)))
        };
        let moved = target.vertices.len();
        let whole = 4 * moved >= 3 * vertices || vertices as u64 > MOST_IMPLICIT;
        let (mut low, mut high) = bounds(&mut target.shifts.iter().copied());
        if moved < vertices {
            (low, high) = (low.min(Vec3::ZERO), high.max(Vec3::ZERO));
        }
        let accessor = if whole {
            let shift = |v: usize| target.vertices.binary_search(&(v as u32)).map_or(Vec3::ZERO, |k| target.shifts[k]);
            self.vectors(Some(VERTICES), vertices, move |v| shift(v).to_array())?
        } else {
            // A sparse accessor replaces at least one.
            let count = moved.max(1);
            let indices = self.view(
                4 * count as u64,
                None,
                Box::new(move |out| {
                    (0..count).try_for_each(|k| out.write_all(&target.vertices.get(k).copied().unwrap_or(0).to_le_bytes()))
                }),
            );
            let values = self.view(
                12 * count as u64,
                None,
                Box::new(move |out| {
                    let shift = |k: usize| target.shifts.get(k).copied().unwrap_or(Vec3::ZERO).to_array();
                    (0..count).try_for_each(|k| out.write_all(shift(k).map(f32::to_le_bytes).as_flattened()))
                }),
            );
            self.add_accessor(json!({
                "componentType": F32, "count": vertices, "type": "VEC3", "sparse": {
                    "count": count,
                    "indices": { "bufferView": indices, "componentType": U32 },
                    "values": { "bufferView": values },
                },
            }))
        };
        self.bound(accessor, &low.as_dvec3().to_array(), &high.as_dvec3().to_array());
        Some(accessor)
    }

    fn animation(&mut self, animation: &'a Animation) -> Value {
        let (mut channels, mut samplers) = (Vec::new(), Vec::new());
        for channel in &animation.channels {
            let (path, node, width) = match channel.of {
                Property::Translation(node) => ("translation", FIRST + node as usize, 3),
                Property::Rotation(node) => ("rotation", FIRST + node as usize, 4),
                Property::Scale(node) => ("scale", FIRST + node as usize, 3),
                Property::Weights => ("weights", MESH_NODE, 1),
            };
            channels.push(json!({ "sampler": samplers.len(), "target": { "node": node, "path": path } }));
            samplers.push(self.sampler(&channel.track, width));
        }
        json!({ "name": animation.name, "channels": channels, "samplers": samplers })
    }

    fn sampler(&mut self, track: &'a Track, width: usize) -> Value {
        let times = &track.times;
        let input = self.vectors(None, times.len(), |k| [times[k]]);
        if let (Some(input), Some(first), Some(last)) = (input, times.first(), times.last()) {
            self.bound(input, &[f64::from(*first)], &[f64::from(*last)]);
        }
        let name = ["SCALAR", "VEC2", "VEC3", "VEC4"][width - 1];
        let output = self.accessor(Shape { name, component: F32, target: None }, track.values.len() / width, |out| {
            track.values.iter().try_for_each(|v| out.write_all(&v.to_le_bytes()))
        });
        let interpolation = match track.interpolation {
            Interpolation::Linear => "LINEAR",
            Interpolation::Step => "STEP",
            Interpolation::CubicSpline => "CUBICSPLINE",
        };
        json!({ "input": input, "output": output, "interpolation": interpolation })
    }
}

/// Place of the motion's first node in the document.
const FIRST: usize = MESH_NODE + 1;

/// Nodes of a document under construction: those of the motion, then what glTF wants besides.
struct Nodes {
    list: Vec<Value>,
    root: usize,
    /// Which are joints already: a skin may name a node once.
    taken: Vec<bool>,
}

impl Nodes {
    fn new(motion: &Motion) -> Self {
        let mut animated = vec![false; motion.nodes.len()];
        let changed = motion.animations.iter().flat_map(|a| &a.channels).filter_map(|c| c.of.node());
        changed.for_each(|n| animated[n as usize] = true);
        let node = |(k, node): (usize, &crate::format::motion::Node)| {
            let mut value = json!({ "name": node.name });
            match node.rest {
                Placement::Matrix(matrix) if !animated[k] => value["matrix"] = json!(matrix.to_cols_array()),
                rest => {
                    let (translation, rotation, scale) = rest.parts();
                    value["translation"] = json!(translation.to_array());
                    value["rotation"] = json!(rotation.to_array());
                    value["scale"] = json!(scale.to_array());
                }
            }
            value
        };
        let mut list: Vec<Value> = motion.nodes.iter().enumerate().map(node).collect();
        let mut roots = Vec::new();
        for (k, node) in motion.nodes.iter().enumerate() {
            match node.parent {
                Some(parent) => hang(&mut list[parent as usize], FIRST + k),
                None => roots.push(FIRST + k),
            }
        }
        // The joints of a skin have one root.
        let root = match roots[..] {
            [root] => root,
            _ => {
                list.push(json!({ "name": "root", "children": roots }));
                FIRST + list.len() - 1
            }
        };
        Self { list, root, taken: vec![false; motion.nodes.len()] }
    }

    /// The place of a joint's node; of a node that is a joint already, of another one that goes with it.
    fn joint(&mut self, node: usize) -> usize {
        if !std::mem::replace(&mut self.taken[node], true) {
            return FIRST + node;
        }
        let name = format!("{} again", self.list[node]["name"].as_str().unwrap_or_default());
        self.list.push(json!({ "name": name }));
        let place = FIRST + self.list.len() - 1;
        hang(&mut self.list[node], place);
        place
    }
}

fn hang(node: &mut Value, child: usize) {
    match node["children"].as_array_mut() {
        Some(children) => children.push(child.into()),
        None => node["children"] = json!([child]),
    }
}
