//! Cutting a mesh into charts and packing them.
//!
//! The default is the crate `uvunwrap`: charts grown within a normal cone, flattened by least squares conformal maps and
//! as-rigid-as-possible rounds, split where they fold or overlap, packed by their shape with quarter turns. Charts grown
//! by [`super::grow`] and the mesh's own islands are packed by it as well. What is ours is around it:
//!
//! 1. The mesh is brought to unit size, so that no tolerance depends on its scale.
//! 2. A large mesh is cut into [`parts`], whose charts are made side by side.
//! 3. Pages are packed at a coarser resolution than they are baked at: a finer one gains next to nothing and costs much.
//! 4. With several pages the density is searched that fills them.

use super::grow::{GrowOptions, grow};
use super::parts::parts;
use super::{Atlas, AtlasError, MAX_SIZE};
use crate::mesh::{Mesh, NONE};
use crate::progress::Progress;
use glam::{DVec2, Vec2};
use std::collections::BTreeMap;
use uvunwrap::{Density, MeshInput};

/// Pages are packed on a grid of at most so many cells a side; cells are whole texels.
const PACKING_GRID: u32 = 1024;

/// Most faces of a part. Smaller parts are faster still, but their borders cost charts and stretch (`docs/performance.md`).
const PART_FACES: usize = 1 << 17;

/// Density is searched for several pages until it is within this share of the best.
const DENSITY_STEP: f64 = 0.97;

/// Where charts come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum ChartMethod {
    /// `uvunwrap`: few, little distorted charts.
    #[default]
    Auto,
    /// Discs grown face by face, the paper's way ([`super::grow`]).
    Grow,
}

/// How to unwrap.
#[derive(Debug, Clone, PartialEq)]
pub struct UnwrapOptions {
    /// Texels along each side of a page.
    pub size: u32,
    /// Pages to fill.
    pub pages: u32,
    /// Mip levels beyond the finest that must be free of other charts' colours; sets the gutters ([`margin`]).
    pub mips: u32,
    /// Where charts come from.
    pub method: ChartMethod,
    /// Growing, if charts are grown.
    pub grow: GrowOptions,
}

impl Default for UnwrapOptions {
    fn default() -> Self {
        Self { size: 2048, pages: 1, mips: 2, method: ChartMethod::Auto, grow: GrowOptions::default() }
    }
}

/// Texels around a chart that bilinear samples on it may touch at mip level `mips`: a texel and a half there.
#[must_use]
pub const fn margin(mips: u32) -> u32 {
    let texel = 1_u32 << if mips > 12 { 12 } else { mips };
    texel + texel.div_ceil(2)
}

/// Cuts a mesh into charts and packs them.
///
/// # Errors
/// If the size cannot be made, or the charts and their gutters do not fit.
pub fn unwrap(mesh: &Mesh, options: &UnwrapOptions, progress: &dyn Progress) -> Result<Atlas, AtlasError> {
    if !(16..=MAX_SIZE).contains(&options.size) {
        return Err(AtlasError::Size(options.size));
    }
    let charts = match options.method {
        ChartMethod::Auto => None,
        ChartMethod::Grow => Some(grow(mesh, &options.grow, progress)?),
    };
    pack(mesh, charts, options, progress)
}

/// Charts laid flat but not packed.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct FlatCharts {
    /// For each face its corners as indices into `vertices` and `uv`.
    pub corners: Vec<[u32; 3]>,
    /// Vertex of the mesh at each of these.
    pub vertices: Vec<u32>,
    /// Places in the plane, y up; no two charts may share a point.
    pub uv: Vec<DVec2>,
}

/// A part of what the packer is given: positions at unit size and corners.
struct Part {
    /// The faces of the mesh that these corners are of.
    faces: Vec<u32>,
    positions: Vec<[f32; 3]>,
    indices: Vec<u32>,
    /// Vertex of the mesh at each position.
    vertices: Vec<u32>,
    uvs: Option<Vec<[f32; 2]>>,
}

/// What the packer is given.
struct Input(Vec<Part>);

impl Input {
    fn new(mesh: &Mesh, charts: Option<FlatCharts>) -> Self {
        let (low, high) = mesh.bounds();
        let middle = (low.as_dvec3() + high.as_dvec3()) * 0.5;
        let size = (high.as_dvec3() - low.as_dvec3()).max_element();
        let scale = if size > 0.0 { 1.0 / size } else { 1.0 };
        let unit = |v: u32| ((mesh.point(v) - middle) * scale).as_vec3().to_array();
        if let Some(charts) = charts {
            return Self(vec![Part {
                faces: (0..mesh.face_count() as u32).collect(),
                positions: charts.vertices.iter().map(|&v| unit(v)).collect(),
                indices: charts.corners.as_flattened().to_vec(),
                vertices: charts.vertices,
                uvs: Some(charts.uv.iter().map(|p| p.as_vec2().to_array()).collect()),
            }]);
        }
        let mut place = vec![NONE; mesh.vertex_count()];
        let part = |faces: Vec<u32>| {
            // In the order of the mesh: charts depend on it.
            let mut vertices: Vec<u32> = faces.iter().flat_map(|&f| mesh.faces[f as usize]).collect();
            vertices.sort_unstable();
            vertices.dedup();
            (0..).zip(&vertices).for_each(|(i, &v)| place[v as usize] = i);
            let indices = faces.iter().flat_map(|&f| mesh.faces[f as usize]).map(|v| place[v as usize]).collect();
            Part { faces, positions: vertices.iter().map(|&v| unit(v)).collect(), indices, vertices, uvs: None }
        };
        Self(parts(mesh, PART_FACES).into_iter().map(part).collect())
    }

    fn generate(&self, options: &uvunwrap::Options, progress: &dyn Progress) -> Result<uvunwrap::Atlas, uvunwrap::Error> {
        fn input(part: &Part) -> MeshInput<'_> {
            MeshInput { existing_uvs: part.uvs.as_deref(), ..MeshInput::new(&part.positions, &part.indices) }
        }
        let told = |p: uvunwrap::Progress| {
            let (name, total) = match p.stage {
                uvunwrap::Stage::Parameterizing => ("laying charts flat", p.total.unwrap_or(0)),
                uvunwrap::Stage::Packing => ("packing charts", 0),
                _ => ("cutting charts", 0),
            };
            if p.done <= 1 || total == 0 {
                progress.stage(name, total as u64);
            }
            progress.done(p.done as u64);
            !progress.cancelled()
        };
        uvunwrap::generate_with_progress(&self.0.iter().map(input).collect::<Vec<_>>(), options, told)
    }
}

/// Packs charts, or makes and packs them.
#[expect(clippy::field_reassign_with_default, reason = "options of that crate can be made in no other way")]
pub(super) fn pack(
    mesh: &Mesh,
    charts: Option<FlatCharts>,
    options: &UnwrapOptions,
    progress: &dyn Progress,
) -> Result<Atlas, AtlasError> {
    let size = options.size;
    let cell = size.div_ceil(PACKING_GRID).next_power_of_two();
    let grid = size / cell;
    let margin = margin(options.mips);
    // The grid's cells are conservative, so a chart keeps its distance whatever part of a cell it fills.
    let padding = margin.div_ceil(cell);
    let fail = |error: uvunwrap::Error, charts: usize| match error {
        uvunwrap::Error::Cancelled => AtlasError::Cancelled,
        uvunwrap::Error::ChartTooLarge { .. } => AtlasError::NoRoom { charts, margin, pages: options.pages, size },
        other => AtlasError::Unwrap(other.to_string()),
    };
    let mut input = Input::new(mesh, charts);
    let mut settings = uvunwrap::Options::default();
    settings.padding = padding;
    settings.density = Density::Auto { page_size: grid };
    if 2 * padding >= grid {
        return Err(AtlasError::NoRoom { charts: 1, margin, pages: options.pages, size });
    }
    let mut made = input.generate(&settings, progress).map_err(|e| fail(e, 0))?;
    if made.page_count > 1 && options.pages == 1 {
        return Err(AtlasError::NoRoom { charts: made.chart_count as usize, margin, pages: 1, size });
    }
    if options.pages > 1 {
        (input, made) = fill_pages(mesh, &input, &made, settings, (grid, options.pages), progress).map_err(|e| fail(e, 0))?;
    }
    Ok(collect(mesh, &input, &made, (grid, size, margin)))
}

/// Packs charts that are made already at the largest density that needs no more than the pages asked for. Returns the answer and
/// what it answers.
fn fill_pages(
    mesh: &Mesh,
    input: &Input,
    made: &uvunwrap::Atlas,
    mut settings: uvunwrap::Options,
    (grid, pages): (u32, u32),
    progress: &dyn Progress,
) -> Result<(Input, uvunwrap::Atlas), uvunwrap::Error> {
    let flat = collect(mesh, input, made, (grid, grid, 0));
    // Charts of different pages must not share a point.
    let place = |v: usize, page: u32| flat.uv[v].as_dvec2() * DVec2::new(1.0, -1.0) + DVec2::new(2.0 * f64::from(page), 0.0);
    let mut page_of = vec![0; flat.vertices.len()];
    for (corners, &chart) in flat.corners.iter().zip(&flat.chart) {
        corners.iter().for_each(|&v| page_of[v as usize] = flat.page[chart as usize]);
    }
    let uv = (0..flat.vertices.len()).map(|v| place(v, page_of[v])).collect();
    let again = Input::new(mesh, Some(FlatCharts { corners: flat.corners, vertices: flat.vertices, uv }));
    let mut density = f64::from(made.texels_per_unit) * f64::from(pages).sqrt() * 1.1;
    loop {
        settings.density = Density::Fixed { texels_per_unit: density as f32, page_size: Some(grid) };
        match again.generate(&settings, progress) {
            Ok(packed) if packed.page_count <= pages => return Ok((again, packed)),
            Ok(_) | Err(uvunwrap::Error::ChartTooLarge { .. }) => density *= DENSITY_STEP,
            Err(error) => return Err(error),
        }
    }
}

/// The crate's answer in our terms.
fn collect(mesh: &Mesh, input: &Input, made: &uvunwrap::Atlas, (grid, size, margin): (u32, u32, u32)) -> Atlas {
    // The page is square; what was packed may be shorter.
    let scale = Vec2::new(made.width as f32, made.height as f32) / grid as f32;
    let mut page = vec![0; made.chart_count as usize];
    let (mut corners, mut chart) = (vec![[0; 3]; mesh.face_count()], vec![NONE; mesh.face_count()]);
    let (mut vertices, mut uv) = (Vec::new(), Vec::new());
    for (part, out) in input.0.iter().zip(&made.meshes) {
        let first = vertices.len() as u32;
        for v in &out.vertices {
            if let (Some(chart), Some(p)) = (v.chart, v.page) {
                page[chart as usize] = p;
            }
            let p = Vec2::from(v.uv) * scale;
            uv.push(Vec2::new(p.x, 1.0 - p.y).clamp(Vec2::ZERO, Vec2::ONE));
            vertices.push(part.vertices[v.xref as usize]);
        }
        for (&f, of_face) in part.faces.iter().zip(out.indices.as_chunks::<3>().0) {
            corners[f as usize] = of_face.map(|v| first + v);
            chart[f as usize] = of_face.iter().find_map(|&v| out.vertices[v as usize].chart).unwrap_or(NONE);
        }
    }
    // A component of nothing but needles has no chart of the crate's: one of its own, however small.
    if chart.contains(&NONE) {
        let (component, _) = mesh.components();
        let mut own: BTreeMap<u32, u32> = BTreeMap::new();
        for (f, c) in chart.iter_mut().enumerate().filter(|(_, c)| **c == NONE) {
            *c = *own.entry(component[f]).or_insert_with(|| {
                page.push(0);
                page.len() as u32 - 1
            });
        }
    }
    if page.is_empty() {
        page.push(0);
    }
    Atlas { chart, corners, vertices, uv, page, pages: made.page_count.max(1), size, margin }
}

#[cfg(test)]
mod tests {
    use super::margin;

    #[test]
    fn margins_hold_a_bilinear_footprint_at_the_level() {
        assert_eq!([0, 1, 2, 3].map(margin), [2, 3, 6, 12], "a texel and a half of each level, rounded up");
    }
}
