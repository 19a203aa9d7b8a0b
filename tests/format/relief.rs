//! Bumps stand out of the surface, whatever convention their normal map was written in.

#![allow(clippy::unwrap_used, reason = "a test may fail by panicking")]

use crate::common::Points;
use glam::Vec3;
use lapped::exemplar::Exemplar;
use lapped::format::{ExemplarOptions, NormalConvention, read_exemplar};
use lapped::job::{ExemplarInput, PasteJob, Pasted, Steer, paste_model};
use lapped::mesh::{Mesh, SurfacePoint};
use lapped::paste::{Composite, PasteOptions};
use lapped::progress::Silent;
use lapped::surface::SurfaceTexture;

/// A demo exemplar with its height map and its normal map in both conventions.
fn both_conventions(name: &str) -> [Exemplar; 2] {
    let folder = tempfile::tempdir().unwrap();
    let at = |file: String| folder.path().join(file);
    for channel in ["color", "height", "normal"] {
        let file = format!("{name}_{channel}.png");
        let image = image::open(format!("{}/assets/exemplars/{file}", env!("CARGO_MANIFEST_DIR"))).unwrap();
        image.save(at(file)).unwrap();
    }
    let read = |normal| {
        let options = ExemplarOptions { normal: Some(normal), ..ExemplarOptions::default() };
        read_exemplar(&at(format!("{name}_color.png")), &options).unwrap().0
    };
    let up = read(NormalConvention::OpenGl);
    let path = at(format!("{name}_normal.png"));
    let mut map = image::open(&path).unwrap().into_rgb8();
    map.pixels_mut().for_each(|p| p[1] = 255 - p[1]);
    map.save(&path).unwrap();
    [up, read(NormalConvention::DirectX)]
}

fn pasted(mesh: &str, exemplar: Exemplar, steer: Steer) -> Pasted {
    let input = ExemplarInput { exemplar, weight: 1.0, patches: Vec::new() };
    // Encoded the other way normals differ in their last bit, which may move a cut.
    let paste = PasteOptions { cuts: false, ..PasteOptions::default() };
    let job = PasteJob { steer, paste, ..PasteJob::default() };
    paste_model(&lapped::assets::mesh(mesh).unwrap(), vec![input], &job, &Silent).unwrap()
}

/// The height's gradient along the surface, by differences within the point's face; `None` too near its edge.
fn slope(mesh: &Mesh, texture: &Composite, at: SurfacePoint, step: f64) -> Option<Vec3> {
    let [a, b, c] = mesh.corners(at.face);
    let (x, y) = (b - a, c - a);
    let move_to = |direction: glam::DVec3| {
        // Solve direction = p x + q y in the face's plane.
        let (xx, xy, yy) = (x.dot(x), x.dot(y), y.dot(y));
        let (dx, dy) = (direction.dot(x), direction.dot(y));
        let det = xx * yy - xy * xy;
        let (p, q) = ((dx * yy - dy * xy) / det, (dy * xx - dx * xy) / det);
        let bary = at.bary + Vec3::new((-p - q) as f32, p as f32, q as f32);
        bary.cmpge(Vec3::ZERO).all().then_some(SurfacePoint { face: at.face, bary })
    };
    let right = x.normalize();
    let up = mesh.normal(at.face).cross(right);
    let mut gradient = Vec3::ZERO;
    for direction in [right, up] {
        let [ahead, behind] = [direction * step, -direction * step].map(move_to);
        let rise = texture.texel(ahead?, 0.0).height - texture.texel(behind?, 0.0).height;
        gradient += direction.as_vec3() * rise;
    }
    Some(gradient)
}

#[test]
fn normals_lean_away_from_what_is_higher_in_either_convention() {
    for (mesh, name, steer) in
        [("vase", "bricks", Steer::default()), ("gear", "pebbles", Steer::Isotropic(None)), ("knot", "weave", Steer::default())]
    {
        let done = both_conventions(name).map(|e| pasted(mesh, e, steer.clone()));
        let texel = done[0].report.scale / f64::from(done[0].lapped.exemplars[0].size()[0]);
        let [up, down] = [&done[0], &done[1]].map(|d| Composite::new(&d.mesh, &d.lapped));
        let mesh_of = &done[0].mesh;
        let (mut both, mut lean_size, mut slope_size, mut points) = (0.0, 0.0, 0.0, 0);
        for at in Points::new(mesh_of).list(6000) {
            let (a, b) = (up.texel(at, 0.0).normal, down.texel(at, 0.0).normal);
            assert!(a.distance(b) < 1e-3, "{mesh}, {name}: the same normal in both conventions: {a}, {b}");
            let Some(slope) = slope(mesh_of, &up, at, 1.5 * texel) else { continue };
            let face = mesh_of.normal(at.face).as_vec3();
            let lean = a - face * a.dot(face);
            both -= lean.dot(slope);
            lean_size += lean.length_squared();
            slope_size += slope.length_squared();
            points += 1;
        }
        let correlation = both / (lean_size * slope_size).sqrt();
        assert!(points > 1000, "{mesh}: {points} points inside their faces");
        assert!(correlation > 0.6, "{mesh}, {name}: normals lean away from what is higher: {correlation}");
    }
}
