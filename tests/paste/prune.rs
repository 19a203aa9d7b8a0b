//! Pruning: what is left out was needless.

#![allow(clippy::unwrap_used, reason = "a test may fail by panicking")]

use crate::common::{along_y, asset, least_alpha, patches};
use lapped::assets;
use lapped::exemplar::PatchSource;
use lapped::paste::{Finish, LappedTexture, PasteOptions, PasteStatistics, cover};
use lapped::progress::Silent;

fn pasted(mesh: &str, exemplar: &str, prune: bool) -> (LappedTexture, PasteStatistics) {
    let mesh = asset(mesh);
    let options = PasteOptions { prune, windows: false, cuts: false, ..PasteOptions::default() };
    let (guide, patches) = (along_y(&mesh), patches(exemplar, PatchSource::Splotch));
    let covered = cover(&mesh, &guide, vec![assets::exemplar(exemplar).unwrap()], patches, &[], &options, &Silent).unwrap();
    let (lapped, _, statistics) = covered.finish(&mesh, Finish { windows: false, cuts: false, contrast: false }, &Silent);
    (lapped, statistics)
}

#[test]
fn what_is_left_out_leaves_no_hole_no_hard_edge_and_fewer_draws() {
    for (mesh, exemplar) in [("dragonling", "bricks"), ("dragonling", "pebbles"), ("knot", "scales"), ("vase", "moss")] {
        let (_, before) = pasted(mesh, exemplar, false);
        let (lapped, after) = pasted(mesh, exemplar, true);
        let told = format!("{mesh} with {exemplar}: {} of {} pastes left out", after.pruned, before.pastes_laid);
        assert!(after.pruned > before.pastes_laid / 50, "{told}");
        assert_eq!(after.pastes_laid, before.pastes_laid, "{told}");
        assert!(
            after.draws_per_face < before.draws_per_face,
            "{told}: {} to {} draws",
            before.draws_per_face,
            after.draws_per_face
        );
        let edges = [before.visible_hard_edge_length, after.visible_hard_edge_length];
        assert!(edges[1] <= edges[0] * 1.001, "{told}: hard edges {} to {}", edges[0], edges[1]);
        let (least, at) = least_alpha(&asset(mesh), &lapped, 100_000);
        assert!(least >= 0.98, "{told}: alpha {least} at {at}");
    }
}

#[test]
fn plain_pasting_keeps_every_paste() {
    let mesh = asset("knot");
    let cover = |options: &PasteOptions| {
        let patches = patches("moss", PatchSource::Splotch);
        let exemplar = assets::exemplar("moss").unwrap();
        let covered = cover(&mesh, &along_y(&mesh), vec![exemplar], patches, &[], options, &Silent).unwrap();
        covered.finish(&mesh, options.finish(), &Silent).2
    };
    let plain = cover(&PasteOptions::default().plain());
    assert_eq!((plain.pruned, plain.overlays, plain.cuts.cut, plain.windows.matched), (0, 0, 0, 0));
    assert!(cover(&PasteOptions::default()).pruned > 0);
}
