//! Every feature of PLY and STL that is promised, each on a file that uses it; and that content decides what a file is.

#![allow(clippy::unwrap_used, clippy::panic, reason = "helpers of tests may fail as tests do")]

use glam::{Vec2, Vec3, Vec4};
use lapped::format::{Model, read_model_bytes};
use std::path::Path;

fn read(name: &str, bytes: impl AsRef<[u8]>) -> Model {
    read_model_bytes(Path::new(name), bytes.as_ref()).unwrap()
}

fn triangles(model: &Model) -> Vec<[Vec3; 3]> {
    model.faces.iter().map(|f| f.map(|v| model.positions[v as usize])).collect()
}

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
    assert_eq!(blue, Vec4::new(1.0, 0.0, lapped::exemplar::srgb::decode(0.4), 1.0), "colours, linear");
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

#[test]
fn the_content_decides_not_the_ending() {
    let obj = "# hello\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n";
    for ending in ["stl", "ply", "glb", "gltf", "txt", "OBJ"] {
        assert_eq!(read(&format!("a.{ending}"), obj).source.format, "Wavefront OBJ", "an OBJ file named .{ending}");
        assert!(read(&format!("a.{ending}"), ply("ascii")).source.format.starts_with("PLY"), "a PLY file named .{ending}");
        assert!(
            read(&format!("a.{ending}"), stl_binary("x", &TWO)).source.format.starts_with("STL"),
            "an STL file named .{ending}"
        );
    }
}
