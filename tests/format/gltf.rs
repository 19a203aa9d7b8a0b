//! Every feature of glTF and GLB that is promised, each on a file that uses it.

#![allow(clippy::unwrap_used, clippy::panic, reason = "helpers of tests may fail as tests do")]

use crate::glb::Gltf;
use glam::{Vec3, Vec4};
use lapped::format::{Model, read_model_bytes};
use serde_json::{Value, json};
use std::path::Path;

fn read(name: &str, bytes: impl AsRef<[u8]>) -> Model {
    read_model_bytes(Path::new(name), bytes.as_ref()).unwrap()
}

fn triangles(model: &Model) -> Vec<[Vec3; 3]> {
    model.faces.iter().map(|f| f.map(|v| model.positions[v as usize])).collect()
}

const SQUARE: [[f32; 3]; 4] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0]];

fn one_primitive(primitive: Value) -> Value {
    json!({ "scene": 0, "scenes": [{ "nodes": [0] }], "nodes": [{ "mesh": 0 }], "meshes": [{ "primitives": [primitive] }] })
}

#[test]
fn gltf_index_types_strips_and_fans() {
    for (component, size) in [(5121, 1), (5123, 2), (5125, 4)] {
        let bytes: Vec<u8> = [0_u32, 1, 2, 3].iter().flat_map(|i| i.to_le_bytes()[..size].to_vec()).collect();
        for (mode, expected) in [(4, vec![[0, 1, 2]]), (5, vec![[0, 1, 2], [1, 3, 2]]), (6, vec![[1, 2, 0], [2, 3, 0]])] {
            let mut gltf = Gltf::default();
            let positions = gltf.positions(&SQUARE);
            let indices = gltf.accessor(&bytes, component, 4, "SCALAR");
            let primitive = json!({ "attributes": { "POSITION": positions }, "indices": indices, "mode": mode });
            let model = read("a.glb", gltf.glb(one_primitive(primitive)));
            assert_eq!(model.faces, expected, "component type {component}, mode {mode}");
        }
    }
    let mut gltf = Gltf::default();
    let positions = gltf.positions(&SQUARE[..3]);
    let model = read("a.glb", gltf.glb(one_primitive(json!({ "attributes": { "POSITION": positions } }))));
    assert_eq!(model.faces, [[0, 1, 2]], "without indices, vertices follow each other");
}

#[test]
fn gltf_node_transforms_multiply_and_mirrors_turn_faces() {
    let mut gltf = Gltf::default();
    let positions = gltf.positions(&SQUARE);
    let normals = gltf.positions(&[[0.0, 0.0, 1.0]; 4]);
    let half = std::f64::consts::FRAC_1_SQRT_2;
    let rest = json!({
        "scene": 0, "scenes": [{ "nodes": [0, 3] }],
        "nodes": [
            { "name": "parent", "translation": [10, 0, 0], "children": [1, 2] },
            { "name": "turned", "rotation": [half, 0, 0, half], "scale": [2, 2, 2], "mesh": 0 },
            { "name": "mirrored", "scale": [-1, 1, 1], "mesh": 0 },
            { "name": "matrix", "matrix": [1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,5,1], "mesh": 0 },
            { "name": "in no scene", "mesh": 0 },
        ],
        "materials": [{ "name": "stone" }],
        "meshes": [{ "name": "square", "primitives": [
            { "attributes": { "POSITION": positions, "NORMAL": normals }, "mode": 5, "material": 0 },
        ] }],
    });
    let model = read("a.glb", gltf.glb(rest));
    assert_eq!(model.faces.len(), 6, "two triangles each of three nodes, nothing from outside the scene");
    // A quarter turn about x takes y to z and the normal z to -y.
    let close = |a: Vec3, b: Vec3| (a - b).length() < 1e-5;
    assert!(close(model.positions[3], Vec3::new(12.0, 0.0, 2.0)), "turned, scaled, moved: {}", model.positions[3]);
    let normals = model.normals.as_ref().unwrap();
    assert!(close(normals[0], Vec3::NEG_Y), "normal turns along: {}", normals[0]);
    assert!(close(model.positions[5], Vec3::new(9.0, 0.0, 0.0)), "mirrored: {}", model.positions[5]);
    for (t, face) in triangles(&model).iter().zip(&model.faces) {
        let flat = (t[1] - t[0]).cross(t[2] - t[0]).normalize();
        assert!(flat.dot(normals[face[0] as usize]) > 0.9, "every face still looks along its normals, mirrored or not");
    }
    let names: Vec<_> = model.groups.iter().map(|g| (g.object.as_str(), g.group.as_str(), g.material.as_str())).collect();
    let expected = [("turned", "square", "stone"), ("mirrored", "square", "stone"), ("matrix", "square", "stone")];
    assert_eq!(names, expected, "node, mesh and material name the groups");
    assert_eq!((model.source.unit.as_deref(), model.source.up.as_deref()), (Some("m"), Some("+Y")), "as glTF defines");
}

#[test]
fn gltf_primitives_that_share_vertices_share_them_here_too() {
    let mut gltf = Gltf::default();
    let positions = gltf.positions(&SQUARE);
    let first = gltf.accessor(&[0, 1, 2], 5121, 3, "SCALAR");
    let second = gltf.accessor(&[1, 3, 2], 5121, 3, "SCALAR");
    let other = gltf.positions(&SQUARE[..3]);
    let rest = json!({
        "scenes": [{ "nodes": [0] }], "nodes": [{ "mesh": 0 }],
        "meshes": [{ "primitives": [
            { "attributes": { "POSITION": positions }, "indices": first },
            { "attributes": { "POSITION": positions }, "indices": second },
            { "attributes": { "POSITION": other } },
            { "attributes": { "POSITION": other }, "mode": 1 },
        ] }],
    });
    let model = read("a.glb", gltf.glb(rest));
    assert_eq!(model.faces, [[0, 1, 2], [1, 3, 2], [4, 5, 6]], "seven vertices, not eleven; lines left out");
    assert_eq!(model.source.notes.len(), 1, "the lines are told: {:?}", model.source.notes);
}

#[test]
fn gltf_sparse_interleaved_and_quantised_accessors() {
    // Positions as normalised 16-bit numbers, interleaved with 8-bit colours; vertex 2 moved by a sparse accessor.
    let mut gltf = Gltf::default();
    let mut bytes = Vec::new();
    for p in SQUARE {
        bytes.extend(p.iter().flat_map(|&c| ((c * 32767.0) as i16).to_le_bytes()));
        bytes.extend([0, 0, 255, 127, 0, 255]);
    }
    let view = gltf.view(&bytes, Some(12));
    let at = gltf.view(&[2], None);
    let by: Vec<u8> = [-32767_i16, 32767, 0].iter().flat_map(|c| c.to_le_bytes()).collect();
    let by = gltf.view(&by, None);
    gltf.accessors.push(json!({
        "bufferView": view, "componentType": 5122, "normalized": true, "count": 4, "type": "VEC3",
        "sparse": { "count": 1, "indices": { "bufferView": at, "componentType": 5121 }, "values": { "bufferView": by } },
    }));
    gltf.accessors.push(json!({
        "bufferView": view, "byteOffset": 8, "componentType": 5121, "normalized": true, "count": 4, "type": "VEC4",
    }));
    let mut rest = one_primitive(json!({ "attributes": { "POSITION": 0, "COLOR_0": 1 }, "mode": 5 }));
    rest["extensionsRequired"] = json!(["KHR_mesh_quantization"]);
    let model = read("a.glb", gltf.glb(rest));
    assert_eq!(model.positions[3], Vec3::new(1.0, 1.0, 0.0), "quantised");
    assert_eq!(model.positions[2], Vec3::new(-1.0, 1.0, 0.0), "moved by the sparse accessor");
    assert_eq!(model.colors.unwrap()[0], Vec4::new(1.0, 127.0 / 255.0, 0.0, 1.0), "colours are linear already");
}

#[test]
fn gltf_data_uris_and_external_buffers() {
    let mut gltf = Gltf::default();
    let positions = gltf.positions(&SQUARE);
    let rest = one_primitive(json!({ "attributes": { "POSITION": positions }, "mode": 5 }));
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.gltf");
    std::fs::write(folder.path().join("some data.bin"), &gltf.bin).unwrap();
    std::fs::write(&path, gltf.document(rest.clone(), Some("some%20data.bin".into())).to_string()).unwrap();
    let external = lapped::format::read_model(&path).unwrap();
    assert_eq!(external.faces.len(), 2, "external buffer, its name escaped");

    const ALPHABET: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut text = String::from("data:application/octet-stream;base64,");
    for three in gltf.bin.chunks(3) {
        let bits = three.iter().fold(0_u32, |bits, &b| bits << 8 | u32::from(b)) << (8 * (3 - three.len()));
        let digits = (0..=three.len()).map(|k| char::from(ALPHABET[(bits >> (18 - 6 * k) & 63) as usize]));
        text.extend(digits);
    }
    let embedded = read("a.gltf", gltf.document(rest.clone(), Some(text)).to_string());
    assert_eq!((&embedded.positions, &embedded.faces), (&external.positions, &external.faces), "data URI");
    let binary = read("a.glb", gltf.glb(rest));
    assert_eq!((&binary.positions, &binary.faces), (&external.positions, &external.faces), "GLB");
}
