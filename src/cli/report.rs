//! Reports of runs as JSON, and what the machine says of a run.

use crate::format::write_file;
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

/// The most memory the process has held so far, bytes; `None` where the system does not say.
#[must_use]
pub fn peak_memory() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|l| l.starts_with("VmHWM:"))?;
    let kilobytes: u64 = line.split_whitespace().nth(1)?.parse().ok()?;
    Some(kilobytes * 1024)
}
