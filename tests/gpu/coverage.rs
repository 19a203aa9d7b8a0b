//! Coverage drawn by a graphics adapter is the processor's.

#![allow(
    clippy::print_stdout,
    clippy::unwrap_used,
    reason = "helpers of tests fail as tests do, and figures are shown when asked for"
)]

use crate::common::{pasted, renderers};
use glam::{DVec2, DVec3};
use lapped::exemplar::CoverageMask;
use lapped::job::{ExemplarInput, JobError, PasteJob, Scale, paste_model};
use lapped::mesh::SurfacePoint;
use lapped::paste::coverage::{Lattice, Reach, Tile};
use lapped::paste::coverage_backend::{CoverageBackend, CoveredFace};
use lapped::paste::stencil::Stencil;
use lapped::paste::{Composite, Coverage, FaceLists, PasteError};
use lapped::progress::Silent;
use lapped::random::Random;
use lapped::render::gpu::{Gpu, GpuCoverage, GpuOptions};
use std::sync::Arc;

/// Within so much of a mask's pixel two places are the same to single precision: the edge ties that may differ.
const TIE: f64 = 1.0 / 500.0;

/// A patch over a face: the mask, and its pixels at the face's corners.
type Over = (usize, [DVec2; 3]);

/// What the processor makes of a face under patches laid one after the other, their pixels moved and scaled.
fn covered(lattice: &Lattice, masks: &[CoverageMask], over: &[Over], shift: DVec2, scale: f64) -> Vec<u8> {
    let mut tile = Tile::Bare;
    for &(mask, pixel) in over {
        let middle = (pixel[0] + pixel[1] + pixel[2]) / 3.0;
        tile.cover(lattice, &Stencil::new(&masks[mask], None), pixel.map(|p| middle + (p - middle) * scale + shift));
    }
    match tile {
        Tile::Bare => vec![255; lattice.cells()],
        Tile::Opaque => vec![0; lattice.cells()],
        Tile::Partial(samples) => samples.to_vec(),
    }
}

#[test]
#[ignore = "needs graphics adapters, software will do: cargo test --test gpu -- --include-ignored"]
fn every_sample_is_the_processors_but_for_edge_ties() {
    for (name, exemplar, ratio, cell) in
        [("dragonling", "fur", 40.0, 2.0), ("knot", "weave", 40.0, 2.0), ("gear", "rust", 20.0, 4.0)]
    {
        let done = pasted(name, &[exemplar], ratio, true);
        let (mesh, lapped) = (&done.mesh, &done.lapped);
        let masks: Vec<CoverageMask> = lapped.patches.iter().map(CoverageMask::new).collect();
        let pitch = cell * done.report.scale / f64::from(lapped.exemplars[0].size()[0]);
        let lists = FaceLists::new(mesh.face_count(), &lapped.pastes);
        let (mut faces, mut asked, mut overs) = (Vec::new(), Vec::new(), Vec::new());
        for face in 0..mesh.face_count() as u32 {
            let lattice = Lattice::new(&mesh.corners(face), pitch);
            let over: Vec<Over> = lists
                .of(face)
                .iter()
                .map(|&(paste, slot)| {
                    let paste = &lapped.pastes[paste as usize];
                    let [w, h] = lapped.patches[paste.patch as usize].mask.size();
                    let size = DVec2::new(f64::from(w), f64::from(h));
                    (usize::from(paste.patch), paste.uv[slot as usize].map(|uv| uv.as_dvec2() * size))
                })
                .filter(|(mask, pixel)| Stencil::new(&masks[*mask], None).reach_of_face(pixel) == Reach::Some)
                .collect();
            let mut one = CoveredFace::new(&lattice, vec![255; lattice.cells()]);
            over.iter().for_each(|&(mask, pixel)| one.lay(&lattice, mask as u32, pixel));
            faces.push(lattice);
            asked.push(one);
            overs.push(over);
        }
        for renderer in renderers() {
            let adapter = renderer.gpu().adapter();
            let coverage = GpuCoverage::new(renderer.gpu().clone()).unwrap();
            let drawn = coverage.prepare(&masks).unwrap().cover(&asked).unwrap();
            assert_eq!(drawn.len(), faces.len(), "an answer for each face");
            let (mut samples, mut opaque, mut ties) = (0, 0, 0);
            for ((lattice, over), drawn) in faces.iter().zip(&overs).zip(&drawn) {
                let expected = covered(lattice, &masks, over, DVec2::ZERO, 1.0);
                assert_eq!(drawn.len(), expected.len(), "a number for each sample");
                samples += expected.len();
                opaque += expected.iter().filter(|&&t| t == 0).count();
                let different: Vec<usize> = (0..expected.len()).filter(|&k| drawn[k] != expected[k]).collect();
                ties += different.len();
                if different.is_empty() {
                    continue;
                }
                let (mut least, mut most) = (expected.clone(), expected.clone());
                for (x, y, scale) in
                    [(1.0, 0.0, 1.0), (-1.0, 0.0, 1.0), (0.0, 1.0, 1.0), (0.0, -1.0, 1.0), (0.0, 0.0, 1.001), (0.0, 0.0, 0.999)]
                {
                    let moved = covered(lattice, &masks, over, DVec2::new(x, y) * TIE, scale);
                    for k in 0..moved.len() {
                        (least[k], most[k]) = (least[k].min(moved[k]), most[k].max(moved[k]));
                    }
                }
                for k in different {
                    assert!(
                        (least[k]..=most[k]).contains(&drawn[k]),
                        "{name} on {adapter}: {} is no tie between {} and {}, the processor has {}",
                        drawn[k],
                        least[k],
                        most[k],
                        expected[k]
                    );
                }
            }
            println!("{name} on {adapter}: {samples} samples, {opaque} opaque, {ties} edge ties");
            assert!(opaque > samples / 8 && opaque < samples, "{name}: {opaque} of {samples} are opaque");
            assert!(ties * 1000 < samples, "{name} on {adapter}: {ties} of {samples} samples are ties");
        }
    }
}

#[test]
#[ignore = "needs graphics adapters, software will do: cargo test --test gpu -- --include-ignored"]
fn a_job_whose_coverage_an_adapter_draws_leaves_nothing_bare() {
    let model = lapped::assets::mesh("knot").unwrap();
    let input = || vec![ExemplarInput { exemplar: lapped::assets::exemplar("weave").unwrap(), weight: 1.0, patches: Vec::new() }];
    let mut job = PasteJob { scale: Scale::Ratio(40.0), ..PasteJob::default() };
    let plain = paste_model(&model, input(), &job, &Silent).unwrap();
    for renderer in renderers() {
        let coverage = Arc::new(GpuCoverage::new(renderer.gpu().clone()).unwrap());
        job.paste.coverage = Coverage(Some(coverage));
        let done = paste_model(&model, input(), &job, &Silent).unwrap();
        let [found, expected] = [&done, &plain].map(|p| &p.report.paste);
        println!("{}: {} pastes, {} on the processor", renderer.gpu().adapter(), found.pastes, expected.pastes);
        assert!(found.least_alpha > 0.98, "the audit's least alpha is {}", found.least_alpha);
        assert!(found.pastes.abs_diff(expected.pastes) * 10 < expected.pastes, "{} pastes, not {}", found.pastes, expected.pastes);
        let composite = Composite::new(&done.mesh, &done.lapped);
        let mut random = Random::new(8, 0);
        for _ in 0..20_000 {
            let face = random.below(done.mesh.face_count() as u64) as u32;
            let (root, v) = (random.unit().sqrt(), random.unit());
            let bary = DVec3::new(1.0 - root, root * (1.0 - v), root * v).as_vec3();
            let alpha = composite.alpha(SurfacePoint { face, bary });
            assert!(alpha > 0.98, "face {face} at {bary} shows through: {alpha}");
        }
        let again = paste_model(&model, input(), &job, &Silent).unwrap();
        assert_eq!(again.lapped.pastes, done.lapped.pastes, "the same every time");
    }
}

#[test]
#[ignore = "needs graphics adapters, software will do: cargo test --test gpu -- --include-ignored"]
fn masks_beyond_an_adapters_limits_are_refused_with_words() {
    let limits = wgpu::Limits { max_storage_buffer_binding_size: 1 << 16, ..wgpu::Limits::downlevel_defaults() };
    let limits = wgpu::Limits { max_storage_buffers_per_shader_stage: 8, ..limits };
    let gpu = Gpu::new(&GpuOptions { adapter: Some("vulkan".into()), limits: Some(limits) }).unwrap();
    let mut job = PasteJob::default();
    job.paste.coverage = Coverage(Some(Arc::new(GpuCoverage::new(gpu).unwrap())));
    let model = lapped::assets::mesh("knot").unwrap();
    let inputs = vec![ExemplarInput { exemplar: lapped::assets::exemplar("weave").unwrap(), weight: 1.0, patches: Vec::new() }];
    let error = paste_model(&model, inputs, &job, &Silent).unwrap_err();
    assert!(matches!(error, JobError::Paste(PasteError::Coverage(_))), "{error}");
    let told = error.to_string();
    assert!(told.contains("65536") && told.contains("--coverage cpu"), "{told}");
}
