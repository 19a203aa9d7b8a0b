//! The folder of real meshes and textures, where there is one.
#![allow(dead_code, reason = "each test program uses its part")]

use std::path::PathBuf;

/// What `LAPPED_CORPUS` names.
pub(crate) fn corpus() -> Option<PathBuf> {
    std::env::var_os("LAPPED_CORPUS").map(PathBuf::from)
}

/// True if `LAPPED_CORPUS_WHOLE` is set: everything is then looked at as closely as can be, for half an hour. Without it the tests
/// that take longest look at the smaller meshes, or at fewer points.
pub(crate) fn whole() -> bool {
    std::env::var_os("LAPPED_CORPUS_WHOLE").is_some()
}
