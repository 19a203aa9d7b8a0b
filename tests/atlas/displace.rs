//! A relief that is real: what geometry takes over from the normal map, and what it leaves.

#![allow(clippy::unwrap_used, reason = "a test may fail by panicking")]

use crate::bake::pasted;
use glam::Vec3;
use lapped::atlas::UnwrapOptions;
use lapped::exemplar::{Channel, Image};
use lapped::job::displace::displace_mesh;
use lapped::job::{BakeJob, BakedModel, Displace, bake_model};
use lapped::paste::Composite;
use lapped::progress::Silent;

fn normals(made: &BakedModel) -> Option<&Image> {
    made.look.pages[0].iter().find(|(c, _)| *c == Channel::Normal).map(|(_, image)| image)
}

/// Root mean square of the slopes of a normal map, and the mean of its normals.
fn slopes(image: &Image) -> (f32, Vec3) {
    let all: Vec<Vec3> = image.data().as_chunks::<3>().0.iter().map(|n| Vec3::from_array(*n)).collect();
    let tilt = |n: &Vec3| n.truncate().length_squared();
    ((all.iter().map(tilt).sum::<f32>() / all.len() as f32).sqrt(), all.iter().sum::<Vec3>() / all.len() as f32)
}

#[test]
fn the_normal_map_keeps_what_is_finer_than_the_faces() {
    let (record, bound) = pasted("vase", "bricks", 20.0);
    let texture = Composite::new(&bound.mesh, &bound.lapped);
    let job = |size| BakeJob { unwrap: UnwrapOptions { size, ..UnwrapOptions::default() }, ..BakeJob::default() };
    let whole = bake_model(&record.model, &bound.mesh, &bound.user_faces, &texture, &job(512), &Silent).unwrap();
    let (all, _) = slopes(normals(&whole).unwrap());
    // Few faces are wider than the bricks' relief and leave all of it.
    let mut most = 1.05 * all;
    for faces in [6_000, 100_000] {
        let made = displace_mesh(&bound.mesh, &texture, &job(512), &Displace { height: 0.01, faces }, &Silent).unwrap();
        let (left, mean) = slopes(normals(&made).unwrap());
        assert!(left < most && left > 0.01, "{faces} faces leave slopes of {left}, {most} at most");
        assert!(mean.truncate().length() < 0.02, "{faces} faces: what is left leans nowhere: {mean}");
        let tangents = made.look.tangents.as_ref().unwrap();
        for (t, n) in tangents.iter().zip(made.model.normals.as_ref().unwrap()) {
            assert!(t.truncate().dot(*n).abs() < 0.1 && (t.truncate().length() - 1.0).abs() < 1e-4, "a tangent {t} at {n}");
        }
        most = 0.9 * left;
    }
    let displace = Displace { height: 0.01, faces: 40_000 };
    let coarse = displace_mesh(&bound.mesh, &texture, &job(64), &displace, &Silent).unwrap();
    assert!(normals(&coarse).is_none() && coarse.look.tangents.is_none(), "faces finer than texels leave nothing");
}
