//! Hard edges: pastes laid over those that show, and cuts before the rest.

#![allow(clippy::unwrap_used, reason = "a test may fail by panicking")]

use crate::common::{along_y, asset, patches};
use lapped::assets;
use lapped::exemplar::PatchSource;
use lapped::paste::{Finish, PasteOptions, PasteStatistics, Seeding, cover};
use lapped::progress::Silent;

fn pasted(name: &str, overlays: bool, cuts: bool) -> (Vec<Seeding>, PasteStatistics) {
    let mesh = asset("dragonling");
    let options =
        PasteOptions { overlays, small: false, prune: false, windows: false, cuts, cull: false, ..PasteOptions::default() };
    let patches = patches(name, PatchSource::Splotch);
    let exemplar = assets::exemplar(name).unwrap();
    let covered = cover(&mesh, &along_y(&mesh), vec![exemplar], patches, &[], &options, &Silent).unwrap();
    let (_, seedings, statistics) = covered.finish(&mesh, Finish { windows: false, cuts, contrast: false }, &Silent);
    (seedings, statistics)
}

#[test]
fn pastes_over_hard_edges_leave_few_to_be_seen_and_take_none_away() {
    let (mut before, bare) = pasted("pebbles", false, false);
    let (mut after, over) = pasted("pebbles", true, false);
    assert!(bare.visible_hard_edge_length > 0.0 && bare.overlays == 0);
    assert!(
        over.visible_hard_edge_length < 0.6 * bare.visible_hard_edge_length,
        "{} of {} still shows, {} laid over",
        over.visible_hard_edge_length,
        bare.visible_hard_edge_length,
        over.overlays
    );
    assert!(over.least_alpha >= 0.98, "{}", over.least_alpha);
    before.sort_by_key(|s| s.laid);
    after.sort_by_key(|s| s.laid);
    assert_eq!(before[..], after[..before.len()], "the pastes of before are all there");
    assert!(before.iter().all(|s| !s.free) && after[before.len()..].iter().all(|s| s.free));
    assert_eq!(after.len() - before.len(), over.overlays);
}

#[test]
fn borders_are_cut_before_hard_edges_where_something_lies_below() {
    let (_, whole) = pasted("pebbles", true, false);
    let (_, cut) = pasted("pebbles", true, true);
    assert!(
        cut.visible_hard_edge_length < 0.9 * whole.visible_hard_edge_length,
        "{} of {} still shows",
        cut.visible_hard_edge_length,
        whole.visible_hard_edge_length
    );
}

#[test]
fn exemplars_with_a_direction_are_laid_along_the_field_even_over_hard_edges() {
    let (mut before, bare) = pasted("scales", false, false);
    let (mut after, over) = pasted("scales", true, false);
    assert!(bare.visible_hard_edge_length > 0.0, "the field has poles, at which pastes end");
    assert!(
        over.visible_hard_edge_length <= bare.visible_hard_edge_length,
        "{} of {} still shows, {} laid over",
        over.visible_hard_edge_length,
        bare.visible_hard_edge_length,
        over.overlays
    );
    before.sort_by_key(|s| s.laid);
    after.sort_by_key(|s| s.laid);
    assert_eq!(before[..], after[..before.len()], "the pastes of before are all there");
    assert_eq!(after.len() - before.len(), over.overlays);
    assert!(after.iter().all(|s| !s.free), "scales point down at the poles of the field too");
}
