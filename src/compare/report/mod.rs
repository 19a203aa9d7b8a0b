//! The report of a comparison: one page that needs nothing else, the same as JSON, and the pictures.

mod embed;
mod rows;

pub use embed::{data_uri, page, png_uri};
pub use rows::{Good, ROWS, Row, RowReport};

use super::cell::{Comparison, MethodReport, SettingReport};
use super::measures::Measured;
use crate::format::{FormatError, write_file};
use rayon::prelude::*;
use serde::Serialize;
use std::path::Path;

/// What all pages look like.
pub(super) const STYLE: &str = include_str!("page/style.css");
/// What all pages have in common.
pub(super) const COMMON: &str = include_str!("page/common.js");
const TEMPLATE: &str = include_str!("page/report.html");
const SCRIPT: &str = include_str!("page/report.js");

/// Names of what is written.
pub const PAGE: &str = "report.html";
/// The same as JSON.
pub const JSON: &str = "report.json";
/// The folder of the pictures.
pub const PICTURES: &str = "pictures";

/// What was asked for, so that it can be done again.
#[derive(Debug, Clone, Default, Serialize)]
pub struct Asked {
    /// The mesh's file.
    pub mesh: String,
    /// The exemplar's file.
    pub exemplar: String,
    /// The command that does it again.
    pub command: String,
    /// What the inputs, the options and the version are known by.
    pub key: String,
}

/// A report as it is written.
#[derive(Debug, Serialize)]
pub struct Report<'a> {
    command: &'static str,
    version: &'static str,
    asked: &'a Asked,
    setting: &'a SettingReport,
    floor: &'a Measured,
    rows: Vec<RowReport>,
    methods: &'a [MethodReport],
    /// Wall seconds of all.
    seconds: f64,
}

impl<'a> Report<'a> {
    /// The report of a comparison.
    #[must_use]
    pub fn new(comparison: &'a Comparison, asked: &'a Asked, seconds: f64) -> Self {
        let Comparison { setting, floor, methods, .. } = comparison;
        let rows = ROWS.iter().map(|row| row.of(methods, floor)).collect();
        Self { command: "compare", version: env!("CARGO_PKG_VERSION"), asked, setting, floor, rows, methods, seconds }
    }
}

/// Why a report could not be written.
#[derive(Debug, thiserror::Error)]
pub enum ReportError {
    /// A file.
    #[error(transparent)]
    Format(#[from] FormatError),
    /// A picture.
    #[error(transparent)]
    Render(#[from] crate::render::RenderError),
    /// The numbers.
    #[error("the report cannot be written as JSON: {0}")]
    Json(#[from] serde_json::Error),
    /// The folder.
    #[error("{folder}: the folder cannot be made ({source}): choose another with -o")]
    Folder {
        /// Its name.
        folder: String,
        /// What the system says.
        source: std::io::Error,
    },
}

/// Makes a folder and all above it.
pub(super) fn make_folder(folder: &Path) -> Result<(), ReportError> {
    let failed = |source| ReportError::Folder { folder: folder.display().to_string(), source };
    std::fs::create_dir_all(folder).map_err(failed)
}

/// Writes page, JSON and pictures into a folder, the JSON last: where it is, all is. Returns the report as written.
///
/// # Errors
/// If a file cannot be written.
pub fn write(folder: &Path, comparison: &Comparison, asked: &Asked, seconds: f64) -> Result<serde_json::Value, ReportError> {
    let pictures = folder.join(PICTURES);
    make_folder(&pictures)?;
    let report = serde_json::to_value(Report::new(comparison, asked, seconds))?;
    let mut data = report.clone();
    let mut images = serde_json::Map::new();
    let written: Vec<String> = comparison
        .pictures
        .par_iter()
        .map(|named| {
            let png = named.picture.png()?;
            write_file(&pictures.join(format!("{}.png", named.name)), |out| out.write_all(&png))?;
            Ok::<_, ReportError>(data_uri(&named.picture))
        })
        .collect::<Result<_, _>>()?;
    for (named, uri) in comparison.pictures.iter().zip(written) {
        images.insert(named.name.clone(), uri.into());
    }
    data["images"] = images.into();
    let title = format!("{} and {}: textures compared", stem(&asked.mesh), stem(&asked.exemplar));
    let html = page(TEMPLATE, &title, &[STYLE], &[COMMON, SCRIPT], &data);
    write_file(&folder.join(PAGE), |out| out.write_all(html.as_bytes()))?;
    let text = serde_json::to_string_pretty(&report)?;
    write_file(&folder.join(JSON), |out| writeln!(out, "{text}"))?;
    Ok(report)
}

/// A file's name without folder and ending.
pub(super) fn stem(path: &str) -> String {
    Path::new(path).file_stem().map_or_else(|| path.to_owned(), |s| s.to_string_lossy().into_owned())
}
