//! Models that move: read as glTF means them, kept by records, and refused with words where they are broken.

#![allow(clippy::unwrap_used, clippy::panic, reason = "helpers of tests may fail as tests do")]

use crate::common::{input, through_file};
use crate::glb::{Gltf, bending, bent, bulged, bulging, carried};
use glam::{DVec3, Vec3};
use lapped::format::motion::Property;
use lapped::format::{Model, read_model_bytes, write_record};
use lapped::job::{Bound, Moving, PasteJob, Scale, paste_model};
use lapped::mesh::{CleanOptions, clean};
use lapped::progress::Silent;
use serde_json::{Value, json};
use std::path::Path;

fn read(bytes: &[u8]) -> Model {
    read_model_bytes(Path::new("a.glb"), bytes).unwrap()
}

/// The model's vertices at a moment of its first animation.
fn at(model: &Model, time: f64) -> Vec<Vec3> {
    model.motion.as_ref().unwrap().positions(&model.positions, Some(0), time).unwrap()
}

fn farthest(found: &[Vec3], expected: impl Iterator<Item = DVec3>) -> f64 {
    found.iter().zip(expected).map(|(a, b)| a.as_dvec3().distance(b)).fold(0.0, f64::max)
}

const MOMENTS: [f64; 8] = [0.0, 0.25, 0.5, 0.9, 1.0, 1.3, 2.0, 7.0];

#[test]
fn gltf_skins_carry_vertices_as_their_joints_go() {
    let (gltf, rest) = bending(12, 20);
    let model = read(&gltf.glb(rest));
    let (straight, _) = crate::glb::tail(12, 20);
    let far = farthest(&model.positions, straight.iter().map(|p| p.as_dvec3()));
    assert!(far < 1e-6, "at rest it stands upright where its joints are, not where its node is: {far}");
    for time in MOMENTS {
        let found = at(&model, time);
        let far = farthest(&found, straight.iter().map(|p| bent(p.as_dvec3(), time)));
        assert!(far < 1e-5, "{time} s: {far} from where linear blending takes it");
    }
    assert!(at(&model, 1.0).iter().any(|p| p.x > 1.5), "the tip goes far");
}

#[test]
fn gltf_morph_targets_and_nodes_move_vertices() {
    let (gltf, rest) = bulging(12, 20);
    let model = read(&gltf.glb(rest));
    let motion = model.motion.as_ref().unwrap();
    assert_eq!(motion.targets[0].name, "fat", "targets keep their names");
    assert_eq!((motion.find("swallow"), motion.find("0")), (Ok(0), Ok(0)), "by name and by number");
    assert!(motion.find("walk").unwrap_err().to_string().contains("swallow"), "and told by name where there is no such");
    assert_eq!(motion.animations[0].duration(), 2.0, "two seconds");
    for time in MOMENTS {
        let far = farthest(&at(&model, time), model.positions.iter().map(|p| bulged(p.as_dvec3(), time)));
        assert!(far < 1e-5, "{time} s: {far}");
    }
}

/// Two nodes with the same triangle and morph targets, keyed at different times; the second hangs on the first.
fn two_parts() -> (Gltf, Value) {
    let mut gltf = Gltf::default();
    let p = gltf.positions(&[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
    let up = gltf.positions(&[[0.0, 0.0, 1.0]; 3]);
    let input = gltf.floats(&[[0.0], [2.0]], "SCALAR");
    let later = gltf.floats(&[[1.0], [2.0]], "SCALAR");
    let weights = gltf.floats(&[[0.0], [1.0]], "SCALAR");
    let way = gltf.positions(&[[0.0; 3], [0.0, 6.0, 0.0]]);
    let rest = json!({
        "nodes": [{ "mesh": 0, "children": [1] }, { "mesh": 0, "translation": [1, 0, 0], "weights": [0.25] }],
        "meshes": [{ "primitives": [{ "attributes": { "POSITION": p }, "targets": [{ "POSITION": up }] }] }],
        "animations": [
            { "channels": [
                { "sampler": 0, "target": { "node": 0, "path": "weights" } },
                { "sampler": 1, "target": { "node": 1, "path": "weights" } },
                { "sampler": 2, "target": { "node": 0, "path": "translation" } },
                { "sampler": 2, "target": { "path": "translation" } },
            ], "samplers": [
                { "input": input, "output": weights }, { "input": later, "output": weights }, { "input": input, "output": way },
            ] },
            { "channels": [{ "sampler": 0, "target": { "node": 0, "path": "weights" } }],
              "samplers": [{ "input": input, "output": weights }] },
        ],
    });
    (gltf, rest)
}

#[test]
fn gltf_parts_of_a_scene_move_each_in_its_own_way() {
    let (gltf, rest) = two_parts();
    let model = read(&gltf.glb(rest));
    let found = at(&model, 1.5);
    assert_eq!(found[0], Vec3::new(0.0, 4.5, 0.75), "the first goes its way, three quarters morphed");
    assert_eq!(found[3], Vec3::new(1.0, 4.5, 0.5), "what hangs on it goes along, half morphed, by keys of its own");
    let motion = model.motion.as_ref().unwrap();
    let second = motion.positions(&model.positions, Some(1), 2.0).unwrap();
    assert_eq!((second[0].z, second[3].z), (1.0, 0.25), "weights that nothing changes stay");
    assert!(motion.animations[0].channels.iter().filter(|c| c.of == Property::Weights).count() == 1, "one track of weights");
    // Both triangles touch in one point, which welding makes one vertex; they move apart all the same.
    let cleaned = clean(&model.positions, &model.faces, &CleanOptions::default()).unwrap();
    let moving = Moving::new(&model, &cleaned).unwrap().unwrap();
    let mesh = moving.at(Some(0), 1.5).unwrap();
    for (face, corners) in mesh.faces.iter().enumerate() {
        let there = corners.map(|v| mesh.positions[v as usize]);
        assert_eq!(there, model.faces[face].map(|v| found[v as usize]), "face {face} is where its own vertices are");
    }
}

#[test]
fn records_move_as_the_model_did_and_every_tool_can_play_them() {
    for (k, (gltf, rest)) in [bending(10, 12), bulging(10, 12)].into_iter().enumerate() {
        let model = read(&gltf.glb(rest));
        // Large texture patches on large faces: some are cut, and new vertices must move along.
        let job = PasteJob { scale: Scale::Ratio(60.0), ..PasteJob::default() };
        let pasted = paste_model(&model, vec![input("scales", &[])], &job, &Silent).unwrap();
        let record = through_file(&pasted.record);
        let cut = record.model.positions.len() > model.positions.len();
        assert!(k == 1 || cut, "some faces were cut");
        assert_eq!(through_file(&record), record, "written again it stays as it is");
        let source = record.source_face.clone().unwrap_or_else(|| (0..model.faces.len() as u32).collect());
        for time in MOMENTS {
            let (before, after) = (at(&model, time), at(&record.model, time));
            let far = farthest(&after, before.iter().map(|p| p.as_dvec3()));
            assert!(far < 1e-5, "the model's own vertices at {time} s: {far}");
            // New vertices lie on the face that they were cut from, at the same place.
            for (face, &from) in record.model.faces.iter().zip(&source) {
                let [a, b, c] = model.faces[from as usize].map(|v| model.positions[v as usize].as_dvec3());
                let [a1, b1, c1] = model.faces[from as usize].map(|v| before[v as usize].as_dvec3());
                for &v in face {
                    let p = record.model.positions[v as usize].as_dvec3();
                    let n = (b - a).cross(c - a);
                    let (u, w) =
                        ((p - a).cross(c - a).dot(n) / n.length_squared(), (b - a).cross(p - a).dot(n) / n.length_squared());
                    let expected = a1 + (b1 - a1) * u + (c1 - a1) * w;
                    let far = after[v as usize].as_dvec3().distance(expected);
                    // Linear blending along a face is a little off the flat face where weights change along it.
                    assert!(far < 0.04, "vertex {v} is {far} off its face at {time} s");
                }
            }
        }
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("record.glb");
        write_record(&path, &pasted.record).unwrap();
        let (document, buffers, _) = gltf::import(&path).unwrap();
        assert_eq!(document.animations().count(), 1, "the other reader finds the animation");
        let skin = document.skins().next().unwrap();
        assert_eq!(skin.joints().count(), [2, 1][k], "the skin");
        let mesh = document.meshes().next().unwrap();
        assert_eq!(mesh.primitives().next().unwrap().morph_targets().count(), k, "and the morph targets");
        let channel = document.animations().next().unwrap().channels().count();
        assert_eq!(channel, [1, 2][k], "channels");
        let reader = skin.reader(|b| buffers.get(b.index()).map(|d| &d.0[..]));
        assert_eq!(reader.read_inverse_bind_matrices().unwrap().count(), [2, 1][k], "with their matrices");
    }
}

#[test]
fn the_texture_stays_in_place_on_a_model_that_moves() {
    use lapped::mesh::SurfacePoint;
    use lapped::paste::Composite;
    use lapped::surface::SurfaceTexture;
    let (gltf, rest) = bending(10, 12);
    let pasted = paste_model(&read(&gltf.glb(rest)), vec![input("scales", &[])], &PasteJob::default(), &Silent).unwrap();
    let bound = Bound::new(through_file(&pasted.record)).unwrap();
    let moving = bound.moving.as_ref().unwrap();
    let (still, moved) = (moving.at(Some(0), 0.0).unwrap(), moving.at(Some(0), 1.0).unwrap());
    assert_eq!(moved.faces.len(), bound.mesh.faces.len(), "the same faces");
    let [before, after] = [&still, &moved].map(|mesh| Composite::new(mesh, &bound.lapped));
    let (mut bare, mut gone) = (0, 0.0_f64);
    for face in 0..moved.face_count() as u32 {
        for bary in [Vec3::splat(1.0 / 3.0), Vec3::new(0.8, 0.1, 0.1), Vec3::new(0.05, 0.05, 0.9)] {
            let point = SurfacePoint { face, bary };
            let [one, other] = [&before, &after].map(|c| c.texel(point, 0.0));
            assert_eq!((one.base_color, one.height, one.alpha), (other.base_color, other.height, other.alpha), "{point:?}");
            bare += usize::from(one.alpha < 1.0);
            gone = gone.max(still.position(point).distance(moved.position(point)));
        }
    }
    assert_eq!(bare, 0, "and it is covered");
    assert!(gone > 2.0, "though it moves: {gone}");
}

#[test]
fn gltf_motions_that_are_broken_say_where() {
    let sound = bending(5, 4);
    let set = |pointer: &str, value: Value| {
        let mut rest = sound.1.clone();
        *rest.pointer_mut(pointer).unwrap_or_else(|| panic!("{pointer} is in the document")) = value;
        sound.0.glb(rest)
    };
    let count = sound.0.accessors.len();
    let with = |make: &dyn Fn(&mut Gltf) -> (usize, &'static str)| {
        let mut gltf = Gltf { bin: sound.0.bin.clone(), views: sound.0.views.clone(), accessors: sound.0.accessors.clone() };
        let (accessor, pointer) = make(&mut gltf);
        let mut rest = sound.1.clone();
        *rest.pointer_mut(pointer).unwrap() = accessor.into();
        gltf.glb(rest)
    };
    let (input, output) = ("/animations/0/samplers/0/input", "/animations/0/samplers/0/output");
    let (joints, weights) = ("/meshes/0/primitives/0/attributes/JOINTS_0", "/meshes/0/primitives/0/attributes/WEIGHTS_0");
    let matrices = "/skins/0/inverseBindMatrices";
    let broken: Vec<(&str, Vec<u8>, &str)> = vec![
        ("a channel without its node", set("/animations/0/channels/0/target/node", json!(9)), "animation 0, channel 0"),
        ("a channel without its sampler", set("/animations/0/channels/0/sampler", json!(4)), "sampler 4"),
        ("an unknown interpolation", set("/animations/0/samplers/0/interpolation", json!("MAGIC")), "MAGIC"),
        ("too few keys for a cubic", set("/animations/0/samplers/0/interpolation", json!("CUBICSPLINE")), "animation 0, channel 0"),
        ("an accessor that is not there", set(output, json!(count)), "no such accessor"),
        ("numbers of another kind", set(output, json!(0)), "accessor 0"),
        ("a skin that is not there", set("/nodes/0/skin", json!(3)), "skin 3"),
        ("a joint that is not there", set("/skins/0/joints", json!([1, 77])), "77"),
        ("no joints", set("/skins/0/joints", json!([])), "skin 0"),
        ("a joint that the skin lacks", set("/skins/0/joints", json!([1])), "names joint 1"),
        ("too few matrices", set("/skins/0/joints", json!([1, 2, 0])), "2 inverse bind matrices"),
        ("a joint above itself", set("/nodes/1/children", json!([1])), "own ancestor"),
        ("times that are not numbers", with(&|g| (g.floats(&[[0.0], [f32::NAN], [2.0]], "SCALAR"), input)), "times"),
        ("times that fall", with(&|g| (g.floats(&[[0.0], [2.0], [1.0]], "SCALAR"), input)), "times"),
        ("no times", with(&|g| (g.floats::<1>(&[], "SCALAR"), input)), "keys"),
        ("too few times", with(&|g| (g.floats(&[[0.0], [2.0]], "SCALAR"), input)), "need 8 numbers"),
        ("a turn that is no number", with(&|g| (g.floats(&[[f32::INFINITY; 4]; 3], "VEC4"), output)), "not a number"),
        ("weights for other vertices", with(&|g| (g.floats(&[[1.0, 0.0, 0.0, 0.0]; 3], "VEC4"), weights)), "positions"),
        ("weights below 0", with(&|g| (g.floats(&[[-1.0; 4]; 25], "VEC4"), weights)), "negative"),
        ("joints that are fractions", with(&|g| (g.floats(&[[0.5; 4]; 25], "VEC4"), joints)), "cannot hold indices"),
        ("a matrix that is no number", with(&|g| (g.floats(&[[f32::NAN; 16]; 2], "MAT4"), matrices)), "inverse bind matrix"),
    ];
    assert!(read_model_bytes(Path::new("a.glb"), &sound.0.glb(sound.1.clone())).is_ok(), "it is sound otherwise");
    for (what, file, word) in broken {
        let message = match read_model_bytes(Path::new("a.glb"), &file) {
            Ok(_) => panic!("{what} is let through"),
            Err(error) => error.to_string(),
        };
        assert!(message.contains(word) && message.starts_with("a.glb"), "{what}: {message}");
    }
    let morphing = bulging(5, 4);
    let set = |pointer: &str, value: Value| {
        let mut rest = morphing.1.clone();
        *rest.pointer_mut(pointer).unwrap() = value;
        read_model_bytes(Path::new("a.glb"), &morphing.0.glb(rest)).map(|_| ()).map_err(|e| e.to_string())
    };
    for (pointer, value) in [
        ("/meshes/0/primitives/0/targets/0/POSITION", json!(2)),
        ("/meshes/0/primitives/0/targets/0/POSITION", json!("x")),
        ("/meshes/0/primitives/0/targets", json!([{ "POSITION": 1 }, { "POSITION": 1 }])),
        ("/animations/0/samplers/0/output", json!(3)),
    ] {
        assert!(set(pointer, value.clone()).is_err(), "{pointer} = {value} is told");
    }
    // Numbers may be sound and the pose not.
    let mut model = read(&sound.0.glb(sound.1));
    let motion = model.motion.as_mut().unwrap();
    motion.animations[0].channels[0].of = Property::Scale(0);
    motion.animations[0].channels[0].track.times.truncate(1);
    motion.animations[0].channels[0].track.values = vec![f32::MAX; 3];
    assert!(motion.positions(&model.positions, Some(0), 0.0).is_err(), "beyond what numbers hold");
    assert!(motion.positions(&model.positions[1..], Some(0), 0.0).is_err(), "another model's vertices");
    assert!(motion.positions(&model.positions, Some(5), 0.0).is_err(), "no such animation");
    assert!(carried(DVec3::Y) == 0.0, "the base stays");
}
