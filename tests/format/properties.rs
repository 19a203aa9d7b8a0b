//! No bytes whatever make a reader panic or ask for more memory than the bytes are worth. Whatever it accepts is sound.

#![allow(clippy::unwrap_used, clippy::panic, reason = "helpers of tests may fail as tests do")]

use lapped::format::record::read_record_bytes;
use lapped::format::{ExemplarOptions, Model, read_exemplar, read_model_bytes};
use proptest::prelude::*;
use std::path::Path;

/// Reads bytes as a mesh; if that works, checks what every model promises.
fn read(name: &str, bytes: &[u8]) {
    if let Ok(model) = read_model_bytes(Path::new(name), bytes) {
        check(&model);
    }
}

fn check(model: &Model) {
    let vertices = model.positions.len();
    assert!(!model.faces.is_empty(), "a model has faces");
    assert!(model.faces.as_flattened().iter().all(|&v| (v as usize) < vertices), "indices are in range");
    assert!(model.positions.iter().all(|p| p.is_finite()), "positions are finite");
    for length in [model.normals.as_ref().map(Vec::len), model.uvs.as_ref().map(Vec::len), model.colors.as_ref().map(Vec::len)] {
        assert!(length.is_none_or(|l| l == vertices), "attributes have one entry a vertex");
    }
    assert!(model.normals.iter().flatten().all(|n| (n.length() - 1.0).abs() < 1e-3), "normals have unit length");
    assert!(model.uvs.iter().flatten().all(|t| t.is_finite()), "texture coordinates are finite");
    let grouped: u32 = model.groups.iter().map(|g| g.count).sum();
    assert!(model.groups.is_empty() || grouped as usize == model.faces.len(), "groups hold every face");
    assert!(model.polygons.iter().all(|p| p.len() == model.faces.len() && p.is_sorted()), "polygons follow the faces");
}

const OBJ: &str = "# c\no a\nv 0 0 0 1 0 0\nv 1 0 0 0 1 0\nv 1 1 0 0 0 1\nv 0 1 0.5 1 1 1\nv 2 2 2 1 1 1\nvt 0 0\nvt 1 1\nvn 0 0 1\ng b c\nusemtl m\nf 1/1/1 2/2/1 3/1/1 4/2/1\nf -1//-1 -2//-1 -3//-1\nf 1 2 3 4 5\n";

const PLY: &str = "ply\nformat ascii 1.0\ncomment x\nelement vertex 4\nproperty float x\nproperty float y\nproperty double z\nproperty uchar red\nproperty uchar green\nproperty uchar blue\nelement face 2\nproperty list uchar int vertex_indices\nproperty list uchar float texcoord\nelement tristrips 1\nproperty list int int vertex_indices\nend_header\n0 0 0 1 2 3\n1 0 0 1 2 3\n1 1 0 1 2 3\n0 1 0 1 2 3\n4 0 1 2 3 0\n3 0 1 2 6 0 0 1 0 1 1\n6 0 1 2 -1 2 3\n";

fn ply_binary(endian: &str) -> Vec<u8> {
    let header = format!(
        "ply\nformat binary_{endian}_endian 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n"
    );
    let mut out = header.into_bytes();
    let bytes = |b: [u8; 4]| if endian == "big" { [b[3], b[2], b[1], b[0]] } else { b };
    for c in [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0_f32] {
        out.extend(bytes(c.to_le_bytes()));
    }
    out.push(3);
    for i in [0, 1, 2_u32] {
        out.extend(bytes(i.to_le_bytes()));
    }
    out
}

fn stl_binary() -> Vec<u8> {
    let mut out = vec![b's'; 80];
    out.extend(2_u32.to_le_bytes());
    out.extend((0..100).map(|k| (k * 7 % 60) as u8));
    out
}

const STL: &str =
    "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid a\n";

const GLTF: &str = r#"{"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0,2]}],"nodes":[{"children":[1],"scale":[-1,1,1]},{"mesh":0,"matrix":[1,0,0,0,0,1,0,0,0,0,1,0,1,2,3,1]},{"mesh":0}],"meshes":[{"primitives":[{"attributes":{"POSITION":0,"NORMAL":0},"indices":1,"mode":5},{"attributes":{"POSITION":0}}]}],"accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","sparse":{"count":1,"indices":{"bufferView":1,"componentType":5121},"values":{"bufferView":0}}},{"bufferView":1,"componentType":5121,"count":3,"type":"SCALAR"}],"bufferViews":[{"buffer":0,"byteLength":36},{"buffer":0,"byteOffset":36,"byteLength":3}],"buffers":[{"byteLength":39,"uri":"data:;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAAAAEC"}]}"#;

/// A small whole record.
fn record() -> Vec<u8> {
    use glam::{Vec2, Vec3};
    use lapped::exemplar::{Exemplar, Hull, Image, MipChain, TexturePatch};
    use lapped::paste::{LappedTexture, Layer, Paste, Turn};
    let mut record = lapped::format::Record::default();
    record.model.positions = vec![Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z];
    record.model.faces = vec![[0, 1, 2], [0, 2, 3]];
    record.field = Some(vec![Vec3::X; 2]);
    let patch = TexturePatch {
        exemplar: 0,
        origin: [0, 0],
        mask: MipChain::mask(Image::grey_from_fn(4, 4, |_, _| 1.0)),
        hull: Hull::new(vec![Vec2::ZERO, Vec2::X, Vec2::Y]),
        centre: Vec2::ONE,
        weight: 1.0,
        slides: false,
    };
    let paste = Paste {
        patch: 0,
        faces: vec![1, 0],
        uv: vec![[Vec2::ZERO; 3]; 2],
        offset: Vec2::X,
        turn: Turn::new(60),
        cut: None,
        agreement: 200,
    };
    record.lapped = LappedTexture {
        exemplars: vec![Exemplar::new("e", Image::from_fn(4, 4, |_, _| Vec3::ONE))],
        patches: vec![patch],
        pastes: vec![paste.clone(), paste],
        layers: vec![Layer {
            name: "l".into(),
            pastes: 2,
            weights: vec![[0.0, 0.5, 1.0]; record.model.faces.len()],
            base: vec![[[9, 0, u16::MAX]; 3]; record.model.faces.len()],
        }],
    };
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("r.glb");
    lapped::format::write_record(&path, &record).unwrap();
    std::fs::read(path).unwrap()
}

/// A change to a file: bytes replaced, a stretch removed or repeated, the end cut off.
#[derive(Debug, Clone)]
enum Change {
    Set(usize, u8),
    Remove(usize, usize),
    Repeat(usize, usize),
    Cut(usize),
    /// Another number in place of a digit run: where things go wrong in headers and JSON.
    Number(usize, u64),
}

fn change() -> impl Strategy<Value = Change> {
    let at = 0..100_000_usize;
    prop_oneof![
        4 => (at.clone(), any::<u8>()).prop_map(|(a, b)| Change::Set(a, b)),
        1 => (at.clone(), 1..20_usize).prop_map(|(a, n)| Change::Remove(a, n)),
        1 => (at.clone(), 1..20_usize).prop_map(|(a, n)| Change::Repeat(a, n)),
        1 => at.clone().prop_map(Change::Cut),
        3 => (at, prop_oneof![0..10_u64, Just(u64::from(u32::MAX)), Just(u64::MAX), any::<u64>()]).prop_map(|(a, n)| Change::Number(a, n)),
    ]
}

fn apply(file: &mut Vec<u8>, change: &Change) {
    if file.is_empty() {
        return;
    }
    let length = file.len();
    match *change {
        Change::Set(at, byte) => file[at % length] = byte,
        Change::Remove(at, n) => drop(file.drain(at % length..(at % length + n).min(length))),
        Change::Repeat(at, n) => {
            let part = file[at % length..(at % length + n).min(length)].to_vec();
            file.splice(at % length..at % length, part);
        }
        Change::Cut(at) => file.truncate(at % length),
        Change::Number(at, number) => {
            let Some(start) = (0..length).map(|k| (at + k) % length).find(|&k| file[k].is_ascii_digit()) else { return };
            let digits = file[start..].iter().take_while(|b| b.is_ascii_digit()).count();
            file.splice(start..start + digits, number.to_string().into_bytes());
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 2000, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn random_bytes_are_no_trouble(bytes in proptest::collection::vec(any::<u8>(), 0..600), kind in 0..6_usize) {
        let starts: [&[u8]; 6] = [b"", b"v 0 0 0\n", b"ply\nformat binary_little_endian 1.0\n", b"solid x\n", b"glTF\x02\0\0\0", b"{\"asset\":{\"version\":\"2.0\"},"];
        let file = [starts[kind], &bytes].concat();
        for name in ["a.obj", "a.ply", "a.stl", "a.glb"] {
            read(name, &file);
        }
        let _ = read_record_bytes(Path::new("a.glb"), &file);
    }

    #[test]
    fn changed_obj_files_are_no_trouble(changes in proptest::collection::vec(change(), 1..6)) {
        let mut file = OBJ.as_bytes().to_vec();
        changes.iter().for_each(|c| apply(&mut file, c));
        read("a.obj", &file);
    }

    #[test]
    fn changed_ply_files_are_no_trouble(changes in proptest::collection::vec(change(), 1..6), kind in 0..3) {
        let mut file = match kind { 0 => PLY.as_bytes().to_vec(), 1 => ply_binary("little"), _ => ply_binary("big") };
        changes.iter().for_each(|c| apply(&mut file, c));
        read("a.ply", &file);
    }

    #[test]
    fn changed_stl_files_are_no_trouble(changes in proptest::collection::vec(change(), 1..6), binary: bool) {
        let mut file = if binary { stl_binary() } else { STL.as_bytes().to_vec() };
        changes.iter().for_each(|c| apply(&mut file, c));
        read("a.stl", &file);
    }

    #[test]
    fn changed_gltf_files_are_no_trouble(changes in proptest::collection::vec(change(), 1..6)) {
        let mut file = GLTF.as_bytes().to_vec();
        changes.iter().for_each(|c| apply(&mut file, c));
        read("a.gltf", &file);
    }

    #[test]
    fn obj_polygons_give_two_triangles_fewer_than_corners(
        points in proptest::collection::vec((-9..9_i32, -9..9_i32, -2..2_i32), 3..30),
    ) {
        // Any outline, also one that crosses itself or repeats points.
        let text: String = points.iter().map(|(x, y, z)| format!("v {x} {y} {z}\n")).collect();
        let face: String = (1..=points.len()).map(|k| format!(" {k}")).collect();
        let model = read_model_bytes(Path::new("a.obj"), format!("{text}f{face}\n").as_bytes()).unwrap();
        prop_assert_eq!(model.faces.len(), points.len() - 2);
        check(&model);
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 1000, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn changed_records_are_no_trouble(changes in proptest::collection::vec(change(), 1..5), keep_length: bool) {
        thread_local!(static FILE: Vec<u8> = record());
        let mut file = FILE.with(Clone::clone);
        changes.iter().for_each(|c| apply(&mut file, c));
        // A wrong length in the header would hide everything behind it.
        if keep_length && file.len() > 20 {
            let length = file.len() as u32;
            file[8..12].copy_from_slice(&length.to_le_bytes());
        }
        if let Ok(record) = read_record_bytes(Path::new("a.glb"), &file) {
            let faces = record.model.faces.len() as u32;
            for paste in &record.lapped.pastes {
                prop_assert!(paste.faces.iter().all(|&f| f < faces), "faces of pastes are in range");
                prop_assert!(usize::from(paste.patch) < record.lapped.patches.len(), "patches are in range");
            }
        }
        read("a.glb", &file);
    }

    #[test]
    fn changed_images_are_no_trouble(changes in proptest::collection::vec(change(), 1..5), kind in 0..8_usize) {
        let ending = ["png", "jpg", "exr", "hdr", "webp", "tga", "bmp", "tiff"][kind];
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(format!("a.{ending}"));
        let image = image::RgbImage::from_fn(9, 7, |x, y| image::Rgb([(x * 20) as u8, (y * 20) as u8, 7]));
        let image = image::DynamicImage::from(image);
        let image = if kind == 2 || kind == 3 { image.into_rgb32f().into() } else { image };
        image.save(&path).unwrap();
        let mut file = std::fs::read(&path).unwrap();
        changes.iter().for_each(|c| apply(&mut file, c));
        std::fs::write(&path, &file).unwrap();
        if let Ok((exemplar, _)) = read_exemplar(&path, &ExemplarOptions::default()) {
            prop_assert!(exemplar.size()[0] > 0 && exemplar.size()[1] > 0, "an exemplar has pixels");
        }
    }
}
