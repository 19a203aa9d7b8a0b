//! Any bytes as a OBJ file: read or refused, and what was read can be cleaned.

#![no_main]

use lapped::format::read_model_bytes;
use lapped::mesh::{CleanOptions, clean};
use libfuzzer_sys::fuzz_target;
use std::path::Path;

fuzz_target!(|data: &[u8]| {
    if let Ok(model) = read_model_bytes(Path::new("fuzz.obj"), data) {
        if let Ok(cleaned) = clean(&model.positions, &model.faces, &CleanOptions::default()) {
            cleaned.mesh.check().expect("a cleaned mesh is sound");
        }
    }
});
