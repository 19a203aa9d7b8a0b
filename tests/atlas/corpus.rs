//! Every mesh of the corpus is unwrapped, baked, written, and passes the checker.
//!
//! `LAPPED_CORPUS` names the folder; without it there is nothing to test here.

#![allow(clippy::unwrap_used, reason = "a test may fail by panicking")]
#![allow(clippy::print_stderr, reason = "measured figures, for whoever runs with --nocapture")]

use crate::bake::Smooth;
use crate::checker::{Shown, overlaps, same_geometry};
use crate::folder::whole;
use glam::Vec3;
use lapped::atlas::UnwrapOptions;
use lapped::exemplar::Channel;
use lapped::format::export::{Export, Kind, write_look};
use lapped::format::read_model;
use lapped::job::{BakeJob, bake_model};
use lapped::mesh::{CleanOptions, NONE, clean};
use lapped::progress::Silent;
use lapped::surface::SurfaceTexture;
use std::path::PathBuf;
use std::time::Instant;

/// Texels along a side; the check for overlaps is finer, whatever this is.
const SIZE: u32 = 1024;

/// Meshes of more faces are left out, and overlaps are looked for on so many texels along a side: for the whole corpus, and for a
/// part in a few minutes.
const WHOLE: (usize, usize) = (200_000, 4096);
const PART: (usize, usize) = (20_000, 2048);

#[test]
fn corpus_meshes_bake_and_pass_the_checker() {
    let Some(folder) = crate::folder::corpus() else { return };
    let (most_faces, fine) = if whole() { WHOLE } else { PART };
    let mut paths: Vec<PathBuf> = std::fs::read_dir(folder.join("meshes")).unwrap().map(|e| e.unwrap().path()).collect();
    paths.sort_by_key(|p| (p.metadata().unwrap().len(), p.clone()));
    let out = tempfile::tempdir().unwrap();
    let mut failures = Vec::new();
    for path in paths {
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        let begin = Instant::now();
        let model = read_model(&path).unwrap();
        let cleaned = clean(&model.positions, &model.faces, &CleanOptions::default()).unwrap();
        if cleaned.mesh.face_count() > most_faces {
            continue;
        }
        let texture = Smooth::new(&cleaned.mesh, &[Channel::BaseColor]);
        let job = BakeJob { unwrap: UnwrapOptions { size: SIZE, ..UnwrapOptions::default() }, ..BakeJob::default() };
        let made = match bake_model(&model, &cleaned.mesh, &cleaned.user_faces, &texture, &job, &Silent) {
            Ok(made) => made,
            Err(error) => {
                failures.push(format!("{name}: {error}"));
                continue;
            }
        };
        let file = out.path().join("a.glb");
        write_look(&file, Kind::Glb, &Export { model: &made.model, look: &made.look, generator: "test" }).unwrap();
        let shown = Shown::read(&file);
        same_geometry(&shown, &model);
        let inside = shown.uv.iter().all(|p| (0.0..=1.0).contains(&p.x) && (0.0..=1.0).contains(&p.y));
        let (shared, doubled) = overlaps(&shown, fine);
        // Colours at corners and middles, at the finest level and two below.
        let levels = shown.levels(2);
        let (low, high) = cleaned.mesh.bounds();
        let (mut wrong, mut asked) = (0, 0);
        for (user, to) in cleaned.user_faces.iter().enumerate().filter(|(_, to)| to.face != NONE) {
            let [a, b, c] = shown.corners(user);
            if (b - a).perp_dot(c - a) == 0.0 {
                continue;
            }
            for at in [Vec3::X, Vec3::splat(1.0 / 3.0)] {
                let uv = a * at.x + b * at.y + c * at.z;
                let expected = texture.texel(lapped::job::bake::on_mesh(to, at), 0.0).base_color;
                for level in 0..levels.len() {
                    let apart = (shown.sample(&levels, level, uv) - expected).abs().max_element();
                    // Charts stretch here and there: twice the mean texel.
                    let texel = f64::from(1 << level) / made.report.density / f64::from((high - low).max_element());
                    asked += 1;
                    wrong += usize::from(apart > (3.0 * texel) as f32 + 0.004);
                }
            }
        }
        let r = &made.report;
        eprintln!(
            "{name:20} {:>7} faces {:>5} charts, {:>4.1} % filled, L2 {:.4} Linf {:.1}, {} collapsed, borders {:.2}/{:.2}/{:.1}, {wrong} of {asked} off, {:.1} s",
            model.faces.len(),
            r.charts,
            100.0 * r.efficiency,
            r.stretch.l2,
            r.stretch.linf,
            r.stretch.collapsed_faces,
            r.bake.seams.mean,
            r.bake.seams.most,
            r.bake.seams.greatest,
            begin.elapsed().as_secs_f64(),
        );
        if !inside || shared > 0 || doubled > 0 || !shown.opaque {
            failures.push(format!("{name}: within the image: {inside}, {shared} texels shared, {doubled} doubled"));
        }
        if wrong * 10_000 > asked {
            failures.push(format!("{name}: {wrong} of {asked} samples show another colour"));
        }
    }
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}
