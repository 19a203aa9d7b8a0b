//! A model as a scene of one node: its primitive, and the material it is shown with.

use super::build::{Builder, INDICES, Shape, U32, VERTICES};
use super::motion_out;
use crate::exemplar::{Channel, Wrap};
use crate::format::look::Look;
use crate::format::model::Model;
use crate::format::pixels::Slot;
use glam::Vec3;
use rayon::prelude::*;
use serde_json::{Map, Value, json};

/// Roughness of a material that says nothing of it.
const PLAIN_ROUGHNESS: f64 = 0.8;

/// Adds a model to the tables and returns the parts of the document that show it. Mesh 0, primitive 0 is the whole model, face
/// for face; a look of several pages is shown by mesh 1, a primitive a page on the same vertices.
pub(crate) fn add_scene<'a>(
    tables: &mut Builder<'a>,
    model: &'a Model,
    look: Option<&'a Look>,
) -> Result<Map<String, Value>, String> {
    let mut attributes = add_attributes(tables, model, look);
    let moving = model.motion.as_ref().map(|m| motion_out::begin(tables, m, model.positions.len(), &mut attributes));
    let indices = tables.whole(Some(INDICES), model.faces.as_flattened());
    let primitive =
        |indices: Option<usize>, material: usize| json!({ "attributes": attributes, "indices": indices, "material": material });
    let mut meshes = vec![json!({ "name": model.name, "primitives": [primitive(indices, 0)] })];
    let mut materials = Vec::new();
    if let Some(look) = look {
        for page in 0..look.pages.len() {
            materials.push(add_material(tables, look, page)?);
        }
        if look.pages.len() > 1 {
            let pages: Vec<Value> = (0..look.pages.len())
                .filter_map(|page| {
                    let faces: Vec<u32> =
                        (0..model.faces.len() as u32).filter(|&f| look.face_page[f as usize] as usize == page).collect();
                    let shape = Shape { name: "SCALAR", component: U32, target: Some(INDICES) };
                    let indices = tables.accessor(shape, 3 * faces.len(), move |out| {
                        faces.iter().flat_map(|&f| model.faces[f as usize]).try_for_each(|v| out.write_all(&v.to_le_bytes()))
                    });
                    indices.map(|indices| primitive(Some(indices), page))
                })
                .collect();
            meshes.push(json!({ "name": model.name, "primitives": pages }));
        }
    } else {
        // Vertex colours are what is to be seen; a grey factor would darken them.
        let grey = if model.colors.is_some() { 1.0 } else { 0.8 };
        materials.push(json!({
            "name": "neutral",
            "pbrMetallicRoughness": { "baseColorFactor": [grey, grey, grey, 1.0], "metallicFactor": 0.0, "roughnessFactor": PLAIN_ROUGHNESS },
            "doubleSided": true,
        }));
    }
    let shown = meshes.len() - 1;
    let mut parts = json!({
        "scene": 0,
        "scenes": [{ "nodes": [0] }],
        "nodes": [{ "mesh": shown, "name": model.name }],
        "meshes": meshes,
        "materials": materials,
    });
    if let Some(moving) = moving {
        motion_out::finish(&mut parts, moving);
    }
    Ok(match parts {
        Value::Object(parts) => parts,
        _ => Map::new(),
    })
}

/// Adds the vertices; returns the primitive's attributes.
fn add_attributes<'a>(tables: &mut Builder<'a>, model: &'a Model, look: Option<&'a Look>) -> Map<String, Value> {
    let mut attributes = Map::new();
    let mut put = |name: &str, accessor: Option<usize>| accessor.map(|a| attributes.insert(name.into(), a.into()));
    let positions = tables.vectors(Some(VERTICES), model.positions.len(), |k| model.positions[k].to_array());
    if let Some(accessor) = positions {
        let start = (Vec3::INFINITY, Vec3::NEG_INFINITY);
        let (low, high) = model.positions.iter().fold(start, |(lo, hi), &p| (lo.min(p), hi.max(p)));
        tables.bound(accessor, &low.as_dvec3().to_array(), &high.as_dvec3().to_array());
    }
    put("POSITION", positions);
    put("NORMAL", model.normals.as_ref().and_then(|n| tables.vectors(Some(VERTICES), n.len(), |k| n[k].to_array())));
    let own = model.uvs.as_ref().and_then(|t| tables.vectors(Some(VERTICES), t.len(), |k| t[k].to_array()));
    let colors = model.colors.as_ref().and_then(|c| tables.vectors(Some(VERTICES), c.len(), |k| c[k].to_array()));
    match look {
        None => {
            put("TEXCOORD_0", own);
            put("COLOR_0", colors);
        }
        Some(look) => {
            put("TEXCOORD_0", tables.vectors(Some(VERTICES), look.uv.len(), |k| look.uv[k].to_array()));
            put("TEXCOORD_1", own);
            // Renderers would multiply the bake by vertex colours that are called so.
            put(OWN_COLOR, colors);
            put("TANGENT", look.tangents.as_ref().and_then(|t| tables.vectors(Some(VERTICES), t.len(), |k| t[k].to_array())));
        }
    }
    attributes
}

/// Name of the attribute that keeps a model's vertex colours beside a look.
pub(crate) const OWN_COLOR: &str = "_COLOR";

/// Adds the images of a page; returns the material that shows them.
pub(crate) fn add_material(tables: &mut Builder<'_>, look: &Look, page: usize) -> Result<Value, String> {
    let number = if look.pages.len() > 1 { format!(" {page}") } else { String::new() };
    let mut texture = Map::new();
    let mut put = |slot: Slot, index: usize| texture.insert(slot.name().into(), json!({ "index": index }));
    let name = |slot: Slot| format!("{}{number}", slot.name());
    if let Some(file) = tables.name_image.take() {
        for slot in look.slots(page) {
            put(slot, tables.outer_texture(name(slot), file(page, slot), Wrap::Clamp));
        }
        tables.name_image = Some(file);
    } else {
        let encoded: Vec<(Slot, Result<Vec<u8>, String>)> =
            look.slots(page).into_par_iter().map(|slot| (slot, look.png(page, slot))).collect();
        for (slot, png) in encoded {
            put(slot, tables.texture(name(slot), png?, Wrap::Clamp));
        }
    }
    let has = |channel: Channel| look.pages[page].iter().any(|(c, _)| *c == channel);
    let mut pbr = json!({
        "metallicFactor": if has(Channel::Metallic) { 1.0 } else { 0.0 },
        "roughnessFactor": if has(Channel::Roughness) { 1.0 } else { PLAIN_ROUGHNESS },
    });
    let mut material = json!({ "name": format!("baked {page}"), "doubleSided": true });
    let move_to = |slot: Slot, target: &mut Value, key: &str| {
        if let Some(value) = texture.get(slot.name()) {
            target[key] = value.clone();
        }
    };
    move_to(Slot::Color, &mut pbr, "baseColorTexture");
    if has(Channel::Roughness) || has(Channel::Metallic) {
        move_to(Slot::Orm, &mut pbr, "metallicRoughnessTexture");
    }
    if has(Channel::Occlusion) {
        move_to(Slot::Orm, &mut material, "occlusionTexture");
    }
    move_to(Slot::Normal, &mut material, "normalTexture");
    move_to(Slot::Emissive, &mut material, "emissiveTexture");
    if has(Channel::Emissive) {
        material["emissiveFactor"] = json!([1.0, 1.0, 1.0]);
    }
    if has(Channel::Opacity) {
        material["alphaMode"] = "BLEND".into();
    }
    if let Some(height) = texture.get(Slot::Height.name()) {
        // glTF has no height; whoever knows of it finds it here.
        material["extras"] = json!({ "heightTexture": height });
    }
    material["pbrMetallicRoughness"] = pbr;
    Ok(material)
}
