//! On a flat sheet under a constant field pasting is exact, and moving the input moves the result along.

#![allow(clippy::unwrap_used, reason = "a test may fail by panicking")]
#![allow(clippy::print_stderr, reason = "measured figures, for whoever runs with --nocapture")]

use crate::common::{Points, exemplar_place, input, mask_alpha, meshed, model_of, opened, paste_alpha, pasted, patches, sheet};
use glam::{DMat3, DVec2, DVec3, Vec2, Vec3};
use lapped::exemplar::srgb::encode;
use lapped::exemplar::{Channel, PatchSource};
use lapped::field::{Guide, TangentField};
use lapped::format::Model;
use lapped::job::{PasteJob, Pasted, Scale, Steer, paste_model};
use lapped::mesh::Mesh;
use lapped::mesh::disc::Scratch;
use lapped::mesh::nearest::Nearest;
use lapped::paste::grow::{PatchPlan, Predictor, Site};
use lapped::paste::lay::{FitChoice, lay};
use lapped::paste::{AGREES, Composite, LappedTexture, Paste, PasteOptions, Turn};
use lapped::progress::Silent;
use lapped::surface::SurfaceTexture;

/// Half a level of an 8-bit picture.
const HALF_LEVEL: f32 = 0.5 / 255.0;

/// The largest difference of two colours as an 8-bit sRGB picture would show them.
fn apart(a: Vec3, b: Vec3) -> f32 {
    (0..3).map(|k| (encode(a[k]) - encode(b[k])).abs()).fold(0.0, f32::max)
}

#[test]
fn one_paste_gives_the_exemplar_back() {
    let exemplar = lapped::assets::exemplar("bricks").unwrap();
    let patch = patches("bricks", PatchSource::Whole).remove(0);
    let [w, h] = exemplar.size();
    let mesh = meshed(&sheet(41, 2.0));
    let scale = 1.37;
    let finder = Nearest::new(&mesh);
    for angle in [0.0_f64, 0.4, 2.5] {
        let up = DVec3::new(-angle.sin(), angle.cos(), 0.0) * scale;
        let right = up.cross(DVec3::Z);
        let guide = Guide::Directed(TangentField::along(vec![up.as_vec3(); mesh.face_count()]));
        let plan = PatchPlan::new(&patch, w);
        let centre = DVec3::new(1.03, 0.97, 0.0);
        let seed = finder.nearest(centre).unwrap().at;
        let site =
            Site { mesh: &mesh, guide: &guide, plan: &plan, seed, distortion: 1.0, predictor: Predictor::Field, free: false };
        let laid = lay(site, 0.0, FitChoice::default(), &mut Scratch::new(&mesh)).unwrap();
        let uv = (0..laid.disc.faces.len()).map(|i| laid.disc.face_uv(i).map(|q| plan.mask_uv(q).as_vec2())).collect();
        let paste = Paste {
            patch: 0,
            faces: laid.disc.faces.clone(),
            uv,
            offset: Vec2::ZERO,
            turn: Turn::NONE,
            cut: None,
            agreement: AGREES,
        };
        let lapped = LappedTexture {
            exemplars: vec![exemplar.clone()],
            patches: vec![patch.clone()],
            pastes: vec![paste],
            ..LappedTexture::default()
        };
        let composite = Composite::new(&mesh, &lapped);
        let (mut worst, mut seen) = (0.0_f32, 0);
        for y in 0..h {
            for x in 0..w {
                let pixel = DVec2::new(f64::from(x), f64::from(y)) + 0.5;
                let q = (pixel - patch.centre.as_dvec2()) / f64::from(w);
                let place = mesh.position(seed) + right * q.x - up * q.y;
                let inside = place.x > 0.0 && place.y > 0.0 && place.x < 2.0 && place.y < 2.0;
                let alpha = mask_alpha(&patch, pixel - glam::IVec2::from(patch.origin).as_dvec2());
                if !inside || alpha <= 0.05 {
                    continue;
                }
                let found = composite.texel(finder.nearest(place).unwrap().at, 0.0);
                let expected = exemplar.channel(Channel::BaseColor).unwrap().finest().pixel(i64::from(x), i64::from(y));
                worst = worst.max(apart(found.base_color, expected));
                let off = (f64::from(found.alpha) - alpha).abs();
                assert!(off < f64::from(HALF_LEVEL), "alpha {} at texel {x}, {y}, the mask has {alpha}", found.alpha);
                let height = exemplar.channel(Channel::Height).unwrap().finest().grey(i64::from(x), i64::from(y));
                assert!((found.height - height).abs() < HALF_LEVEL, "height {} at texel {x}, {y}, not {height}", found.height);
                seen += 1;
            }
        }
        eprintln!("turned by {angle}: {seen} texels, at most {:.3} levels off", worst * 255.0);
        assert!(seen > w * h / 2, "most of the exemplar lies on the sheet: {seen} of {}", w * h);
        assert!(worst < HALF_LEVEL, "turned by {angle}: a texel is {} levels off", worst * 255.0);
    }
}

/// Where a paste's texture lies on a flat sheet: the mask pixel under the world's origin, from one corner of one face.
/// `right` and `up` are exemplar widths in the world.
struct Flat {
    origin: DVec2,
    right: DVec2,
    up: DVec2,
    width: f64,
}

impl Flat {
    fn pixel(&self, at: DVec2) -> DVec2 {
        let step = DVec2::new(at.dot(self.right) / self.right.length_squared(), -at.dot(self.up) / self.up.length_squared());
        self.origin + self.width * step
    }
}

#[test]
fn overlapping_pastes_blend_as_computed_by_hand() {
    let mut model = sheet(24, 3.0);
    // Uneven triangles, still flat: a linear map is reproduced on any of them.
    let mut random = lapped::random::Random::new(3, 3);
    for p in &mut model.positions {
        if p.x > 0.0 && p.y > 0.0 && p.x < 3.0 && p.y < 3.0 {
            *p += Vec3::new(random.range(-0.03, 0.03) as f32, random.range(-0.03, 0.03) as f32, 0.0);
        }
    }
    for (source, cull) in [(PatchSource::Whole, true), (PatchSource::Splotch, false), (PatchSource::Circle, true)] {
        let axis = DVec3::new(0.3, 1.0, 0.0);
        let scale = 0.83;
        let job = PasteJob {
            scale: Scale::World(scale),
            steer: Steer::Up(axis),
            paste: PasteOptions { cull, ..PasteOptions::default() },
            ..PasteJob::default()
        };
        let done = paste_model(&model, vec![input("scales", std::slice::from_ref(&source))], &job, &Silent).unwrap();
        let bound = opened(&done.record);
        let (mesh, lapped) = (&bound.mesh, &bound.lapped);
        let exemplar = &lapped.exemplars[0];
        let width = f64::from(exemplar.size()[0]);
        let up = axis.truncate().normalize() * scale;
        let right = -up.perp();
        let flats: Vec<Flat> = lapped
            .pastes
            .iter()
            .map(|paste| {
                let corner = mesh.corners(paste.faces[0])[0].truncate();
                let [w, h] = lapped.patches[paste.patch as usize].mask.size();
                let pixel = paste.uv[0][0].as_dvec2() * DVec2::new(f64::from(w), f64::from(h));
                let flat = Flat { origin: DVec2::ZERO, right, up, width };
                Flat { origin: pixel - flat.pixel(corner), ..flat }
            })
            .collect();
        let composite = Composite::new(mesh, lapped);
        let colours = exemplar.channel(Channel::BaseColor).unwrap().finest();
        let (mut worst, mut layers) = (0.0_f32, 0);
        for at in Points::new(mesh).list(20_000) {
            let place = mesh.position(at).truncate();
            let (mut sum, mut clear) = (Vec3::ZERO, 1.0_f64);
            for (k, flat) in flats.iter().enumerate().rev() {
                let pixel = flat.pixel(place);
                let alpha = paste_alpha(lapped, k as u32, pixel);
                layers += usize::from(alpha > 0.0);
                sum += colours.bilinear(exemplar_place(lapped, k as u32, pixel)) * (clear * alpha) as f32;
                clear *= 1.0 - alpha;
            }
            worst = worst.max(apart(composite.texel(at, 0.0).base_color, sum / (1.0 - clear) as f32));
        }
        eprintln!("{source:?}: {} pastes, {:.2} layers, at most {:.3} levels off", flats.len(), layers as f64 / 2e4, worst * 255.0);
        assert!(flats.len() > 20 && layers > 20_000, "{source:?}: several pastes overlap");
        // The compositor stops where less than half a level can still show, and in linear light: dark colours differ more
        // once encoded.
        assert!(worst < 1.5 / 255.0, "{source:?}: a point is {} levels off", worst * 255.0);
    }
}

fn moved(model: &Model, place: impl Fn(DVec3) -> DVec3) -> Model {
    let positions = model.positions.iter().map(|p| place(p.as_dvec3()).as_vec3()).collect();
    model_of(positions, model.faces.clone())
}

/// The model with coordinates that are multiples of 2^-16, so that turns and moves are exact.
fn rounded(name: &str) -> Model {
    moved(&lapped::assets::mesh(name).unwrap(), |p| (p * 65536.0).round() / 65536.0)
}

fn same_pastes(what: &str, a: &Pasted, b: &Pasted, tolerance: f32) {
    let (a, b) = (&a.lapped, &b.lapped);
    assert_eq!(a.pastes.len(), b.pastes.len(), "{what}: number of pastes");
    for (i, (p, q)) in a.pastes.iter().zip(&b.pastes).enumerate() {
        // Which of two faces equally far from the centre joins first is left to the last bit, and shows nowhere.
        let by_face = |p: &Paste| {
            let mut faces: Vec<(u32, [Vec2; 3])> = p.faces.iter().copied().zip(p.uv.iter().copied()).collect();
            faces.sort_by_key(|(face, _)| *face);
            faces.into_iter().unzip::<u32, [Vec2; 3], Vec<_>, Vec<_>>()
        };
        let ((faces, uv), (faces_of_q, uv_of_q)) = (by_face(p), by_face(q));
        assert_eq!((p.patch, &faces), (q.patch, &faces_of_q), "{what}: patch and faces of paste {i}");
        let pairs = uv.as_flattened().iter().zip(uv_of_q.as_flattened());
        let off = pairs.map(|(a, b)| (*a - *b).abs().max_element()).fold(0.0, f32::max);
        assert!(off <= tolerance, "{what}: paste {i} lies {off} of its mask elsewhere");
    }
}

fn same_look(what: &str, a: &Pasted, b: &Pasted) {
    let (here, there) = (Composite::new(&a.mesh, &a.lapped), Composite::new(&b.mesh, &b.lapped));
    for at in Points::new(&a.mesh).list(2000) {
        let (p, q) = (here.texel(at, 0.0), there.texel(at, 0.0));
        let off = apart(p.base_color, q.base_color);
        assert!(off < 1.0 / 255.0, "{what}: {} levels of colour differ at {at:?}", off * 255.0);
    }
}

fn upright(ratio: f64, axis: DVec3) -> PasteJob {
    PasteJob { scale: Scale::Ratio(ratio), steer: Steer::Up(axis), ..PasteJob::default() }
}

#[test]
fn scaling_by_powers_of_two_changes_no_bit_of_the_pastes() {
    let model = rounded("vase");
    for steer in [Steer::default(), Steer::Isotropic(None)] {
        let job = PasteJob { steer, ..PasteJob::default() };
        let here = pasted(&model, "bark", &job);
        for power in [-20, -1, 1, 20] {
            let factor = 2.0_f64.powi(power);
            let there = pasted(&moved(&model, |p| p * factor), "bark", &job);
            assert_eq!(there.report.scale, here.report.scale * factor, "the scale follows");
            same_pastes(&format!("2^{power} times as large"), &here, &there, 0.0);
        }
    }
}

#[test]
fn turning_mesh_and_axis_by_right_angles_turns_the_pastes_along() {
    let model = rounded("knot");
    let axis = DVec3::new(0.25, 1.0, 0.5);
    let here = pasted(&model, "scales", &upright(40.0, axis));
    let turns = [
        DMat3::from_cols(DVec3::X, DVec3::Z, -DVec3::Y),
        DMat3::from_cols(-DVec3::Z, DVec3::Y, DVec3::X),
        DMat3::from_cols(DVec3::Y, -DVec3::X, DVec3::Z),
    ];
    for (i, turn) in turns.into_iter().enumerate() {
        assert_eq!(turn.determinant(), 1.0, "a rotation");
        let there = pasted(&moved(&model, |p| turn * p), "scales", &upright(40.0, turn * axis));
        same_pastes(&format!("turned about axis {i}"), &here, &there, 1e-3);
        same_look(&format!("turned about axis {i}"), &here, &there);
    }
}

#[test]
fn moving_the_mesh_moves_the_pastes_along() {
    let model = rounded("vase");
    let here = pasted(&model, "bricks", &upright(40.0, DVec3::Y));
    for by in [DVec3::new(8.0, 0.0, 0.0), DVec3::new(-16.0, 32.0, 64.0)] {
        let there = pasted(&moved(&model, |p| p + by), "bricks", &upright(40.0, DVec3::Y));
        let exact = there.mesh.positions.iter().zip(&here.mesh.positions).all(|(a, b)| *a == *b + by.as_vec3());
        assert!(exact, "the move is exact");
        same_pastes(&format!("moved by {by}"), &here, &there, 1e-3);
        same_look(&format!("moved by {by}"), &here, &there);
    }
}

#[test]
fn turning_the_axis_alone_turns_the_texture() {
    // A quarter turn of a square sheet's axis: the same texture, a quarter turned.
    let model = sheet(16, 1.0);
    let angle = |axis: DVec3| {
        let Pasted { mesh, lapped, .. } = pasted(&model, "stripes", &upright(9.0, axis));
        let paste = &lapped.pastes[0];
        direction_of_up(&mesh, &lapped, paste, 0)
    };
    for axis in [DVec3::Y, DVec3::X, DVec3::new(-1.0, 2.0, 0.0)] {
        assert!(angle(axis).angle_between(axis) < 1e-4, "texture up points to {}, not {axis}", angle(axis));
    }
}

/// The world direction along which the mask's v falls fastest with u unchanged: texture up on a face.
fn direction_of_up(mesh: &Mesh, lapped: &LappedTexture, paste: &Paste, slot: usize) -> DVec3 {
    let [w, h] = lapped.patches[paste.patch as usize].mask.size();
    let pixel = paste.uv[slot].map(|uv| uv.as_dvec2() * DVec2::new(f64::from(w), f64::from(h)));
    let [a, b, c] = mesh.corners(paste.faces[slot]);
    let (d, e) = (pixel[1] - pixel[0], pixel[2] - pixel[0]);
    // Solve x d + y e = (0, -1).
    let det = d.perp_dot(e);
    let (x, y) = (e.x / det, -d.x / det);
    (b - a) * x + (c - a) * y
}
