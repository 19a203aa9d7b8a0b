//! Any bytes as a lapped-texture record, whose every index is in range once read.

#![no_main]

use lapped::format::record::read_record_bytes;
use libfuzzer_sys::fuzz_target;
use std::path::Path;

fuzz_target!(|data: &[u8]| {
    if let Ok(record) = read_record_bytes(Path::new("fuzz.glb"), data) {
        for paste in &record.lapped.pastes {
            assert!(paste.faces.iter().all(|&f| (f as usize) < record.model.faces.len()), "faces are in range");
            assert!(usize::from(paste.patch) < record.lapped.patches.len(), "patches are in range");
        }
    }
});
