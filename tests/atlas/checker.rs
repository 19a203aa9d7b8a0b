//! A checker that knows nothing but a written GLB: geometry, coordinates, overlaps, colours in charts and gutters.
//!
//! It reads the file with the `gltf` crate and rasterizes on its own, sample by sample.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test may fail by panicking")]

use glam::{DVec2, Vec2, Vec3};
use lapped::exemplar::srgb;
use lapped::format::Model;
use std::path::Path;

/// What a GLB shows.
pub(crate) struct Shown {
    pub(crate) positions: Vec<Vec3>,
    pub(crate) faces: Vec<[u32; 3]>,
    pub(crate) uv: Vec<Vec2>,
    pub(crate) own_uv: Option<Vec<Vec2>>,
    pub(crate) size: u32,
    /// Base colour, linear light.
    pub(crate) color: Vec<Vec3>,
    /// True if every texel is opaque.
    pub(crate) opaque: bool,
}

impl Shown {
    pub(crate) fn read(path: &Path) -> Self {
        let (document, buffers, images) = gltf::import(path).unwrap();
        let mesh = document.nodes().find_map(|n| n.mesh()).unwrap();
        let primitive = mesh.primitives().next().unwrap();
        let reader = primitive.reader(|b| Some(&buffers[b.index()]));
        let texture = primitive.material().pbr_metallic_roughness().base_color_texture().unwrap();
        assert_eq!(texture.tex_coord(), 0, "the atlas is the first set of coordinates");
        let image = &images[texture.texture().source().index()];
        assert_eq!(image.width, image.height, "pages are square");
        let step = match image.format {
            gltf::image::Format::R8G8B8 => 3,
            gltf::image::Format::R8G8B8A8 => 4,
            other => panic!("an image of {other:?}"),
        };
        let pixels = image.pixels.chunks_exact(step);
        let linear: Vec<f32> = (0..256).map(|b| srgb::decode(b as f32 / 255.0)).collect();
        let uv = |set| reader.read_tex_coords(set).map(|t| t.into_f32().map(Vec2::from).collect::<Vec<_>>());
        Self {
            positions: reader.read_positions().unwrap().map(Vec3::from).collect(),
            faces: reader.read_indices().unwrap().into_u32().collect::<Vec<_>>().as_chunks::<3>().0.to_vec(),
            uv: uv(0).unwrap(),
            own_uv: uv(1),
            size: image.width,
            color: pixels.clone().map(|p| Vec3::from_array([0, 1, 2].map(|c| linear[usize::from(p[c])]))).collect(),
            opaque: step == 3 || pixels.into_iter().all(|p| p[3] == 255),
        }
    }

    pub(crate) fn corners(&self, face: usize) -> [Vec2; 3] {
        self.faces[face].map(|v| self.uv[v as usize])
    }

    /// Charts as the file shows them: faces that share a place of the surface and of the image.
    pub(crate) fn charts(&self) -> Vec<usize> {
        let key =
            |v: u32| (self.positions[v as usize].to_array().map(f32::to_bits), self.uv[v as usize].to_array().map(f32::to_bits));
        let mut known = std::collections::HashMap::new();
        let mut parent: Vec<usize> = Vec::new();
        let mut vertex = Vec::new();
        for v in 0..self.uv.len() as u32 {
            vertex.push(*known.entry(key(v)).or_insert_with(|| {
                parent.push(parent.len());
                parent.len() - 1
            }));
        }
        fn root(parent: &mut [usize], mut v: usize) -> usize {
            while parent[v] != v {
                parent[v] = parent[parent[v]];
                v = parent[v];
            }
            v
        }
        for f in &self.faces {
            let a = root(&mut parent, vertex[f[0] as usize]);
            for &v in &f[1..] {
                let b = root(&mut parent, vertex[v as usize]);
                parent[b] = a;
            }
        }
        self.faces.iter().map(|f| root(&mut parent, vertex[f[0] as usize])).collect()
    }

    /// The colour at a place of the image at a mip level, by box-filtered levels and bilinear sampling.
    pub(crate) fn sample(&self, levels: &[(u32, Vec<Vec3>)], level: usize, uv: Vec2) -> Vec3 {
        let (size, texels) = &levels[level];
        let p = uv * *size as f32 - 0.5;
        let low = p.floor();
        let part = p - low;
        let at = |dx: i64, dy: i64| {
            let c = |v: f32, d: i64| (v as i64 + d).clamp(0, i64::from(*size) - 1) as usize;
            texels[c(low.y, dy) * *size as usize + c(low.x, dx)]
        };
        at(0, 0).lerp(at(1, 0), part.x).lerp(at(0, 1).lerp(at(1, 1), part.x), part.y)
    }

    /// Mip levels down to `count` below the finest.
    pub(crate) fn levels(&self, count: usize) -> Vec<(u32, Vec<Vec3>)> {
        let mut levels = vec![(self.size, self.color.clone())];
        for _ in 0..count {
            let (size, texels) = levels.last().unwrap();
            let (n, half) = (*size as usize, *size as usize / 2);
            let mean = |x: usize, y: usize| {
                (texels[2 * y * n + 2 * x]
                    + texels[2 * y * n + 2 * x + 1]
                    + texels[(2 * y + 1) * n + 2 * x]
                    + texels[(2 * y + 1) * n + 2 * x + 1])
                    / 4.0
            };
            let next = (0..half * half).map(|i| mean(i % half, i / half)).collect();
            levels.push((half as u32, next));
        }
        levels
    }
}

/// The geometry is the model's, face by face and corner by corner.
pub(crate) fn same_geometry(shown: &Shown, model: &Model) {
    assert_eq!(shown.faces.len(), model.faces.len(), "as many faces");
    for (f, (mine, theirs)) in shown.faces.iter().zip(&model.faces).enumerate() {
        for k in 0..3 {
            let (a, b) = (shown.positions[mine[k] as usize], model.positions[theirs[k] as usize]);
            assert_eq!(a, b, "corner {k} of face {f} has not moved");
        }
    }
}

/// Texels whose square two charts touch, and texels whose centre lies well inside two faces of one chart, at `size` texels.
pub(crate) fn overlaps(shown: &Shown, size: usize) -> (usize, usize) {
    let charts = shown.charts();
    let mut owner = vec![usize::MAX; size * size];
    let (mut shared, mut doubled) = (0, 0);
    let mut inside = vec![false; size * size];
    // Copies of a face share its place, as they share its points of the surface.
    let mut seen = std::collections::HashSet::new();
    for f in 0..shown.faces.len() {
        let mut corners = shown.corners(f).map(|p| p.to_array().map(f32::to_bits));
        corners.sort_unstable();
        if !seen.insert(corners) {
            continue;
        }
        let t = shown.corners(f).map(|p| p.as_dvec2() * size as f64);
        let area = (t[1] - t[0]).perp_dot(t[2] - t[0]);
        if area == 0.0 {
            continue;
        }
        let t = if area > 0.0 { t } else { [t[0], t[2], t[1]] };
        let low = t[0].min(t[1]).min(t[2]).floor();
        let high = t[0].max(t[1]).max(t[2]).floor().min(DVec2::splat(size as f64 - 1.0));
        for y in low.y as usize..=high.y as usize {
            for x in low.x as usize..=high.x as usize {
                let centre = DVec2::new(x as f64 + 0.5, y as f64 + 0.5);
                let mut touches = true;
                let mut deep = true;
                for k in 0..3 {
                    let edge = t[(k + 1) % 3] - t[k];
                    let side = edge.perp_dot(centre - t[k]);
                    touches &= side + 0.5 * (edge.x.abs() + edge.y.abs()) > 0.0;
                    // A hundredth of a texel away from every edge.
                    deep &= side > 0.01 * edge.length();
                }
                let i = y * size + x;
                if touches {
                    shared += usize::from(owner[i] != usize::MAX && owner[i] != charts[f]);
                    owner[i] = charts[f];
                }
                if deep {
                    doubled += usize::from(std::mem::replace(&mut inside[i], true));
                }
            }
        }
    }
    (shared, doubled)
}
