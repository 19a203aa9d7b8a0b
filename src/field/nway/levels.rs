//! Relaxation over a pyramid of meshes, as Wei and Levoy do it: from the coarsest level, where it starts, to the finest, each
//! level from what the one above it says at its vertices' parents.

use super::connection::{Connection, unit};
use super::{NWayField, NWayOptions, NWaySolver, NWayStatistics, Over, Start, random};
use crate::mesh::pyramid::{Parent, Pyramid};
use crate::mesh::transport::turned;
use crate::progress::Progress;
use glam::DVec2;
use rayon::prelude::*;

/// A field over the vertices of each level, the finest first.
#[derive(Debug, Clone)]
pub struct LevelFields {
    /// The fields.
    pub fields: Vec<NWayField>,
    /// What each is measured against.
    pub tables: Vec<Connection>,
    /// What was done on each level.
    pub statistics: Vec<NWayStatistics>,
}

/// Relaxes an n-way field over the vertices of all levels.
#[must_use]
pub fn on_pyramid(pyramid: &Pyramid, n: u32, options: &NWayOptions, progress: &dyn Progress) -> LevelFields {
    let mut out = LevelFields { fields: Vec::new(), tables: Vec::new(), statistics: Vec::new() };
    let mut above: Option<(NWaySolver, NWayField)> = None;
    for (level, made) in pyramid.levels.iter().enumerate().rev() {
        let solver = NWaySolver::new(&made.mesh, Over::Vertices, n);
        let mut statistics = NWayStatistics::default();
        let mut powers = match &above {
            Some((coarse, field)) => interpolated(pyramid, level, &solver, coarse, field),
            None if options.start == Start::Smooth => solver.smooth_start(&[], &mut statistics.iterations),
            None => random(solver.table.len(), options.seed),
        };
        progress.stage("relaxing directions", 0);
        solver.relax(&mut powers, &[], options, &mut statistics);
        let field = NWayField { n: solver.n, over: Over::Vertices, powers };
        let found = solver.singularities(&field);
        statistics.singularities = found.len();
        statistics.index_sum = found.iter().map(|s| i64::from(s.parts)).sum();
        out.statistics.push(statistics);
        if let Some((solver, field)) = above.replace((solver, field)) {
            out.tables.push(solver.table);
            out.fields.push(field);
        }
    }
    if let Some((solver, field)) = above {
        out.tables.push(solver.table);
        out.fields.push(field);
    }
    out.fields.reverse();
    out.tables.reverse();
    out.statistics.reverse();
    out
}

/// The mean of the n-th powers at the corners of each vertex's parent face.
fn interpolated(pyramid: &Pyramid, level: usize, fine: &NWaySolver, coarse: &NWaySolver, field: &NWayField) -> Vec<DVec2> {
    let mesh = &pyramid.levels[level + 1].mesh;
    let degree = f64::from(field.n);
    let directions = coarse.directions(field);
    let one = |(v, parent): (usize, &Parent)| {
        let mut sum = DVec2::ZERO;
        for (k, w) in mesh.faces[parent.at.face as usize].into_iter().enumerate() {
            let here = turned(directions[w as usize], coarse.table.normal[w as usize], fine.table.normal[v]);
            sum += unit(degree * fine.table.angle_of(v as u32, here)) * f64::from(parent.at.bary[k]);
        }
        sum.normalize_or(DVec2::X)
    };
    pyramid.parents[level].par_iter().enumerate().map(one).collect()
}
