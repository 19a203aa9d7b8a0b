//! The table of formats names tests that exist.

#![allow(clippy::unwrap_used, reason = "a test may fail by panicking")]

use std::path::Path;

#[test]
fn every_cell_of_the_formats_table_is_backed_by_a_test_that_exists() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let page = std::fs::read_to_string(root.join("docs/formats.md")).unwrap();
    let mut found = 0;
    // `room::file::name` or `file::name` of a test beside the library, `path::tests::name` of one within it.
    for (place, name) in page.split('`').skip(1).step_by(2).filter_map(|code| code.rsplit_once("::")) {
        let paths: Vec<String> = match place.strip_suffix("::tests") {
            Some(module) => vec![format!("src/{}.rs", module.replace("::", "/"))],
            None => ["format", "cli", "synth"].iter().map(|room| format!("tests/{room}/{place}.rs")).collect(),
        };
        let source = paths.iter().find_map(|path| std::fs::read_to_string(root.join(path)).ok()).unwrap_or_default();
        let before = source.split_once(&format!("fn {name}()")).map_or("", |(before, _)| before).trim_end();
        let attributes = before.rsplit_once("\n\n").map_or(before, |(_, last)| last);
        assert!(attributes.contains("#[test]"), "{place}::{name} is a test");
        found += 1;
    }
    assert!(found > 50, "the page names its tests: {found}");
}
