//! GLB to record. Every index, length and offset is checked; mip chains are built anew.

use super::{EXTENSION, Record, VERSION};
use crate::exemplar::{Channel, Exemplar, FramesBy, Hull, Image, MipChain, TexturePatch, Wrap};
use crate::format::error::Problem;
use crate::format::gltf::accessor::Data;
use crate::format::gltf::document::Document;
use crate::format::gltf::motion::{Part, Tree, read_motion};
use crate::format::gltf::scene_out::OWN_COLOR;
use crate::format::gltf::{glb, scene, uri};
use crate::format::model::{FaceGroup, Model, Source};
use crate::format::picture::{MOST_PIXELS, Transfer, decode, too_large};
use crate::format::{FormatError, read_file};
use crate::paste::cut::CUT_STEPS;
use crate::paste::{AGREES, BaseColor, Cut, LappedTexture, Layer, Paste, Turn};
use glam::{Vec2, Vec3, Vec4};
use image::ImageFormat;
use serde::Deserialize;
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::Path;

/// Reads a record that [`super::write_record`] wrote.
///
/// # Errors
/// If the file cannot be read, is no record, or contradicts itself anywhere.
pub fn read_record(path: &Path) -> Result<Record, FormatError> {
    read_record_bytes(path, &read_file(path, "the GLB file")?)
}

/// Reads a record from the bytes of a file; `path` is for messages and for buffers beside it.
///
/// # Errors
/// As [`read_record`].
pub fn read_record_bytes(path: &Path, file: &[u8]) -> Result<Record, FormatError> {
    if file.is_empty() {
        return Err(FormatError::Empty { path: path.to_owned() });
    }
    parse(file, path.parent()).map_err(|problem| FormatError::malformed(path, problem))
}

/// True if a file is glTF and holds a lapped texture; says nothing of whether that is sound.
#[must_use]
pub fn holds_record(file: &[u8]) -> bool {
    let json = if glb::is_glb(file) { glb::split(file).map(|(json, _)| json).ok() } else { Some(file) };
    let document = json.filter(|j| j.trim_ascii_start().starts_with(b"{")).and_then(|j| Document::parse(j).ok());
    document.is_some_and(|d| d.extensions.contains_key(EXTENSION))
}

/// The extension as it stands in the JSON.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
struct Extension {
    version: u64,
    mesh: usize,
    primitive: usize,
    field: Option<usize>,
    source_face: Option<usize>,
    #[serde(default)]
    model: ModelExtras,
    exemplars: Vec<ExemplarEntry>,
    patches: Vec<PatchEntry>,
    pastes: PasteTables,
    #[serde(default)]
    layers: Vec<LayerEntry>,
    #[serde(default)]
    baked: bool,
    #[serde(default)]
    job: Value,
}

#[derive(Debug, Deserialize)]
struct LayerEntry {
    #[serde(default)]
    name: String,
    pastes: u32,
    weight: Option<usize>,
    base: Option<usize>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
struct ModelExtras {
    name: String,
    groups: Vec<FaceGroup>,
    source: Source,
    polygon: Option<usize>,
}

#[derive(Debug, Deserialize)]
struct ExemplarEntry {
    #[serde(default)]
    name: String,
    images: BTreeMap<String, usize>,
    size: [u32; 2],
    #[serde(default)]
    wrap: Wrap,
    frames: Option<FramesEntry>,
}

#[derive(Debug, Deserialize)]
struct FramesEntry {
    by: FramesBy,
    #[serde(default)]
    seconds: Vec<f64>,
    images: Vec<BTreeMap<String, usize>>,
}

#[derive(Debug, Deserialize)]
struct PatchEntry {
    exemplar: u16,
    mask: usize,
    origin: [i32; 2],
    size: [u32; 2],
    hull: Vec<f64>,
    centre: [f64; 2],
    weight: f64,
    #[serde(default)]
    slides: bool,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
struct PasteTables {
    count: usize,
    patch: Option<usize>,
    face_offset: Option<usize>,
    face: Option<usize>,
    uv: Option<usize>,
    offset: Option<usize>,
    turn: Option<usize>,
    cut: Option<usize>,
    agreement: Option<usize>,
}

fn parse(file: &[u8], folder: Option<&Path>) -> Result<Record, Problem> {
    let remedy = "name a GLB that `lapped paste` wrote";
    let (json, bin) = if glb::is_glb(file) {
        glb::split(file)?
    } else if file.trim_ascii_start().starts_with(b"{") {
        (file, None)
    } else {
        return Err(Problem::new("", "this is no glTF file, so it holds no lapped texture", remedy));
    };
    let mut document = Document::parse(json)?;
    let Some(extension) = document.extensions.remove(EXTENSION) else {
        return Err(Problem::new("", "the file holds a mesh but no lapped texture", remedy));
    };
    let version = extension.get("version").and_then(Value::as_u64);
    if version != Some(VERSION) {
        let what = format!("the lapped texture has version {}, only {VERSION} is read", extension["version"]);
        return Err(Problem::new(EXTENSION, what, "use the release of lapped that wrote it, or paste again"));
    }
    let extension: Extension = serde_json::from_value(extension).map_err(|e| Problem::damaged(EXTENSION, e.to_string()))?;
    let buffers = uri::load_buffers(&document, bin, folder)?;
    let data = Data { document: &document, buffers: &buffers };
    let model = read_model(&data, &extension)?;
    let exemplars = extension.exemplars.iter().enumerate().map(|(k, e)| read_exemplar(&data, k, e)).collect::<Result<_, _>>()?;
    let patches = extension.patches.iter().enumerate().map(|(k, p)| read_patch(&data, k, p)).collect::<Result<_, _>>()?;
    let pastes = read_pastes(&data, &extension.pastes)?;
    let layers = extension.layers.into_iter().map(|l| read_layer(&data, l)).collect::<Result<_, _>>()?;
    let vectors = |a: usize| Ok(data.floats::<3>(a)?.into_iter().map(Vec3::from_array).collect());
    let record = Record {
        model,
        lapped: LappedTexture { exemplars, patches, pastes, layers },
        field: extension.field.map(vectors).transpose()?,
        source_face: extension.source_face.map(|a| data.indices(a)).transpose()?,
        generator: document.asset.generator.clone().unwrap_or_default(),
        job: extension.job,
        look: None,
    };
    debug_assert_eq!(extension.version, VERSION, "checked above");
    record.check().map_err(|(place, what)| Problem::damaged(place, what))?;
    Ok(record)
}

fn read_model(data: &Data<'_>, extension: &Extension) -> Result<Model, Problem> {
    let place = format!("mesh {}, primitive {}", extension.mesh, extension.primitive);
    let primitive = data.document.meshes.get(extension.mesh).and_then(|m| m.primitives.get(extension.primitive));
    let primitive = primitive.ok_or_else(|| Problem::damaged(&place, "it does not exist"))?;
    let mut vertices = scene::read_vertices(data, primitive, &place)?;
    if extension.baked {
        // The first coordinates are the atlas's; the user's own stand second.
        let own = |name: &str| primitive.attributes.get(name).copied();
        vertices.uvs = own("TEXCOORD_1").map(|a| data.floats::<2>(a)).transpose()?;
        vertices.colors = own(OWN_COLOR).map(|a| data.floats::<4>(a)).transpose()?;
    }
    let faces = scene::read_triangles(data, primitive, vertices.positions.len(), &place)?;
    let extras = &extension.model;
    let mut source = extras.source.clone();
    let vertex_count = vertices.positions.len();
    let part = |node| Part {
        node,
        mesh: extension.mesh,
        primitive: extension.primitive,
        vertices: 0..vertex_count,
        to_model: glam::DMat4::IDENTITY,
    };
    // A look of several pages is shown by another mesh, on the same vertices.
    let nodes = &data.document.nodes;
    let node = nodes.iter().position(|n| n.mesh == Some(extension.mesh)).or_else(|| nodes.iter().position(|n| n.mesh.is_some()));
    let parts: Vec<Part> = node.map(part).into_iter().collect();
    let motion = match parts[..] {
        [] => None,
        _ => read_motion(data, &Tree::new(data.document), &parts, vertex_count, &mut source.notes)?,
    };
    Ok(Model {
        name: extras.name.clone(),
        positions: vertices.positions.into_iter().map(Vec3::from_array).collect(),
        faces: faces.ok_or_else(|| Problem::damaged(&place, "it is not made of triangles"))?,
        normals: vertices.normals.map(|n| n.into_iter().map(Vec3::from_array).collect()),
        uvs: vertices.uvs.map(|t| t.into_iter().map(Vec2::from_array).collect()),
        colors: vertices.colors.map(|c| c.into_iter().map(Vec4::from_array).collect()),
        groups: extras.groups.clone(),
        polygons: extras.polygon.map(|a| data.indices(a)).transpose()?,
        motion,
        source,
    })
}

fn read_image(data: &Data<'_>, texture: usize, transfer: Transfer, place: &str) -> Result<Image, Problem> {
    let document = data.document;
    let source = document.textures.get(texture).and_then(|t| t.source).and_then(|s| document.images.get(s));
    let view =
        source.and_then(|i| i.buffer_view).ok_or_else(|| Problem::damaged(place, format!("texture {texture} has no image")))?;
    let picture = decode(data.view(view)?, Some(ImageFormat::Png), transfer);
    Ok(picture.map_err(|p| Problem { place: place.to_owned(), ..p })?.image)
}

fn sized(image: &Image, size: [u32; 2], components: usize, place: &str) -> Result<(), Problem> {
    if image.size() == size && image.components() == components {
        return Ok(());
    }
    let [w, h] = image.size();
    let what = format!("its image has {w} x {h} pixels of {}, not {} x {} of {components}", image.components(), size[0], size[1]);
    Err(Problem::damaged(place, what))
}

fn read_exemplar(data: &Data<'_>, index: usize, entry: &ExemplarEntry) -> Result<Exemplar, Problem> {
    let place = format!("exemplar {index}");
    let mut exemplar = read_frame(data, &place, entry, &entry.images, None)?;
    if let Some(frames) = &entry.frames {
        // One small image may be named by many frames, and is decoded for each.
        let area = exemplar.size().map(u64::from).iter().product::<u64>();
        let count = frames.images.len() + 1;
        if area.saturating_mul(count as u64) > MOST_PIXELS {
            return Err(Problem { place, ..too_large(&format!("has {count} frames of {} x {}", entry.size[0], entry.size[1])) });
        }
        let other = |(k, images)| read_frame(data, &format!("{place}, frame {}", k + 2), entry, images, Some(&exemplar));
        let others = frames.images.iter().enumerate().map(other).collect::<Result<_, _>>()?;
        let set = exemplar.set_frames(frames.by, others, frames.seconds.clone());
        set.map_err(|e| Problem::damaged(&place, e.to_string()))?;
    }
    Ok(exemplar)
}

/// One frame of an exemplar: images by the names of their channels. Those that are missing are the first frame's.
fn read_frame(
    data: &Data<'_>,
    place: &str,
    entry: &ExemplarEntry,
    images: &BTreeMap<String, usize>,
    first: Option<&Exemplar>,
) -> Result<Exemplar, Problem> {
    let load = |channel: Channel| -> Result<Option<Image>, Problem> {
        let Some(&texture) = images.get(channel.name()) else { return Ok(None) };
        let place = format!("{place}, {}", channel.name());
        let image = read_image(data, texture, Transfer::of(channel), &place)?;
        sized(&image, entry.size, channel.components(), &place)?;
        Ok(Some(image))
    };
    let missing = || Problem::damaged(place, "it has no base colour");
    let mut exemplar = match first {
        Some(first) => first.clone(),
        None => Exemplar::new(entry.name.clone(), load(Channel::BaseColor)?.ok_or_else(missing)?),
    };
    exemplar.wrap = entry.wrap;
    for channel in Channel::ALL.into_iter().filter(|&c| first.is_some() || c != Channel::BaseColor) {
        if let Some(image) = load(channel)? {
            exemplar.set(channel, image).map_err(|e| Problem::damaged(place, e.to_string()))?;
        }
    }
    Ok(exemplar)
}

fn read_patch(data: &Data<'_>, index: usize, entry: &PatchEntry) -> Result<TexturePatch, Problem> {
    let place = format!("patch {index}");
    let mask = read_image(data, entry.mask, Transfer::Linear, &place)?;
    sized(&mask, entry.size, 1, &place)?;
    let point = |p: [f64; 2]| Vec2::new(p[0] as f32, p[1] as f32);
    let (pairs, rest) = entry.hull.as_chunks::<2>();
    if !rest.is_empty() {
        return Err(Problem::damaged(place, "its hull has half a point"));
    }
    Ok(TexturePatch {
        exemplar: entry.exemplar,
        origin: entry.origin,
        mask: MipChain::mask(mask),
        hull: Hull::new(pairs.iter().map(|&p| point(p)).collect()),
        centre: point(entry.centre),
        weight: entry.weight as f32,
        slides: entry.slides,
    })
}

fn read_layer(data: &Data<'_>, entry: LayerEntry) -> Result<Layer, Problem> {
    let weights = entry.weight.map_or(Ok(Vec::new()), |a| data.floats::<1>(a))?;
    let (corners, rest) = weights.as_flattened().as_chunks::<3>();
    if !rest.is_empty() {
        return Err(Problem::damaged("layers", "a layer's weights are not three a face"));
    }
    let base = entry.base.map_or(Ok(Vec::new()), |a| data.indices(a))?;
    let (faces, rest) = base.as_chunks::<9>();
    let colour = |k: u32| u16::try_from(k).map_err(|_| Problem::damaged("layers", "a layer's base is not of 16 bits"));
    if !rest.is_empty() {
        return Err(Problem::damaged("layers", "a layer's base is not nine numbers a face"));
    }
    let of_face = |face: &[u32; 9]| -> Result<[BaseColor; 3], Problem> {
        let mut corners = [[0; 3]; 3];
        for (to, &from) in corners.as_flattened_mut().iter_mut().zip(face) {
            *to = colour(from)?;
        }
        Ok(corners)
    };
    let base = faces.iter().map(of_face).collect::<Result<_, _>>()?;
    Ok(Layer { name: entry.name, pastes: entry.pastes, weights: corners.to_vec(), base })
}

/// A cut, unless it leaves the mask whole.
fn read_cut(steps: &[u32; CUT_STEPS]) -> Option<Box<Cut>> {
    let cut = Cut::from_steps(steps.map(|step| [step as u8, (step >> 8) as u8]));
    (!cut.is_whole()).then(|| Box::new(cut))
}

fn read_pastes(data: &Data<'_>, tables: &PasteTables) -> Result<Vec<Paste>, Problem> {
    let indices = |a: Option<usize>| a.map_or(Ok(Vec::new()), |a| data.indices(a));
    let vectors = |a: Option<usize>| a.map_or(Ok(Vec::new()), |a| data.floats::<2>(a));
    let patch = indices(tables.patch)?;
    let ends = indices(tables.face_offset)?;
    let face = indices(tables.face)?;
    let uv = vectors(tables.uv)?;
    let offset = vectors(tables.offset)?;
    let turn = indices(tables.turn)?;
    let cut = indices(tables.cut)?;
    let agreement = indices(tables.agreement)?;
    let count = tables.count;
    let lengths = [
        ("patch", patch.len(), count),
        ("faceOffset", ends.len(), count + usize::from(tables.face_offset.is_some() || count > 0)),
        ("uv", uv.len(), 3 * face.len()),
        ("offset", offset.len(), if tables.offset.is_some() { count } else { 0 }),
        ("turn", turn.len(), if tables.turn.is_some() { count } else { 0 }),
        ("cut", cut.len(), if tables.cut.is_some() { CUT_STEPS * count } else { 0 }),
        ("agreement", agreement.len(), if tables.agreement.is_some() { count } else { 0 }),
    ];
    if let Some((name, has, needed)) = lengths.into_iter().find(|(_, has, needed)| has != needed) {
        return Err(Problem::damaged("pastes", format!("{name} has {has} entries, not {needed}")));
    }
    let rising = ends.is_sorted() && ends.first().is_none_or(|&e| e == 0);
    if !rising || ends.last().map_or(0, |&e| e as usize) != face.len() {
        return Err(Problem::damaged("pastes", format!("faceOffset does not rise from 0 to {}", face.len())));
    }
    let corners = uv.as_chunks::<3>().0;
    let cuts = cut.as_chunks::<CUT_STEPS>().0;
    (0..count)
        .map(|k| {
            let range = ends[k] as usize..ends[k + 1] as usize;
            Ok(Paste {
                patch: u16::try_from(patch[k]).map_err(|_| Problem::damaged(format!("paste {k}"), "its patch is out of range"))?,
                faces: face[range.clone()].to_vec(),
                uv: corners[range].iter().map(|c| c.map(Vec2::from_array)).collect(),
                offset: offset.get(k).map_or(Vec2::ZERO, |&o| Vec2::from_array(o)),
                turn: turn.get(k).map_or(Turn::NONE, |&parts| Turn::new(parts)),
                cut: cuts.get(k).and_then(read_cut),
                agreement: agreement.get(k).map_or(AGREES, |&a| a.min(u32::from(AGREES)) as u8),
            })
        })
        .collect()
}
