//! Many comparisons: meshes and exemplars, a folder for each pair, and a page over all of them.
//!
//! A cell that is finished is kept: its report says by a key which inputs, options and version it is of. One that fails is told in the
//! page, and the others go on.

use super::CompareError;
use super::cell::{CompareJob, compare};
use super::report::{Asked, COMMON, JSON, PAGE, PICTURES, ReportError, STYLE, make_folder, page, png_uri, write};
use crate::exemplar::{Channel, Exemplar};
use crate::format::{ExemplarOptions, FormatError, Model, read_exemplar, read_model, write_file};
use crate::job::Steer;
use crate::progress::Progress;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use std::time::Instant;

/// One mesh and one exemplar.
#[derive(Debug, Clone)]
pub struct CellJob {
    /// Its folder within that of all; empty if it is the only one.
    pub name: String,
    /// The mesh's file.
    pub mesh: PathBuf,
    /// The exemplar's file.
    pub exemplar: PathBuf,
    /// What is compared, and how.
    pub job: CompareJob,
    /// Whether the exemplar decides about directions, whatever the job says.
    pub steer_by_exemplar: bool,
    /// The command that does this cell alone.
    pub command: String,
}

/// What became of a cell.
#[derive(Debug, Clone)]
pub struct CellDone {
    /// Its folder's name.
    pub name: String,
    /// The mesh's file.
    pub mesh: String,
    /// The exemplar's file.
    pub exemplar: String,
    /// The report, or why there is none.
    pub report: Result<Value, String>,
    /// Whether it was there already.
    pub kept: bool,
    /// Seconds it took now.
    pub seconds: f64,
}

/// Why a cell has no report.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum CellError {
    /// Its files.
    #[error(transparent)]
    Format(#[from] FormatError),
    /// The comparison.
    #[error("{file}: {source}")]
    Compare {
        /// The file it concerns most.
        file: String,
        /// What is wrong.
        source: CompareError,
    },
    /// Writing.
    #[error(transparent)]
    Report(#[from] ReportError),
}

/// Does a cell, or finds it done. The second of the result is true if it was.
///
/// # Errors
/// If a file cannot be read or written, or there is nothing to compare.
pub fn run_cell(cell: &CellJob, folder: &Path, progress: &dyn Progress) -> Result<(Value, bool), CellError> {
    let begin = Instant::now();
    progress.stage("reading", 0);
    let model = read_model(&cell.mesh)?;
    let (exemplar, _) = read_exemplar(&cell.exemplar, &ExemplarOptions { alone: true, ..ExemplarOptions::default() })?;
    let mut job = cell.job.clone();
    if cell.steer_by_exemplar {
        job.setting.steer = Steer::by_exemplar(&exemplar).0;
    }
    let key = key(&model, &exemplar, &job);
    if let Some(report) = finished(folder, &key) {
        return Ok((report, true));
    }
    let found = compare(&model, &exemplar, &job, progress).map_err(|source| {
        let of_exemplar = matches!(source, CompareError::Exemplar(_));
        let file = if of_exemplar { &cell.exemplar } else { &cell.mesh }.display().to_string();
        CellError::Compare { file, source }
    })?;
    let asked = Asked {
        mesh: cell.mesh.display().to_string(),
        exemplar: cell.exemplar.display().to_string(),
        command: cell.command.clone(),
        key,
    };
    progress.stage("writing the report", 0);
    Ok((write(folder, &found, &asked, begin.elapsed().as_secs_f64())?, false))
}

/// The report of a cell that is finished and of these inputs.
fn finished(folder: &Path, key: &str) -> Option<Value> {
    let report: Value = serde_json::from_slice(&std::fs::read(folder.join(JSON)).ok()?).ok()?;
    (report["asked"]["key"] == key && folder.join(PAGE).is_file()).then_some(report)
}

/// What inputs, options and version are known by: 128 bits of them all.
fn key(model: &Model, exemplar: &Exemplar, job: &CompareJob) -> String {
    let mut hash = Hash::default();
    hash.take(concat!("lapped ", env!("CARGO_PKG_VERSION")).as_bytes());
    hash.take(format!("{job:?}").as_bytes());
    model.positions.iter().for_each(|p| hash.take(p.to_array().map(f32::to_le_bytes).as_flattened()));
    model.faces.iter().for_each(|f| hash.take(f.map(u32::to_le_bytes).as_flattened()));
    hash.take(exemplar.size().map(u32::to_le_bytes).as_flattened());
    for channel in [Channel::BaseColor, Channel::Opacity] {
        if let Some(chain) = exemplar.channel(channel) {
            chain.finest().data().iter().for_each(|x| hash.take(&x.to_le_bytes()));
        }
    }
    format!("{:016x}{:016x}", hash.0, hash.1)
}

/// Two sums after Fowler, Noll and Vo (FNV-1a, 64 bits) that begin apart.
struct Hash(u64, u64);

impl Default for Hash {
    fn default() -> Self {
        Self(0xcbf2_9ce4_8422_2325, 0x6c62_272e_07bb_0142)
    }
}

impl Hash {
    fn take(&mut self, bytes: &[u8]) {
        const PRIME: u64 = 0x0100_0000_01b3;
        for &byte in bytes {
            self.0 = (self.0 ^ u64::from(byte)).wrapping_mul(PRIME);
            self.1 = (self.1.rotate_left(5) ^ u64::from(byte)).wrapping_mul(PRIME);
        }
    }
}

/// Does all cells, one after the other, and writes the page over them; `told` hears of each.
///
/// # Errors
/// If the page cannot be written. Cells that fail are told in it.
pub fn run_all(
    cells: &[CellJob],
    folder: &Path,
    progress: &dyn Progress,
    told: &mut dyn FnMut(&CellDone),
) -> Result<Vec<CellDone>, ReportError> {
    make_folder(folder)?;
    let mut all = Vec::new();
    for cell in cells {
        let begin = Instant::now();
        let done = run_cell(cell, &folder.join(&cell.name), progress);
        let kept = matches!(done, Ok((_, true)));
        let done = CellDone {
            name: cell.name.clone(),
            mesh: cell.mesh.display().to_string(),
            exemplar: cell.exemplar.display().to_string(),
            report: done.map(|d| d.0).map_err(|e| e.to_string()),
            kept,
            seconds: begin.elapsed().as_secs_f64(),
        };
        told(&done);
        all.push(done);
        // What is finished can be looked at while the others are on their way.
        summarize(folder, &all)?;
        if progress.cancelled() {
            break;
        }
    }
    Ok(all)
}

/// Names of the page over all cells, and of the same as JSON.
pub const SUMMARY_PAGE: &str = "index.html";
/// The same as JSON.
pub const SUMMARY_JSON: &str = "index.json";

const TEMPLATE: &str = include_str!("report/page/summary.html");
const SCRIPT: &str = include_str!("report/page/summary.js");

/// Failures of each method that are shown.
const FAILURES: usize = 2;

/// The row by which failures are the worst, as a multiple of its floor.
const FAILURE_ROW: &str = "coherence99";
/// The measure whose worst place shows such a failure.
const FAILURE_PLACE: &str = "coherence";

/// Writes the page over all cells.
///
/// # Errors
/// If it cannot be written.
pub fn summarize(folder: &Path, all: &[CellDone]) -> Result<(), ReportError> {
    let cell = |done: &CellDone| match &done.report {
        Ok(report) => {
            let row =
                |row: &Value| json!({"key": row["key"], "floor": row["floor"], "values": row["values"], "winners": row["winners"]});
            let rows: Vec<Value> = report["rows"].as_array().into_iter().flatten().map(row).collect();
            let method = |m: &Value| json!({"method": m["method"], "label": m["label"], "failed": m["failed"]});
            let methods: Vec<Value> = report["methods"].as_array().into_iter().flatten().map(method).collect();
            json!({
                "name": done.name, "mesh": done.mesh, "exemplar": done.exemplar, "seconds": report["seconds"],
                "rows": rows, "methods": methods, "page": format!("{}/{PAGE}", done.name),
            })
        }
        Err(why) => json!({"name": done.name, "mesh": done.mesh, "exemplar": done.exemplar, "failed": why}),
    };
    let described = |row: &Value| {
        json!({"key": row["key"], "group": row["group"], "label": row["label"], "unit": row["unit"], "good": row["good"],
               "explains": row["explains"]})
    };
    let first = all.iter().find_map(|d| d.report.as_ref().ok());
    let rows: Vec<Value> = first.and_then(|r| r["rows"].as_array()).into_iter().flatten().map(described).collect();
    let mut data = json!({
        "command": "compare", "version": env!("CARGO_PKG_VERSION"), "rows": rows,
        "cells": all.iter().map(cell).collect::<Vec<_>>(),
        "failures": failures(all),
    });
    let text = serde_json::to_string_pretty(&data)?;
    for failure in data["failures"].as_array_mut().into_iter().flatten() {
        let file = folder.join(failure["picture"].as_str().unwrap_or_default());
        if let Ok(png) = std::fs::read(file) {
            failure["image"] = png_uri(&png).into();
        }
    }
    let html = page(TEMPLATE, "Textures compared", &[STYLE], &[COMMON, SCRIPT], &data);
    write_file(&folder.join(SUMMARY_PAGE), |out| out.write_all(html.as_bytes()))?;
    write_file(&folder.join(SUMMARY_JSON), |out| writeln!(out, "{text}"))?;
    Ok(())
}

/// The cells in which each method looks least like the exemplar, as a multiple of the floor.
fn failures(all: &[CellDone]) -> Vec<Value> {
    let mut found: Vec<(String, f64, Value)> = Vec::new();
    for done in all {
        let Ok(report) = &done.report else { continue };
        let rows = report["rows"].as_array();
        let Some(row) = rows.and_then(|rows| rows.iter().find(|r| r["key"] == FAILURE_ROW)) else { continue };
        let floor = row["floor"].as_f64().filter(|f| *f > 0.0).unwrap_or(1.0);
        for (i, method) in report["methods"].as_array().into_iter().flatten().enumerate() {
            let worst = method["worst"].as_array().and_then(|w| w.iter().find(|w| w["measure"] == FAILURE_PLACE));
            let (Some(value), Some(worst)) = (row["values"][i].as_f64(), worst) else { continue };
            let picture = format!("{}/{PICTURES}/{}.png", done.name, worst["picture"].as_str().unwrap_or_default());
            let key = method["method"].as_str().unwrap_or_default().to_owned();
            let told = json!({
                "method": key, "label": method["label"], "cell": done.name, "page": format!("{}/{PAGE}", done.name),
                "timesFloor": value / floor, "picture": picture,
            });
            found.push((key, value / floor, told));
        }
    }
    found.sort_by(|a, b| b.1.total_cmp(&a.1));
    super::Method::ALL.iter().flat_map(|m| found.iter().filter(|f| f.0 == m.key()).take(FAILURES).map(|f| f.2.clone())).collect()
}
