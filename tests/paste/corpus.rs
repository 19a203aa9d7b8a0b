//! The claims that need meshes made by others: every one of the corpus covered, and directions followed on bunnies.
//!
//! `LAPPED_CORPUS` names the folder; without it there is nothing to test here.

#![allow(clippy::unwrap_used, reason = "a test may fail by panicking")]
#![allow(clippy::print_stderr, reason = "measured figures, for whoever runs with --nocapture")]

use crate::common::{draws_per_face, least_alpha, mask_pixel, opened, paste_alpha, quantile};
use crate::folder::{corpus, whole};
use glam::{DVec2, DVec3};
use lapped::field::singularities;
use lapped::format::{ExemplarOptions, read_exemplar, read_model};
use lapped::job::{Bound, ExemplarInput, PasteJob, Pasted, Scale, Steer, paste_model};
use lapped::mesh::SurfacePoint;
use lapped::paste::{FaceLists, LappedTexture};
use lapped::progress::Silent;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Random points per mesh and exemplar: of the whole corpus, and where each mesh gets one exemplar only.
const WHOLE: usize = 1_000_000;
const PART: usize = 200_000;

/// An isotropic, a structured and an anisotropic exemplar, each with the ratio of surface to exemplar area it is laid at.
fn kinds() -> [(&'static str, Steer, f64); 3] {
    [
        ("pebbles.jpg", Steer::Isotropic(None), 20.0),
        ("brick.png", Steer::Up(DVec3::Y), 30.0),
        ("stripes-128.png", Steer::Up(DVec3::Z), 40.0),
    ]
}

fn input(folder: &Path, name: &str) -> ExemplarInput {
    let (exemplar, _) = read_exemplar(&folder.join("textures").join(name), &ExemplarOptions::default()).unwrap();
    ExemplarInput { exemplar, weight: 1.0, patches: Vec::new() }
}

fn meshes(folder: &Path) -> Vec<PathBuf> {
    let mut all: Vec<PathBuf> = std::fs::read_dir(folder.join("meshes")).unwrap().map(|e| e.unwrap().path()).collect();
    // Small ones first: what is wrong shows early.
    all.sort_by_key(|path| (path.metadata().unwrap().len(), path.clone()));
    all
}

#[test]
fn no_point_of_any_corpus_mesh_shows_through() {
    let Some(folder) = corpus() else { return };
    let points = if whole() { WHOLE } else { PART };
    let begin = Instant::now();
    let (mut runs, mut failures) = (0, Vec::new());
    for (k, path) in meshes(&folder).into_iter().enumerate() {
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        let model = read_model(&path).unwrap();
        // In turn, unless all are to be.
        for (exemplar, steer, ratio) in
            kinds().into_iter().enumerate().filter(|(i, _)| whole() || (k + i) % 3 == 2).map(|(_, kind)| kind)
        {
            let start = Instant::now();
            let job = PasteJob { scale: Scale::Ratio(ratio), steer, ..PasteJob::default() };
            let Pasted { record, report, .. } = paste_model(&model, vec![input(&folder, exemplar)], &job, &Silent).unwrap();
            let pasting = start.elapsed().as_secs_f64();
            let Bound { mesh, lapped, .. } = opened(&record);
            drop(record);
            let (least, at) = least_alpha(&mesh, &lapped, points);
            let draws = draws_per_face(&mesh, &lapped);
            let told = f64::from(report.paste.least_alpha);
            eprintln!(
                "{name:20} {exemplar:16} {:7} faces {:5} pastes {draws:5.2} draws, least {least:.4} told {told:.4}, {pasting:.1} of {:.1} s",
                mesh.face_count(),
                lapped.pastes.len(),
                start.elapsed().as_secs_f64()
            );
            runs += 1;
            let sane = (1.0..=6.0).contains(&draws);
            // The audit looks at texels, the points lie between them.
            let agree = told >= 0.98 && least >= told - 0.05;
            if !(least >= 0.98 && sane && agree) {
                failures.push(format!("{name} with {exemplar}: least alpha {least:.4} at {at}, told {told:.4}, {draws:.2} draws"));
            }
        }
    }
    eprintln!("{runs} jobs in {:.0} s, {points} points each", begin.elapsed().as_secs_f64());
    assert!(runs >= 3, "the corpus holds meshes");
    assert!(failures.is_empty(), "{} of {runs} jobs:\n{}", failures.len(), failures.join("\n"));
}

/// World direction of texture up of a paste on a face: the image's upward step through the inverse of the recorded map.
fn texture_up(bound: &Bound, paste: u32, slot: u32) -> DVec3 {
    let p = &bound.lapped.pastes[paste as usize];
    let [w, h] = bound.lapped.patches[p.patch as usize].mask.size().map(f64::from);
    let pixel = p.uv[slot as usize].map(|uv| uv.as_dvec2() * DVec2::new(w, h));
    let [a, b, c] = bound.mesh.corners(p.faces[slot as usize]);
    let (d, e) = (pixel[1] - pixel[0], pixel[2] - pixel[0]);
    let det = d.perp_dot(e);
    ((b - a) * e.x - (c - a) * d.x) / det
}

/// What shows most at a point: the paste with the largest share of what is seen there.
fn shown(lapped: &LappedTexture, lists: &FaceLists, at: SurfacePoint) -> Option<(u32, u32)> {
    let (mut clear, mut most, mut found) = (1.0, 0.0, None);
    for &(paste, slot) in lists.of(at.face).iter().rev() {
        let alpha = paste_alpha(lapped, paste, mask_pixel(lapped, paste, slot, at.bary));
        if clear * alpha > most {
            (most, found) = (clear * alpha, Some((paste, slot)));
        }
        clear *= 1.0 - alpha;
    }
    found
}

#[test]
fn the_texture_follows_the_field_on_bunnies_away_from_its_singularities() {
    let Some(folder) = corpus() else { return };
    for mesh in ["stanford-bunny.obj", "bunny-npm.obj"] {
        for (exemplar, ratio) in [("brick.png", 40.0), ("stripes-128.png", 100.0)] {
            let model = read_model(&folder.join("meshes").join(mesh)).unwrap();
            let job = PasteJob { scale: Scale::Ratio(ratio), ..PasteJob::default() };
            let done = paste_model(&model, vec![input(&folder, exemplar)], &job, &Silent).unwrap();
            let bound = opened(&done.record);
            let up = &bound.field.as_ref().unwrap().up;
            let poles: Vec<DVec3> = singularities(&bound.mesh, up).iter().map(|s| bound.mesh.point(s.vertex)).collect();
            let lists = FaceLists::new(bound.mesh.face_count(), &bound.lapped.pastes);
            let reach = 0.5 * done.report.scale;
            let (mut to_field, mut to_axis, mut all) = (Vec::new(), Vec::new(), 0);
            for at in crate::common::Points::new(&bound.mesh).list(100_000) {
                let place = bound.mesh.position(at);
                all += 1;
                if poles.iter().any(|p| p.distance(place) < reach) {
                    continue;
                }
                let Some((paste, slot)) = shown(&bound.lapped, &lists, at) else { continue };
                let found = texture_up(&bound, paste, slot);
                to_field.push((found.angle_between(up[at.face as usize].as_dvec3()).to_degrees(), 1.0));
                // The axis itself in the face's plane, where that means something: closer to "up" than any field's smoothing.
                let normal = bound.mesh.normal(at.face);
                let axis = DVec3::Y - normal * normal.y;
                if axis.length() > 0.3 {
                    to_axis.push((found.angle_between(axis).to_degrees(), 1.0));
                }
            }
            let share = to_field.len() as f64 / f64::from(all);
            let [median, p95] = [0.5, 0.95].map(|q| quantile(&mut to_field, q));
            let axis = [0.5, 0.95].map(|q| quantile(&mut to_axis, q));
            eprintln!(
                "{mesh} {exemplar} ratio {ratio}: median {median:.2}, 95 % {p95:.2} degrees on {:.0} % of the surface ({} \
                 singular vertices); against the bare axis {:.2} and {:.2}",
                share * 100.0,
                poles.len(),
                axis[0],
                axis[1]
            );
            assert!(share > 0.4, "{mesh}: only {share} of the surface is away from singularities");
            assert!(median < 3.0 && p95 < 20.0, "{mesh} with {exemplar}: median {median}, 95 % {p95} degrees");
            assert!(axis[0] < 6.0, "{mesh} with {exemplar}: {} degrees from the bare axis", axis[0]);
        }
    }
}
