//! The parts of a glTF document that matter here. Whatever else a document holds is not looked at, so that nothing in it
//! can be in the way.

use crate::format::error::Problem;
use serde::Deserialize;
use serde_json::{Map, Value};
use std::collections::BTreeMap;

macro_rules! parts {
    ($($(#[$about:meta])* $name:ident { $($field:ident: $kind:ty,)* })*) => {$(
        $(#[$about])*
        #[derive(Debug, Clone, Default, Deserialize)]
        #[serde(rename_all = "camelCase", default)]
        pub(crate) struct $name { $(pub(crate) $field: $kind,)* }
    )*};
}

parts! {
    /// The whole document.
    Document {
        asset: Asset,
        scene: Option<usize>,
        scenes: Vec<Scene>,
        nodes: Vec<Node>,
        meshes: Vec<Mesh>,
        materials: Vec<Material>,
        accessors: Vec<Accessor>,
        buffer_views: Vec<BufferView>,
        buffers: Vec<Buffer>,
        textures: Vec<Texture>,
        images: Vec<Image>,
        skins: Vec<Skin>,
        animations: Vec<Animation>,
        extensions: Map<String, Value>,
        extensions_required: Vec<String>,
    }
    /// What made the file, and for which version.
    Asset { version: String, generator: Option<String>, }
    /// Root nodes that are shown together.
    Scene { nodes: Vec<usize>, }
    /// A place in the scene.
    Node {
        name: Option<String>,
        children: Vec<usize>,
        mesh: Option<usize>,
        skin: Option<usize>,
        matrix: Option<[f64; 16]>,
        translation: Option<[f64; 3]>,
        rotation: Option<[f64; 4]>,
        scale: Option<[f64; 3]>,
        weights: Option<Vec<f32>>,
    }
    /// How a primitive looks.
    Material {
        name: Option<String>,
        pbr_metallic_roughness: Map<String, Value>,
        normal_texture: Value,
        occlusion_texture: Value,
        emissive_texture: Value,
        alpha_mode: Option<String>,
        extras: Map<String, Value>,
    }
    /// Primitives that share a name.
    Mesh { name: Option<String>, primitives: Vec<Primitive>, weights: Vec<f32>, extras: Value, }
    /// Triangles, lines or points.
    Primitive {
        attributes: BTreeMap<String, usize>,
        indices: Option<usize>,
        material: Option<usize>,
        mode: Option<u32>,
        targets: Vec<BTreeMap<String, usize>>,
    }
    /// Nodes that carry vertices.
    Skin { joints: Vec<usize>, inverse_bind_matrices: Option<usize>, }
    /// What is played together.
    Animation { name: Option<String>, channels: Vec<Channel>, samplers: Vec<Sampler>, }
    /// What a sampler changes.
    Channel { sampler: usize, target: ChannelTarget, }
    /// A property of a node.
    ChannelTarget { node: Option<usize>, path: String, }
    /// Numbers over time.
    Sampler { input: usize, output: usize, interpolation: Option<String>, }
    /// Typed numbers.
    Accessor {
        buffer_view: Option<usize>,
        byte_offset: u64,
        component_type: u32,
        normalized: bool,
        count: u64,
        r#type: String,
        sparse: Option<Sparse>,
    }
    /// Numbers that replace some of an accessor's.
    Sparse { count: u64, indices: SparseIndices, values: SparseValues, }
    /// Which ones.
    SparseIndices { buffer_view: usize, byte_offset: u64, component_type: u32, }
    /// By what.
    SparseValues { buffer_view: usize, byte_offset: u64, }
    /// A stretch of a buffer.
    BufferView { buffer: usize, byte_offset: u64, byte_length: u64, byte_stride: Option<u64>, }
    /// Bytes of a file, a data URI or the GLB itself.
    Buffer { uri: Option<String>, byte_length: u64, }
    /// An image with a way of sampling it.
    Texture { source: Option<usize>, }
    /// An image file, within a buffer or beside the document.
    Image { buffer_view: Option<usize>, uri: Option<String>, }
}

impl Document {
    /// Parses the JSON of a document.
    pub(crate) fn parse(json: &[u8]) -> Result<Self, Problem> {
        let document: Self = serde_json::from_slice(json.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(json)).map_err(|e| {
            let place = format!("JSON, line {} column {}", e.line(), e.column());
            let text = e.to_string();
            let what = text.split(" at line ").next().unwrap_or_default().to_owned();
            Problem::damaged(place, what)
        })?;
        if document.asset.version.is_empty() {
            let what = "the JSON has no asset.version: it is no glTF document";
            return Err(Problem::new("", what, "name a glTF, GLB, OBJ, PLY or STL file"));
        }
        if !document.asset.version.starts_with("2.") {
            let what = format!("it is glTF version {}, only version 2 is read", document.asset.version);
            return Err(Problem::new("", what, "export it again as glTF 2.0"));
        }
        Ok(document)
    }
}
