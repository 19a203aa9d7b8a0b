//! A lapped texture as ordinary glTF: overlapping primitives in paint order, blended by alpha, for renderers that know nothing
//! of pastes.
//!
//! The plain model comes first, opaque, so that depth is written and the back does not show through. Then the pastes follow, each
//! a copy of its faces with coordinates into an image of its texture patch: the exemplar under the mask, the mask as alpha. The
//! patches of one exemplar share an image and a material, so that with one exemplar all pastes are one primitive, whose triangles
//! every renderer draws in order.
//!
//! All channels that glTF materials know travel along, each layer lit by itself before it is blended; normal maps have tangents
//! along their own image. Detail over a base has the base as vertex colours, which go beyond 1 where it is lighter than a quarter. Lost on the way: heights and opacity (the alpha is the mask's), the soft weights of regions, and the exact
//! mip levels of masks. With several exemplars the order of primitives is kept in the file, but renderers that sort translucent
//! primitives by distance may draw them in another.

use crate::exemplar::{Channel, Image, Wrap};
use crate::format::gltf::build::{Builder, INDICES, Shape, U32, VERTICES};
use crate::format::gltf::scene_out::{add_material, add_scene};
use crate::format::look::Look;
use crate::format::{FormatError, Record};
use crate::mesh::SurfacePoint;
use crate::paste::{BaseColor, Cut, LappedTexture, Layer as SoftLayer, Paste, Turn};
use glam::{Vec2, Vec3, Vec4};
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::path::Path;

/// Transparent pixels around each patch of an image beyond what faces reach over its edge, enough for the first mip levels.
const APART: u32 = 8;

/// Faces reach over a patch's edge by at most so many of its sizes; what is further out would be transparent anyway.
const REACH: f32 = 4.0;

/// Figures of a written file.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, serde::Serialize)]
pub struct LayersReport {
    /// Primitives beside the model's own.
    pub primitives: usize,
    /// Triangles in them.
    pub triangles: usize,
    /// Vertices in them.
    pub vertices: usize,
    /// Materials beside the model's own.
    pub materials: usize,
}

/// Writes a record's pastes as layers of ordinary primitives (GLB). The record's model should have normals.
///
/// # Errors
/// If the record contradicts itself, an image cannot be encoded, or the file cannot be written.
pub fn write_layers(path: &Path, record: &Record) -> Result<LayersReport, FormatError> {
    let fail =
        |what: String| FormatError::Write { path: path.to_owned(), what, remedy: "use smaller exemplars or fewer patches".into() };
    record.check().map_err(|(place, what)| fail(format!("{place}: {what}")))?;
    let mut tables = Builder::default();
    let mut parts = add_scene(&mut tables, &record.model, None).map_err(fail)?;
    let mut report = LayersReport::default();
    let lapped = &record.lapped;
    let sheets: Vec<Sheet> = (0..lapped.exemplars.len()).map(|exemplar| Sheet::new(lapped, exemplar)).collect();
    let pages = sheets.iter().enumerate().map(|(exemplar, sheet)| sheet.images(lapped, exemplar));
    let images = Look { pages: pages.collect::<Result<_, _>>().map_err(fail)?, ..Look::default() };
    let mut materials = Vec::new();
    for (page, exemplar) in lapped.exemplars.iter().enumerate() {
        let mut material = add_material(&mut tables, &images, page).map_err(fail)?;
        material["name"] = format!("{} layers", exemplar.name).into();
        materials.push(material);
    }
    report.materials = materials.len();
    let exemplar_of = |paste: &Paste| lapped.patches[paste.patch as usize].exemplar;
    // Where a layer has a base, its pastes show their detail of it: vertex colours multiply what is seen.
    let of_layers = lapped.layers.iter().flat_map(|layer| std::iter::repeat_n(layer, layer.pastes as usize));
    let based = lapped.layers.iter().any(|layer| !layer.base.is_empty());
    let over: Vec<Option<&SoftLayer>> = of_layers.map(Some).chain(std::iter::repeat(None)).take(lapped.pastes.len()).collect();
    let mut begin = 0;
    let primitives: Vec<Value> = lapped
        .pastes
        .chunk_by(|a, b| exemplar_of(a) == exemplar_of(b))
        .filter_map(|run| {
            let exemplar = usize::from(exemplar_of(run.first()?));
            let over = &over[begin..begin + run.len()];
            begin += run.len();
            let layer = Layer::new(record, run, over, based, &sheets[exemplar]);
            report.primitives += 1;
            report.triangles += layer.indices.len() / 3;
            report.vertices += layer.positions.len();
            layer.add(&mut tables, 1 + exemplar, lapped.exemplars[exemplar].channel(Channel::Normal).is_some())
        })
        .collect();
    if let Some(list) = parts.get_mut("meshes").and_then(|m| m[0]["primitives"].as_array_mut()) {
        list.extend(primitives);
    }
    if let Some(list) = parts.get_mut("materials").and_then(Value::as_array_mut) {
        list.extend(materials);
    }
    let document = tables.document(&record.generator, parts);
    tables.write_glb(path, &document)?;
    Ok(report)
}

/// A texture patch with its content shifted and turned, and its cut: what one paste shows.
type Window = (u16, [u32; 2], Turn, Option<Cut>);

fn window(paste: &Paste) -> Window {
    (paste.patch, paste.offset.to_array().map(f32::to_bits), paste.turn, paste.cut.as_deref().copied())
}

/// True if no part of a face can lie on the mask.
fn beyond(uv: &[Vec2; 3]) -> bool {
    (0..2).any(|axis| uv.iter().all(|t| t[axis] <= 0.0) || uv.iter().all(|t| t[axis] >= 1.0))
}

/// What lies under a window.
struct Under<'a> {
    mask: &'a Image,
    cut: Option<&'a Cut>,
    turn: Turn,
    size: [i64; 2],
    origin: Vec2,
}

impl Under<'_> {
    /// Where the content of a pixel lies, turned about the mask's middle.
    fn content(&self, pixel: Vec2) -> Vec2 {
        let middle = 0.5 * Vec2::from(self.size.map(|s| s as f32));
        self.turn.apply(pixel - middle) + middle
    }

    /// A normal of the content as one of the window.
    fn upright(&self, normal: Vec3) -> Vec3 {
        // Normals count upwards, pixels down: the same turn for these is the other way round for those.
        self.turn.apply(normal.truncate()).extend(normal.z)
    }

    /// Alpha that the cut leaves at a pixel.
    fn left(&self, x: i64, y: i64) -> f32 {
        let size = Vec2::from(self.size.map(|s| s as f32));
        let at = Vec2::new(x as f32 + 0.5, y as f32 + 0.5);
        self.cut.map_or(1.0, |cut| cut.alpha(at / size, 2.0 / size.min_element()))
    }
}

/// The windows of one exemplar in one image, in rows.
struct Sheet {
    size: [u32; 2],
    /// Top left pixel of each.
    at: BTreeMap<Window, [u32; 2]>,
}

impl Sheet {
    fn new(lapped: &LappedTexture, exemplar: usize) -> Self {
        // How far faces reach over the edges of masks, pixels: there must be nothing but transparency there.
        let mut windows: BTreeMap<Window, u32> = BTreeMap::new();
        for paste in &lapped.pastes {
            let patch = &lapped.patches[paste.patch as usize];
            if usize::from(patch.exemplar) != exemplar {
                continue;
            }
            let size = Vec2::from(patch.mask.size().map(|s| s as f32));
            let far = paste.uv.iter().filter(|uv| !beyond(uv)).flatten().fold(0.0, |far: f32, uv| {
                let over = (-*uv).max(*uv - 1.0).clamp(Vec2::ZERO, Vec2::splat(REACH)) * size;
                far.max(over.max_element())
            });
            let widest = windows.entry(window(paste)).or_default();
            *widest = (*widest).max(far.ceil() as u32);
        }
        let room = |w: &Window, reach: u32| lapped.patches[w.0 as usize].mask.size().map(|s| s + 2 * (reach + APART));
        let area: f64 = windows.iter().map(|(w, &r)| room(w, r).map(f64::from)).map(|[w, h]| w * h).sum();
        let widest = windows.iter().map(|(w, &r)| room(w, r)[0]).max().unwrap_or(1);
        let width = (area.sqrt().ceil() as u32).max(widest);
        let mut at = BTreeMap::new();
        let (mut x, mut y, mut row) = (0, 0, 1);
        for (&w, &reach) in &windows {
            let [across, down] = room(&w, reach);
            if x + across > width {
                (x, y, row) = (0, y + row, 1);
            }
            at.insert(w, [x + reach + APART, y + reach + APART]);
            x += across;
            row = row.max(down);
        }
        Self { size: [width, y + row], at }
    }

    /// Its images: the exemplar's channels under each mask, extended a little beyond it, and the mask as opacity.
    fn images(&self, lapped: &LappedTexture, exemplar: usize) -> Result<Vec<(Channel, Image)>, String> {
        let source = &lapped.exemplars[exemplar];
        let kept = source.channels().with(Channel::BaseColor).iter().filter(|c| !matches!(c, Channel::Height | Channel::Opacity));
        let mut images = Vec::new();
        for channel in kept {
            let image = source.channel(channel).ok_or("an exemplar has no base colour")?.finest();
            let n = image.components();
            let size = Vec2::from(image.size().map(|s| s as f32));
            let nothing = if channel == Channel::Normal { Vec3::Z } else { Vec3::ZERO };
            let filled = self.filled(lapped, n, nothing, |patch, x, y, shift| {
                let from = patch.content(Vec2::new(x as f32 + 0.5, y as f32 + 0.5)) + shift + patch.origin;
                let shown = image.bilinear(if source.wrap == Wrap::Repeat { from.rem_euclid(size) } else { from });
                if channel == Channel::Normal { patch.upright(shown) } else { shown }
            });
            images.push((channel, filled));
        }
        let mask = self.filled(lapped, 1, Vec3::ZERO, |patch, x, y, _| {
            let inside = (0..patch.size[0]).contains(&x) && (0..patch.size[1]).contains(&y);
            if inside { Vec3::splat(patch.mask.grey(x, y) * patch.left(x, y)) } else { Vec3::ZERO }
        });
        images.push((Channel::Opacity, mask));
        images.into_iter().map(|(channel, image)| Ok((channel, image?))).collect()
    }

    /// An image with `pixel(patch, x, y, shift)` in each window, x and y in pixels of its mask, and `nothing` elsewhere.
    fn filled(
        &self,
        lapped: &LappedTexture,
        components: usize,
        nothing: Vec3,
        pixel: impl Fn(&Under<'_>, i64, i64, Vec2) -> Vec3,
    ) -> Result<Image, String> {
        let [width, height] = self.size;
        let mut data = nothing.to_array()[..components].repeat(width as usize * height as usize);
        let rim = i64::from(APART);
        for (&(patch, offset, turn, ref cut), at) in &self.at {
            let patch = &lapped.patches[patch as usize];
            let under = Under {
                mask: patch.mask.finest(),
                cut: cut.as_ref(),
                turn,
                size: patch.mask.size().map(i64::from),
                origin: Vec2::new(patch.origin[0] as f32, patch.origin[1] as f32),
            };
            let shift = Vec2::from(offset.map(f32::from_bits));
            for y in -rim..under.size[1] + rim {
                for x in -rim..under.size[0] + rim {
                    let to = (i64::from(at[1]) + y) * i64::from(width) + i64::from(at[0]) + x;
                    let value = pixel(&under, x, y, shift).to_array();
                    data[to as usize * components..][..components].copy_from_slice(&value[..components]);
                }
            }
        }
        Image::new(width, height, components, data).ok_or_else(|| "the texture patches make an image too large".to_owned())
    }

    /// Where a place on a paste's mask, 0 to 1, lies on the image.
    fn place(&self, lapped: &LappedTexture, paste: &Paste, uv: Vec2) -> Vec2 {
        let size = Vec2::from(lapped.patches[paste.patch as usize].mask.size().map(|s| s as f32));
        let at = self.at.get(&window(paste)).map_or(Vec2::ZERO, |at| Vec2::from(at.map(|c| c as f32)));
        (at + uv * size) / Vec2::from(self.size.map(|s| s as f32))
    }
}

/// Triangles of pastes that follow each other.
#[derive(Default)]
struct Layer {
    positions: Vec<Vec3>,
    normals: Vec<Vec3>,
    uv: Vec<Vec2>,
    /// Direction in which the image goes right, and the sign of the one in which it goes up.
    tangents: Vec<Vec4>,
    /// What the image's colours are multiplied by, if any layer has a base; up to 1 over [`DETAIL`](crate::exemplar::DETAIL).
    colors: Vec<Vec3>,
    indices: Vec<u32>,
}

impl Layer {
    /// `over` has the layer of each paste.
    fn new(record: &Record, run: &[Paste], over: &[Option<&SoftLayer>], based: bool, sheet: &Sheet) -> Self {
        let model = &record.model;
        let mut out = Self::default();
        for (paste, over) in run.iter().zip(over) {
            // Within a paste corners at one vertex, one place and of one colour are one.
            let mut made: BTreeMap<(u32, [u32; 2], BaseColor), u32> = BTreeMap::new();
            for (&face, uv) in paste.faces.iter().zip(&paste.uv) {
                if beyond(uv) {
                    continue;
                }
                let corners = model.faces[face as usize];
                let right = right(corners.map(|v| model.positions[v as usize]), uv);
                for (k, &vertex) in corners.iter().enumerate() {
                    let base = over.and_then(|layer| layer.base.get(face as usize)).map_or_else(BaseColor::default, |b| b[k]);
                    let key = (vertex, uv[k].to_array().map(f32::to_bits), base);
                    let index = *made.entry(key).or_insert_with(|| {
                        out.positions.push(model.positions[vertex as usize]);
                        out.normals.extend(model.normals.as_ref().map(|n| n[vertex as usize]));
                        out.uv.push(sheet.place(&record.lapped, paste, uv[k]));
                        out.tangents.push(Vec4::ZERO);
                        if based {
                            let mut bary = Vec3::ZERO;
                            bary[k] = 1.0;
                            out.colors.push(over.map_or(Vec3::ONE, |layer| layer.gain(SurfacePoint { face, bary })));
                        }
                        out.positions.len() as u32 - 1
                    });
                    out.tangents[index as usize] += right;
                    out.indices.push(index);
                }
            }
        }
        for (tangent, normal) in out.tangents.iter_mut().zip(&out.normals) {
            let along = tangent.truncate().reject_from_normalized(*normal).normalize_or(normal.any_orthonormal_vector());
            *tangent = along.extend(if tangent.w < 0.0 { -1.0 } else { 1.0 });
        }
        out
    }

    /// Adds the primitive to the tables; tangents only where there is a normal map.
    fn add(self, tables: &mut Builder<'_>, material: usize, normal_map: bool) -> Option<Value> {
        let Self { positions, normals, uv, tangents, colors, indices } = self;
        if indices.is_empty() {
            return None;
        }
        let start = (Vec3::INFINITY, Vec3::NEG_INFINITY);
        let (low, high) = positions.iter().fold(start, |(lo, hi), &p| (lo.min(p), hi.max(p)));
        let count = positions.len();
        let with_normals = normals.len() == count;
        let position = tables.vectors(Some(VERTICES), count, move |k| positions[k].to_array())?;
        tables.bound(position, &low.as_dvec3().to_array(), &high.as_dvec3().to_array());
        let mut attributes = json!({ "POSITION": position });
        if with_normals {
            attributes["NORMAL"] = tables.vectors(Some(VERTICES), count, move |k| normals[k].to_array())?.into();
            if normal_map {
                attributes["TANGENT"] = tables.vectors(Some(VERTICES), count, move |k| tangents[k].to_array())?.into();
            }
        }
        attributes["TEXCOORD_0"] = tables.vectors(Some(VERTICES), count, move |k| uv[k].to_array())?.into();
        if let Some(colors) = tables.vectors(Some(VERTICES), colors.len(), move |k| colors[k].to_array()) {
            attributes["COLOR_0"] = colors.into();
        }
        let shape = Shape { name: "SCALAR", component: U32, target: Some(INDICES) };
        let indices =
            tables.accessor(shape, indices.len(), move |out| indices.iter().try_for_each(|i| out.write_all(&i.to_le_bytes())))?;
        Some(json!({ "attributes": attributes, "indices": indices, "material": material }))
    }
}

/// The direction on a face in which its image goes right, as long as the face is large; w is positive if the image is not
/// mirrored.
fn right([a, b, c]: [Vec3; 3], uv: &[Vec2; 3]) -> Vec4 {
    let (d, e) = (uv[1] - uv[0], uv[2] - uv[0]);
    // The image counts downward, so that an unmirrored face runs against it.
    let turn = -d.perp_dot(e);
    let along = ((c - a) * d.y - (b - a) * e.y) * turn.signum();
    let size = (b - a).cross(c - a).length();
    (along.normalize_or_zero() * size).extend(size * turn.signum())
}
