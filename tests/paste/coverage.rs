//! Coverage of whole jobs as the written file has it: no hole, few draws, and nothing that order or culling changes.

#![allow(clippy::unwrap_used, reason = "a test may fail by panicking")]
#![allow(clippy::print_stderr, reason = "measured figures, for whoever runs with --nocapture")]

use crate::common::{
    Points, alpha_at, draws_per_face, exemplar_place, input, least_alpha, mask_pixel, opened, paste_alpha, pasted,
};
use glam::{DVec3, Vec3};
use lapped::exemplar::PatchSource;
use lapped::job::{Bound, PasteJob, Scale, Steer, paste_model};
use lapped::paste::audit::LEAST_ALPHA;
use lapped::paste::{Composite, FaceLists, PasteOptions};
use lapped::progress::Silent;
use lapped::surface::SurfaceTexture;

fn job(ratio: f64, steer: Steer) -> PasteJob {
    PasteJob { scale: Scale::Ratio(ratio), steer, ..PasteJob::default() }
}

/// Half a level of 8-bit alpha: masks are rounded to it in the file.
const HALF_LEVEL: f64 = 0.5 / 255.0;

#[test]
fn no_point_of_a_written_record_shows_through() {
    let cases = [
        ("dragonling", "moss", Steer::Isotropic(None), 20.0),
        ("dragonling", "bricks", Steer::Up(DVec3::Y), 40.0),
        ("knot", "stripes", Steer::Up(DVec3::Y), 30.0),
        ("gear", "rust", Steer::Isotropic(None), 40.0),
        ("vase", "scales", Steer::Up(DVec3::Y), 80.0),
        ("terrain", "leaves", Steer::Up(DVec3::X), 10.0),
    ];
    for (mesh, exemplar, steer, ratio) in cases {
        let done = pasted(&lapped::assets::mesh(mesh).unwrap(), exemplar, &job(ratio, steer));
        let bound = opened(&done.record);
        let (least, at) = least_alpha(&bound.mesh, &bound.lapped, 100_000);
        eprintln!("{mesh} {exemplar}: least {least:.4}, audit {:.4}", done.report.paste.least_alpha);
        assert!(least >= 0.98, "{mesh} with {exemplar}: alpha {least} at {at}");
        let audited = f64::from(done.report.paste.least_alpha);
        assert!(audited >= f64::from(LEAST_ALPHA), "{mesh} with {exemplar}: the audit ended at {audited}");
        // The audit looks at texels, we between them: alpha cannot change by much in half a texel.
        assert!(least >= audited - 0.05, "{mesh} with {exemplar}: the file has {least}, the audit claims {audited}");
    }
}

#[test]
fn a_paste_left_out_shows_as_a_hole() {
    let done = pasted(&lapped::assets::mesh("knot").unwrap(), "moss", &job(30.0, Steer::default()));
    let mut bound = opened(&done.record);
    bound.lapped.pastes.pop();
    let (least, _) = least_alpha(&bound.mesh, &bound.lapped, 100_000);
    assert!(least < 0.5, "the top paste covers what no other does, and without it the least alpha is still {least}");
}

#[test]
fn the_compositor_agrees_with_the_definition_of_over() {
    let done = pasted(&lapped::assets::mesh("vase").unwrap(), "bark", &job(60.0, Steer::default()));
    let Bound { mesh, lapped, .. } = opened(&done.record);
    let (composite, lists) = (Composite::new(&mesh, &lapped), FaceLists::new(mesh.face_count(), &lapped.pastes));
    for at in Points::new(&mesh).list(5000) {
        let ours = alpha_at(&lapped, &lists, at);
        assert!((f64::from(composite.alpha(at)) - ours).abs() < 1e-4, "alpha {} or {ours}", composite.alpha(at));
        // Bottom up, each paste over what is there; nearest the definition, unlike the top-down walk.
        let mut under = Vec3::ZERO;
        let mut covered = 0.0;
        for &(paste, slot) in lists.of(at.face) {
            let patch = &lapped.patches[lapped.pastes[paste as usize].patch as usize];
            let pixel = mask_pixel(&lapped, paste, slot, at.bary);
            let alpha = paste_alpha(&lapped, paste, pixel) as f32;
            let place = exemplar_place(&lapped, paste, pixel);
            let image = lapped.exemplars[patch.exemplar as usize].channel(lapped::exemplar::Channel::BaseColor).unwrap().finest();
            under = under * (1.0 - alpha) + image.bilinear(place) * alpha;
            covered = covered * (1.0 - alpha) + alpha;
        }
        let texel = composite.texel(at, 0.0);
        assert!(
            (texel.base_color - under / covered).abs().max_element() < 1.0 / 255.0,
            "{} or {}",
            texel.base_color,
            under / covered
        );
    }
}

#[test]
fn draws_per_face_are_the_papers_at_its_texture_scales() {
    for (mesh, exemplar) in [("dragonling", "scales"), ("knot", "weave"), ("vase", "bricks")] {
        let model = lapped::assets::mesh(mesh).unwrap();
        for ratio in [80.0, 160.0] {
            let done = pasted(&model, exemplar, &job(ratio, Steer::default()));
            let Bound { mesh: found, lapped, .. } = opened(&done.record);
            let draws = draws_per_face(&found, &lapped);
            let before = done.report.paste.draws_before_cull;
            eprintln!("{mesh} {exemplar} ratio {ratio}: {draws:.2} draws per face, {before:.2} before culling");
            assert!((1.5..=3.2).contains(&draws), "{mesh} with {exemplar} at ratio {ratio}: {draws:.2} draws per face");
            assert!(
                (draws - done.report.paste.draws_per_face).abs() < 0.05,
                "{draws} told as {}",
                done.report.paste.draws_per_face
            );
            assert!(before > draws, "culling at ratio {ratio} removed nothing: {before} to {draws}");
        }
    }
}

#[test]
fn culling_changes_nothing_that_shows() {
    for (name, exemplar, steer) in
        [("dragonling", "pebbles", Steer::Isotropic(None)), ("gear", "stone", Steer::default()), ("vase", "wood", Steer::default())]
    {
        let model = lapped::assets::mesh(name).unwrap();
        let culled = pasted(&model, exemplar, &job(60.0, steer.clone()));
        let paste = PasteOptions { cull: false, ..PasteOptions::default() };
        let whole = pasted(&model, exemplar, &PasteJob { paste, ..job(60.0, steer) });
        let faces = |done: &lapped::job::Pasted| done.lapped.pastes.iter().map(|p| p.faces.len()).sum::<usize>();
        assert!(faces(&culled) * 10 < faces(&whole) * 9, "{name}: culling did little, the test would show nothing");
        let (with, without) = (Composite::new(&culled.mesh, &culled.lapped), Composite::new(&whole.mesh, &whole.lapped));
        let mut most = 0.0_f32;
        for at in Points::new(&whole.mesh).list(40_000) {
            let (a, b) = (with.texel(at, 0.0), without.texel(at, 0.0));
            let off = (a.base_color - b.base_color).abs().max_element().max((a.alpha - b.alpha).abs());
            most = most.max(off.max((a.height - b.height).abs()));
        }
        eprintln!("{name} {exemplar}: culling changes at most {:.3} levels", most * 255.0);
        assert!(most < 1.0 / 255.0, "{name} with {exemplar}: culling changed a point by {} levels", most * 255.0);
    }
}

#[test]
fn sorting_by_hard_edges_hides_them_and_leaves_coverage_alone() {
    for (name, exemplar) in [("gear", "stone"), ("dragonling", "bricks")] {
        let model = lapped::assets::mesh(name).unwrap();
        let run = |hide_hard_edges| {
            let paste = PasteOptions {
                hide_hard_edges,
                overlays: false,
                prune: false,
                cuts: false,
                cull: false,
                ..PasteOptions::default()
            };
            pasted(&model, exemplar, &PasteJob { paste, ..job(40.0, Steer::default()) })
        };
        let (sorted, laid) = (run(true), run(false));
        let [a, b] = [&sorted, &laid].map(|d| FaceLists::new(d.mesh.face_count(), &d.lapped.pastes));
        for at in Points::new(&laid.mesh).list(20_000) {
            let (a, b) = (alpha_at(&sorted.lapped, &a, at), alpha_at(&laid.lapped, &b, at));
            assert!((a - b).abs() < 1e-9, "{name}: alpha {a} sorted, {b} as laid");
        }
        let (less, more) = (sorted.report.paste.visible_hard_edge_length, laid.report.paste.visible_hard_edge_length);
        eprintln!("{name}: {less:.3} of hard edges show sorted, {more:.3} as laid");
        assert!(more > 0.0 && less < 0.9 * more, "{name}: {less} of hard edges show sorted, {more} as laid");
        let all = (sorted.report.paste.hard_edge_length, laid.report.paste.hard_edge_length);
        assert!((all.0 - all.1).abs() < 1e-6 * all.1, "{name}: sorting makes no hard edges: {all:?}");
    }
}

#[test]
fn every_shape_of_patch_covers() {
    let mask = lapped::exemplar::Image::grey_from_fn(64, 64, |x, y| {
        let p = glam::Vec2::new(x as f32 - 31.5, (y as f32 - 31.5) * 1.5);
        ((28.0 - p.length()) / 6.0).clamp(0.0, 1.0)
    });
    let outline = "[[[0.1, 0.1], [0.9, 0.15], [0.8, 0.9], [0.45, 0.6], [0.15, 0.85]]]";
    let outlines = lapped::exemplar::Outline::from_json(outline, "an outline");
    let outlines = outlines.unwrap();
    let sources = [
        PatchSource::Whole,
        PatchSource::Circle,
        PatchSource::Splotch,
        PatchSource::Mask { name: "an ellipse".into(), image: mask },
        PatchSource::Outlines { name: "an outline".into(), outlines },
    ];
    let model = lapped::assets::mesh("vase").unwrap();
    for source in sources {
        let name = format!("{source:.40?}");
        let done = paste_model(&model, vec![input("leaves", &[source])], &job(30.0, Steer::default()), &Silent).unwrap();
        let bound = opened(&done.record);
        let (least, at) = least_alpha(&bound.mesh, &bound.lapped, 100_000);
        assert!(least >= 0.98 - HALF_LEVEL, "{name}: alpha {least} at {at}");
    }
}
