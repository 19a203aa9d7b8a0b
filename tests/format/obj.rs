//! Every feature of OBJ that is promised, each on a file that uses it.

#![allow(clippy::unwrap_used, clippy::panic, reason = "helpers of tests may fail as tests do")]

use glam::{Vec2, Vec3, Vec4};
use lapped::format::{FaceGroup, Model, read_model_bytes};
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
    let half = lapped::exemplar::srgb::decode(0.5);
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

#[test]
fn normals_that_are_none_are_taken_from_the_faces() {
    let model = read("a.obj", format!("{CUBE_FACE}vn 0 0 0\nvn nan 0 0\nvn 0 0 9\nf 1//1 2//2 3//3\n"));
    assert_eq!(model.normals.unwrap()[..3], [Vec3::Z; 3], "zero, NaN and long normals");
}
