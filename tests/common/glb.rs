//! GLB files made by tests: a document under construction, and models that move.

#![allow(dead_code, reason = "each test program uses its part")]
#![allow(clippy::unwrap_used, reason = "helpers of tests may fail as tests do")]

use glam::{DQuat, DVec3, Vec3};
use serde_json::{Value, json};

/// A document under construction.
#[derive(Default)]
pub(crate) struct Gltf {
    pub(crate) bin: Vec<u8>,
    pub(crate) views: Vec<Value>,
    pub(crate) accessors: Vec<Value>,
}

impl Gltf {
    pub(crate) fn view(&mut self, bytes: &[u8], stride: Option<usize>) -> usize {
        self.bin.resize(self.bin.len().next_multiple_of(4), 0);
        let mut view = json!({ "buffer": 0, "byteOffset": self.bin.len(), "byteLength": bytes.len() });
        if let Some(stride) = stride {
            view["byteStride"] = stride.into();
        }
        self.views.push(view);
        self.bin.extend(bytes);
        self.views.len() - 1
    }

    pub(crate) fn accessor(&mut self, bytes: &[u8], component: u32, count: usize, kind: &str) -> usize {
        let view = self.view(bytes, None);
        self.accessors.push(json!({ "bufferView": view, "componentType": component, "count": count, "type": kind }));
        self.accessors.len() - 1
    }

    pub(crate) fn floats<const N: usize>(&mut self, values: &[[f32; N]], kind: &str) -> usize {
        let bytes: Vec<u8> = values.as_flattened().iter().flat_map(|c| c.to_le_bytes()).collect();
        self.accessor(&bytes, 5126, values.len(), kind)
    }

    pub(crate) fn positions(&mut self, p: &[[f32; 3]]) -> usize {
        self.floats(p, "VEC3")
    }

    pub(crate) fn document(&self, rest: Value, uri: Option<String>) -> Value {
        let mut buffer = json!({ "byteLength": self.bin.len() });
        if let Some(uri) = uri {
            buffer["uri"] = uri.into();
        }
        let mut all = json!({
            "asset": { "version": "2.0" }, "buffers": [buffer], "bufferViews": self.views, "accessors": self.accessors,
        });
        for (key, value) in rest.as_object().unwrap() {
            all[key] = value.clone();
        }
        all
    }

    pub(crate) fn glb(&self, rest: Value) -> Vec<u8> {
        let mut json = self.document(rest, None).to_string().into_bytes();
        json.resize(json.len().next_multiple_of(4), b' ');
        let mut bin = self.bin.clone();
        bin.resize(bin.len().next_multiple_of(4), 0);
        let mut out = b"glTF\x02\0\0\0".to_vec();
        out.extend(((12 + 8 + json.len() + 8 + bin.len()) as u32).to_le_bytes());
        out.extend((json.len() as u32).to_le_bytes());
        out.extend(b"JSON");
        out.extend(json);
        out.extend((bin.len() as u32).to_le_bytes());
        out.extend(b"BIN\0");
        out.extend(bin);
        out
    }
}

/// A tail along +y from 0 to 4, tapering from a radius of 0.6, with a round end: positions and triangles.
pub(crate) fn tail(around: u32, along: u32) -> (Vec<Vec3>, Vec<[u32; 3]>) {
    let (mut positions, mut faces) = (Vec::new(), Vec::new());
    for j in 0..=along {
        for i in 0..around {
            let (y, angle) = (4.0 * j as f32 / along as f32, std::f32::consts::TAU * i as f32 / around as f32);
            let radius = 0.6 * (1.0 - (y / 4.0).powi(3)).sqrt().max(0.02);
            positions.push(Vec3::new(radius * angle.sin(), y, radius * angle.cos()));
            let [a, b] = [i, (i + 1) % around].map(|i| j * around + i);
            if j < along {
                faces.extend([[a, b, b + around], [a, b + around, a + around]]);
            }
        }
    }
    (positions, faces)
}

/// How much the bending joint of [`bending`] carries a vertex.
pub(crate) fn carried(p: DVec3) -> f64 {
    ((p.y - 1.0) / 2.0).clamp(0.0, 1.0)
}

/// Where [`bending`] takes a vertex after `time` seconds: a quarter turn about the point (0, 2, 0) in one second, and back.
pub(crate) fn bent(p: DVec3, time: f64) -> DVec3 {
    let turn = DQuat::from_rotation_z(-std::f64::consts::FRAC_PI_2 * (1.0 - (time.clamp(0.0, 2.0) - 1.0).abs()));
    let pivot = DVec3::Y * 2.0;
    p.lerp(pivot + turn * (p - pivot), carried(p))
}

/// A skinned tail whose tip bends. Its own coordinates lie on the side, and a node far away holds it: neither may matter.
pub(crate) fn bending(around: u32, along: u32) -> (Gltf, Value) {
    let (positions, faces) = tail(around, along);
    let mut gltf = Gltf::default();
    // x and y changed places, z turned round: the inverse bind matrices undo that.
    let lying: Vec<[f32; 3]> = positions.iter().map(|p| [p.y, p.x, -p.z]).collect();
    let position = gltf.positions(&lying);
    let joints: Vec<u8> = positions.iter().flat_map(|_| [0, 1, 0, 0]).collect();
    let joints = gltf.accessor(&joints, 5121, positions.len(), "VEC4");
    let weights: Vec<[f32; 4]> = positions.iter().map(|p| carried(p.as_dvec3()) as f32).map(|w| [1.0 - w, w, 0.0, 0.0]).collect();
    let weights = gltf.floats(&weights, "VEC4");
    let indices: Vec<u8> = faces.as_flattened().iter().flat_map(|i| i.to_le_bytes()).collect();
    let indices = gltf.accessor(&indices, 5125, 3 * faces.len(), "SCALAR");
    let stand = |y: f32| [0.0, 1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, -1.0, 0.0, 0.0, -y, 0.0, 1.0];
    let inverse = gltf.floats(&[stand(0.0), stand(2.0)], "MAT4");
    let input = gltf.floats(&[[0.0], [1.0], [2.0]], "SCALAR");
    let half = -std::f32::consts::FRAC_PI_4;
    let output = gltf.floats(&[[0.0, 0.0, 0.0, 1.0], [0.0, 0.0, half.sin(), half.cos()], [0.0, 0.0, 0.0, 1.0]], "VEC4");
    let rest = json!({
        "scene": 0, "scenes": [{ "nodes": [0, 1] }],
        "nodes": [
            { "name": "tail", "mesh": 0, "skin": 0, "translation": [100, 0, 0] },
            { "name": "base", "children": [2] },
            { "name": "tip", "translation": [0, 2, 0] },
        ],
        "meshes": [{ "primitives": [{
            "attributes": { "POSITION": position, "JOINTS_0": joints, "WEIGHTS_0": weights }, "indices": indices,
        }] }],
        "skins": [{ "joints": [1, 2], "inverseBindMatrices": inverse }],
        "animations": [{
            "name": "bend", "channels": [{ "sampler": 0, "target": { "node": 2, "path": "rotation" } }],
            "samplers": [{ "input": input, "output": output, "interpolation": "LINEAR" }],
        }],
    });
    (gltf, rest)
}

/// How far [`bulging`] moves a vertex at weight 1; the upper half stays.
pub(crate) fn bulge(p: DVec3) -> DVec3 {
    DVec3::new(p.x, 0.0, p.z) * (1.5 * p.y * (2.0 - p.y)).max(0.0)
}

/// A tail that swells and shrinks along a cubic while its node turns: weight 0 at 0 s, 1 at 1 s, 0 at 2 s, slopes 0.
pub(crate) fn bulging(around: u32, along: u32) -> (Gltf, Value) {
    let (positions, faces) = tail(around, along);
    let mut gltf = Gltf::default();
    let position = gltf.positions(&positions.iter().map(Vec3::to_array).collect::<Vec<_>>());
    let shifts: Vec<[f32; 3]> = positions.iter().map(|p| bulge(p.as_dvec3()).as_vec3().to_array()).collect();
    let shifts = gltf.positions(&shifts);
    let indices: Vec<u8> = faces.as_flattened().iter().flat_map(|i| i.to_le_bytes()).collect();
    let indices = gltf.accessor(&indices, 5125, 3 * faces.len(), "SCALAR");
    let input = gltf.floats(&[[0.0], [1.0], [2.0]], "SCALAR");
    let weights = gltf.floats(&[0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0_f32].map(|w| [w]), "SCALAR");
    let turns = gltf.floats(&[[0.0, 0.0, 0.0, 1.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0]], "VEC4");
    let rest = json!({
        "scenes": [{ "nodes": [0] }],
        "nodes": [{ "name": "tail", "mesh": 0, "scale": [2, 2, 2], "translation": [5, 0, 0] }],
        "meshes": [{
            "primitives": [{ "attributes": { "POSITION": position }, "indices": indices, "targets": [{ "POSITION": shifts }] }],
            "weights": [0], "extras": { "targetNames": ["fat"] },
        }],
        "animations": [{
            "name": "swallow",
            "channels": [
                { "sampler": 0, "target": { "node": 0, "path": "weights" } },
                { "sampler": 1, "target": { "node": 0, "path": "rotation" } },
            ],
            "samplers": [
                { "input": input, "output": weights, "interpolation": "CUBICSPLINE" },
                { "input": input, "output": turns, "interpolation": "STEP" },
            ],
        }],
    });
    (gltf, rest)
}

/// Where [`bulging`] takes a vertex after `time` seconds, given where the model has it at rest.
pub(crate) fn bulged(p: DVec3, time: f64) -> DVec3 {
    let own = (p - DVec3::X * 5.0) / 2.0;
    let s = 1.0 - (time.clamp(0.0, 2.0) - 1.0).abs();
    let own = own + bulge(own) * (s * s * (3.0 - 2.0 * s));
    let turn = if (1.0..2.0).contains(&time) { DQuat::from_rotation_y(std::f64::consts::PI) } else { DQuat::IDENTITY };
    turn * own * 2.0 + DVec3::X * 5.0
}
