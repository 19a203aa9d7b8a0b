//! The pastes as ordinary primitives: every channel that glTF knows, read by somebody else's reader.

#![allow(clippy::unwrap_used, reason = "a test may fail by panicking")]

use crate::turned::{one_paste, waves};
use glam::{Vec2, Vec3, Vec4};
use lapped::exemplar::{Channel, Exemplar, Image};
use lapped::format::Record;
use lapped::format::export::write_layers;
use lapped::job::bake::with_normals;
use lapped::job::{ExemplarInput, PasteJob, Scale, Steer, paste_model};
use lapped::paste::{Layer, TURNS, Turn, base_color};
use lapped::progress::Silent;

fn record() -> Record {
    let model = lapped::assets::mesh("knot").unwrap();
    let mut exemplar = lapped::assets::exemplar("scales").unwrap();
    let [w, h] = exemplar.size();
    exemplar.set(Channel::Roughness, Image::grey_from_fn(w, h, |x, _| x as f32 / w as f32)).unwrap();
    exemplar.set(Channel::Emissive, Image::from_fn(w, h, |x, y| Vec3::new(0.0, y as f32 / h as f32, x as f32 / w as f32))).unwrap();
    let input = ExemplarInput { exemplar, weight: 1.0, patches: Vec::new() };
    let job = PasteJob { scale: Scale::Ratio(25.0), steer: Steer::Up(glam::DVec3::Y), ..PasteJob::default() };
    let record = paste_model(&model, vec![input], &job, &Silent).unwrap().record;
    Record { model: with_normals(&record.model).unwrap(), ..record }
}

#[test]
fn layers_keep_every_channel_that_materials_know_with_tangents_along_their_images() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("layers.glb");
    let record = record();
    let report = write_layers(&path, &record).unwrap();
    assert_eq!((report.primitives, report.materials), (1, 1), "one exemplar");
    let (document, buffers, images) = gltf::import(&path).unwrap();
    let material = document.materials().find(|m| m.name() == Some("scales layers")).unwrap();
    assert_eq!(material.alpha_mode(), gltf::material::AlphaMode::Blend, "blended by the mask");
    let pbr = material.pbr_metallic_roughness();
    assert!(pbr.base_color_texture().is_some(), "base colour");
    assert!(pbr.metallic_roughness_texture().is_some() && pbr.roughness_factor() == 1.0, "roughness");
    assert_eq!(pbr.metallic_factor(), 0.0, "nothing is said of metal");
    assert!(material.emissive_texture().is_some() && material.emissive_factor() == [1.0; 3], "emission");
    let normal = material.normal_texture().unwrap().texture().source().index();

    let primitive = document.meshes().next().unwrap().primitives().nth(1).unwrap();
    let reader = primitive.reader(|b| Some(&buffers[b.index()]));
    let positions: Vec<Vec3> = reader.read_positions().unwrap().map(Vec3::from_array).collect();
    let normals: Vec<Vec3> = reader.read_normals().unwrap().map(Vec3::from_array).collect();
    let tangents: Vec<Vec4> = reader.read_tangents().unwrap().map(Vec4::from_array).collect();
    let uv: Vec<Vec2> = reader.read_tex_coords(0).unwrap().into_f32().map(Vec2::from_array).collect();
    let corners: Vec<usize> = reader.read_indices().unwrap().into_u32().map(|i| i as usize).collect();
    for (t, n) in tangents.iter().zip(&normals) {
        let t3 = t.truncate();
        assert!((t3.length() - 1.0).abs() < 1e-4 && t3.dot(*n).abs() < 1e-3 && t.w.abs() == 1.0, "a unit tangent across {n}: {t}");
    }
    // A small step along the tangent moves to the right in the image; one along the bitangent, up.
    let (mut along, mut all) = (0, 0);
    for f in corners.as_chunks::<3>().0 {
        let [a, b, c] = *f;
        let (e1, e2) = (positions[b] - positions[a], positions[c] - positions[a]);
        let (d1, d2) = (uv[b] - uv[a], uv[c] - uv[a]);
        let across = e1.cross(e2);
        let inverse = across.length_squared().recip();
        let moved = |step: Vec3| {
            let (s, t) = (step.cross(e2).dot(across) * inverse, e1.cross(step).dot(across) * inverse);
            (d1 * s + d2 * t).normalize_or_zero()
        };
        for &v in f {
            let t = tangents[v].truncate();
            let (right, up) = (moved(t), moved(normals[v].cross(t) * tangents[v].w));
            along += usize::from(right.x > 0.7 && up.y < -0.7);
            all += 1;
        }
    }
    assert!(along * 100 > all * 97, "{along} of {all} tangents lie along their image");

    // Under the middle of each patch, the normal map is the exemplar's.
    let sheet = &images[normal];
    let color = &images[pbr.base_color_texture().unwrap().texture().source().index()];
    let source = record.lapped.exemplars[0].channel(Channel::Normal).unwrap().finest();
    let size = source.size().map(i64::from);
    let mut seen = 0;
    for y in (0..sheet.height as usize).step_by(37) {
        for x in (0..sheet.width as usize).step_by(41) {
            let alpha = color.pixels[4 * (y * sheet.width as usize + x) + 3];
            let pixel: [u8; 3] = sheet.pixels[3 * (y * sheet.width as usize + x)..][..3].try_into().unwrap();
            if alpha == 255 {
                let same = |i: i64| {
                    let n = source.pixel(i % size[0], i / size[0]).to_array().map(|c| (127.5 * c + 127.5).round() as i32);
                    (0..3).all(|c| (n[c] - i32::from(pixel[c])).abs() <= 2)
                };
                assert!((0..size[0] * size[1]).any(same), "{pixel:?} at {x} {y} is nowhere in the exemplar's normal map");
                seen += 1;
            }
        }
    }
    assert!(seen > 20, "{seen} opaque pixels looked at");
}

#[test]
fn layers_have_their_base_as_vertex_colours() {
    let folder = tempfile::tempdir().unwrap();
    let mut record = record();
    let faces = record.model.faces.len();
    let base = base_color(Vec3::new(0.5, 0.125, 0.25));
    let pastes = record.lapped.pastes.len() as u32;
    record.lapped.layers = vec![Layer { pastes, base: vec![[base; 3]; faces], ..Layer::default() }];
    let path = folder.path().join("layers.glb");
    let report = write_layers(&path, &record).unwrap();
    let (document, buffers, _) = gltf::import(&path).unwrap();
    let layers: Vec<_> = document.meshes().flat_map(|m| m.primitives()).skip(1).collect();
    assert_eq!(layers.len(), report.primitives);
    for primitive in layers {
        let colors = primitive.reader(|b| Some(&buffers[b.index()])).read_colors(0).unwrap().into_rgb_f32();
        for color in colors {
            let expected = Vec3::new(2.0, 0.5, 1.0);
            assert!((Vec3::from(color) - expected).abs().max_element() < 1e-3, "{color:?}, not the base over a quarter");
        }
    }
}

#[test]
fn layers_of_turned_pastes_show_the_turned_exemplar_and_its_normals() {
    let folder = tempfile::tempdir().unwrap();
    let images = |exemplar: Exemplar, turn: Turn| {
        let mut record = Record { lapped: one_paste(exemplar, turn), ..Record::default() };
        record.model.positions = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]].map(|[x, y]| Vec3::new(x, y, 0.0)).to_vec();
        record.model.faces = vec![[0, 1, 2], [0, 2, 3]];
        record.model.normals = Some(vec![Vec3::Z; 4]);
        let path = folder.path().join("layers.glb");
        write_layers(&path, &record).unwrap();
        gltf::import(&path).unwrap().2
    };
    let found = images(waves(false), Turn::new(TURNS / 4));
    let (expected, still) = (images(waves(true), Turn::NONE), images(waves(false), Turn::NONE));
    assert!(found.len() == expected.len() && found.len() >= 2, "colour and normals, and what the record keeps");
    let off = |a: &gltf::image::Data, b: &gltf::image::Data| {
        assert_eq!((a.width, a.height), (b.width, b.height));
        let steps = a.pixels.iter().zip(&b.pixels).map(|(a, b)| f64::from(a.abs_diff(*b)));
        steps.sum::<f64>() / a.pixels.len() as f64
    };
    // Colour and normals: as those of the turned exemplar, and not as those of the one that lies as it is.
    let both = found.iter().zip(&expected).zip(&still);
    let shown = both.filter(|((found, expected), still)| off(found, expected) < 0.6 && off(found, still) > 4.0).count();
    assert!(shown >= 2, "{shown} of {} images are those of the turned exemplar", found.len());
}
