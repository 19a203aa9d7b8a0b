//! Hard edges: pastes laid over those that show, and cuts before the rest.

#![allow(clippy::unwrap_used, reason = "a test may fail by panicking")]

use crate::common::{along_y, asset, meshed, patches, torus};
use glam::DVec3;
use lapped::assets;
use lapped::exemplar::PatchSource;
use lapped::field::{Guide, TangentField, turning_points};
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
fn exemplars_with_a_direction_leave_the_field_at_its_poles_alone() {
    let (mut before, bare) = pasted("scales", false, false);
    let (mut after, over) = pasted("scales", true, false);
    assert!(
        over.overlays > 0 && over.visible_hard_edge_length < 0.8 * bare.visible_hard_edge_length,
        "{} of {} still shows, {} laid over",
        over.visible_hard_edge_length,
        bare.visible_hard_edge_length,
        over.overlays
    );
    before.sort_by_key(|s| s.laid);
    after.sort_by_key(|s| s.laid);
    assert_eq!(before[..], after[..before.len()], "the pastes of before are all there");
    let mesh = asset("dragonling");
    let guide = along_y(&mesh);
    let poles = turning_points(&mesh, guide.field().unwrap());
    for seeding in &after[before.len()..] {
        let at = mesh.position(seeding.at);
        // As the crow flies, which is never further than along the surface; the middle of a face stands for all of it.
        let corners = mesh.corners(seeding.at.face);
        let size = corners.iter().map(|c| c.distance(at)).fold(0.0, f64::max);
        let nearest = poles.iter().map(|pole| mesh.point(pole.place).distance(at)).fold(f64::INFINITY, f64::min);
        let reach = 0.25 * f64::from(guide.scale(seeding.at.face));
        assert!(seeding.free && nearest <= reach + size, "{nearest} from the next pole, {reach} allowed");
    }
}

#[test]
fn a_field_without_poles_is_followed_everywhere() {
    let mesh = meshed(&torus());
    let up = |f: u32| {
        let [a, b, c] = mesh.corners(f);
        // Around the hole, which leaves nothing singular.
        let around = DVec3::Z.cross(a + b + c);
        let normal = mesh.normal(f);
        ((around - normal * around.dot(normal)).normalize() * 1.8).as_vec3()
    };
    let field = TangentField::along((0..mesh.face_count() as u32).map(up).collect());
    assert_eq!(turning_points(&mesh, &field), [], "the torus has none this way");
    let exemplar = assets::exemplar("scales").unwrap();
    let patches = patches("scales", PatchSource::Splotch);
    let covered = cover(&mesh, &Guide::Directed(field), vec![exemplar], patches, &[], &PasteOptions::default(), &Silent).unwrap();
    let (_, seedings, statistics) = covered.finish(&mesh, PasteOptions::default().finish(), &Silent);
    assert!(statistics.hard_edge_length > 0.0, "patches as wide as the tube meet themselves");
    assert!(statistics.overlays == 0 && seedings.iter().all(|s| !s.free));
}
