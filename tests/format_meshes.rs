//! Every feature of the mesh formats that is promised, each on a file that uses it.

#![allow(clippy::unwrap_used, clippy::panic, reason = "helpers of tests may fail as tests do")]

use glam::{Vec2, Vec3, Vec4};
use lapped::format::{FaceGroup, Model, read_model_bytes};
use serde_json::{Value, json};
use std::path::Path;

fn read(name: &str, bytes: impl AsRef<[u8]>) -> Model {
    read_model_bytes(Path::new(name), bytes.as_ref()).unwrap()
}

fn triangles(model: &Model) -> Vec<[Vec3; 3]> {
    model.faces.iter().map(|f| f.map(|v| model.positions[v as usize])).collect()
}

fn area(model: &Model) -> f32 {
    triangles(model).iter().map(|[a, b, c]| 0.5 * (b - a).cross(c - a).length()).sum()
}

// ---- OBJ

const CUBE_FACE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

#[test]
fn obj_quads_are_cut_and_counted() {
    let model = read("a.obj", format!("{CUBE_FACE}f 1 2 3 4\nf 4 3 2\n"));
    assert_eq!(model.faces, [[0, 1, 2], [0, 2, 3], [3, 2, 1]], "two triangles for the quad, one for the triangle");
    assert_eq!(model.polygons, Some(vec![0, 0, 1]), "polygon of each triangle");
    assert_eq!((model.source.vertices, model.source.polygons), (4, 2), "counts of the file");
    assert_eq!(model.name, "a", "the file's stem where the file names nothing");
}

#[test]
fn obj_concave_polygons_keep_their_area() {
    // An L of area 3, starting at each of its corners: a fan covers too much from most of them.
    let corners = ["0 0 0", "2 0 0", "2 0 1", "1 0 1", "1 0 2", "0 0 2"];
    let vertices: String = corners.iter().map(|c| format!("v {c}\n")).collect();
    for start in 0..6 {
        let face: String = (0..6).map(|k| format!(" {}", (start + k) % 6 + 1)).collect();
        let model = read("l.obj", format!("{vertices}f{face}\n"));
        assert_eq!(model.faces.len(), 4, "six corners, four triangles");
        assert!((area(&model) - 3.0).abs() < 1e-6, "area from corner {start}: {}", area(&model));
    }
}

#[test]
fn obj_negative_indices_count_back_from_the_line() {
    let plain = read("a.obj", format!("{CUBE_FACE}f 1 2 3\nv 5 5 5\nf 2 3 5\n"));
    let negative = read("a.obj", format!("{CUBE_FACE}f -4 -3 -2\nv 5 5 5\nf -4 -3 -1\n"));
    assert_eq!(plain.faces, negative.faces, "the same faces");
}

#[test]
fn obj_corner_attributes_split_vertices_and_keep_their_order() {
    let text = format!("{CUBE_FACE}vt 0 0\nvt 1 0\nvt 1 1\nvn 0 0 1\nf 1/1/1 2/2/1 3/3/1\nf 1/2/1 3/3/1 4/1/1\n");
    let model = read("a.obj", text);
    assert_eq!(model.faces, [[0, 1, 2], [4, 2, 3]], "only corner 1 of the second face differs from its vertex");
    assert_eq!(model.positions[4], model.positions[0], "the copy lies at its vertex");
    let uvs = model.uvs.unwrap();
    assert_eq!((uvs[0], uvs[4]), (Vec2::new(0.0, 1.0), Vec2::new(1.0, 1.0)), "v counts down from the top, as in glTF");
    assert_eq!(model.normals.unwrap(), vec![Vec3::Z; 5], "normals");
}

#[test]
fn obj_objects_groups_and_materials_are_runs_of_faces() {
    let text = format!(
        "mtllib not there.mtl\n{CUBE_FACE}f 1 2 3\no box\ng side wall\nusemtl red brick\nf 1 2 3 4\nusemtl blue\nf 1 2 3\ng\nf 2 3 4\n"
    );
    let model = read("a.obj", text);
    let group = |object: &str, group: &str, material: &str, start, count| FaceGroup {
        object: object.into(),
        group: group.into(),
        material: material.into(),
        start,
        count,
    };
    let expected = vec![
        group("", "", "", 0, 1),
        group("box", "side wall", "red brick", 1, 2),
        group("box", "side wall", "blue", 3, 1),
        group("box", "", "blue", 4, 1),
    ];
    assert_eq!(model.groups, expected, "names change where the file says so; a missing material file is no matter");
    assert_eq!(model.name, "box", "the first object's name");
}

#[test]
fn obj_line_ends_comments_continuations_and_odd_spacing_do_not_matter() {
    let plain = read("a.obj", format!("{CUBE_FACE}f 1 2 3 4\n"));
    let text = "\u{FEFF}# made by hand\r\n# File units = millimeters\r\n\r\n  v 0 0 0\r\nv\t1 0  0 # right\r\nv 1 1 0 1.0\r\nv 0 1 \\\r\n0\r\ns off\r\nf 1 \\\r\n2 3 4 # all";
    let odd = read("a.obj", text);
    assert_eq!((plain.positions, plain.faces), (odd.positions, odd.faces), "the same mesh");
    assert_eq!(odd.source.unit.as_deref(), Some("millimeters"), "unit from a comment");
    assert_eq!(read("a.obj", format!("{CUBE_FACE}f 1 2 3 4\n").replace('\n', "\r")).faces.len(), 2, "old line ends");
}

#[test]
fn obj_vertex_colours_come_as_linear_light() {
    let model = read("a.obj", "v 0 0 0 1 0.5 0\nv 1 0 0 0 0 0\nv 0 1 0 1 1 1\nf 1 2 3\n");
    let half = lapped::format::srgb::decode(0.5);
    assert_eq!(model.colors.unwrap(), [Vec4::new(1.0, half, 0.0, 1.0), Vec4::new(0.0, 0.0, 0.0, 1.0), Vec4::ONE], "decoded");
    let bytes = read("a.obj", "v 0 0 0 255 0 0\nv 1 0 0 0 0 0\nv 0 1 0 0 0 255\nf 1 2 3\n");
    assert_eq!(bytes.colors.unwrap()[0], Vec4::new(1.0, 0.0, 0.0, 1.0), "0 to 255 is understood");
}

#[test]
fn obj_lines_points_and_thin_faces_are_left_out_with_a_note() {
    let model = read("a.obj", format!("{CUBE_FACE}f 1 2\nl 1 2 3\np 1\nf 1 2 3\n"));
    assert_eq!(model.faces.len(), 1, "one real face");
    assert_eq!(model.source.notes.len(), 2, "a note for each kind: {:?}", model.source.notes);
}

#[test]
fn obj_vertices_keep_the_order_of_the_file() {
    // Used backwards, one not at all, one repeated, and faces before their vertices.
    let model =
        read("a.obj", "f 5/2 3/3 2/1\nf 2 1 5\nv 0 0 0\nv 1 0 0\nv 2 2 0\nv 7 7 7\nv 1 0 0\nvt 0 1\nvt 1 1\nvt 1 0\nvt 5 5\n");
    let expected = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [2.0, 2.0, 0.0], [7.0, 7.0, 7.0], [1.0, 0.0, 0.0]];
    assert_eq!(model.positions[..5], expected.map(Vec3::from_array), "all five, each in its place");
    assert_eq!(model.faces[0], [4, 2, 1], "indices of the file");
    let uvs = model.uvs.unwrap();
    assert_eq!([uvs[4], uvs[2], uvs[1]], [Vec2::X, Vec2::ONE, Vec2::ZERO], "each corner its own texture coordinate");
}

#[test]
fn obj_corners_without_attributes_borrow_none() {
    let text = format!("{CUBE_FACE}v 3 0 0\nvt 0.5 0.25\nvn 1 0 0\nf 1/1/1 2/1/1 3/1/1\nf 5 3 4\nf 5//1 2/1 1\n");
    let model = read("a.obj", text);
    let (uvs, normals) = (model.uvs.unwrap(), model.normals.unwrap());
    let at = |face: usize, corner: usize| model.faces[face][corner] as usize;
    assert_eq!([uvs[at(0, 2)], uvs[at(1, 1)]], [Vec2::new(0.5, 0.75), Vec2::ZERO], "vertex 3 has one in the first face only");
    assert_eq!([uvs[at(2, 0)], uvs[at(2, 1)], uvs[at(2, 2)]], [Vec2::ZERO, Vec2::new(0.5, 0.75), Vec2::ZERO], "within a face");
    assert_eq!([normals[at(0, 0)], normals[at(2, 0)]], [Vec3::X; 2], "normals where the file has them");
    assert_eq!(normals[at(1, 2)].x, 0.0, "elsewhere those of the faces around: {}", normals[at(1, 2)]);
    let bare = read("a.obj", format!("{CUBE_FACE}vt 0 0\nvn 0 0 1\nf 1 2 3\n"));
    assert_eq!((bare.uvs, bare.normals), (None, None), "no corner has any");
}

#[test]
fn obj_weights_do_not_move_vertices_and_colours_may_be_missing() {
    let model = read("a.obj", "v 2 0 0 0\nv 4 0 0 2\nv 0 6 0 3 3\nf 1 2 3\n");
    assert_eq!(model.positions[1..], [Vec3::X * 4.0, Vec3::Y * 6.0], "weights are for curves");
    let model = read("a.obj", "v 0 0 0\nv 1 0 0 255 0 0 128\nv 0 1 0 a b c\nf 1 2 3\n");
    let expected = [Vec4::ONE, Vec4::new(1.0, 0.0, 0.0, 1.0), Vec4::ONE];
    assert_eq!(model.colors.unwrap(), expected, "vertices without a colour are white");
}

#[test]
fn obj_names_may_be_in_any_encoding() {
    let mut file = b"# caf\xE9\no b\xE9ton\n".to_vec();
    file.extend(format!("{CUBE_FACE}usemtl\n\x0busemtl x\nusemtl\ttabbed name\nf 1 2 3\n").bytes());
    let model = read("a.obj", file);
    assert_eq!(model.groups[0].object, "b\u{FFFD}ton", "what is not UTF-8 is replaced");
    assert_eq!(model.groups[0].material, "tabbed name", "a tab ends the word as well");
}

// ---- PLY

/// The same little mesh in each encoding, with numbers of many types.
fn ply(encoding: &str) -> Vec<u8> {
    let header = format!(
        "ply\nformat {encoding} 1.0\ncomment units: mm\nelement junk 2\nproperty list uchar short stuff\nproperty double d\nelement vertex 5\nproperty double x\nproperty float y\nproperty float32 z\nproperty int16 flags\nproperty float nx\nproperty float ny\nproperty float nz\nproperty float s\nproperty float t\nproperty uchar red\nproperty uchar green\nproperty uchar blue\nproperty uchar alpha\nelement face 2\nproperty uchar material\nproperty list ushort uint vertex_indices\nproperty list uchar float weights\nend_header\n"
    );
    let mut out = header.into_bytes();
    let mut row = |numbers: &[(f64, &str)]| match encoding {
        "ascii" => {
            let words: Vec<String> = numbers.iter().map(|(n, _)| n.to_string()).collect();
            out.extend(format!("{}\n", words.join(" ")).bytes());
        }
        _ => {
            for &(n, kind) in numbers {
                let mut bytes = match kind {
                    "u8" => (n as u8).to_le_bytes().to_vec(),
                    "i16" => (n as i16).to_le_bytes().to_vec(),
                    "u16" => (n as u16).to_le_bytes().to_vec(),
                    "u32" => (n as u32).to_le_bytes().to_vec(),
                    "f32" => (n as f32).to_le_bytes().to_vec(),
                    _ => n.to_le_bytes().to_vec(),
                };
                if encoding.ends_with("big_endian") {
                    bytes.reverse();
                }
                out.extend(bytes);
            }
        }
    };
    row(&[(2.0, "u8"), (-5.0, "i16"), (6.0, "i16"), (0.5, "f64")]);
    row(&[(0.0, "u8"), (0.25, "f64")]);
    for (k, [x, y]) in [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0], [2.0, 0.5]].into_iter().enumerate() {
        row(&[
            (x, "f64"),
            (y, "f32"),
            (0.5, "f32"),
            (-3.0, "i16"),
            (0.0, "f32"),
            (0.0, "f32"),
            (2.0, "f32"),
            (x, "f32"),
            (0.25, "f32"),
            (255.0, "u8"),
            (0.0, "u8"),
            (51.0 * k as f64, "u8"),
            (255.0, "u8"),
        ]);
    }
    let quad = [(7.0, "u8"), (4.0, "u16"), (0.0, "u32"), (1.0, "u32"), (2.0, "u32"), (3.0, "u32"), (1.0, "u8"), (0.1, "f32")];
    row(&quad);
    row(&[(7.0, "u8"), (3.0, "u16"), (1.0, "u32"), (4.0, "u32"), (2.0, "u32"), (0.0, "u8")]);
    out
}

#[test]
fn ply_encodings_hold_the_same_mesh() {
    let ascii = read("a.ply", ply("ascii"));
    assert_eq!(ascii.faces, [[0, 1, 2], [0, 2, 3], [1, 4, 2]], "a quad and a triangle, other elements stepped over");
    assert_eq!((ascii.source.vertices, ascii.source.polygons), (5, 2), "counts of the file");
    assert_eq!(ascii.positions[4], Vec3::new(2.0, 0.5, 0.5), "doubles and floats");
    assert_eq!(ascii.normals.as_deref(), Some(&[Vec3::Z; 5][..]), "normals are made unit");
    assert_eq!(ascii.uvs.as_ref().unwrap()[1], Vec2::new(1.0, 0.75), "s and t, t up");
    let blue = ascii.colors.as_ref().unwrap()[2];
    assert_eq!(blue, Vec4::new(1.0, 0.0, lapped::format::srgb::decode(0.4), 1.0), "colours, linear");
    assert_eq!(ascii.source.unit.as_deref(), Some("mm"), "unit from a comment");
    for encoding in ["binary_little_endian", "binary_big_endian"] {
        let mut binary = read("a.ply", ply(encoding));
        binary.source.format.clone_from(&ascii.source.format);
        assert_eq!(binary, ascii, "{encoding}");
    }
}

#[test]
fn ply_triangle_strips_turn_every_second_triangle() {
    let text = "ply\nformat ascii 1.0\nelement vertex 6\nproperty float x\nproperty float y\nproperty float z\nelement tristrips 1\nproperty list int int vertex_indices\nend_header\n0 0 0\n0 1 0\n1 0 0\n1 1 0\n2 0 0\n2 1 0\n10 0 1 2 3 -1 2 3 4 4 5\n";
    let model = read("a.ply", text);
    // The second strip repeats vertex 4 to turn itself around.
    assert_eq!(model.faces, [[0, 1, 2], [2, 1, 3], [2, 3, 4]], "-1 begins a new strip, repeats are no triangles");
    assert_eq!(model.source.polygons, 3, "triangles are counted");
}

#[test]
fn ply_texture_coordinates_of_corners_split_vertices() {
    let text = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\nelement face 2\nproperty list uchar int vertex_index\nproperty list uchar float texcoord\nend_header\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n3 0 1 2 6 0 0 1 0 1 1\n3 0 2 3 6 0.5 0.5 1 1 0 1\n";
    let model = read("a.ply", text);
    assert_eq!(model.faces, [[0, 1, 2], [4, 2, 3]], "vertex 0 carries two coordinates");
    assert_eq!(model.uvs.unwrap()[4], Vec2::new(0.5, 0.5), "the second one");
}

// ---- STL

fn stl_binary(header: &str, triangles: &[[[f32; 3]; 3]]) -> Vec<u8> {
    let mut out = vec![b' '; 80];
    out[..header.len()].copy_from_slice(header.as_bytes());
    out.extend((triangles.len() as u32).to_le_bytes());
    for t in triangles {
        out.extend([0_u8; 12]);
        out.extend(t.as_flattened().iter().flat_map(|c| c.to_le_bytes()));
        out.extend([0_u8; 2]);
    }
    out
}

const TWO: [[[f32; 3]; 3]; 2] =
    [[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], [[1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.5]]];

#[test]
fn stl_binary_is_known_by_its_length_even_if_it_begins_with_solid() {
    for header in ["exported", "solid exported by something, units: mm"] {
        let model = read("a.stl", stl_binary(header, &TWO));
        assert_eq!(model.faces, [[0, 1, 2], [3, 4, 5]], "{header}: three vertices a triangle");
        assert_eq!(model.positions[5], Vec3::new(0.0, 1.0, 0.5), "{header}: coordinates");
        assert_eq!(model.source.unit.is_some(), header.contains("mm"), "{header}: unit");
    }
}

#[test]
fn stl_ascii_holds_the_same_as_binary() {
    let facet = |t: &[[f32; 3]; 3]| {
        let v: String = t.iter().map(|p| format!("    vertex {} {:e} {}\n", p[0], p[1], p[2])).collect();
        format!("  facet normal 0 0 1\n   outer loop\n{v}   endloop\n  endfacet\n")
    };
    let text = format!("solid first part\n{}endsolid first part\nSOLID second\n{}ENDSOLID\n", facet(&TWO[0]), facet(&TWO[1]));
    let model = read("a.stl", text);
    assert_eq!(triangles(&model), triangles(&read("a.stl", stl_binary("", &TWO))), "the same triangles");
    let names: Vec<_> = model.groups.iter().map(|g| (g.object.as_str(), g.start, g.count)).collect();
    assert_eq!(names, [("first part", 0, 1), ("second", 1, 1)], "solids are groups");
}

// ---- glTF

/// A document under construction.
#[derive(Default)]
struct Gltf {
    bin: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
}

impl Gltf {
    fn view(&mut self, bytes: &[u8], stride: Option<usize>) -> usize {
        self.bin.resize(self.bin.len().next_multiple_of(4), 0);
        let mut view = json!({ "buffer": 0, "byteOffset": self.bin.len(), "byteLength": bytes.len() });
        if let Some(stride) = stride {
            view["byteStride"] = stride.into();
        }
        self.views.push(view);
        self.bin.extend(bytes);
        self.views.len() - 1
    }

    fn accessor(&mut self, bytes: &[u8], component: u32, count: usize, kind: &str) -> usize {
        let view = self.view(bytes, None);
        self.accessors.push(json!({ "bufferView": view, "componentType": component, "count": count, "type": kind }));
        self.accessors.len() - 1
    }

    fn positions(&mut self, p: &[[f32; 3]]) -> usize {
        let bytes: Vec<u8> = p.as_flattened().iter().flat_map(|c| c.to_le_bytes()).collect();
        self.accessor(&bytes, 5126, p.len(), "VEC3")
    }

    fn document(&self, rest: Value, uri: Option<String>) -> Value {
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

    fn glb(&self, rest: Value) -> Vec<u8> {
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

// ---- all of them

#[test]
fn the_content_decides_not_the_ending() {
    let obj = format!("# hello\n{CUBE_FACE}f 1 2 3 4\n");
    for ending in ["stl", "ply", "glb", "gltf", "txt", "OBJ"] {
        assert_eq!(read(&format!("a.{ending}"), &obj).source.format, "Wavefront OBJ", "an OBJ file named .{ending}");
        assert!(read(&format!("a.{ending}"), ply("ascii")).source.format.starts_with("PLY"), "a PLY file named .{ending}");
        assert!(
            read(&format!("a.{ending}"), stl_binary("x", &TWO)).source.format.starts_with("STL"),
            "an STL file named .{ending}"
        );
    }
}

#[test]
fn normals_that_are_none_are_taken_from_the_faces() {
    let model = read("a.obj", format!("{CUBE_FACE}vn 0 0 0\nvn nan 0 0\nvn 0 0 9\nf 1//1 2//2 3//3\n"));
    assert_eq!(model.normals.unwrap()[..3], [Vec3::Z; 3], "zero, NaN and long normals");
}
