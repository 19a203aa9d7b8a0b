//! The demo assets: every mesh and every exemplar, made from formulas and noise.

mod animals;
mod crafts;
mod creature;
mod gear;
mod masonry;
mod noise;
mod plants;
mod portable;
mod relief;
mod remesh;
mod sdf;
mod solids;
mod write;

use glam::DVec3;
use image::ImageError;
use relief::Pictures;

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

/// An exemplar asset: its name, which pictures belong to it, and how it is made.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ExemplarAsset {
    /// First part of the file names.
    pub(crate) name: &'static str,
    /// With normal and height pictures beside the colour.
    pub(crate) relief: bool,
    /// Makes it.
    pub(crate) make: fn() -> Pictures,
}

impl ExemplarAsset {
    /// File names below `exemplars/` and bytes of the files.
    ///
    /// # Errors
    /// If a picture cannot be encoded.
    pub(crate) fn files(&self) -> Result<Vec<(String, Vec<u8>)>, ImageError> {
        let pictures = (self.make)();
        let mut parts = vec![("color", &pictures.color, 3)];
        if self.relief {
            parts.extend([("normal", &pictures.normal, 3), ("height", &pictures.height, 1)]);
        }
        let file = |(part, pixels, components): (&str, &Vec<u8>, usize)| {
            Ok((format!("{}_{part}.png", self.name), write::png(pixels, pictures.size, components)?))
        };
        parts.into_iter().map(file).collect()
    }
}

/// All exemplars.
pub(crate) const EXEMPLARS: &[ExemplarAsset] = &[
    ExemplarAsset { name: "bricks", relief: true, make: masonry::bricks },
    ExemplarAsset { name: "scales", relief: true, make: animals::scales },
    ExemplarAsset { name: "fur", relief: false, make: animals::fur },
    ExemplarAsset { name: "pebbles", relief: true, make: masonry::pebbles },
    ExemplarAsset { name: "stripes", relief: false, make: crafts::stripes },
    ExemplarAsset { name: "leaves", relief: false, make: plants::leaves },
    ExemplarAsset { name: "wood", relief: false, make: plants::wood },
    ExemplarAsset { name: "weave", relief: true, make: crafts::weave },
    ExemplarAsset { name: "rust", relief: false, make: crafts::rust },
    ExemplarAsset { name: "stone", relief: true, make: masonry::stone },
    ExemplarAsset { name: "moss", relief: false, make: animals::moss },
    ExemplarAsset { name: "bark", relief: false, make: plants::bark },
];
