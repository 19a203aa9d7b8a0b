//! A draft shows at once what a change will bring: the pastes of before, laid again where they were.

#![allow(clippy::unwrap_used, reason = "a test may fail by panicking")]

use crate::common::input;
use glam::{DVec3, Vec3};
use lapped::exemplar::PatchSource;
use lapped::job::{Draft, Drafts, Laid, PasteJob, Scale, Steer, cut_patches, lay, lay_with_draft};
use lapped::mesh::{CleanOptions, Cleaned, SurfacePoint, clean};
use lapped::paste::{Composite, PasteOptions};
use lapped::progress::Silent;
use lapped::random::Random;

fn job(axis: DVec3, ratio: f64) -> PasteJob {
    let paste = PasteOptions { windows: false, cuts: false, ..PasteOptions::default() };
    PasteJob { scale: Scale::Ratio(ratio), steer: Steer::Up(axis), paste, ..PasteJob::default() }
}

fn model() -> Cleaned {
    let model = lapped::assets::mesh("dragonling").unwrap();
    clean(&model.positions, &model.faces, &CleanOptions::default()).unwrap()
}

/// What a job brings after another one: its draft, if there is one, and the whole.
fn after(cleaned: &Cleaned, before: &PasteJob, then: &PasteJob) -> (Option<Laid>, Laid) {
    let cut = |job: &PasteJob| cut_patches(vec![input("scales", &[PatchSource::Splotch])], job, &mut Vec::new()).unwrap();
    let (exemplars, patches) = cut(before);
    let before = lay(cleaned, exemplars, patches, before, &Silent).unwrap();
    let (exemplars, patches) = cut(then);
    let mut seen = None;
    let mut take = |draft: Draft, laid: Laid| {
        assert_eq!(draft, Draft::Again, "there are neither windows nor cuts to leave out");
        assert!(seen.replace(laid).is_none(), "one draft");
    };
    let drafts = Drafts { take: &mut take, before: Some(&before) };
    let whole = lay_with_draft(cleaned, exemplars, patches, then, &Silent, Some(drafts)).unwrap();
    (seen, whole)
}

/// The share of the surface on which alpha is at least a half, and the mean angle, radians, between the topmost paste's up and
/// the field's.
fn seen(cleaned: &Cleaned, laid: &Laid) -> (f64, f64) {
    let mesh = laid.mesh(cleaned);
    let composite = Composite::new(mesh, &laid.lapped);
    let field = laid.guide.field().unwrap();
    let mut random = Random::new(5, 0);
    let (mut covered, mut all) = (0.0, 0.0);
    for _ in 0..20_000 {
        let face = random.below(mesh.face_count() as u64) as u32;
        let area = mesh.area(face);
        all += area;
        covered += if composite.alpha(SurfacePoint { face, bary: Vec3::splat(1.0 / 3.0) }) >= 0.5 { area } else { 0.0 };
    }
    let (mut off, mut weight) = (0.0, 0.0);
    for paste in &laid.lapped.pastes {
        for (&face, uv) in paste.faces.iter().zip(&paste.uv) {
            // The direction in which v grows is up to where it is not stretched.
            let [a, b, c] = mesh.corners(face);
            let (e1, e2) = ((uv[1] - uv[0]).as_dvec2(), (uv[2] - uv[0]).as_dvec2());
            let det = e1.perp_dot(e2);
            if det.abs() > 1e-12 {
                // Rows of masks run down.
                let up = ((b - a) * e2.x - (c - a) * e1.x) / det;
                off += up.angle_between(field.up[face as usize].as_dvec3()) * mesh.area(face);
                weight += mesh.area(face);
            }
        }
    }
    (covered / all, off / weight)
}

#[test]
fn a_draft_follows_the_new_direction_and_leaves_little_open() {
    let cleaned = model();
    let (draft, whole) = after(&cleaned, &job(DVec3::Y, 40.0), &job(DVec3::new(0.5, 1.0, 0.2), 44.0));
    let draft = draft.expect("a small change");
    let ((open, off), (closed, whole_off)) = (seen(&cleaned, &draft), seen(&cleaned, &whole));
    assert!(closed > 0.9999, "the whole covers everything: {closed}");
    assert!(open > 0.93, "the draft covers {open}");
    assert!(off < 1.2 * whole_off + 0.01, "the draft is {off} off the field, the whole {whole_off}");
    assert_eq!(draft.seedings.len(), draft.lapped.pastes.len(), "each with its seed");
}

#[test]
fn the_whole_does_not_depend_on_what_was_shown_before() {
    let cleaned = model();
    let (_, one) = after(&cleaned, &job(DVec3::Y, 40.0), &job(DVec3::Z, 40.0));
    let (_, other) = after(&cleaned, &job(DVec3::X, 30.0), &job(DVec3::Z, 40.0));
    assert_eq!(one.lapped.pastes, other.lapped.pastes);
}

#[test]
fn there_is_no_draft_of_a_change_that_leaves_nothing_as_it_was() {
    let cleaned = model();
    for ratio in [4.0, 400.0] {
        assert!(after(&cleaned, &job(DVec3::Y, 40.0), &job(DVec3::Y, ratio)).0.is_none(), "ratio {ratio}");
    }
}
