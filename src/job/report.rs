//! Figures of a job.

use super::estimate::Estimate;
use crate::field::RefineStatistics;
use crate::mesh::CleanReport;
use crate::paste::PasteStatistics;
use serde::Serialize;

/// Figures of a job.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct JobReport {
    /// What cleaning did.
    pub clean: CleanReport,
    /// World length of one exemplar width, at relative scale 1.
    pub scale: f64,
    /// Surface area over the first exemplar's area.
    pub ratio: f64,
    /// What the job was thought to take.
    pub estimate: Estimate,
    /// Faces that took their direction from neighbours, because the axis says nothing there.
    pub filled_faces: usize,
    /// What subdivision near singularities did.
    pub refine: Option<RefineStatistics>,
    /// Texture patches.
    pub patches: usize,
    /// Figures of pasting.
    pub paste: PasteStatistics,
    /// Figures of each region, if there are several.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub regions: Vec<RegionReport>,
    /// What the user should know, one sentence each.
    pub warnings: Vec<String>,
    /// Seconds of cleaning, field and patches (wall).
    pub prepare_seconds: f64,
}

/// Figures of one region.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct RegionReport {
    /// Its name.
    pub name: String,
    /// Faces on which any of it shows.
    pub faces: usize,
    /// World length of one exemplar width.
    pub scale: f64,
    /// Its area over the first exemplar's.
    pub ratio: f64,
    /// Figures of pasting.
    pub paste: PasteStatistics,
}
