//! How a model looks to whoever knows nothing of pastes: texture coordinates and a page of images, or several.

use super::error::Problem;
use super::gltf::accessor::Data;
use super::gltf::document::Document;
use super::gltf::{glb, scene, uri};
use super::model::Model;
use super::picture::{Transfer, decode};
use super::pixels::{Pixels, Slot, slots};
use super::{FormatError, read_file};
use crate::exemplar::{Channel, Image};
use glam::{Vec2, Vec3, Vec4};
use serde_json::Value;
use std::path::Path;

/// A baked atlas on the vertices of a model.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Look {
    /// Texture coordinates at each vertex, 0 to 1, (0, 0) at the top left.
    pub uv: Vec<Vec2>,
    /// Unit tangents at each vertex, w the sign of the bitangent; needed where there is a normal map.
    pub tangents: Option<Vec<Vec4>>,
    /// Images of each page, colour in linear light, normals in the frames of normals and tangents.
    pub pages: Vec<Vec<(Channel, Image)>>,
    /// For each face its page; empty if there is one page.
    pub face_page: Vec<u32>,
    /// For each page its mip levels below the finest, the largest first, if they are to be kept.
    pub mips: Vec<Vec<Vec<(Channel, Image)>>>,
}

impl Look {
    /// Checks lengths and indices against a model's.
    pub(crate) fn check(&self, vertices: usize, faces: usize) -> Result<(), (String, String)> {
        let fail = |what: &str| Err(("look".to_owned(), what.to_owned()));
        if self.uv.len() != vertices || self.tangents.as_ref().is_some_and(|t| t.len() != vertices) {
            return fail("it does not have one entry a vertex");
        }
        if self.uv.iter().any(|t| !t.is_finite()) {
            return fail("a texture coordinate is NaN or infinite");
        }
        let pages = self.pages.len();
        let one = pages == 1 && self.face_page.is_empty();
        if !one && (self.face_page.len() != faces || self.face_page.iter().any(|&p| p as usize >= pages)) {
            return fail("a face lies on a page that does not exist");
        }
        Ok(())
    }

    /// The image files that a page needs in glTF.
    pub(crate) fn slots(&self, page: usize) -> Vec<Slot> {
        slots(&self.pages[page])
    }

    /// One of them, encoded.
    pub(crate) fn png(&self, page: usize, slot: Slot) -> Result<Vec<u8>, String> {
        Pixels::new(&self.pages[page], slot)?.png()
    }
}

/// Reads how a glTF file looks: its primitive with texture coordinates and embedded images. `None` if it has none, or is no
/// glTF file.
///
/// # Errors
/// If the file cannot be read or is damaged.
pub fn read_look(path: &Path) -> Result<Option<(Model, Look)>, FormatError> {
    read_look_bytes(path, &read_file(path, "the GLB file")?)
}

/// The same from the bytes of a file; `path` is for messages and for files beside it.
///
/// # Errors
/// As [`read_look`].
pub fn read_look_bytes(path: &Path, file: &[u8]) -> Result<Option<(Model, Look)>, FormatError> {
    parse(file, path.parent()).map_err(|problem| FormatError::malformed(path, problem))
}

fn parse(file: &[u8], folder: Option<&Path>) -> Result<Option<(Model, Look)>, Problem> {
    let (json, bin) = if glb::is_glb(file) {
        glb::split(file)?
    } else if file.trim_ascii_start().starts_with(b"{") {
        (file, None)
    } else {
        return Ok(None);
    };
    let document = Document::parse(json)?;
    let buffers = uri::load_buffers(&document, bin, folder)?;
    let data = Data { document: &document, buffers: &buffers };
    let Some(mesh) = document.nodes.iter().find_map(|n| n.mesh).and_then(|m| document.meshes.get(m)) else { return Ok(None) };
    let (mut model, mut look) = (Model::default(), Look::default());
    for (page, primitive) in mesh.primitives.iter().enumerate() {
        let place = format!("primitive {page}");
        let material = primitive.material.and_then(|m| document.materials.get(m));
        let Some(material) = material.filter(|m| m.pbr_metallic_roughness.get("baseColorTexture").is_some()) else {
            return Ok(None);
        };
        if page == 0 {
            let vertices = scene::read_vertices(&data, primitive, &place)?;
            let Some(uv) = vertices.uvs else { return Ok(None) };
            model.positions = vertices.positions.into_iter().map(Vec3::from_array).collect();
            model.normals = vertices.normals.map(|n| n.into_iter().map(Vec3::from_array).collect());
            look.uv = uv.into_iter().map(Vec2::from_array).collect();
            look.tangents = match primitive.attributes.get("TANGENT") {
                Some(&a) => Some(data.floats::<4>(a)?.into_iter().map(Vec4::from_array).collect()),
                None => None,
            };
        } else if primitive.attributes != mesh.primitives[0].attributes {
            // Several meshes in one: nothing that was baked here.
            return Ok(None);
        }
        let faces = scene::read_triangles(&data, primitive, model.positions.len(), &place)?.unwrap_or_default();
        look.face_page.extend(std::iter::repeat_n(page as u32, faces.len()));
        model.faces.extend(faces);
        look.pages.push(read_page(&data, folder, material)?);
    }
    look.check(model.positions.len(), model.faces.len()).map_err(|(place, what)| Problem::damaged(place, what))?;
    Ok(Some((model, look)))
}

/// The images that a material shows.
fn read_page(
    data: &Data<'_>,
    folder: Option<&Path>,
    material: &super::gltf::document::Material,
) -> Result<Vec<(Channel, Image)>, Problem> {
    let pbr = &material.pbr_metallic_roughness;
    let of = |value: Option<&Value>| value.and_then(|t| t["index"].as_u64()).map(|t| t as usize);
    let load = |texture: Option<usize>, transfer: Transfer| {
        texture.map(|t| uri::load_image(data, t, folder).and_then(|bytes| decode(&bytes, None, transfer))).transpose()
    };
    let part = |image: &Image, component: usize| {
        let [w, h] = image.size();
        let step = image.components();
        let values = image.data().iter().skip(component.min(step - 1)).step_by(step).copied().collect();
        Image::new(w, h, 1, values)
    };
    let three = |image: Image| {
        let [w, h] = image.size();
        if image.components() == 3 { image } else { Image::from_fn(w, h, |x, y| image.pixel(i64::from(x), i64::from(y))) }
    };
    let mut page = Vec::new();
    if let Some(color) = load(of(pbr.get("baseColorTexture")), Transfer::Srgb)? {
        page.push((Channel::BaseColor, three(color.image)));
        if material.alpha_mode.as_deref().is_some_and(|mode| mode != "OPAQUE") {
            page.extend(color.alpha.map(|alpha| (Channel::Opacity, alpha)));
        }
    }
    if let Some(normal) = load(of(Some(&material.normal_texture)), Transfer::Signed)? {
        page.push((Channel::Normal, three(normal.image)));
    }
    if let Some(height) = load(of(material.extras.get("heightTexture")), Transfer::Linear)? {
        page.extend(part(&height.image, 0).map(|image| (Channel::Height, image)));
    }
    if let Some(map) = load(of(pbr.get("metallicRoughnessTexture")), Transfer::Linear)? {
        let used = |key: &str| pbr.get(key).and_then(Value::as_f64).is_none_or(|f| f > 0.0);
        if used("roughnessFactor") {
            page.extend(part(&map.image, 1).map(|image| (Channel::Roughness, image)));
        }
        if used("metallicFactor") {
            page.extend(part(&map.image, 2).map(|image| (Channel::Metallic, image)));
        }
    }
    if let Some(map) = load(of(Some(&material.occlusion_texture)), Transfer::Linear)? {
        page.extend(part(&map.image, 0).map(|image| (Channel::Occlusion, image)));
    }
    if let Some(map) = load(of(Some(&material.emissive_texture)), Transfer::Srgb)? {
        page.push((Channel::Emissive, three(map.image)));
    }
    page.sort_by_key(|(channel, _)| *channel);
    Ok(page)
}
