//! The demo assets: every mesh and every exemplar, made from formulas and noise.

mod creature;
mod gear;
#[allow(dead_code)]
mod noise;
#[allow(dead_code)]
mod portable;
mod remesh;
mod sdf;
mod solids;
#[allow(dead_code)]
mod write;

use glam::DVec3;

/// Positions and triangles, counter-clockwise from outside.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Triangles {
    /// World units.
    pub(crate) positions: Vec<DVec3>,
    /// Three vertices each.
    pub(crate) faces: Vec<[u32; 3]>,
}

/// A mesh asset: its file name and how it is made.
#[derive(Debug, Clone, Copy)]
pub(crate) struct MeshAsset {
    /// File name below `meshes/`; its ending says the format.
    pub(crate) file: &'static str,
    /// Makes it.
    pub(crate) make: fn() -> Triangles,
}

impl MeshAsset {
    /// The bytes of the file.
    pub(crate) fn bytes(&self) -> Vec<u8> {
        let mesh = (self.make)();
        if self.file.ends_with(".obj") { write::obj(&mesh) } else { write::ply(&mesh) }
    }
}

/// All meshes.
pub(crate) const MESHES: &[MeshAsset] = &[
    MeshAsset { file: "dragonling.ply", make: creature::coarse },
    MeshAsset { file: "dragonling_25k.ply", make: creature::fine },
    MeshAsset { file: "knot.ply", make: solids::knot },
    MeshAsset { file: "gear.ply", make: gear::gear },
    MeshAsset { file: "vase.obj", make: solids::vase },
    MeshAsset { file: "vase.ply", make: solids::vase },
    MeshAsset { file: "terrain.ply", make: solids::terrain },
];
