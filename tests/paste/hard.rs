//! Pasting ends, and with a whole cover, on input that no texture was meant for; and each way of steering does what it
//! says.

#![allow(clippy::unwrap_used, reason = "a test may fail by panicking")]
#![allow(clippy::print_stderr, reason = "measured figures, for whoever runs with --nocapture")]

use crate::common::{draws_per_face, input, least_alpha, model_of, opened, pasted, sheet, torus};
use glam::{DVec3, Vec3};
use lapped::exemplar::PatchSource;
use lapped::field::{Constraint, Constraints, TangentField};
use lapped::format::Model;
use lapped::job::{ExemplarInput, PasteJob, Pasted, Scale, Steer, paste_model};
use lapped::progress::Silent;
use std::f32::consts::{PI, TAU};

/// Pastes the model, upright and without direction, and checks the written file. Returns the upright one.
fn survives(what: &str, model: &Model, exemplar: &str, scale: Scale) -> Pasted {
    let run = |steer| {
        let done = pasted(model, exemplar, &PasteJob { scale, steer, ..PasteJob::default() });
        let bound = opened(&done.record);
        let (least, at) = least_alpha(&bound.mesh, &bound.lapped, 30_000);
        let (told, draws) = (done.report.paste.least_alpha, draws_per_face(&bound.mesh, &bound.lapped));
        eprintln!(
            "{what}: {} pastes, {draws:.2} draws per face, least alpha {least:.4}, told {told:.4}",
            bound.lapped.pastes.len()
        );
        assert!(least >= 0.98 && told >= 0.98, "{what}: alpha {least} at {at}, told as {told}");
        assert!(draws.is_finite() && draws >= 1.0, "{what}: {draws} draws per face");
        done
    };
    run(Steer::Isotropic(None));
    run(Steer::Up(DVec3::Y))
}

fn triangle() -> Model {
    model_of(vec![Vec3::ZERO, Vec3::X, Vec3::new(0.3, 0.8, 0.1)], vec![[0, 1, 2]])
}

fn tetrahedron() -> Model {
    let p = vec![Vec3::new(1.0, 1.0, 1.0), Vec3::new(1.0, -1.0, -1.0), Vec3::new(-1.0, 1.0, -1.0), Vec3::new(-1.0, -1.0, 1.0)];
    model_of(p, vec![[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]])
}

#[test]
fn a_single_triangle_is_covered_whether_smaller_or_larger_than_the_patch() {
    for length in [0.25, 1.0, 100.0] {
        survives(&format!("triangle, scale {length}"), &triangle(), "wood", Scale::World(length));
    }
}

#[test]
fn a_closed_mesh_smaller_than_a_patch_is_covered() {
    for length in [1.0, 3.0, 40.0] {
        survives(&format!("tetrahedron, scale {length}"), &tetrahedron(), "bark", Scale::World(length));
    }
}

#[test]
fn a_component_of_two_faces_is_covered() {
    let fold = model_of(vec![Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::new(0.8, 0.7, 0.6)], vec![[0, 1, 2], [2, 1, 3]]);
    for ratio in [0.1, 4.0, 20.0] {
        survives(&format!("two faces, ratio {ratio}"), &fold, "moss", Scale::Ratio(ratio));
    }
}

#[test]
fn two_thousand_components_are_each_covered() {
    let mut model = Model::default();
    for k in 0..2000_u32 {
        let at = Vec3::new((k % 50) as f32, (k / 50) as f32, (k * 7 % 11) as f32) * 3.0;
        let first = model.positions.len() as u32;
        model.positions.extend(tetrahedron().positions.iter().map(|p| *p * (0.2 + (k % 9) as f32 * 0.1) + at));
        model.faces.extend(tetrahedron().faces.iter().map(|f| f.map(|v| v + first)));
    }
    let done = survives("2000 tetrahedra", &model, "rust", Scale::World(6.0));
    assert_eq!(done.report.clean.components, 2000, "components");
}

/// A strip of `n` by 4 quads that closes after `half_turns` half turns.
fn strip(n: u32, half_turns: u32) -> Model {
    let rows = 4;
    let mut model = Model::default();
    for i in 0..n {
        for j in 0..=rows {
            let t = i as f32 / n as f32;
            let (turn, width) = (half_turns as f32 * PI * t, 0.3 * (j as f32 / rows as f32 * 2.0 - 1.0));
            let r = 1.0 + width * turn.cos();
            model.positions.push(Vec3::new(r * (TAU * t).cos(), r * (TAU * t).sin(), width * turn.sin()));
        }
    }
    for i in 0..n {
        for j in 0..rows {
            let at = |i: u32, j: u32| {
                if i == n && half_turns % 2 == 1 { rows - j } else { (i % n) * (rows + 1) + j }
            };
            let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            model.faces.extend([[a, b, c], [a, c, d]]);
        }
    }
    model
}

#[test]
fn a_moebius_strip_is_covered_although_it_has_no_sides() {
    for ratio in [1.0, 20.0] {
        survives(&format!("Moebius strip, ratio {ratio}"), &strip(60, 1), "stripes", Scale::Ratio(ratio));
    }
}

#[test]
fn a_torus_is_covered_by_patches_larger_than_its_tube() {
    let model = torus();
    for ratio in [0.5, 3.0, 30.0] {
        survives(&format!("torus, ratio {ratio}"), &model, "weave", Scale::Ratio(ratio));
    }
}

#[test]
fn needles_are_covered() {
    // A plate of slivers 2000 times as long as wide, and a cone of them that meet in one vertex.
    let mut plate = Model::default();
    let n = 400;
    for k in 0..=n {
        plate
            .positions
            .extend([Vec3::new(k as f32 * 0.0005, 0.0, 0.0), Vec3::new(k as f32 * 0.0005, 1.0, 0.0002 * (k % 3) as f32)]);
    }
    plate.faces = (0..n).flat_map(|k| [[2 * k, 2 * k + 2, 2 * k + 1], [2 * k + 1, 2 * k + 2, 2 * k + 3]]).collect();
    survives("plate of needles", &plate, "fur", Scale::World(0.3));
    let mut cone = model_of(vec![Vec3::new(0.0, 3.0, 0.0)], Vec::new());
    for k in 0..500 {
        let angle = TAU * k as f32 / 500.0;
        cone.positions.push(Vec3::new(0.2 * angle.cos(), 0.0, 0.2 * angle.sin()));
        cone.faces.push([0, 1 + (k + 1) % 500, 1 + k]);
    }
    survives("cone of needles", &cone, "scales", Scale::World(0.4));
}

#[test]
fn tiny_huge_and_far_away_meshes_are_covered_as_any_other() {
    let model = lapped::assets::mesh("vase").unwrap();
    let here = survives("vase", &model, "bark", Scale::default()).report.paste;
    let place = |what: &str, size: f32, by: Vec3| {
        let positions = model.positions.iter().map(|p| *p * size + by).collect();
        let there = survives(what, &model_of(positions, model.faces.clone()), "bark", Scale::default()).report.paste;
        let draws = there.draws_per_face / here.draws_per_face;
        assert!((0.8..1.25).contains(&draws), "{what}: {} draws per face, {} in place", there.draws_per_face, here.draws_per_face);
    };
    place("tiny vase", 1e-6, Vec3::ZERO);
    place("huge vase", 1e6, Vec3::ZERO);
    // A hundred units in size, so that its detail survives 32-bit positions there.
    place("far vase", 100.0, Vec3::new(1e5, -1e5, 1e5));
}

fn constraints(list: Vec<Constraint>) -> Constraints {
    Constraints { constraints: list, ..Constraints::default() }
}

/// Mean world area of one exemplar square under the pastes, over the faces that `choose` picks by their centroid.
fn texture_size(done: &Pasted, choose: impl Fn(DVec3) -> bool) -> f64 {
    let (mut world, mut texture) = (0.0, 0.0);
    for paste in &done.lapped.pastes {
        let patch = &done.lapped.patches[paste.patch as usize];
        let [w, h] = patch.mask.size().map(f64::from);
        let width = f64::from(done.lapped.exemplars[patch.exemplar as usize].size()[0]);
        for (&face, uv) in paste.faces.iter().zip(&paste.uv).filter(|(f, _)| choose(done.mesh.centroid(**f))) {
            world += done.mesh.area(face);
            let (a, b) = ((uv[1] - uv[0]).as_dvec2(), (uv[2] - uv[0]).as_dvec2());
            texture += 0.5 * a.perp_dot(b).abs() * w * h / (width * width);
        }
    }
    (world / texture).sqrt()
}

#[test]
fn a_scale_field_that_varies_fourfold_is_followed() {
    let model = sheet(60, 4.0);
    let wish = |x: f64, scale: f64| Constraint { position: Some([x, 2.0, 0.0]), scale: Some(scale), ..Constraint::default() };
    let asked = constraints(vec![wish(0.0, 0.5), wish(4.0, 2.0)]);
    let both = [Steer::Isotropic(Some(asked.clone())), Steer::Constraints(asked, DVec3::Y)];
    for steer in both {
        let job = PasteJob { scale: Scale::World(0.4), steer, ..PasteJob::default() };
        let done = pasted(&model, "pebbles", &job);
        let bound = opened(&done.record);
        let (least, at) = least_alpha(&bound.mesh, &bound.lapped, 50_000);
        assert!(least >= 0.98, "alpha {least} at {at}");
        let [small, large] = [texture_size(&done, |p| p.x < 0.5), texture_size(&done, |p| p.x > 3.5)];
        eprintln!("exemplar widths of {small:.3} and {large:.3}");
        assert!((0.17..0.25).contains(&small) && (0.65..0.9).contains(&large), "widths {small} and {large}, 0.2 and 0.8 asked for");
    }
}

#[test]
fn a_full_tangential_basis_shears_and_stretches_the_texture() {
    let model = sheet(30, 3.0);
    let faces = model.faces.len();
    let (up, right) = (Vec3::new(0.1, 0.5, 0.0), Vec3::new(0.9, 0.2, 0.0));
    let field = TangentField { up: vec![up; faces], right: Some(vec![right; faces]), ways: 1 };
    let steer = Steer::Field(field.to_json().unwrap());
    let done = pasted(&model, "stripes", &PasteJob { scale: Scale::World(0.5), steer, ..PasteJob::default() });
    let bound = opened(&done.record);
    let (least, at) = least_alpha(&bound.mesh, &bound.lapped, 50_000);
    assert!(least >= 0.98, "alpha {least} at {at}");
    let width = f64::from(bound.lapped.exemplars[0].size()[0]);
    for paste in &bound.lapped.pastes {
        let [w, h] = bound.lapped.patches[paste.patch as usize].mask.size().map(f64::from);
        for (&face, uv) in paste.faces.iter().zip(&paste.uv) {
            let [a, b, c] = bound.mesh.corners(face);
            // World steps of one exemplar width right and up, from the recorded coordinates.
            let pixel = uv.map(|q| glam::DVec2::new(f64::from(q.x) * w, -f64::from(q.y) * h) / width);
            let inverse = glam::DMat2::from_cols(pixel[1] - pixel[0], pixel[2] - pixel[0]).inverse();
            let world = |q: glam::DVec2| {
                let x = inverse * q;
                ((b - a) * x.x + (c - a) * x.y).as_vec3()
            };
            let (s, t) = (world(glam::DVec2::X), world(glam::DVec2::Y));
            assert!((s - right).length() < 1e-3 && (t - up).length() < 1e-3, "face {face}: S {s}, T {t}");
        }
    }
}

#[test]
fn constraints_turn_the_texture_where_they_are() {
    let model = sheet(40, 4.0);
    let wish =
        |x: f64, direction| Constraint { position: Some([x, 2.0, 0.0]), direction: Some(direction), ..Constraint::default() };
    let text = constraints(vec![wish(0.0, [0.0, 1.0, 0.0]), wish(4.0, [1.0, 0.0, 0.0])]).to_json().unwrap();
    let steer = Steer::Constraints(Constraints::from_json(&text).unwrap(), DVec3::Y);
    let done = pasted(&model, "wood", &PasteJob { scale: Scale::World(0.5), steer, ..PasteJob::default() });
    let field = done.guide.field().unwrap();
    let near = |x: f64, axis: DVec3| {
        let faces =
            (0..done.mesh.face_count() as u32).filter(|&f| (done.mesh.centroid(f) - DVec3::new(x, 2.0, 0.0)).length() < 0.3);
        faces.map(|f| field.up[f as usize].as_dvec3().angle_between(axis).to_degrees()).fold(0.0, f64::max)
    };
    assert!(near(0.0, DVec3::Y) < 5.0 && near(4.0, DVec3::X) < 5.0, "{} {} degrees", near(0.0, DVec3::Y), near(4.0, DVec3::X));
    let bound = opened(&done.record);
    let (least, at) = least_alpha(&bound.mesh, &bound.lapped, 50_000);
    assert!(least >= 0.98, "alpha {least} at {at}");
}

#[test]
fn shares_of_pastes_follow_the_weights_of_exemplars() {
    let model = lapped::assets::mesh("dragonling").unwrap();
    let weighted = |name: &str, weight, sources: &[PatchSource]| ExemplarInput { weight, ..input(name, sources) };
    let inputs = vec![
        weighted("moss", 3.0, &[]),
        weighted("stone", 1.0, &[PatchSource::Circle]),
        weighted("rust", 6.0, &[PatchSource::Splotch, PatchSource::Circle]),
    ];
    let job = PasteJob {
        scale: Scale::Ratio(400.0),
        steer: Steer::Isotropic(None),
        // What culling removes depends on the shape, what is laid does not.
        paste: lapped::paste::PasteOptions { cull: false, ..lapped::paste::PasteOptions::default() },
        ..PasteJob::default()
    };
    let done = paste_model(&model, inputs, &job, &Silent).unwrap();
    let mut count = [0.0; 3];
    for paste in &done.lapped.pastes {
        count[done.lapped.patches[paste.patch as usize].exemplar as usize] += 1.0;
    }
    let all = done.lapped.pastes.len() as f64;
    for (found, share) in count.into_iter().zip([0.3, 0.1, 0.6]) {
        // Four standard deviations of a binomial.
        let allowed = 4.0 * (share * (1.0 - share) / all).sqrt();
        let share_found = found / all;
        assert!((share_found - share).abs() < allowed, "{count:?} of {all}: {share_found:.3}, {share} was asked for");
    }
    assert!(all > 500.0, "{all} pastes are enough to tell shares apart");
}
