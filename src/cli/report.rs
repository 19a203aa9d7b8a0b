//! Reports of runs as JSON, and what the machine says of a run.

use crate::format::write_file;
pub use crate::job::estimate::peak_memory;
use anyhow::Context;
use serde::Serialize;
use std::path::Path;

/// Writes a report.
///
/// # Errors
/// If the file cannot be written.
pub fn write(path: &Path, report: &impl Serialize) -> anyhow::Result<()> {
    let text = serde_json::to_string_pretty(report).context("the report cannot be written as JSON")?;
    write_file(path, |out| writeln!(out, "{text}"))?;
    Ok(())
}
