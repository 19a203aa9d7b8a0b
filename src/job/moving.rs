//! The clean mesh of a model that moves. Its faces stay, in their order, so what is pasted on them stays in place.

use crate::format::{Model, Motion, MotionError};
use crate::mesh::clean::{UserFace, part_fans};
use crate::mesh::{CleanReport, Cleaned, Mesh, MeshError, NONE};
use glam::Vec3;

/// A mesh that moves.
#[derive(Debug, Clone)]
pub struct Moving {
    /// How the model's vertices move.
    pub motion: Motion,
    /// The model's vertices at rest.
    rest: Vec<Vec3>,
    /// The mesh, but that vertices which welding had joined are parted again where they do not move alike.
    mesh: Mesh,
    /// The model's vertex at each vertex of the mesh.
    source: Vec<u32>,
}

impl Moving {
    /// A model's clean mesh in motion; `None` if it does not move.
    ///
    /// # Errors
    /// If the mesh is none; one that was cleaned is.
    pub fn new(model: &Model, cleaned: &Cleaned) -> Result<Option<Self>, MeshError> {
        let Some(motion) = model.motion.clone() else { return Ok(None) };
        let mesh = &cleaned.mesh;
        // Of several copies of a face the first counts.
        let mut corners: Vec<Option<[u32; 3]>> = vec![None; mesh.face_count()];
        for (user, UserFace { face, corners: to }) in model.faces.iter().zip(&cleaned.user_faces) {
            if *face != NONE && corners[*face as usize].is_none() {
                let mut mine = [0; 3];
                (0..3).for_each(|k| mine[to[k] as usize] = user[k]);
                corners[*face as usize] = Some(mine);
            }
        }
        let mut source = cleaned.user_vertices.clone();
        let mut parted: Vec<Vec<u32>> = vec![Vec::new(); source.len()];
        let mut faces = mesh.faces.clone();
        for (face, users) in faces.iter_mut().zip(corners) {
            for (vertex, user) in face.iter_mut().zip(users.into_iter().flatten()) {
                let place = *vertex as usize;
                if motion.moves_alike(source[place], user) {
                    continue;
                }
                let known = parted[place].iter().copied().find(|&v| motion.moves_alike(source[v as usize], user));
                *vertex = known.unwrap_or_else(|| {
                    source.push(user);
                    parted[place].push(source.len() as u32 - 1);
                    source.len() as u32 - 1
                });
            }
        }
        let positions: Vec<Vec3> = source.iter().map(|&v| model.positions[v as usize]).collect();
        let opposite = Mesh::new(positions.clone(), faces.clone())?.opposite;
        let (mesh, from) = part_fans(&positions, faces, opposite, &mut CleanReport::default());
        let source = from.iter().map(|&v| source[v as usize]).collect();
        Ok(Some(Self { motion, rest: model.positions.clone(), mesh, source }))
    }

    /// The mesh `time` seconds into an animation, or without one as its file shows it when nothing is played.
    ///
    /// # Errors
    /// If there is no such animation, or it leads nowhere.
    pub fn at(&self, animation: Option<usize>, time: f64) -> Result<Mesh, MotionError> {
        let moved = self.motion.positions(&self.rest, animation, time)?;
        let positions = self.source.iter().map(|&v| moved[v as usize]).collect();
        Ok(Mesh { positions, ..self.mesh.clone() })
    }
}
