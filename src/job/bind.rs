//! Between the user's model and the clean mesh: results go out on the user's faces, in the user's order, and come back.

use super::moving::Moving;
use crate::field::TangentField;
use crate::format::{Model, Record};
use crate::mesh::Mesh;
use crate::mesh::clean::UserFace;
use crate::mesh::subdivide::Subdivision;
use crate::mesh::{CleanOptions, CleanReport, Cleaned, MeshError, NONE, clean};
use crate::paste::{LappedTexture, Layer, Paste};
use glam::{Vec2, Vec3};
use std::collections::BTreeMap;

/// The model to write, and for each of its faces where it lies on the mesh that was worked on.
#[derive(Debug, Clone)]
pub struct Outgoing {
    /// The user's model; faces that were subdivided are replaced by their parts, in place.
    pub model: Model,
    /// One per face of `model`.
    pub faces: Vec<UserFace>,
    /// For each face of `model` the user's face it is (part of); absent if nothing was subdivided.
    pub source_face: Option<Vec<u32>>,
}

impl Outgoing {
    /// The user's model as it came, or with the faces cut that `fine` cuts.
    #[must_use]
    pub fn new(model: &Model, cleaned: &Cleaned, fine: Option<&Subdivision>) -> Self {
        match fine.filter(|f| f.mesh.face_count() > cleaned.mesh.face_count()) {
            Some(fine) => cut(model, cleaned, fine),
            None => Self { model: model.clone(), faces: cleaned.user_faces.clone(), source_face: None },
        }
    }

    /// The pastes on the model's faces. Copies of a face get what the face they copy has.
    #[must_use]
    pub fn pastes(&self, pastes: &[Paste]) -> Vec<Paste> {
        let mesh_faces = self.faces.iter().filter(|u| u.face != NONE).map(|u| u.face as usize + 1).max().unwrap_or(0);
        let mut start = vec![0_u32; mesh_faces + 1];
        self.faces.iter().filter(|u| u.face != NONE).for_each(|u| start[u.face as usize + 1] += 1);
        for f in 0..mesh_faces {
            start[f + 1] += start[f];
        }
        let mut fill = start.clone();
        let mut users = vec![0_u32; start[mesh_faces] as usize];
        for (user, to) in self.faces.iter().enumerate().filter(|(_, u)| u.face != NONE) {
            let place = &mut fill[to.face as usize];
            users[*place as usize] = user as u32;
            *place += 1;
        }
        let outward = |paste: &Paste| {
            let (faces, uv) = (Vec::with_capacity(paste.faces.len()), Vec::with_capacity(paste.uv.len()));
            let mut out = Paste { faces, uv, cut: paste.cut.clone(), ..*paste };
            for (&face, uv) in paste.faces.iter().zip(&paste.uv) {
                for &user in &users[start[face as usize] as usize..start[face as usize + 1] as usize] {
                    out.faces.push(user);
                    out.uv.push(self.faces[user as usize].corners.map(|k| uv[k as usize]));
                }
            }
            out
        };
        pastes.iter().map(outward).collect()
    }

    /// Layers with their weights and bases on the model's faces; 0 where a face was dropped.
    #[must_use]
    pub fn layers(&self, layers: &[Layer]) -> Vec<Layer> {
        let outward = |layer: &Layer| {
            let of = |u: &UserFace| layer.weights.get(u.face as usize).map_or([0.0; 3], |w| u.corners.map(|k| w[k as usize]));
            let base_of = |u: &UserFace| layer.base.get(u.face as usize).map_or([[0; 3]; 3], |b| u.corners.map(|k| b[k as usize]));
            let weights = if layer.weights.is_empty() { Vec::new() } else { self.faces.iter().map(of).collect() };
            let base = if layer.base.is_empty() { Vec::new() } else { self.faces.iter().map(base_of).collect() };
            Layer { name: layer.name.clone(), pastes: layer.pastes, weights, base }
        };
        layers.iter().map(outward).collect()
    }

    /// A vector per mesh face as one per face of the model; zero where a face was dropped.
    #[must_use]
    pub fn per_face(&self, values: &[Vec3]) -> Vec<Vec3> {
        self.faces.iter().map(|u| if u.face == NONE { Vec3::ZERO } else { values[u.face as usize] }).collect()
    }
}

/// Replaces cut faces by their parts. A new vertex takes its attributes from the face it lies on.
fn cut(model: &Model, cleaned: &Cleaned, fine: &Subdivision) -> Outgoing {
    let mut out = Model { faces: Vec::new(), polygons: model.polygons.as_ref().map(|_| Vec::new()), ..model.clone() };
    let (mut faces, mut source_face) = (Vec::new(), Vec::new());
    let mut first_of = Vec::with_capacity(model.faces.len() + 1);
    for (user, (corners, to)) in model.faces.iter().zip(&cleaned.user_faces).enumerate() {
        first_of.push(out.faces.len() as u32);
        let children = match to.face {
            NONE => 0..0,
            face => fine.parent.partition_point(|&p| p < face)..fine.parent.partition_point(|&p| p <= face),
        };
        if children.len() <= 1 {
            out.faces.push(*corners);
            faces.push(UserFace { face: children.clone().next().map_or(NONE, |c| c as u32), ..*to });
        } else {
            // The user's corner at each corner of the mesh face.
            let mut at = [0; 3];
            (0..3).for_each(|k| at[to.corners[k] as usize] = k);
            let mut made: BTreeMap<u32, u32> = BTreeMap::new();
            for child in children {
                let place = |k: usize| {
                    let bary = fine.corners[child][k];
                    let bary = Vec3::new(bary[to.corners[0] as usize], bary[to.corners[1] as usize], bary[to.corners[2] as usize]);
                    match (0..3).find(|&j| bary[j] == 1.0) {
                        Some(j) => corners[j],
                        None => {
                            let vertex = fine.mesh.faces[child][k];
                            let position = fine.mesh.positions[vertex as usize];
                            *made.entry(vertex).or_insert_with(|| add_vertex(&mut out, position, *corners, bary))
                        }
                    }
                };
                // The child in the winding of the user's face.
                let mut place = place;
                let mine = [0, 1, 2].map(&mut place);
                let order = if winding(to.corners) { [0, 1, 2] } else { [0, 2, 1] };
                out.faces.push(order.map(|k| mine[k as usize]));
                faces.push(UserFace { face: child as u32, corners: order });
            }
        }
        while source_face.len() < out.faces.len() {
            source_face.push(user as u32);
            if let (Some(to), Some(from)) = (&mut out.polygons, &model.polygons) {
                to.push(from[user]);
            }
        }
    }
    first_of.push(out.faces.len() as u32);
    for group in &mut out.groups {
        let (start, end) = (group.start as usize, (group.start + group.count) as usize);
        group.start = first_of[start];
        group.count = first_of[end] - first_of[start];
    }
    Outgoing { model: out, faces, source_face: Some(source_face) }
}

/// True if the permutation of corners is even: the user's face and the mesh's run the same way.
fn winding(corners: [u8; 3]) -> bool {
    matches!(corners, [0, 1, 2] | [1, 2, 0] | [2, 0, 1])
}

fn add_vertex(model: &mut Model, position: Vec3, corners: [u32; 3], bary: Vec3) -> u32 {
    let [a, b, c] = corners.map(|v| v as usize);
    let index = model.positions.len() as u32;
    model.positions.push(position);
    if let Some(n) = &mut model.normals {
        n.push((n[a] * bary.x + n[b] * bary.y + n[c] * bary.z).normalize_or(n[a]));
    }
    if let Some(t) = &mut model.uvs {
        t.push(t[a] * bary.x + t[b] * bary.y + t[c] * bary.z);
    }
    if let Some(motion) = &mut model.motion {
        motion.add_vertex(corners, bary);
    }
    if let Some(colour) = &mut model.colors {
        colour.push(colour[a] * bary.x + colour[b] * bary.y + colour[c] * bary.z);
    }
    index
}

/// Something at the corners of the model's faces as it is at those of the mesh's; `first` says which of the model's stands for each.
fn corners_inward<T: Copy + Default>(values: &[[T; 3]], first: &[u32], user_faces: &[UserFace]) -> Vec<[T; 3]> {
    if values.is_empty() {
        return Vec::new();
    }
    let of = |&user: &u32| {
        let mut mine = [T::default(); 3];
        (0..3).for_each(|k| mine[user_faces[user as usize].corners[k] as usize] = values[user as usize][k]);
        mine
    };
    first.iter().map(of).collect()
}

/// A record's lapped texture on the clean mesh of its model.
#[derive(Debug, Clone)]
pub struct Bound {
    /// The mesh.
    pub mesh: Mesh,
    /// The lapped texture; its pastes are on the mesh's faces.
    pub lapped: LappedTexture,
    /// The tangent field on the mesh's faces, if the record has one.
    pub field: Option<TangentField>,
    /// How the mesh moves, if it does.
    pub moving: Option<Moving>,
    /// What cleaning did to the model.
    pub report: CleanReport,
    /// Where each face of the model went.
    pub user_faces: Vec<UserFace>,
}

impl Bound {
    /// Cleans the record's model and carries its pastes over.
    ///
    /// # Errors
    /// If the model is no mesh at all.
    pub fn new(record: Record) -> Result<Self, MeshError> {
        let Record { model, lapped, field, .. } = record;
        let cleaned = clean(&model.positions, &model.faces, &CleanOptions::default())?;
        let moving = Moving::new(&model, &cleaned)?;
        let Cleaned { mesh, user_faces, report, .. } = cleaned;
        // Of several copies of a face the first brings what lies on it.
        let mut first = vec![NONE; mesh.face_count()];
        for (user, to) in user_faces.iter().enumerate().rev() {
            if to.face != NONE {
                first[to.face as usize] = user as u32;
            }
        }
        let inward = |paste: Paste| {
            let mut out = Paste { faces: Vec::with_capacity(paste.faces.len()), uv: Vec::with_capacity(paste.uv.len()), ..paste };
            for (&user, uv) in paste.faces.iter().zip(&paste.uv) {
                let to = user_faces[user as usize];
                if to.face != NONE && first[to.face as usize] == user {
                    let mut mine = [Vec2::ZERO; 3];
                    (0..3).for_each(|k| mine[to.corners[k] as usize] = uv[k]);
                    out.faces.push(to.face);
                    out.uv.push(mine);
                }
            }
            out
        };
        let layer_inward = |layer: Layer| Layer {
            weights: corners_inward(&layer.weights, &first, &user_faces),
            base: corners_inward(&layer.base, &first, &user_faces),
            ..layer
        };
        let LappedTexture { exemplars, patches, pastes, layers } = lapped;
        let layers = layers.into_iter().map(layer_inward).collect();
        let lapped = LappedTexture { exemplars, patches, pastes: pastes.into_iter().map(inward).collect(), layers };
        let field = field.map(|f| TangentField::along(first.iter().map(|&user| f[user as usize]).collect()));
        Ok(Self { mesh, lapped, field, moving, report, user_faces })
    }
}
