//! One mesh and one exemplar through all methods.

use glam::Vec3;
use lapped::compare::report::{Asked, ROWS, Report};
use lapped::compare::{CompareJob, Comparison, Method, SettingOptions, compare};
use lapped::exemplar::{Exemplar, Image};
use lapped::job::{Scale, Steer};
use lapped::progress::Silent;
use lapped::render::View;
use std::collections::BTreeSet;
use std::sync::OnceLock;

fn job() -> CompareJob {
    CompareJob {
        setting: SettingOptions { scale: Scale::Ratio(5.0), side: 64, ..SettingOptions::default() },
        views: vec![View::degrees(30.0, 18.0)],
        size: [96, 80],
        ..CompareJob::default()
    }
}

fn compared(job: &CompareJob) -> Comparison {
    let model = lapped::assets::mesh("knot").expect("a demo mesh");
    let exemplar = lapped::assets::exemplar("weave").expect("a demo exemplar");
    compare(&model, &exemplar, job, &Silent).expect("it can be compared")
}

/// All methods, made once for all tests.
fn all() -> &'static Comparison {
    static ALL: OnceLock<Comparison> = OnceLock::new();
    ALL.get_or_init(|| compared(&job()))
}

#[test]
fn every_method_covers_the_surface_and_is_measured_and_seen() {
    let found = all();
    let names: BTreeSet<&str> = found.pictures.iter().map(|p| p.name.as_str()).collect();
    assert_eq!(names.len(), found.pictures.len(), "each picture has a name of its own");
    for (method, report) in Method::USUAL.into_iter().zip(&found.methods) {
        assert_eq!((report.method, &report.failed), (method, &None), "in the order asked for");
        let f = report.figures.as_ref().expect("figures");
        assert_eq!(f.mapping.bare, 0.0, "{method} covers everything");
        assert!(f.fidelity.swd.is_finite() && f.fidelity.coherence.p99 > 0.0, "{method}: {:?}", f.fidelity);
        assert!(f.seams.places > 100, "{method} has borders: {:?}", f.seams);
        assert!(f.mapping.used > 0.3, "{method}: {:?}", f.mapping);
        assert!((0.6..1.6).contains(&f.mapping.scale), "{method} has the size asked for: {:?}", f.mapping);
        let pictures = report.pictures.iter().flat_map(|v| [&v.texture, &v.source, &v.error]);
        for name in pictures.chain(report.worst.iter().map(|w| &w.picture)) {
            assert!(names.contains(name.as_str()), "{method} has its picture {name}");
        }
        assert!(report.worst.iter().any(|w| w.measure == "coherence"), "{method} is looked at where it is least like the exemplar");
    }
}

#[test]
fn methods_differ_as_they_are_known_to() {
    let of = |method: Method| {
        let report = all().methods.iter().find(|m| m.method == method).expect("the method");
        report.figures.as_ref().expect("figures")
    };
    let off = |method: Method| of(method).mapping.direction_rms.expect("a direction was asked for");
    // Over its poles they are laid straight, and that is most of it.
    assert!(off(Method::Pasted) < 25.0, "pastes follow the field: {}", off(Method::Pasted));
    assert!(off(Method::Tiling) > 2.0 * off(Method::Pasted), "charts know no field: {}", off(Method::Tiling));
    assert!(off(Method::Triplanar) > off(Method::Pasted), "nor do planes: {}", off(Method::Triplanar));
    assert_eq!(off(Method::Baked), off(Method::Pasted), "a bake lies as its pastes");
    let copied = |method: Method| of(method).mapping.copy_length;
    assert!(copied(Method::Pasted) > copied(Method::WeiLevoy), "pastes are pieces, synthesis goes pixel by pixel");
    let seams = |method: Method| of(method).chart_seams.map(|s| s.ratio);
    let (tiled, baked) = (seams(Method::Tiling).expect("charts"), seams(Method::Baked).expect("charts"));
    assert!(tiled > 1.5 * baked, "tiles jump at chart borders, bakes do not: {tiled} and {baked}");
    assert!(seams(Method::Pasted).is_none(), "pastes need no charts");
    let bytes = |method: Method| of(method).costs.texture_bytes_per_square + of(method).costs.record_bytes_per_square;
    let (planes, pastes, bake) = (bytes(Method::Triplanar), bytes(Method::Pasted), bytes(Method::Baked));
    assert!(planes < pastes.min(bake), "planes are cheapest: {planes}, {pastes}, {bake}");
    // With so few texels an exemplar the pastes' coordinates weigh as much as an atlas would.
    assert!(pastes < 1.5 * bake, "pastes need no more room than that: {pastes}, {bake}");
    assert!(of(Method::Pasted).costs.draws_per_face > 1.0, "pastes overlap");
}

#[test]
fn where_pictures_are_taken_from_changes_no_number() {
    let methods = vec![Method::Pasted, Method::Hex];
    let view = View { zoom: 3.0, ..View::degrees(-100.0, 60.0) };
    let other = compared(&CompareJob { methods: methods.clone(), views: vec![view], size: [40, 90], ..job() });
    for (method, report) in methods.into_iter().zip(&other.methods) {
        let before = all().methods.iter().find(|m| m.method == method).and_then(|m| m.figures.as_ref()).expect("figures");
        let now = report.figures.as_ref().expect("figures");
        assert_eq!(before.fidelity, now.fidelity, "{method}");
        assert_eq!(before.mapping, now.mapping, "{method}");
        assert_eq!((before.seams, before.chart_seams), (now.seams, now.chart_seams), "{method}");
    }
}

#[test]
fn each_row_names_the_best_and_says_why() {
    let asked = Asked::default();
    let value = serde_json::to_value(Report::new(all(), &asked, 1.0)).expect("it can be written");
    let rows = value["rows"].as_array().expect("rows");
    assert_eq!(rows.len(), ROWS.len(), "all rows");
    let keys: BTreeSet<&str> = ROWS.iter().map(|r| r.key).collect();
    assert_eq!(keys.len(), ROWS.len(), "each once");
    for row in rows {
        let winners: Vec<&str> = row["winners"].as_array().expect("winners").iter().filter_map(|w| w.as_str()).collect();
        let values: Vec<Option<f64>> = row["values"].as_array().expect("values").iter().map(serde_json::Value::as_f64).collect();
        assert!(!row["why"].as_str().expect("why").is_empty(), "{row}");
        assert!(winners.len() < Method::USUAL.len(), "not all win: {row}");
        let Some(first) = winners.first() else { continue };
        let index = Method::USUAL.iter().position(|m| m.key() == *first).expect("a method");
        let best = values[index].expect("the best was measured");
        let floor = row["floor"].as_f64().unwrap_or(f64::NEG_INFINITY);
        let better = |v: &f64| match row["good"].as_str() {
            Some("lower") => v.max(floor) < 0.96 * best.max(floor),
            Some("higher") => *v > 1.04 * best,
            _ => v.ln().abs() < best.ln().abs() - 0.04,
        };
        assert!(!values.iter().flatten().any(better), "nothing is clearly better than the best: {row}");
    }
}

#[test]
fn exemplars_with_nothing_to_tell_are_compared_all_the_same() {
    let model = lapped::assets::mesh("knot").expect("a demo mesh");
    for side in [1, 9] {
        let exemplar = Exemplar::new("one colour", Image::from_fn(side, side, |_, _| Vec3::splat(0.3)));
        let job = CompareJob { methods: vec![Method::Triplanar, Method::Hex, Method::WeiLevoy], ..job() };
        let job = CompareJob { setting: SettingOptions { steer: Steer::Isotropic(None), ..job.setting.clone() }, ..job };
        match compare(&model, &exemplar, &job, &Silent) {
            Ok(found) => {
                let value = serde_json::to_value(Report::new(&found, &Asked::default(), 1.0)).expect("it can be written");
                assert!(value["rows"].as_array().is_some_and(|rows| !rows.is_empty()), "{side} pixels: rows");
            }
            Err(error) => assert!(!error.to_string().is_empty(), "{side} pixels: a sentence"),
        }
    }
}

#[test]
fn a_blind_look_mixes_as_many_crops_of_both_and_keeps_the_answers() {
    let methods = vec![Method::Plain, Method::Tiling];
    let seen = compared(&CompareJob { methods: methods.clone(), blind: 6, ..job() });
    for (method, report) in methods.into_iter().zip(&seen.methods) {
        let (name, key) = report.blind.as_ref().expect("a sheet");
        assert_eq!((key.crops, key.surface.len(), key.side), (12, 6, 32), "{method}");
        assert!(key.surface.iter().all(|n| (1..=12).contains(n)), "{method}: {key:?}");
        let sheet = &seen.pictures.iter().find(|p| p.name == *name).expect("its picture").picture;
        assert_eq!((sheet.width, sheet.height), (8 * 84, 2 * 84), "{method}: two rows of eight");
    }
    assert!(all().methods.iter().all(|m| m.blind.is_none()), "nobody asked");
    let value = serde_json::to_value(Report::new(&seen, &Asked::default(), 1.0)).expect("it can be written");
    assert_eq!(value["methods"][0]["blind"][1]["surface"].as_array().map(Vec::len), Some(6));
}
