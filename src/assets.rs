//! The demo meshes and exemplars, built into the program. `examples/make_assets` made them.

use crate::exemplar::{Channel, Exemplar};
use crate::format::{FormatError, Model, read_exemplar_bytes, read_model_bytes};
use std::path::Path;

macro_rules! assets {
    ($folder:literal: $($name:literal)*) => {
        &[$(($name, include_bytes!(concat!("../assets/", $folder, "/", $name)))),*]
    };
}

const MESHES: &[(&str, &[u8])] =
    assets!("meshes": "dragonling.ply" "dragonling_25k.ply" "knot.ply" "gear.ply" "vase.ply" "terrain.ply");

const EXEMPLARS: &[(&str, &[u8])] = assets!("exemplars":
    "bark_color.png" "bricks_color.png" "bricks_height.png" "bricks_normal.png" "fur_color.png" "leaves_color.png"
    "moss_color.png" "pebbles_color.png" "pebbles_height.png" "pebbles_normal.png" "rust_color.png" "scales_color.png"
    "scales_height.png" "scales_normal.png" "stone_color.png" "stone_height.png" "stone_normal.png" "stripes_color.png"
    "weave_color.png" "weave_height.png" "weave_normal.png" "wood_color.png");

/// Names of the demo meshes.
pub fn mesh_names() -> impl Iterator<Item = &'static str> {
    MESHES.iter().filter_map(|(file, _)| file.strip_suffix(".ply"))
}

/// Names of the demo exemplars.
pub fn exemplar_names() -> impl Iterator<Item = &'static str> {
    EXEMPLARS.iter().filter_map(|(file, _)| file.strip_suffix("_color.png"))
}

/// A demo mesh.
///
/// # Errors
/// If there is none of that name.
pub fn mesh(name: &str) -> Result<Model, FormatError> {
    let file = format!("{name}.ply");
    read_model_bytes(Path::new(&file), find(MESHES, &file))
}

/// A demo exemplar with all channels it has.
///
/// # Errors
/// If there is none of that name.
pub fn exemplar(name: &str) -> Result<Exemplar, FormatError> {
    let channels = [(Channel::BaseColor, "color"), (Channel::Normal, "normal"), (Channel::Height, "height")];
    let files: Vec<(Channel, String)> = channels.into_iter().map(|(c, suffix)| (c, format!("{name}_{suffix}.png"))).collect();
    let files = files.iter().map(|(c, file)| (*c, Path::new(file), find(EXEMPLARS, file)));
    read_exemplar_bytes(name, files.filter(|(c, _, bytes)| *c == Channel::BaseColor || !bytes.is_empty()))
}

/// The bytes of a file, none if there is no such file.
fn find(files: &'static [(&str, &[u8])], name: &str) -> &'static [u8] {
    files.iter().find(|(file, _)| *file == name).map_or(&[], |(_, bytes)| bytes)
}
