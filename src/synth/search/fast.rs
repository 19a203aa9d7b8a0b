//! The search that is fast and good: continuations against a tree over principal components.
//!
//! Based on: Ashikhmin, "Synthesizing natural textures", I3D 2001 (a neighbour's place, moved by the way from there to here, is a
//! candidate), and the choice between it and the nearest neighbour in Hertzmann et al., "Image analogies", SIGGRAPH 2001, sec. 3.2.
//!
//! 1. Neighbourhoods are projected on their principal components.
//! 2. The best of the continuations is known by a handful of distances.
//! 3. A kd-tree gives the best candidate of a few leaves, nearest leaves first (Arya, Mount 1993): exact search in so many
//!    dimensions would look at nearly all of them.
//! 4. The continuation is taken unless it fits worse by more than a factor. The nearest of all is also the blurriest: it
//!    drifts to flat parts of the exemplar, and neighbours that each found their own do not continue one another.

use super::{Choice, Nearby, Search};
use crate::numeric::kd::KdTree;
use crate::numeric::pca::Pca;
use crate::numeric::rows::{Rows, distance_squared};
use pulp::Arch;

/// Principal components kept.
pub(in super::super) const KEPT: usize = 24;
/// Leaves of the tree that are looked at.
const LEAVES: usize = 8;

/// A continuation may have this many times the squared distance of the best match.
const PREFERENCE: f32 = 2.0;

/// Projected candidates and their tree.
pub(in super::super) struct Fast {
    pca: Pca,
    rows: Rows,
    tree: KdTree,
}

impl Fast {
    /// From a projection and the projected rows of all candidates.
    pub(in super::super) fn new(pca: Pca, rows: Rows) -> Self {
        let tree = KdTree::new(&rows);
        Self { pca, rows, tree }
    }
}

impl Search for Fast {
    fn wants_nearby(&self) -> bool {
        true
    }

    fn choose(&self, queries: &Rows, nearby: &Nearby) -> Vec<Choice> {
        let mut point = vec![0.0; self.pca.kept()];
        let mut between = point.clone();
        let mut finder = self.tree.finder();
        // The loops below are compiled for the widest registers only inside of what is dispatched.
        let all = || {
            let mut choices = Vec::with_capacity(queries.len());
            for (q, query) in queries.iter().enumerate() {
                self.pca.project(query, &mut point);
                let mut best = (f32::INFINITY, 0_u32);
                for k in nearby.range(q) {
                    // Neighbourhoods between pixels are what bilinear sampling makes of the image, and all here is linear.
                    between.fill(0.0);
                    for (row, share) in nearby.between[k].rows.into_iter().zip(nearby.between[k].shares).filter(|(_, s)| *s > 0.0) {
                        between.iter_mut().zip(self.rows.row(row as usize)).for_each(|(b, &x)| *b += share * x);
                    }
                    let squared = distance_squared(&point, &between);
                    if squared < best.0 {
                        best = (squared, k as u32);
                    }
                }
                // Only a row that is nearer by the factor can be preferred, and most of the tree is farther than that.
                choices.push(match finder.nearest(&point, LEAVES, best.0 / PREFERENCE) {
                    Some((row, _)) => Choice::Row(row),
                    None if best.0 < f32::INFINITY => Choice::Nearby(best.1),
                    // Distances that are no numbers, from channels that hold none, leave nothing to choose by.
                    None => Choice::Row(0),
                });
            }
            choices
        };
        Arch::new().dispatch(all)
    }
}
