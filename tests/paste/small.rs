//! Smaller patches: laid where wider ones end in hard edges.

#![allow(clippy::unwrap_used, reason = "a test may fail by panicking")]

use crate::common::{along_y, asset, patches};
use lapped::assets;
use lapped::exemplar::{PatchSource, TexturePatch};
use lapped::paste::{Finish, LappedTexture, PasteOptions, PasteStatistics, cover};
use lapped::progress::Silent;

fn pasted(exemplar: &str, patches: &[TexturePatch], small: bool, prune: bool) -> (LappedTexture, PasteStatistics) {
    let mesh = asset("dragonling");
    let options = PasteOptions { small, prune, ..PasteOptions::default() };
    let exemplars = vec![assets::exemplar(exemplar).unwrap()];
    let covered = cover(&mesh, &along_y(&mesh), exemplars, patches.to_vec(), &[], &options, &Silent).unwrap();
    let (lapped, _, statistics) = covered.finish(&mesh, Finish { windows: false, cuts: false, contrast: false }, &Silent);
    (lapped, statistics)
}

#[test]
fn smaller_pastes_hide_hard_edges_that_overlays_leave() {
    // At the poles of the field scales follow it, and end in shards however small; moss lies whole there.
    for (exemplar, left) in [("scales", 0.85), ("moss", 0.8)] {
        let splotches = patches(exemplar, PatchSource::Splotch);
        let (_, without) = pasted(exemplar, &splotches, false, true);
        let (_, with) = pasted(exemplar, &splotches, true, true);
        assert!(without.small == 0 && with.small > 0, "{exemplar}: {} laid", with.small);
        assert!(
            with.visible_hard_edge_length < left * without.visible_hard_edge_length,
            "{exemplar}: {} of {} still shows",
            with.visible_hard_edge_length,
            without.visible_hard_edge_length
        );
        assert!(with.draws_per_face < 1.1 * without.draws_per_face, "{exemplar}: {} draws", with.draws_per_face);
        assert!(with.least_alpha >= 0.98, "{exemplar}: covered to {}", with.least_alpha);
    }
}

#[test]
fn the_result_has_the_patches_given_and_the_smaller_ones_that_are_used() {
    let given = patches("scales", PatchSource::Splotch);
    let (lapped, _) = pasted("scales", &given, true, true);
    assert_eq!(lapped.patches[..given.len()], given[..], "those given come first, as they were");
    let smaller = &lapped.patches[given.len()..];
    assert!(!smaller.is_empty());
    for (number, patch) in smaller.iter().enumerate() {
        let of = |p: &TexturePatch| p.mask.size().map(f64::from).iter().product::<f64>();
        assert!(given.iter().any(|g| of(patch) < 0.6 * of(g)), "patch {number} is no smaller");
        let used = lapped.pastes.iter().any(|p| usize::from(p.patch) == given.len() + number);
        assert!(used, "smaller patch {number} lies nowhere");
    }
}

#[test]
fn smaller_pastes_take_none_of_the_others_away() {
    let given = patches("scales", PatchSource::Splotch);
    let ((_, without), (_, with)) = (pasted("scales", &given, false, false), pasted("scales", &given, true, false));
    assert_eq!(with.pastes_laid - with.small, without.pastes_laid);
    assert_eq!(with.overlays, without.overlays);
}

#[test]
fn patches_that_follow_their_exemplar_are_not_made_smaller() {
    let fixed: Vec<TexturePatch> =
        patches("scales", PatchSource::Splotch).into_iter().map(|p| TexturePatch { slides: false, ..p }).collect();
    let (lapped, statistics) = pasted("scales", &fixed, true, true);
    assert_eq!(statistics.small, 0);
    assert_eq!(lapped.patches, fixed);
}
