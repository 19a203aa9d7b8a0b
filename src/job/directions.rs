//! Which way a synthesised texture lies: directions at the vertices of every level.

use super::input::Steer;
use crate::field::nway::align::least_curvature;
use crate::field::nway::{NWayOptions, NWaySolver, Over, on_pyramid};
use crate::field::{FieldError, FieldOptions, TangentField, constrained, default_scale};
use crate::mesh::curvature::curvature;
use crate::mesh::nearest::Nearest;
use crate::mesh::pyramid::Pyramid;
use crate::mesh::{Cleaned, Mesh};
use crate::progress::Progress;
use crate::synth::{Frame, combed_right, random_right};
use glam::{DVec2, DVec3};
use rayon::prelude::*;

/// Which way the texture lies.
#[derive(Debug, Clone, PartialEq)]
pub enum Direction {
    /// Another way at every vertex (WL 3.1).
    Random,
    /// As in pasting; without a direction there, the smoothest field is used.
    Steered(Steer),
}

/// Which way, and how it is found.
#[derive(Debug, Clone, Copy)]
pub(super) struct Way<'a> {
    pub(super) direction: &'a Direction,
    /// Also relax the paper's own error of directions.
    pub(super) nearest: bool,
    pub(super) seed: u64,
}

/// A direction of texture right at each vertex of each level.
pub(super) type Right = Vec<Vec<DVec3>>;

/// The directions over a pyramid of a mesh, and how many singularities they have on its finest level if a smooth field was made.
pub(super) fn directions(
    cleaned: &Cleaned,
    pyramid: &Pyramid,
    way: &Way,
    progress: &dyn Progress,
) -> Result<(Right, Option<usize>), FieldError> {
    let mesh = &cleaned.mesh;
    let relaxed = |n: u32| {
        let options = NWayOptions { nearest: way.nearest, seed: way.seed, ..NWayOptions::default() };
        let fields = on_pyramid(pyramid, n, &options, progress);
        let right = fields.tables.iter().zip(&fields.fields).map(|(t, f)| combed_right(t, f)).collect();
        (right, fields.statistics.first().map(|s| s.singularities))
    };
    let up = |axis: DVec3| {
        let level = |mesh: &Mesh| mesh.vertex_normals().iter().map(|n| axis.cross(n.as_dvec3())).collect();
        pyramid.levels.iter().map(|l| level(&l.mesh)).collect()
    };
    Ok(match way.direction {
        Direction::Random => (random_right(pyramid, way.seed), None),
        Direction::Steered(Steer::Isotropic(_)) => relaxed(1),
        Direction::Steered(Steer::Relaxed(n)) => relaxed(*n),
        Direction::Steered(Steer::Up(axis)) => (up(*axis), None),
        Direction::Steered(Steer::Curvature) => {
            let level = |mesh: &Mesh| {
                let solver = NWaySolver::new(mesh, Over::Vertices, 2);
                let mut wishes = vec![DVec2::ZERO; mesh.vertex_count()];
                least_curvature(mesh, &solver.table, 2, &mut wishes, &curvature(mesh), 1.0);
                combed_right(&solver.table, &solver.solve(&wishes, &NWayOptions::default(), progress).0)
            };
            (pyramid.levels.iter().map(|l| level(&l.mesh)).collect(), None)
        }
        Direction::Steered(Steer::Constraints(constraints, axis)) => {
            let scale = default_scale(mesh, crate::field::DEFAULT_RATIO, 1.0);
            let axis = constraints.axis(*axis);
            let anchors = constraints.anchors(mesh, Some(&cleaned.user_faces), axis, scale)?;
            let options = FieldOptions { scale, axis, base_weight: constraints.base_weight, ..FieldOptions::default() };
            (carried(mesh, &constrained(mesh, &anchors, &options)?.0, pyramid), None)
        }
        Direction::Steered(Steer::Field(text)) => (carried(mesh, &TangentField::from_json(mesh, text)?, pyramid), None),
    })
}

/// A field on the mesh's faces, smoothed over its vertices, read at the vertices of every level.
fn carried(mesh: &Mesh, field: &TangentField, pyramid: &Pyramid) -> Right {
    let mut up = vec![DVec3::ZERO; mesh.vertex_count()];
    for (f, corners) in mesh.faces.iter().enumerate() {
        let direction = field.up[f].as_dvec3().normalize_or_zero() * mesh.area(f as u32);
        corners.iter().for_each(|&v| up[v as usize] += direction);
    }
    let tree = Nearest::new(mesh);
    let level = |level: &Mesh| {
        let normals = level.vertex_normals();
        let one = |v: usize| {
            let Some(hit) = tree.nearest(level.point(v as u32)) else { return DVec3::X };
            let corners = mesh.faces[hit.at.face as usize];
            let mean: DVec3 = (0..3).map(|k| up[corners[k] as usize].normalize_or_zero() * f64::from(hit.at.bary[k])).sum();
            // Where they cancel, at a singularity, the face's own direction is as good as any.
            let up = if mean.length() > 0.1 { mean } else { field.up[hit.at.face as usize].as_dvec3() };
            Frame::new(normals[v].as_dvec3(), up.cross(normals[v].as_dvec3())).right
        };
        (0..level.vertex_count()).into_par_iter().map(one).collect()
    };
    pyramid.levels.iter().map(|l| level(&l.mesh)).collect()
}
