//! Any bytes as a glTF or GLB file, on their own and as the JSON of a GLB that has some binary data.

#![no_main]

use lapped::format::read_model_bytes;
use libfuzzer_sys::fuzz_target;
use std::path::Path;

fuzz_target!(|data: &[u8]| {
    let _ = read_model_bytes(Path::new("fuzz.glb"), data);
    // Most changes to a whole GLB only break its lengths; here they are always right.
    let bin: Vec<u8> = (0..200).collect();
    let mut glb = b"glTF\x02\0\0\0".to_vec();
    glb.extend(((12 + 8 + data.len() + 8 + bin.len()) as u32).to_le_bytes());
    glb.extend((data.len() as u32).to_le_bytes());
    glb.extend(b"JSON");
    glb.extend(data);
    glb.extend((bin.len() as u32).to_le_bytes());
    glb.extend(b"BIN\0");
    glb.extend(bin);
    let _ = read_model_bytes(Path::new("fuzz.glb"), &glb);
});
