//! A mesh as its file holds it: faces and vertices in the file's order, triangulated but not cleaned.

use super::error::Problem;
use super::motion::Motion;
use glam::{Vec2, Vec3, Vec4};
use serde::{Deserialize, Serialize};

/// The most faces or vertices a file may unfold to: files that instance one mesh many times are small and become large.
/// Pasting needs about 1 KB a face, so hardly a machine could go on with more.
pub(crate) const MAX_MODEL_FACES: usize = 50_000_000;

/// What a mesh file holds, in world coordinates.
///
/// Every face index is in range, every position finite; the optional attributes have one entry a vertex. Vertices keep the
/// file's order. Where a format gives attributes to corners, a vertex that carries several is repeated: the first set stays
/// with the file's own vertex, further ones follow after all of those.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Model {
    /// What the file calls it, or the file's stem.
    pub name: String,
    /// Vertex positions.
    pub positions: Vec<Vec3>,
    /// Triangles; polygons are cut into `corners - 2` of them.
    pub faces: Vec<[u32; 3]>,
    /// Unit normal at each vertex.
    pub normals: Option<Vec<Vec3>>,
    /// Texture coordinates at each vertex, (0, 0) at the top left as in glTF.
    pub uvs: Option<Vec<Vec2>>,
    /// Colour at each vertex, linear light, and alpha; 0 to 1.
    pub colors: Option<Vec<Vec4>>,
    /// Objects, groups and materials: runs of faces, in order. Together they hold every face, or the file names nothing
    /// and there are none.
    pub groups: Vec<FaceGroup>,
    /// For each face the polygon of the file it was cut from; absent if every polygon is a triangle.
    pub polygons: Option<Vec<u32>>,
    /// How the vertices move, if they do; it fits them.
    pub motion: Option<Motion>,
    /// What the file says of itself.
    pub source: Source,
}

/// A run of faces with the same names.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub struct FaceGroup {
    /// Object, or node of a scene; may be empty.
    pub object: String,
    /// Group within the object; may be empty.
    pub group: String,
    /// Material; may be empty.
    pub material: String,
    /// First face.
    pub start: u32,
    /// Number of faces.
    pub count: u32,
}

/// What a file is and what it says of itself.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(default)]
pub struct Source {
    /// Kind of file, in words.
    pub format: String,
    /// Vertices as the file counts them.
    pub vertices: usize,
    /// Polygons as the file counts them; triangles of strips and fans one by one.
    pub polygons: usize,
    /// Unit of length, if the file states one.
    pub unit: Option<String>,
    /// Which way is up (`"+Y"`), if the file or its format states it.
    pub up: Option<String>,
    /// What was left out or mended while reading, one sentence each.
    pub notes: Vec<String>,
}

impl Model {
    /// Mends what no reader needs to care about, and checks what every reader must: lengths of normals, attributes that
    /// are not numbers, positions that are not finite, and that there is a face at all. Indices are in range already.
    ///
    /// `element` names a vertex of the file in words, for messages.
    pub(crate) fn finish(mut self, element: impl Fn(usize) -> String) -> Result<Self, Problem> {
        if self.faces.is_empty() {
            let what = if self.positions.is_empty() {
                "the file holds no vertices and no faces".to_owned()
            } else {
                format!("the file holds {} vertices but no faces", self.positions.len())
            };
            return Err(Problem::new("", what, "export the mesh with its triangles or polygons"));
        }
        if let Some(vertex) = self.positions.iter().position(|p| !p.is_finite()) {
            return Err(Problem::new(
                element(vertex),
                "a coordinate is NaN, infinite or beyond 32-bit range",
                "repair the mesh where it was made",
            ));
        }
        self.mend_normals();
        let broken_uvs = self.uvs.iter_mut().flatten().filter(|t| !t.is_finite()).map(|t| *t = Vec2::ZERO).count();
        if broken_uvs > 0 {
            self.source.notes.push(format!("{broken_uvs} texture coordinates are not numbers and were set to 0"));
        }
        for c in self.colors.iter_mut().flatten() {
            *c = if c.is_nan() { Vec4::ONE } else { c.clamp(Vec4::ZERO, Vec4::ONE) };
        }
        self.merge_groups();
        Ok(self)
    }

    /// Gives every normal unit length. Where the file has none worth the name, that of the faces around is taken.
    fn mend_normals(&mut self) {
        let Some(normals) = &mut self.normals else { return };
        let mut missing = Vec::new();
        for (v, n) in normals.iter_mut().enumerate() {
            let unit = n.as_dvec3().normalize_or_zero();
            // Normals of unit length within rounding stay bit for bit what they were.
            if !n.is_normalized() || unit == glam::DVec3::ZERO {
                *n = unit.as_vec3();
            }
            if unit == glam::DVec3::ZERO {
                missing.push(v as u32);
            }
        }
        if missing.is_empty() {
            return;
        }
        let mut sums = vec![glam::DVec3::ZERO; missing.len()];
        for face in &self.faces {
            let places = face.map(|v| missing.binary_search(&v).ok());
            if places.iter().any(Option::is_some) {
                let [a, b, c] = face.map(|v| self.positions[v as usize].as_dvec3());
                let area = (b - a).cross(c - a);
                places.into_iter().flatten().for_each(|m| sums[m] += area);
            }
        }
        for (&v, sum) in missing.iter().zip(sums) {
            normals[v as usize] = sum.normalize_or(glam::DVec3::Z).as_vec3();
        }
    }

    /// Joins neighbouring runs with the same names, drops empty ones, and all of them if none has a name.
    fn merge_groups(&mut self) {
        let groups = &mut self.groups;
        groups.retain(|g| g.count > 0);
        groups.dedup_by(|next, run| {
            let same = next.object == run.object && next.group == run.group && next.material == run.material;
            if same {
                run.count += next.count;
            }
            same
        });
        if groups.iter().all(|g| g.object.is_empty() && g.group.is_empty() && g.material.is_empty()) {
            groups.clear();
        }
    }
}

/// The unit that a comment or header line states (`units: mm`, `# File units = centimeters`), if it does.
pub(crate) fn stated_unit(text: &str) -> Option<String> {
    let lower = text.to_ascii_lowercase();
    let after = &lower[lower.find("unit")? + 4..];
    let after = after.strip_prefix('s').unwrap_or(after).trim_start();
    let after = after.strip_prefix('=').or_else(|| after.strip_prefix(':')).unwrap_or(after).trim_start();
    let word: String = after.chars().take_while(char::is_ascii_alphabetic).collect();
    KNOWN_UNITS.contains(&word.as_str()).then_some(word)
}

/// Words that are taken for units of length; anything else after "unit" is prose.
const KNOWN_UNITS: [&str; 19] = [
    "mm",
    "cm",
    "dm",
    "m",
    "km",
    "in",
    "ft",
    "um",
    "inch",
    "inches",
    "feet",
    "foot",
    "meter",
    "meters",
    "metre",
    "metres",
    "millimeters",
    "centimeters",
    "millimetres",
];
