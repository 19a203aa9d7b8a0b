//! The files that come out: read by other readers than ours, held against what went in.

#![allow(clippy::unwrap_used, reason = "a test may fail by panicking")]

use crate::bake::{Smooth, pasted, points};
use crate::charts::charts_in;
use crate::checker::{Shown, overlaps, same_geometry};
use glam::Vec3;
use lapped::atlas::UnwrapOptions;
use lapped::exemplar::Channel;
use lapped::format::export::{Export, Kind, write_look};
use lapped::format::{Model, Record, read_look, read_model, read_record, write_record};
use lapped::job::{BakeJob, BakedModel, bake_model};
use lapped::mesh::{CleanOptions, clean};
use lapped::paste::Composite;
use lapped::progress::Silent;
use lapped::surface::SurfaceTexture;
use std::path::Path;

fn job(size: u32, pages: u32) -> BakeJob {
    BakeJob { unwrap: UnwrapOptions { size, pages, ..UnwrapOptions::default() }, ..BakeJob::default() }
}

fn baked(model: &Model, channels: &[Channel], size: u32, pages: u32) -> BakedModel {
    let cleaned = clean(&model.positions, &model.faces, &CleanOptions::default()).unwrap();
    let texture = Smooth::new(&cleaned.mesh, channels);
    bake_model(model, &cleaned.mesh, &cleaned.user_faces, &texture, &job(size, pages), &Silent).unwrap()
}

fn write(path: &Path, made: &BakedModel) -> Vec<std::path::PathBuf> {
    let export = Export { model: &made.model, look: &made.look, generator: "test" };
    write_look(path, Kind::of(path).unwrap(), &export).unwrap()
}

#[test]
fn a_glb_passes_the_checker_down_to_the_gutters_of_its_mips() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["dragonling", "gear"] {
        let model = lapped::assets::mesh(name).unwrap();
        let path = folder.path().join("a.glb");
        let made = baked(&model, &[Channel::BaseColor], 1024, 1);
        write(&path, &made);
        let shown = Shown::read(&path);
        same_geometry(&shown, &model);
        assert!(shown.uv.iter().all(|p| (0.0..=1.0).contains(&p.x) && (0.0..=1.0).contains(&p.y)), "{name}: within the image");
        assert_eq!(overlaps(&shown, 4096), (0, 0), "{name}: no texel is owned twice");
        assert!(shown.opaque, "{name}: nothing shows through");
        assert_eq!(shown.size, 1024, "{name}");
        assert!(charts_in(&shown) >= made.report.charts, "{name}: vertices are split at chart borders");
        // Whatever is sampled on a chart is its own colour, at the finest level and at two below.
        let cleaned = clean(&model.positions, &model.faces, &CleanOptions::default()).unwrap();
        let texture = Smooth::new(&cleaned.mesh, &[Channel::BaseColor]);
        let levels = shown.levels(2);
        let (low, high) = cleaned.mesh.bounds();
        for (user, to) in cleaned.user_faces.iter().enumerate() {
            let [a, b, c] = shown.corners(user);
            for at in [Vec3::X, Vec3::new(0.5, 0.5, 0.0), Vec3::splat(1.0 / 3.0)] {
                let uv = a * at.x + b * at.y + c * at.z;
                let expected = texture.texel(lapped::job::bake::on_mesh(to, at), 0.0).base_color;
                for level in 0..levels.len() {
                    let apart = (shown.sample(&levels, level, uv) - expected).abs().max_element();
                    // The colour changes by 0.6 over the model, and a texel of the level has this share of it.
                    let texel = f64::from(1 << level) / made.report.density / f64::from((high - low).max_element());
                    let slack = (1.5 * texel) as f32 + 0.004;
                    assert!(apart < slack, "{name}: level {level}, face {user}: off by {apart}, {slack} allowed");
                }
            }
        }
    }
}

/// A face without area is no part of the clean mesh; its corners may lie in three charts.
#[test]
fn a_dropped_face_covers_no_chart() {
    let folder = tempfile::tempdir().unwrap();
    let mut model = lapped::assets::mesh("dragonling").unwrap();
    let (a, b) = (0, model.positions.len() as u32 / 2);
    // A vertex of its own in the middle of the line between two of the model's, and one of no other face.
    let middle = (model.positions[a as usize] + model.positions[b as usize]) * 0.5;
    model.positions.push(middle);
    model.normals = None;
    model.uvs = None;
    model.faces.push([a, b, model.positions.len() as u32 - 1]);
    model.faces.push([a, b, b]);
    let path = folder.path().join("a.glb");
    write(&path, &baked(&model, &[Channel::BaseColor], 512, 1));
    let shown = Shown::read(&path);
    for face in [model.faces.len() - 2, model.faces.len() - 1] {
        let [a, b, c] = shown.corners(face);
        assert!(a == b && b == c, "a face without area has one place in the image: {a} {b} {c}");
    }
    assert_eq!(overlaps(&shown, 4096), (0, 0), "no texel is owned twice");
}

#[test]
fn a_record_with_a_bake_is_still_the_record() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.glb");
    let (record, bound) = pasted("knot", "rust", 30.0);
    let texture = Composite::new(&bound.mesh, &bound.lapped);
    let made = bake_model(&record.model, &bound.mesh, &bound.user_faces, &texture, &job(512, 1), &Silent).unwrap();
    write_record(&path, &Record { model: made.model, look: Some(made.look), ..record.clone() }).unwrap();
    let found = read_record(&path).unwrap();
    assert_eq!(found.lapped.pastes, record.lapped.pastes, "the pastes are where they were");
    assert_eq!(found.model.uvs, record.model.uvs, "the user's coordinates are not the atlas's");
    assert_eq!(found.model.faces.len(), record.model.faces.len(), "face for face");
    let shown = Shown::read(&path);
    same_geometry(&shown, &record.model);
    assert_eq!(shown.own_uv.is_some(), record.model.uvs.is_some(), "a second set of coordinates only where the user had one");
    let (model, look) = read_look(&path).unwrap().unwrap();
    assert_eq!(model.faces.len(), record.model.faces.len(), "the look is of all faces");
    assert_eq!(look.pages.len(), 1, "one page");
    // Through the file, our own tools see the same pastes at every point.
    let again = lapped::job::Bound::new(found).unwrap();
    let other = Composite::new(&again.mesh, &again.lapped);
    assert_eq!(again.mesh.faces.len(), bound.mesh.faces.len(), "the same clean mesh");
    for at in points(&bound.mesh, 2000) {
        let apart = (texture.texel(at, 0.0).base_color - other.texel(at, 0.0).base_color).abs().max_element();
        assert!(apart < 0.01, "the same texture, off by {apart} (images are stored in 8 bits)");
    }
}

#[test]
fn gltf_obj_and_ply_hold_the_same_model() {
    let folder = tempfile::tempdir().unwrap();
    let model = lapped::assets::mesh("gear").unwrap();
    let made = baked(&model, &Channel::ALL, 256, 1);
    for (file, beside) in [
        ("a.gltf", &["a.bin", "a_color.png", "a_orm.png", "a_normal.png", "a_emissive.png", "a_height.png"][..]),
        (
            "b.obj",
            &["b.mtl", "b_color.png", "b_normal.png", "b_roughness.png", "b_metallic.png", "b_occlusion.png", "b_height.png"],
        ),
        ("c.ply", &["c_color.png"]),
        ("d.glb", &[]),
    ] {
        let path = folder.path().join(file);
        let written = write(&path, &made);
        for name in beside {
            let other = folder.path().join(name);
            assert!(written.contains(&other) && other.metadata().unwrap().len() > 0, "{file}: {name} is there");
        }
        let read = read_model(&path).unwrap();
        assert_eq!(read.faces.len(), model.faces.len(), "{file}: face for face");
        let uv = read.uvs.unwrap();
        for (mine, theirs) in read.faces.iter().zip(&made.model.faces) {
            for k in 0..3 {
                let (a, b) = (mine[k] as usize, theirs[k] as usize);
                assert_eq!(read.positions[a], made.model.positions[b], "{file}: positions");
                assert!((uv[a] - made.look.uv[b]).abs().max_element() < 1e-5, "{file}: coordinates from the top left");
            }
        }
    }
    let shown = Shown::read(&folder.path().join("a.gltf"));
    same_geometry(&shown, &model);
    for file in ["a.gltf", "d.glb"] {
        let (_, look) = read_look(&folder.path().join(file)).unwrap().unwrap();
        let channels: Vec<Channel> = look.pages[0].iter().map(|(c, _)| *c).collect();
        assert_eq!(channels, Channel::ALL, "{file}: every channel comes back");
        assert!(look.tangents.is_some(), "{file}: with the frames of its normals");
        for ((channel, a), (_, b)) in look.pages[0].iter().zip(&made.look.pages[0]) {
            let apart = a.data().iter().zip(b.data()).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
            assert!(apart < 0.01, "{file}: {channel:?} is off by {apart}");
        }
    }
}

#[test]
fn several_pages_are_several_materials() {
    let folder = tempfile::tempdir().unwrap();
    let model = lapped::assets::mesh("dragonling").unwrap();
    let made = baked(&model, &[Channel::BaseColor], 256, 3);
    assert!(made.look.pages.len() > 1, "several pages");
    for file in ["a.glb", "b.obj"] {
        let path = folder.path().join(file);
        write(&path, &made);
        assert_eq!(read_model(&path).unwrap().faces.len(), model.faces.len(), "{file}: every face on one page");
    }
    let (document, ..) = gltf::import(folder.path().join("a.glb")).unwrap();
    assert_eq!(document.materials().len(), made.look.pages.len(), "a material a page");
    let shown = document.nodes().find_map(|n| n.mesh()).unwrap();
    assert_eq!(shown.primitives().len(), made.look.pages.len(), "a primitive a page");
    let (_, look) = read_look(&folder.path().join("a.glb")).unwrap().unwrap();
    assert_eq!(look.pages.len(), made.look.pages.len(), "and they come back");
}
