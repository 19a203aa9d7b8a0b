//! Whatever is wrong with a file ends in one sentence that names the file, what is wrong, where, and what to do.

#![allow(clippy::unwrap_used, clippy::panic, reason = "helpers of tests may fail as tests do")]

use lapped::format::{FormatError, read_exemplar, read_mask, read_model, read_model_bytes, read_record, save_image, write_record};
use std::path::Path;

/// The message for a mesh file of these bytes.
fn refusal(name: &str, bytes: impl AsRef<[u8]>) -> String {
    let message = match read_model_bytes(Path::new(name), bytes.as_ref()) {
        Ok(model) => panic!("{name} was read: {} faces", model.faces.len()),
        Err(error) => error.to_string(),
    };
    assert!(message.starts_with(name), "{message:?} begins with the file's name");
    assert!(message.matches(':').count() >= 2, "{message:?} says what is wrong and what to do");
    assert!(!message.contains('\n'), "{message:?} is one line");
    message
}

/// Checks that the message for a file contains all of the words.
fn refused(name: &str, bytes: impl AsRef<[u8]>, words: &[&str]) {
    let message = refusal(name, bytes);
    for word in words {
        assert!(message.contains(word), "{message:?} says {word:?}");
    }
}

const TRIANGLE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";

#[test]
fn obj_problems_name_their_line() {
    refused("a.obj", "", &["empty"]);
    refused("a.obj", format!("{TRIANGLE}f 1 2 9\n"), &["line 4", "vertex 9", "only 3"]);
    refused("a.obj", format!("{TRIANGLE}f 1 2 0\n"), &["line 4", "\"0\""]);
    refused("a.obj", format!("{TRIANGLE}f 1 2 -4\n"), &["line 4", "\"-4\""]);
    refused("a.obj", format!("{TRIANGLE}f 1/1 2/1 3/1\n"), &["line 4", "texture coordinate 1", "only 0"]);
    refused("a.obj", format!("{TRIANGLE}f 1 2 three\n"), &["line 4", "three"]);
    refused("a.obj", "v 0 0 0\nv 1 0\nf 1 2 1\n", &["line 2", "missing"]);
    refused("a.obj", "v 0 0 0\nv 1 nan 0\nf 1 2 1\n", &["line 2", "NaN"]);
    refused("a.obj", "v 0 0 0\nv 1 1e99 0\nf 1 2 1\n", &["line 2", "32-bit"]);
    refused("a.obj", "v 0 0 inf\nf 1 1 1\n", &["line 1", "infinite"]);
    refused("a.obj", TRIANGLE, &["3 vertices", "no faces"]);
    refused("a.obj", "# nothing\n", &["no vertices"]);
    refused("a.obj", "v 0 0 0\0\0\0", &["line 1"]);
    refused("a.obj", format!("{TRIANGLE}vt 0 x\nf 1 2 3\n"), &["line 4", "texture coordinate", "\"x\""]);
    refused("a.obj", format!("# a\n{TRIANGLE}vn 0 0\nf 1 2 3\n"), &["line 5", "normal", "missing"]);
    refused("a.obj", b"o a\nv 0 0 \xFF\nf 1 1 1\n", &["line 2", "not a number"]);
}

#[test]
fn obj_indices_that_a_lenient_reader_would_take_are_refused() {
    let file = |face: &str| format!("{TRIANGLE}vt 0 0\nvn 0 0 1\nf {face}\n");
    for (corner, words) in [
        ("3/0", &["\"3/0\""]),
        ("3//0", &["\"3//0\""]),
        ("3/-2", &["\"3/-2\""]),
        ("3//-2", &["\"3//-2\""]),
        ("3/-9223372036854775807", &["no corner"]),
        ("3/9223372036854775809", &["no corner"]),
        ("3//6148914691236517207", &["normal 6148914691236517207, but the file has only 1"]),
        ("3/2147483647", &["texture coordinate 2147483647, but the file has only 1"]),
        ("3//2", &["normal 2, but the file has only 1"]),
        ("3/1/1/1", &["\"3/1/1/1\""]),
        ("/1/1", &["\"/1/1\""]),
    ] {
        refused("a.obj", file(&format!("1 2 {corner}")), words);
        refused("a.obj", file(&format!("1 2 {corner}")), &["line 6"]);
    }
}

#[test]
fn ply_problems_name_their_element() {
    let header = |vertices: &str, faces: &str| {
        format!(
            "ply\nformat ascii 1.0\nelement vertex {vertices}\nproperty float x\nproperty float y\nproperty float z\nelement face {faces}\nproperty list uchar int vertex_indices\nend_header\n"
        )
    };
    let vertices = "0 0 0\n1 0 0\n0 1 0\n";
    refused("a.ply", "ply\nformat ascii 1.0\n", &["header"]);
    refused("a.ply", "ply\nformat runes 1.0\nend_header\n", &["line 2", "runes"]);
    refused("a.ply", "ply\nelement vertex 1\nend_header\n", &["format"]);
    refused("a.ply", header("3", "4000000000") + vertices, &["4000000000", "face", "bytes follow"]);
    refused("a.ply", header("99999999999999999999", "1"), &["line 3", "count"]);
    refused("a.ply", header("3", "1") + vertices + "3 0 1 7\n", &["face 0", "vertex 7", "only 3"]);
    refused("a.ply", header("3", "1") + vertices + "3 0 1 -2\n", &["face 0", "line 13", "-2"]);
    refused("a.ply", header("3", "1") + vertices + "200000 0 1 2\n", &["face 0"]);
    refused("a.ply", header("3", "1") + vertices + "3 0 x 2\n", &["face 0", "line 13"]);
    refused("a.ply", header("3", "1") + "0 0 0\n1 nan 0\n0 1 0\n3 0 1 2\n", &["vertex 1", "NaN"]);
    refused("a.ply", header("3", "1").replace(" z", " w") + vertices + "3 0 1 2\n", &["no z"]);
    refused("a.ply", header("3", "1").replace("vertex_indices", "stuff") + vertices + "3 0 1 2\n", &["vertex indices"]);
    refused("a.ply", header("3", "0") + vertices, &["no faces"]);
    let binary = header("3", "2").replace("ascii", "binary_little_endian");
    let mut body = binary.into_bytes();
    body.extend([0_u8; 36]);
    body.push(3);
    body.extend([0_u8; 12]);
    refused("a.ply", &body, &["face 1", "ends here"]);
}

#[test]
fn stl_problems_tell_counts() {
    let mut file = vec![0_u8; 84];
    file[80..84].copy_from_slice(&1_000_000_u32.to_le_bytes());
    file.extend([0; 50]);
    refused("a.stl", &file, &["1000000", "only 1"]);
    refused("a.stl", [0_u8; 30], &["shorter"]);
    refused("a.stl", [0_u8; 84], &["no faces"]);
    refused("a.stl", "solid x\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\n", &["no end"]);
    refused("a.stl", "solid x\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nendloop\n", &["line 5", "2 corners"]);
    refused("a.stl", "solid x\nvertex 0 0 zero\n", &["line 2", "zero"]);
    refused("a.stl", "solid x\nendsolid\n", &["no faces"]);
}

#[test]
fn gltf_problems_name_their_object() {
    let document = |rest: &str| format!("{{ \"asset\": {{ \"version\": \"2.0\" }}, {rest} }}");
    let mesh = "\"nodes\": [{ \"mesh\": 0 }], \"meshes\": [{ \"primitives\": [{ \"attributes\": { \"POSITION\": 0 } }] }]";
    refused("a.gltf", "{ \"asset\": ", &["JSON", "line 1"]);
    refused("a.gltf", "{}", &["asset.version"]);
    refused("a.gltf", "{ \"asset\": { \"version\": \"1.0\" } }", &["1.0", "2.0"]);
    refused("a.gltf", document("\"scene\": 3"), &["scene 3"]);
    refused("a.gltf", document("\"nodes\": []"), &["no vertices"]);
    refused("a.gltf", document("\"scenes\": [{ \"nodes\": [7] }]"), &["node 7"]);
    let cycle = "\"scenes\": [{ \"nodes\": [0] }], \"nodes\": [{ \"children\": [1] }, { \"children\": [0] }]";
    refused("a.gltf", document(cycle), &["node 0", "ancestor"]);
    refused("a.gltf", document(mesh), &["accessor 0", "no such"]);
    let accessor = |rest: &str| format!("{mesh}, \"accessors\": [{{ \"componentType\": 5126, \"type\": \"VEC3\", {rest} }}]");
    refused("a.gltf", document(&accessor("\"count\": 3")), &["accessor 0", "no data", "compression"]);
    refused("a.gltf", document(&accessor("\"count\": 3, \"bufferView\": 0")), &["buffer view 0", "no such"]);
    let far = "\"count\": 4000000000, \"bufferView\": 0";
    let buffers = "\"bufferViews\": [{ \"buffer\": 0, \"byteLength\": 8 }], \"buffers\": [{ \"byteLength\": 8, \"uri\": \"data:;base64,AAAAAAAAAAA=\" }]";
    refused("a.gltf", document(&format!("{}, {buffers}", accessor(far))), &["accessor 0", "4000000000", "beyond"]);
    let sparse = "\"count\": 4000000000, \"sparse\": { \"count\": 0, \"indices\": { \"bufferView\": 0, \"componentType\": 5121 }, \"values\": { \"bufferView\": 0 } }";
    refused("a.gltf", document(&format!("{}, {buffers}", accessor(sparse))), &["accessor 0", "without data"]);
    let outside = "\"buffers\": [{ \"byteLength\": 8, \"uri\": \"/etc/passwd\" }]";
    refused("a.gltf", document(&format!("{mesh}, {outside}")), &["buffer 0", "beside"]);
    let missing = "\"buffers\": [{ \"byteLength\": 8, \"uri\": \"not-there.bin\" }]";
    refused("a.gltf", document(&format!("{mesh}, {missing}")), &["buffer 0", "not-there.bin"]);
    let draco = "\"extensionsRequired\": [\"KHR_draco_mesh_compression\"]";
    refused("a.gltf", document(draco), &["KHR_draco_mesh_compression", "without compression"]);
    refused("a.glb", b"glTF\x02\0\0\0", &["shorter"]);
    refused("a.glb", b"glTF\x01\0\0\0\x0c\0\0\0", &["version 1"]);
    refused("a.glb", b"glTF\x02\0\0\0\xff\xff\0\0", &["65535"]);
    refused("a.glb", b"glTF\x02\0\0\0\x0c\0\0\0", &["no JSON"]);
}

#[test]
fn files_of_other_kinds_are_named() {
    refused("a.fbx", b"Kaydara FBX Binary  \0", &["FBX", "export"]);
    refused("a.obj", b"\x89PNG\r\n\x1a\n", &["PNG", "not read as a mesh"]);
    refused("a.glb", b"PK\x03\x04", &["ZIP"]);
    refused("a.ply", "plywood is a material\n", &["no mesh file"]);
    refused("notes.txt", "Dear diary\n", &["no mesh file", ".txt"]);
}

#[test]
fn paths_that_are_no_files_are_told_apart() {
    let folder = tempfile::tempdir().unwrap();
    let missing = folder.path().join("missing.obj");
    assert!(matches!(read_model(&missing), Err(FormatError::Missing { .. })), "no such file");
    assert!(matches!(read_model(folder.path()), Err(FormatError::Folder { .. })), "a folder");
    assert!(matches!(read_record(&missing), Err(FormatError::Missing { .. })), "no such record");
    assert!(matches!(read_mask(&missing), Err(FormatError::Missing { .. })), "no such mask");
    let options = lapped::format::ExemplarOptions::default();
    assert!(matches!(read_exemplar(&missing, &options), Err(FormatError::Missing { .. })), "no such exemplar");
    let empty = read_exemplar(folder.path(), &options);
    assert!(matches!(empty, Err(FormatError::NoBaseColor { .. })), "a folder without images: {empty:?}");
}

#[test]
fn outputs_that_cannot_be_written_leave_nothing_behind() {
    let folder = tempfile::tempdir().unwrap();
    let image = lapped::exemplar::Image::from_fn(4, 4, |_, _| glam::Vec3::ONE);
    let lost = folder.path().join("no such folder").join("out.png");
    let message = save_image(&lost, &image).unwrap_err().to_string();
    assert!(message.contains("no such folder does not exist"), "{message}");
    let message = save_image(folder.path(), &image).unwrap_err().to_string();
    assert!(message.contains("folder of that name"), "{message}");

    let target = folder.path().join("kept.png");
    std::fs::write(&target, "what was here").unwrap();
    let failed = lapped::format::write_file(&target, |out| {
        out.write_all(&[1; 100_000])?;
        Err(std::io::ErrorKind::StorageFull.into())
    });
    let message = failed.unwrap_err().to_string();
    assert!(message.contains("disk is full") && message.contains("kept.png"), "{message}");
    assert_eq!(std::fs::read(&target).unwrap(), b"what was here", "the old file is whole");
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1, "no temporary file is left");

    let record = lapped::format::Record::default();
    let message = write_record(&folder.path().join("empty.glb"), &record).unwrap_err().to_string();
    assert!(message.contains("no faces"), "{message}");
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1, "nothing was written");
}

#[cfg(unix)]
#[test]
fn outputs_have_the_permissions_of_any_new_file_and_follow_links() {
    use std::os::unix::fs::PermissionsExt;
    let folder = tempfile::tempdir().unwrap();
    let plain = folder.path().join("plain");
    std::fs::write(&plain, "x").unwrap();
    let written = folder.path().join("written");
    lapped::format::write_file(&written, |out| out.write_all(b"x")).unwrap();
    let mode = |p: &Path| std::fs::metadata(p).unwrap().permissions().mode();
    assert_eq!(mode(&written), mode(&plain), "not the private mode of temporary files");

    let link = folder.path().join("link");
    std::os::unix::fs::symlink(&plain, &link).unwrap();
    lapped::format::write_file(&link, |out| out.write_all(b"through")).unwrap();
    assert!(link.is_symlink(), "the link is still one");
    assert_eq!(std::fs::read(&plain).unwrap(), b"through", "its target was replaced");
}
