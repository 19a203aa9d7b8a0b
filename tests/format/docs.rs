//! The table of formats names tests that exist.

#![allow(clippy::unwrap_used, reason = "a test may fail by panicking")]

use std::path::Path;

#[test]
fn every_cell_of_the_formats_table_is_backed_by_a_test_that_exists() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let page = std::fs::read_to_string(root.join("docs/formats.md")).unwrap();
    let mut found = 0;
    for (file, name) in page.split('`').skip(1).step_by(2).filter_map(|code| code.split_once("::")) {
        let source = ["format", "cli", "synth"]
            .iter()
            .find_map(|kind| std::fs::read_to_string(root.join(format!("tests/{kind}/{file}.rs"))).ok());
        let source = source.unwrap_or_default();
        assert!(source.contains(&format!("#[test]\nfn {name}()")), "{file}::{name} is a test");
        found += 1;
    }
    assert!(found > 50, "the page names its tests: {found}");
}
