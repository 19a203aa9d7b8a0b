//! Finding the place of the exemplar whose neighbourhood fits best.

mod exhaustive;
mod fast;
mod tsvq;

pub(super) use exhaustive::Whole;
pub(super) use fast::{Fast, KEPT};
pub(super) use tsvq::Tsvq;

use crate::numeric::rows::Rows;
use serde::Serialize;

/// How to search.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum SearchKind {
    /// Every candidate is looked at.
    Exhaustive,
    /// Tree-structured vector quantization (Wei, Levoy, "Fast texture synthesis using tree-structured vector quantization",
    /// SIGGRAPH 2000).
    Tsvq,
    /// Continuations of what the neighbours show, against the best of a few leaves of a tree over principal components.
    #[default]
    Fast,
}

/// Candidates that continue what lies around each query.
#[derive(Debug, Clone, Default)]
pub(super) struct Nearby {
    /// One past the last of each query.
    pub(super) ends: Vec<u32>,
    /// What each blends.
    pub(super) between: Vec<Between>,
}

/// A place between four candidates: their rows, and each one's share.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Between {
    pub(super) rows: [u32; 4],
    pub(super) shares: [f32; 4],
}

impl Between {
    /// A place that is a candidate's own.
    pub(super) const fn at(row: u32) -> Self {
        Self { rows: [row; 4], shares: [1.0, 0.0, 0.0, 0.0] }
    }
}

impl Nearby {
    pub(super) fn range(&self, query: usize) -> std::ops::Range<usize> {
        let start = if query == 0 { 0 } else { self.ends[query - 1] as usize };
        start..self.ends[query] as usize
    }
}

/// What was chosen for a query.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Choice {
    /// A row.
    Row(u32),
    /// One of the nearby candidates, counted over all queries.
    Nearby(u32),
}

/// A way to choose.
pub(super) trait Search: Sync {
    /// True if it looks at nearby candidates.
    fn wants_nearby(&self) -> bool {
        false
    }

    /// Chooses for each query.
    fn choose(&self, queries: &Rows, nearby: &Nearby) -> Vec<Choice>;
}
