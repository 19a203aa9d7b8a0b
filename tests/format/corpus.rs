//! Every mesh of the corpus reads with the counts that another program found in it. The folder comes from
//! `LAPPED_CORPUS`; without it there is nothing to test.

#![allow(clippy::unwrap_used, clippy::panic, reason = "helpers of tests may fail as tests do")]

use glam::{Vec2, Vec3};
use lapped::format::{ExemplarOptions, read_model};
use lapped::mesh::{CleanOptions, clean};
use std::path::{Path, PathBuf};

/// File, vertices, polygons and triangles as counted by the corpus's own index, which gives of suzanne.obj only the number of
/// quads (468); 32 triangles come on top.
const COUNTS: [(&str, usize, usize, usize); 24] = [
    ("stanford-bunny.obj", 35947, 69451, 69451),
    ("bunny-npm.obj", 1839, 3674, 3674),
    ("horse.ply", 48485, 96966, 96966),
    ("cat.obj", 7949, 15894, 15894),
    ("dino.obj", 3916, 7828, 7828),
    ("teapot.obj", 3644, 6320, 6320),
    ("torus.obj", 2304, 4608, 4608),
    ("sphere.obj", 642, 1280, 1280),
    ("knot.obj", 3200, 6400, 6400),
    ("fandisk.obj", 6475, 12946, 12946),
    ("rocker-arm.obj", 10044, 20088, 20088),
    ("mechpart.obj", 7612, 15232, 15232),
    ("armadillo.obj", 43243, 86482, 86482),
    ("dragon.ply", 437_645, 871_414, 871_414),
    ("dragon-res4.ply", 5205, 11102, 11102),
    ("spot.obj", 2930, 5856, 5856),
    ("cow.obj", 2903, 5804, 5804),
    ("mannequin.obj", 12977, 25888, 25888),
    ("nefertiti.obj", 35002, 70000, 70000),
    ("ogre.obj", 62194, 124_008, 124_008),
    ("blade.obj", 8231, 16222, 16222),
    ("range-scan.ply", 44461, 86766, 86766),
    ("suzanne.obj", 507, 500, 968),
    ("duck.glb", 2399, 4212, 4212),
];

#[test]
fn every_mesh_has_the_counts_of_the_index() {
    let Some(folder) = meshes() else { return };
    for (name, vertices, polygons, faces) in COUNTS {
        let model = read_model(&folder.join(name)).unwrap();
        assert_eq!(model.source.vertices, vertices, "{name}: vertices of the file");
        assert_eq!(model.source.polygons, polygons, "{name}: polygons of the file");
        assert_eq!(model.faces.len(), faces, "{name}: triangles");
        assert!(model.positions.len() >= vertices, "{name}: no vertex is lost");
        assert_eq!(model.polygons.is_some(), polygons != faces, "{name}: polygons are told exactly if some are no triangles");
        assert_eq!(model.source.notes, Vec::<String>::new(), "{name}: nothing needs mending");
        let report = clean(&model.positions, &model.faces, &CleanOptions::default()).unwrap().report;
        assert_eq!(report.faces_in, faces, "{name}: cleaning takes every face");
    }
}

/// The corpus folder of meshes, if there is one.
fn meshes() -> Option<PathBuf> {
    crate::folder::corpus().map(|corpus| corpus.join("meshes"))
}

/// Corner positions of all triangles: what two readers must agree on, however they number vertices.
fn corners(positions: &[[f32; 3]], faces: impl IntoIterator<Item = u32>) -> Vec<[f32; 3]> {
    faces.into_iter().map(|v| positions[v as usize]).collect()
}

fn ours(path: &Path) -> Vec<[f32; 3]> {
    let model = read_model(path).unwrap();
    let positions: Vec<[f32; 3]> = model.positions.iter().map(Vec3::to_array).collect();
    corners(&positions, model.faces.into_flattened())
}

#[test]
fn obj_files_hold_what_a_reader_of_two_statements_sees() {
    let Some(folder) = meshes() else { return };
    for (name, ..) in COUNTS.iter().filter(|c| c.0.ends_with(".obj")) {
        let path = folder.join(name);
        let text = std::fs::read_to_string(&path).unwrap();
        let (mut positions, mut faces) = (Vec::new(), Vec::new());
        for line in text.lines() {
            let mut words = line.split_ascii_whitespace();
            match words.next() {
                Some("v") => positions.push([0; 3].map(|_| words.next().unwrap().parse::<f32>().unwrap())),
                Some("f") => {
                    let corners: Vec<u32> = words.map(|w| w.split('/').next().unwrap().parse::<u32>().unwrap() - 1).collect();
                    // A fan: the corpus has convex polygons only.
                    faces.extend((2..corners.len()).flat_map(|k| [corners[0], corners[k - 1], corners[k]]));
                }
                _ => {}
            }
        }
        let model = read_model(&path).unwrap();
        let file_order: Vec<[f32; 3]> = model.positions[..positions.len()].iter().map(Vec3::to_array).collect();
        assert!(file_order == positions, "{name}: vertices in the file's order, used or not");
        let different = ours(&path).chunks(3).zip(corners(&positions, faces.clone()).chunks(3)).filter(|(a, b)| a != b).count();
        assert_eq!(model.faces.len() * 3, faces.len(), "{name}: corners");
        assert_eq!(different, 0, "{name}: triangles that differ");
    }
}

#[test]
fn ply_files_hold_what_another_reader_sees() {
    use ply_rs_bw::ply::Property;
    let Some(folder) = meshes() else { return };
    for name in ["horse.ply", "dragon-res4.ply", "range-scan.ply"] {
        let path = folder.join(name);
        let mut file = std::io::BufReader::new(std::fs::File::open(&path).unwrap());
        let ply = ply_rs_bw::parser::Parser::<ply_rs_bw::ply::DefaultElement>::new().read_ply(&mut file).unwrap();
        let number = |p: &Property| match *p {
            Property::Float(f) => f,
            _ => panic!("{name}: coordinates are floats"),
        };
        let positions: Vec<[f32; 3]> = ply.payload["vertex"].iter().map(|v| ["x", "y", "z"].map(|c| number(&v[c]))).collect();
        let indices = ply.payload["face"].iter().flat_map(|f| match f.get("vertex_indices").or(f.get("vertex_index")) {
            Some(Property::ListInt(list)) => list.iter().map(|&i| i as u32).collect::<Vec<_>>(),
            Some(Property::ListUInt(list)) => list.clone(),
            other => panic!("{name}: indices are integers, not {other:?}"),
        });
        assert_eq!(ours(&path), corners(&positions, indices), "{name}: all triangles");
    }
}

#[test]
fn the_duck_holds_what_another_reader_sees() {
    let Some(folder) = meshes() else { return };
    let path = folder.join("duck.glb");
    let (document, buffers, _) = gltf::import(&path).unwrap();
    let node = document.nodes().find(|n| n.mesh().is_some()).unwrap();
    let primitive = node.mesh().unwrap().primitives().next().unwrap();
    let reader = primitive.reader(|b| Some(&buffers[b.index()].0));
    let positions: Vec<[f32; 3]> = reader.read_positions().unwrap().collect();
    let theirs = corners(&positions, reader.read_indices().unwrap().into_u32());
    let uvs: Vec<[f32; 2]> = reader.read_tex_coords(0).unwrap().into_f32().collect();
    let model = read_model(&path).unwrap();
    // The duck's parent shrinks it by a hundred.
    let scale = ours(&path)[0][0] / theirs[0][0];
    assert!((scale - 0.01).abs() < 1e-6, "scale of the scene: {scale}");
    for (a, b) in ours(&path).iter().zip(&theirs) {
        let worst = a.iter().zip(b).map(|(a, b)| (a - b * scale).abs()).fold(0.0, f32::max);
        assert!(worst < 1e-5, "{a:?} is {b:?} shrunk");
    }
    let found: Vec<[f32; 2]> = model.uvs.unwrap().iter().map(Vec2::to_array).collect();
    assert_eq!(found, uvs, "texture coordinates");
}

#[test]
fn material_sets_are_found_and_their_heights_turned_outward() {
    let Some(corpus) = crate::folder::corpus() else { return };
    let folder = corpus.join("textures");
    // As the index says, bright is deep in bricks, stone wall and cheese. It is in wool too: both slopes of its height map
    // run against those of its normal map (correlations -0.35 and -0.42).
    for (set, channels, turned) in [
        ("bricks-pbr", 3, true),
        ("stonewall-pbr", 3, true),
        ("cheese", 3, true),
        ("wool", 3, true),
        ("bark", 3, false),
        ("cliff", 3, false),
        ("tartan", 2, false),
        ("brushed-metal", 2, false),
    ] {
        let (exemplar, warnings) = lapped::format::read_exemplar(&folder.join(set), &ExemplarOptions::default()).unwrap();
        assert_eq!(exemplar.channels().iter().count(), channels, "{set}: channels");
        assert_eq!(warnings.iter().any(|w| w.text.contains("turned over")), turned, "{set}: {warnings:?}");
    }
}
