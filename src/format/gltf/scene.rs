//! The default scene of a glTF document as one model: node transforms applied, primitives in the order of the scene.

use super::accessor::Data;
use super::document::{Document, Primitive};
use super::motion::{Part, Tree, bound, placement, read_motion};
use crate::format::error::Problem;
use crate::format::model::{FaceGroup, MAX_MODEL_FACES, Model};
use glam::{DMat3, DMat4, DVec3, Vec2, Vec3, Vec4};
use std::collections::BTreeMap;

/// Extensions without which there are no vertices to read.
const COMPRESSED: [&str; 3] = ["KHR_draco_mesh_compression", "EXT_meshopt_compression", "KHR_meshopt_compression"];

/// The whole default scene.
pub(crate) fn read_scene(data: &Data<'_>, format: &str) -> Result<Model, Problem> {
    let document = data.document;
    if let Some(name) = document.extensions_required.iter().find(|e| COMPRESSED.contains(&e.as_str())) {
        return Err(Problem::new("", format!("its geometry is compressed ({name})"), "export the mesh again without compression"));
    }
    let mut gather = Gather::new(data);
    gather.model.source.format = format.into();
    gather.model.source.unit = Some("m".into());
    gather.model.source.up = Some("+Y".into());
    // A stack of nodes with the transform of their parent; children are pushed last first, so that order is kept.
    let mut stack: Vec<(usize, DMat4)> = roots(document)?.into_iter().rev().map(|n| (n, DMat4::IDENTITY)).collect();
    let mut seen = vec![false; document.nodes.len()];
    while let Some((index, parent)) = stack.pop() {
        let place = || format!("node {index}");
        let node = document.nodes.get(index).ok_or_else(|| Problem::damaged(place(), "there is no such node"))?;
        if std::mem::replace(&mut seen[index], true) {
            return Err(Problem::damaged(place(), "it has two parents or is its own ancestor"));
        }
        let world = parent * placement(node).matrix();
        if let Some(mesh) = node.mesh {
            gather.mesh(index, mesh, world)?;
        }
        stack.extend(node.children.iter().rev().map(|&child| (child, world)));
    }
    gather.finish()
}

/// Root nodes of the default scene; where there are no scenes, all nodes that are nobody's child.
fn roots(document: &Document) -> Result<Vec<usize>, Problem> {
    let scene = document.scene.unwrap_or(0);
    if let Some(scene) = document.scenes.get(scene) {
        return Ok(scene.nodes.clone());
    }
    if document.scene.is_some() {
        return Err(Problem::damaged(format!("scene {scene}"), "the default scene does not exist"));
    }
    let mut child = vec![false; document.nodes.len()];
    for &c in document.nodes.iter().flat_map(|n| &n.children) {
        if let Some(c) = child.get_mut(c) {
            *c = true;
        }
    }
    Ok((0..document.nodes.len()).filter(|&n| !child[n]).collect())
}

/// A primitive's own vertices and triangles, nothing applied.
#[derive(Debug, Default)]
pub(crate) struct Triangles {
    pub(crate) positions: Vec<[f32; 3]>,
    pub(crate) normals: Option<Vec<[f32; 3]>>,
    pub(crate) uvs: Option<Vec<[f32; 2]>>,
    pub(crate) colors: Option<Vec<[f32; 4]>>,
}

/// The vertices of a primitive; attributes whose number differs from that of the positions are an error.
pub(crate) fn read_vertices(data: &Data<'_>, primitive: &Primitive, place: &str) -> Result<Triangles, Problem> {
    let attribute = |name: &str| primitive.attributes.get(name).copied();
    let position = attribute("POSITION").ok_or_else(|| Problem::damaged(place, "it has no positions"))?;
    let positions = data.floats::<3>(position)?;
    let fits = |count: usize, name: &str| {
        let what = || format!("it has {} positions, but {count} elements of {name}", positions.len());
        if count == positions.len() { Ok(()) } else { Err(Problem::damaged(place, what())) }
    };
    let normals = attribute("NORMAL").map(|a| data.floats::<3>(a)).transpose()?;
    let uvs = attribute("TEXCOORD_0").map(|a| data.floats::<2>(a)).transpose()?;
    let colors = attribute("COLOR_0").map(|a| read_colors(data, a)).transpose()?;
    for (count, name) in [
        (normals.as_ref().map(Vec::len), "NORMAL"),
        (uvs.as_ref().map(Vec::len), "TEXCOORD_0"),
        (colors.as_ref().map(Vec::len), "COLOR_0"),
    ] {
        count.map_or(Ok(()), |count| fits(count, name))?;
    }
    Ok(Triangles { positions, normals, uvs, colors })
}

fn read_colors(data: &Data<'_>, accessor: usize) -> Result<Vec<[f32; 4]>, Problem> {
    let three = data.document.accessors.get(accessor).is_some_and(|a| a.r#type == "VEC3");
    if three {
        Ok(data.floats::<3>(accessor)?.into_iter().map(|[r, g, b]| [r, g, b, 1.0]).collect())
    } else {
        data.floats::<4>(accessor)
    }
}

/// The triangles of a primitive with `vertices` vertices. `None` if it is lines or points.
pub(crate) fn read_triangles(
    data: &Data<'_>,
    primitive: &Primitive,
    vertices: usize,
    place: &str,
) -> Result<Option<Vec<[u32; 3]>>, Problem> {
    let mode = primitive.mode.unwrap_or(4);
    match mode {
        4..=6 => {}
        0..=3 => return Ok(None),
        _ => return Err(Problem::damaged(place, format!("mode {mode} does not exist"))),
    }
    let indices = match primitive.indices {
        Some(accessor) => data.indices(accessor)?,
        None => (0..u32::try_from(vertices).unwrap_or(u32::MAX)).collect(),
    };
    if let Some(bad) = indices.iter().position(|&i| i as usize >= vertices) {
        let what = format!("index {bad} names vertex {}, but there are only {vertices} (counting from 0)", indices[bad]);
        return Err(Problem::damaged(place, what));
    }
    let distinct = |t: &[u32; 3]| t[0] != t[1] && t[1] != t[2] && t[2] != t[0];
    Ok(Some(match mode {
        4 => indices.as_chunks::<3>().0.to_vec(),
        // Triangles of a strip that repeat a vertex only steer it.
        5 => indices
            .windows(3)
            .enumerate()
            .map(|(k, w)| if k % 2 == 0 { [w[0], w[1], w[2]] } else { [w[0], w[2], w[1]] })
            .filter(distinct)
            .collect(),
        _ => indices.get(1..).unwrap_or_default().windows(2).map(|w| [w[0], w[1], indices[0]]).filter(distinct).collect(),
    }))
}

/// A model under construction.
struct Gather<'a> {
    data: &'a Data<'a>,
    model: Model,
    /// Attributes so far; shorter than the positions while no primitive had any.
    normals: Vec<Vec3>,
    uvs: Vec<Vec2>,
    colors: Vec<Vec4>,
    skipped: usize,
    tree: Tree,
    parts: Vec<Part>,
}

/// What tells a set of vertices from others: attributes and morph targets.
type VertexKey<'a> = (&'a BTreeMap<String, usize>, &'a [BTreeMap<String, usize>]);

impl<'a> Gather<'a> {
    fn new(data: &'a Data<'a>) -> Self {
        let (normals, uvs, colors) = (Vec::new(), Vec::new(), Vec::new());
        let tree = Tree::new(data.document);
        Self { data, model: Model::default(), normals, uvs, colors, skipped: 0, tree, parts: Vec::new() }
    }

    fn mesh(&mut self, node: usize, index: usize, world: DMat4) -> Result<(), Problem> {
        let document = self.data.document;
        let mesh = document.meshes.get(index).ok_or_else(|| Problem::damaged(format!("node {node}"), "its mesh does not exist"))?;
        let name = |name: &Option<String>| name.clone().unwrap_or_default();
        let object = document.nodes[node].name.clone().or_else(|| mesh.name.clone()).unwrap_or_default();
        // A skinned mesh is where its joints are, whatever it hangs on.
        let world = document.nodes[node].skin.map_or(Ok(world), |skin| bound(self.data, &self.tree, skin))?;
        // Exporters often let the primitives of a mesh share one set of vertices, a primitive a material.
        let mut shared: BTreeMap<VertexKey<'_>, (u32, usize)> = BTreeMap::new();
        for (k, primitive) in mesh.primitives.iter().enumerate() {
            let place = format!("mesh {index}, primitive {k}");
            if primitive.mode.is_some_and(|m| m <= 3) {
                self.skipped += 1;
                continue;
            }
            let key = (&primitive.attributes, &primitive.targets[..]);
            let (base, count) = match shared.get(&key) {
                Some(&known) => known,
                None => {
                    let base = self.model.positions.len() as u32;
                    let count = self.vertices(read_vertices(self.data, primitive, &place)?, world)?;
                    shared.insert(key, (base, count));
                    let vertices = base as usize..base as usize + count;
                    self.parts.push(Part { node, mesh: index, primitive: k, vertices, to_model: world });
                    (base, count)
                }
            };
            let Some(triangles) = read_triangles(self.data, primitive, count, &place)? else { continue };
            let start = self.model.faces.len();
            if start + triangles.len() > MAX_MODEL_FACES {
                return Err(too_large());
            }
            let mirrored = world.determinant() < 0.0;
            self.model.faces.extend(triangles.iter().map(|&[a, b, c]| {
                let [b, c] = if mirrored { [c, b] } else { [b, c] };
                [base + a, base + b, base + c]
            }));
            let material = primitive.material.and_then(|m| document.materials.get(m)).map(|m| name(&m.name)).unwrap_or_default();
            self.model.groups.push(FaceGroup {
                object: object.clone(),
                group: name(&mesh.name),
                material,
                start: start as u32,
                count: triangles.len() as u32,
            });
        }
        Ok(())
    }

    /// Adds vertices in world coordinates; returns how many.
    fn vertices(&mut self, v: Triangles, world: DMat4) -> Result<usize, Problem> {
        let (base, count) = (self.model.positions.len(), v.positions.len());
        if base + count > MAX_MODEL_FACES {
            return Err(too_large());
        }
        // Numbers that need no transform stay bit for bit what they were.
        let still = world == DMat4::IDENTITY;
        let place =
            |p: [f32; 3]| if still { p.into() } else { world.transform_point3(DVec3::from_array(p.map(f64::from))).as_vec3() };
        self.model.positions.extend(v.positions.into_iter().map(place));
        if let Some(normals) = v.normals {
            // The cofactor matrix carries normals over even where the transform is singular.
            let m = DMat3::from_mat4(world);
            let cofactor = DMat3::from_cols(m.y_axis.cross(m.z_axis), m.z_axis.cross(m.x_axis), m.x_axis.cross(m.y_axis));
            let cofactor = if m.determinant() < 0.0 { -cofactor } else { cofactor };
            let turn = |n: [f32; 3]| {
                if still { n.into() } else { (cofactor * DVec3::from_array(n.map(f64::from))).normalize_or_zero().as_vec3() }
            };
            self.normals.resize(base, Vec3::ZERO);
            self.normals.extend(normals.into_iter().map(turn));
        }
        if let Some(uvs) = v.uvs {
            self.uvs.resize(base, Vec2::ZERO);
            self.uvs.extend(uvs.into_iter().map(Vec2::from_array));
        }
        if let Some(colors) = v.colors {
            self.colors.resize(base, Vec4::ONE);
            self.colors.extend(colors.into_iter().map(Vec4::from_array));
        }
        Ok(count)
    }

    fn finish(mut self) -> Result<Model, Problem> {
        let count = self.model.positions.len();
        fn fill<T: Clone>(mut values: Vec<T>, count: usize, missing: T) -> Option<Vec<T>> {
            (!values.is_empty()).then(|| {
                values.resize(count, missing);
                values
            })
        }
        let mut model = self.model;
        model.normals = fill(self.normals, count, Vec3::ZERO);
        model.uvs = fill(self.uvs, count, Vec2::ZERO);
        model.colors = fill(self.colors, count, Vec4::ONE);
        model.name = model.groups.first().map(|g| g.object.clone()).unwrap_or_default();
        model.source.vertices = count;
        model.source.polygons = model.faces.len();
        let scenes = self.data.document.scenes.len();
        if scenes > 1 {
            model.source.notes.push(format!("of {scenes} scenes the default one was read"));
        }
        if self.skipped > 0 {
            model.source.notes.push(format!("{} primitives of lines or points were left out", self.skipped));
        }
        model.motion = read_motion(self.data, &self.tree, &self.parts, count, &mut model.source.notes)?;
        self.normals = Vec::new();
        model.finish(|v| format!("vertex {v} of the scene"))
    }
}

fn too_large() -> Problem {
    let what = format!("the scene unfolds to more than {MAX_MODEL_FACES} faces or vertices");
    Problem::new("", what, "split it into several files")
}
