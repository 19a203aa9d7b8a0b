//! Every candidate is looked at: the truth that the other searches are held against.

use super::{Choice, Nearby, Search};
use crate::numeric::rows::{Exhaustive, Rows};

/// All rows.
pub(in super::super) struct Whole(Exhaustive);

impl Whole {
    pub(in super::super) fn new(rows: Rows) -> Self {
        Self(Exhaustive::new(rows))
    }
}

impl Search for Whole {
    fn choose(&self, queries: &Rows, _nearby: &Nearby) -> Vec<Choice> {
        self.0.nearest(queries).into_iter().map(|near| Choice::Row(near.row)).collect()
    }
}
