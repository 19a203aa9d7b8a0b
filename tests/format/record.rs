//! Lapped-texture records: what is written comes back, and nothing that contradicts itself is taken.

#![allow(clippy::unwrap_used, clippy::panic, reason = "helpers of tests may fail as tests do")]

use glam::{Vec2, Vec3, Vec4};
use lapped::exemplar::{Channel, Exemplar, FramesBy, Hull, Image, MipChain, TexturePatch, Wrap};
use lapped::format::{FaceGroup, Model, Record, read_model, read_record, write_record};
use lapped::paste::cut::CUT_STEPS;
use lapped::paste::{Cut, LappedTexture, Layer, Paste, TURNS, Turn};
use lapped::random::Random;

/// A cut of random distances.
fn cut(random: &mut Random) -> Box<Cut> {
    let steps: Vec<[f32; 2]> = (0..CUT_STEPS).map(|_| [random.range(0.2, 1.1) as f32, random.range(0.01, 0.3) as f32]).collect();
    Box::new(Cut::new(|way| Some(steps[way])))
}

fn bytes_image(width: u32, height: u32, components: usize, random: &mut Random, decode: impl Fn(f32) -> f32) -> Image {
    let data = (0..width * height * components as u32).map(|_| decode(random.below(256) as f32 / 255.0)).collect();
    Image::new(width, height, components, data).unwrap()
}

/// A record with one of everything that a record can hold.
fn full_record() -> Record {
    let mut r = Random::new(7, 0);
    let side = 20_u32;
    let mut model = Model { name: "a hill".into(), ..Model::default() };
    for k in 0..side * side {
        let (x, y) = ((k % side) as f32, (k / side) as f32);
        model.positions.push(Vec3::new(x, (x * 0.7).sin() * (y * 0.3).cos(), y) * 0.1);
    }
    for k in 0..(side - 1) * (side - 1) {
        let v = k % (side - 1) + k / (side - 1) * side;
        model.faces.extend([[v, v + side, v + 1], [v + 1, v + side, v + side + 1]]);
    }
    let vertices = model.positions.len();
    let faces = model.faces.len();
    model.normals = Some((0..vertices).map(|k| Vec3::new(0.1, 1.0, k as f32 * 0.001).normalize()).collect());
    model.uvs = Some((0..vertices).map(|k| Vec2::new(k as f32 * 0.01, 0.25)).collect());
    model.colors = Some((0..vertices).map(|k| Vec4::new(k as f32 / vertices as f32, 0.5, 0.25, 1.0)).collect());
    model.polygons = Some((0..faces as u32).map(|f| f / 2).collect());
    let group =
        |object: &str, start, count| FaceGroup { object: object.into(), group: "g".into(), material: "m".into(), start, count };
    model.groups = vec![group("left", 0, 100), group("right", 100, faces as u32 - 100)];
    model.source.format = "Wavefront OBJ".into();
    model.source.vertices = vertices;
    model.source.polygons = faces / 2;
    model.source.unit = Some("mm".into());
    model.source.notes = vec!["3 lines and points were left out".into()];

    let mut first = Exemplar::new("bricks", bytes_image(33, 17, 3, &mut r, lapped::exemplar::srgb::decode));
    first.wrap = Wrap::Repeat;
    for channel in Channel::ALL {
        let decode = |v: f32| match channel {
            Channel::Emissive | Channel::BaseColor => lapped::exemplar::srgb::decode(v),
            Channel::Normal => v * 2.0 - 1.0,
            _ => v,
        };
        first.set(channel, bytes_image(33, 17, channel.components(), &mut r, decode)).unwrap();
    }
    let deep = (0..64).map(|_| r.below(65536) as f32 / 65535.0).collect();
    let mut second = Exemplar::new("grey", bytes_image(8, 8, 3, &mut r, lapped::exemplar::srgb::decode));
    second.set(Channel::Height, Image::new(8, 8, 1, deep).unwrap()).unwrap();

    // Three frames, the second with another height.
    let (mut next, mut last) = (second.clone(), second.clone());
    let other = (0..64).map(|_| r.below(65536) as f32 / 65535.0).collect();
    next.set(Channel::Height, Image::new(8, 8, 1, other).unwrap()).unwrap();
    last.set(Channel::BaseColor, bytes_image(8, 8, 3, &mut r, lapped::exemplar::srgb::decode)).unwrap();
    second.set_frames(FramesBy::Time, vec![next, last], vec![0.1, 0.25, 1.0 / 3.0]).unwrap();

    let patch = |exemplar, random: &mut Random| TexturePatch {
        exemplar,
        origin: [-3, 4],
        mask: MipChain::mask(bytes_image(9, 12, 1, random, |v| v)),
        hull: Hull::new(vec![Vec2::new(0.1, 0.2), Vec2::new(7.3, 1.0 / 3.0), Vec2::new(5.0, 9.87654)]),
        centre: Vec2::new(3.3, 4.7),
        weight: 0.7,
        slides: exemplar == 0,
    };
    let patches = vec![patch(0, &mut r), patch(1, &mut r), patch(0, &mut r)];
    let pastes: Vec<Paste> = (0..40)
        .map(|k| {
            let count = if k == 5 { 0 } else { 1 + r.below(50) as usize };
            let on = (0..count).map(|_| r.below(faces as u64) as u32).collect();
            let mut uv = || Vec2::new(r.range(-0.5, 1.5) as f32, r.unit() as f32);
            let uv = (0..count).map(|_| [uv(), uv(), uv()]).collect();
            let cut = (k % 2 == 0).then(|| cut(&mut r));
            Paste {
                patch: r.below(3) as u16,
                faces: on,
                uv,
                offset: Vec2::new(k as f32, -0.5),
                turn: Turn::new(r.below(u64::from(TURNS)) as u32),
                cut,
                agreement: r.below(256) as u8,
            }
        })
        .collect();
    let upper =
        Layer { name: "upper".into(), pastes: pastes.len() as u32 - 1, weights: vec![[0.25, 1.0, 0.0]; faces], ..Layer::default() };
    let base = (0..faces as u16).map(|f| [[f, 1, 2], [3, u16::MAX, 5], [6, 7, 8]]).collect();
    let layers = vec![Layer { name: "lower".into(), pastes: 1, base, ..Layer::default() }, upper];
    Record {
        field: Some((0..faces).map(|f| Vec3::new(0.3, f as f32, -1.0)).collect()),
        source_face: Some((0..faces as u32).map(|f| f / 4).collect()),
        model,
        lapped: LappedTexture { exemplars: vec![first, second], patches, layers, pastes },
        generator: "lapped test".into(),
        job: serde_json::json!({ "seed": 1, "scale": 0.25 }),
        look: None,
    }
}

#[test]
fn a_record_comes_back_equal() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("record.glb");
    let record = full_record();
    write_record(&path, &record).unwrap();
    let back = read_record(&path).unwrap();
    assert_eq!(back.model, record.model, "model");
    assert_eq!(back.lapped.layers, record.lapped.layers, "layers and weights, bit for bit");
    assert_eq!(back.lapped.exemplars, record.lapped.exemplars, "exemplars, bit for bit");
    assert_eq!(back.lapped.patches, record.lapped.patches, "patches and masks, bit for bit");
    assert_eq!(back, record, "everything else");
    if let Some(keep) = std::env::var_os("LAPPED_KEEP_RECORD") {
        std::fs::copy(&path, keep).unwrap();
    }
}

#[test]
fn any_gltf_reader_sees_the_plain_mesh() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("record.glb");
    let record = full_record();
    write_record(&path, &record).unwrap();
    let plain = read_model(&path).unwrap();
    assert_eq!((&plain.positions, &plain.faces), (&record.model.positions, &record.model.faces), "our own reader");

    let (document, buffers, images) = gltf::import(&path).unwrap();
    let primitive = document.meshes().next().unwrap().primitives().next().unwrap();
    let reader = primitive.reader(|b| Some(&buffers[b.index()].0));
    let positions: Vec<Vec3> = reader.read_positions().unwrap().map(Vec3::from_array).collect();
    let indices: Vec<u32> = reader.read_indices().unwrap().into_u32().collect();
    assert_eq!(positions, record.model.positions, "positions seen by another reader");
    assert_eq!(indices, record.model.faces.as_flattened(), "faces seen by another reader");
    assert_eq!(
        images.len(),
        8 + 2 + 3 + 2,
        "all channels, masks, and what later frames do not share with the first are ordinary images"
    );
}

/// A record's file with its second exemplar's frames changed.
fn with_frames(file: &[u8], change: impl Fn(&mut serde_json::Value)) -> Vec<u8> {
    let length = u32::from_le_bytes(file[12..16].try_into().unwrap()) as usize;
    let mut document: serde_json::Value = serde_json::from_slice(&file[20..20 + length]).unwrap();
    let extensions = document["extensions"].as_object_mut().unwrap();
    let record = extensions.values_mut().find(|e| e.get("pastes").is_some()).unwrap();
    change(&mut record["exemplars"][1]["frames"]);
    let mut json = document.to_string().into_bytes();
    json.resize(json.len().next_multiple_of(4), b' ');
    let rest = &file[20 + length..];
    let mut out = file[..8].to_vec();
    out.extend((20 + json.len() as u32 + rest.len() as u32).to_le_bytes());
    out.extend((json.len() as u32).to_le_bytes());
    out.extend(b"JSON");
    out.extend(json);
    out.extend(rest);
    out
}

#[test]
fn frames_that_contradict_their_record_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("record.glb");
    write_record(&path, &full_record()).unwrap();
    let file = std::fs::read(&path).unwrap();
    std::fs::write(&path, with_frames(&file, |_| {})).unwrap();
    assert_eq!(read_record(&path).unwrap().lapped.exemplars[1].frames().unwrap().count(), 3, "unchanged it is read");
    let refused = |change: &dyn Fn(&mut serde_json::Value), words: &str| {
        std::fs::write(&path, with_frames(&file, change)).unwrap();
        let error = read_record(&path).unwrap_err().to_string();
        assert!(error.contains(words) && error.contains("record.glb"), "{words:?}: {error}");
    };
    refused(&|f| f["seconds"][1] = 0.into(), "frame 2 is shown for 0 seconds");
    refused(&|f| f["seconds"][1] = (-1.5).into(), "frame 2 is shown for -1.5 seconds");
    refused(&|f| f["seconds"] = serde_json::json!([1e308, 1e308, 1e308]), "without end");
    refused(&|f| f["seconds"] = serde_json::json!([1.0]), "durations for 1 frames, not for 3");
    refused(&|f| f["by"] = "view".into(), "durations for 3 frames, not for 0");
    refused(&|f| f["by"] = "moon".into(), "moon");
    refused(&|f| f["images"] = serde_json::json!([]), "only one frame");
    refused(&|f| f["images"][0]["baseColor"] = 100_000.into(), "texture 100000 has no image");
    refused(&|f| f["images"][0]["roughness"] = f["images"][0]["height"].clone(), "roughness");
    // The same small image over and over: what it decodes to has bounds too.
    let crowd = |f: &mut serde_json::Value| f["images"] = vec![f["images"][0].clone(); (1 << 20) + 1].into();
    refused(&crowd, "1048578 frames of 8 x 8");
}

#[test]
fn frames_by_time_view_and_light_come_back() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("record.glb");
    for by in [FramesBy::Time, FramesBy::View, FramesBy::Light] {
        let mut record = full_record();
        let exemplar = &mut record.lapped.exemplars[1];
        let frames = exemplar.frames().unwrap().clone();
        let seconds = if by == FramesBy::Time { frames.seconds().to_vec() } else { Vec::new() };
        exemplar.set_frames(by, frames.others().to_vec(), seconds).unwrap();
        write_record(&path, &record).unwrap();
        assert_eq!(read_record(&path).unwrap().lapped.exemplars, record.lapped.exemplars, "{by:?}");
    }
}
