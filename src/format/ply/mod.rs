//! PLY: ascii and both binary byte orders, any property types, faces and triangle strips.
//!
//! 1. The header is parsed to elements and properties. Declared counts are checked against the bytes that follow
//!    before anything is allocated.
//! 2. `vertex`, `face` and `tristrips` are read, everything else is stepped over.
//! 3. Texture coordinates given per corner (`texcoord` lists in faces) split vertices.

mod body;
mod header;

use super::corners::{cut_polygons, join_corners};
use super::error::Problem;
use super::model::{MAX_MODEL_FACES, Model};
use crate::exemplar::srgb;
use body::{AsciiBody, BinaryBody, Body};
use glam::{Vec2, Vec3, Vec4};
use header::{Element, Encoding, Header, Kind, Property, parse_header};

/// Reads a whole file, which begins with `ply`.
pub(crate) fn parse(file: &[u8]) -> Result<Model, Problem> {
    let (header, body) = parse_header(file)?;
    let mut builder = Builder::default();
    builder.model.source.unit.clone_from(&header.unit);
    match header.encoding {
        Encoding::Ascii => read_body(&header, &mut AsciiBody::new(body, header.lines), &mut builder)?,
        Encoding::Little => read_body(&header, &mut BinaryBody::<true>::new(body), &mut builder)?,
        Encoding::Big => read_body(&header, &mut BinaryBody::<false>::new(body), &mut builder)?,
    }
    builder.model.source.format = header.encoding.name().into();
    builder.finish()
}

/// What a property of a vertex is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Role {
    Position(usize),
    Normal(usize),
    Texture(usize),
    Color(usize),
    Other,
}

fn role(name: &str) -> Role {
    match name {
        "x" => Role::Position(0),
        "y" => Role::Position(1),
        "z" => Role::Position(2),
        "nx" | "normal_x" => Role::Normal(0),
        "ny" | "normal_y" => Role::Normal(1),
        "nz" | "normal_z" => Role::Normal(2),
        "s" | "u" | "texture_u" | "texture_s" => Role::Texture(0),
        "t" | "v" | "texture_v" | "texture_t" => Role::Texture(1),
        "red" | "r" | "diffuse_red" => Role::Color(0),
        "green" | "g" | "diffuse_green" => Role::Color(1),
        "blue" | "b" | "diffuse_blue" => Role::Color(2),
        "alpha" | "a" | "diffuse_alpha" => Role::Color(3),
        _ => Role::Other,
    }
}

#[derive(Debug, Default)]
struct Builder {
    model: Model,
    /// Vertices of all polygons in turn, and where each polygon ends.
    corners: Vec<u32>,
    ends: Vec<u32>,
    /// Texture coordinates of the corners; empty if none were given that way.
    corner_uvs: Vec<Vec2>,
    /// Name of the rows, and row, of the largest vertex index.
    largest: (u32, usize),
    thin: usize,
}

fn read_body<B: Body>(header: &Header, body: &mut B, builder: &mut Builder) -> Result<(), Problem> {
    for element in &header.elements {
        let smallest = B::smallest_row(element);
        if element.count > body.left().div_ceil(smallest.max(1)) && smallest > 0 {
            let (name, count) = (&element.name, element.count);
            let what = format!("the header declares {count} of element {name:?}, but only {} bytes follow", body.left());
            return Err(Problem::damaged("", what));
        }
        match element.name.as_str() {
            "vertex" => read_vertices(element, body, builder)?,
            "face" => read_faces(element, body, builder)?,
            "tristrips" => read_strips(element, body, builder)?,
            _ if smallest == 0 => {}
            _ => {
                for row in 0..element.count {
                    body.next_row().ok_or_else(|| cut_short(element, row, body))?;
                    skip(&element.properties, body).ok_or_else(|| cut_short(element, row, body))?;
                }
            }
        }
    }
    Ok(())
}

fn cut_short<B: Body>(element: &Element, row: usize, body: &B) -> Problem {
    let place = format!("{} {row}{}", element.name, body.place());
    if body.left() == 0 {
        Problem::damaged(place, format!("the file ends here, {} were declared", element.count))
    } else {
        Problem::damaged(place, "a number is missing, is not a number or is out of range")
    }
}

fn skip<B: Body>(properties: &[Property], body: &mut B) -> Option<()> {
    for property in properties {
        let times = match property.length {
            Some(length) => list_length(length, body)?,
            None => 1,
        };
        for _ in 0..times {
            body.number(property.kind)?;
        }
    }
    Some(())
}

/// Length of a list; never more than the file can hold.
fn list_length<B: Body>(kind: Kind, body: &mut B) -> Option<usize> {
    let length = body.number(kind)?;
    (length >= 0.0 && length <= body.left() as f64 && length.fract() == 0.0).then_some(length as usize)
}

fn read_vertices<B: Body>(element: &Element, body: &mut B, builder: &mut Builder) -> Result<(), Problem> {
    let roles: Vec<Role> =
        element.properties.iter().map(|p| if p.length.is_some() { Role::Other } else { role(&p.name) }).collect();
    if let Some(missing) = (0..3).find(|&k| !roles.contains(&Role::Position(k))) {
        return Err(Problem::damaged("header", format!("vertices have no {}", ["x", "y", "z"][missing])));
    }
    let model = &mut builder.model;
    model.source.vertices = element.count;
    model.positions.reserve_exact(element.count);
    let all = |wanted: &[Role]| wanted.iter().all(|r| roles.contains(r));
    let mut normals = all(&[Role::Normal(0), Role::Normal(1), Role::Normal(2)]).then(|| Vec::with_capacity(element.count));
    let mut uvs = all(&[Role::Texture(0), Role::Texture(1)]).then(|| Vec::with_capacity(element.count));
    let mut colors = all(&[Role::Color(0), Role::Color(1), Role::Color(2)]).then(|| Vec::with_capacity(element.count));
    let bytes = srgb::byte_table();
    for row in 0..element.count {
        body.next_row().ok_or_else(|| cut_short(element, row, body))?;
        let mut position = Vec3::ZERO;
        let mut normal = Vec3::ZERO;
        let mut uv = Vec2::ZERO;
        let mut color = Vec4::ONE;
        for (property, role) in element.properties.iter().zip(&roles) {
            if let Some(length) = property.length {
                let length = list_length(length, body).ok_or_else(|| cut_short(element, row, body))?;
                for _ in 0..length {
                    body.number(property.kind).ok_or_else(|| cut_short(element, row, body))?;
                }
                continue;
            }
            let value = body.number(property.kind).ok_or_else(|| cut_short(element, row, body))?;
            match *role {
                Role::Position(k) => position[k] = value as f32,
                Role::Normal(k) => normal[k] = value as f32,
                Role::Texture(0) => uv.x = value as f32,
                Role::Texture(_) => uv.y = (1.0 - value) as f32,
                Role::Color(3) => color.w = (value / property.kind.white()) as f32,
                Role::Color(k) if property.kind == Kind::U8 => color[k] = bytes[value as u8 as usize],
                Role::Color(k) => color[k] = srgb::decode((value / property.kind.white()) as f32),
                Role::Other => {}
            }
        }
        model.positions.push(position);
        normals.iter_mut().for_each(|n| n.push(normal));
        uvs.iter_mut().for_each(|t| t.push(uv));
        colors.iter_mut().for_each(|c| c.push(color));
    }
    (model.normals, model.uvs, model.colors) = (normals, uvs, colors);
    Ok(())
}

fn read_faces<B: Body>(element: &Element, body: &mut B, builder: &mut Builder) -> Result<(), Problem> {
    let Some(list) = element.list(&["vertex_indices", "vertex_index"]) else {
        return Err(Problem::damaged("header", "faces have no list of vertex indices"));
    };
    let texture = element.list(&["texcoord"]);
    builder.ends.reserve_exact(element.count);
    builder.corners.reserve(3 * element.count);
    let mut coordinates = Vec::new();
    for row in 0..element.count {
        body.next_row().ok_or_else(|| cut_short(element, row, body))?;
        let start = builder.corners.len();
        coordinates.clear();
        for (k, property) in element.properties.iter().enumerate() {
            let fail = |body: &B| cut_short(element, row, body);
            let Some(kind) = property.length else {
                body.number(property.kind).ok_or_else(|| fail(body))?;
                continue;
            };
            let length = list_length(kind, body).ok_or_else(|| fail(body))?;
            for _ in 0..length {
                let value = body.number(property.kind).ok_or_else(|| fail(body))?;
                if k == list {
                    builder.corner(value, row).ok_or_else(|| no_index(element, row, value, body))?;
                } else if Some(k) == texture {
                    coordinates.push(value as f32);
                }
            }
        }
        builder.end_polygon(start, &coordinates, row)?;
    }
    Ok(())
}

fn read_strips<B: Body>(element: &Element, body: &mut B, builder: &mut Builder) -> Result<(), Problem> {
    let Some(list) = element.list(&["vertex_indices", "vertex_index"]) else {
        return Err(Problem::damaged("header", "triangle strips have no list of vertex indices"));
    };
    for row in 0..element.count {
        body.next_row().ok_or_else(|| cut_short(element, row, body))?;
        skip(&element.properties[..list], body).ok_or_else(|| cut_short(element, row, body))?;
        let property = &element.properties[list];
        let length = property.length.and_then(|kind| list_length(kind, body)).ok_or_else(|| cut_short(element, row, body))?;
        let mut strip: [f64; 2] = [-1.0; 2];
        let mut turned = false;
        for _ in 0..length {
            let value = body.number(property.kind).ok_or_else(|| cut_short(element, row, body))?;
            // A negative index ends a strip; the next vertex begins another.
            if value < 0.0 {
                (strip, turned) = ([-1.0; 2], false);
                continue;
            }
            let [a, b] = strip;
            if a >= 0.0 {
                // Triangles that repeat a vertex only steer the strip.
                if a != b && b != value && value != a {
                    let start = builder.corners.len();
                    for index in if turned { [b, a, value] } else { [a, b, value] } {
                        builder.corner(index, row).ok_or_else(|| no_index(element, row, index, body))?;
                    }
                    builder.end_polygon(start, &[], row)?;
                }
                turned = !turned;
            }
            strip = [b, value];
        }
        skip(&element.properties[list + 1..], body).ok_or_else(|| cut_short(element, row, body))?;
    }
    Ok(())
}

fn no_index<B: Body>(element: &Element, row: usize, value: f64, body: &B) -> Problem {
    Problem::damaged(format!("{} {row}{}", element.name, body.place()), format!("{value} is no vertex index"))
}

impl Builder {
    /// Adds a corner to the polygon at hand. `None` if `index` cannot be one.
    fn corner(&mut self, index: f64, row: usize) -> Option<()> {
        if !(index >= 0.0 && index < f64::from(u32::MAX) && index.fract() == 0.0) {
            return None;
        }
        let index = index as u32;
        if self.corners.is_empty() || index > self.largest.0 {
            self.largest = (index, row);
        }
        self.corners.push(index);
        Some(())
    }

    fn end_polygon(&mut self, start: usize, coordinates: &[f32], row: usize) -> Result<(), Problem> {
        let corners = self.corners.len() - start;
        if corners < 3 {
            self.corners.truncate(start);
            self.thin += 1;
            return Ok(());
        }
        if self.corners.len() > 4 * MAX_MODEL_FACES {
            let what = format!("more than {MAX_MODEL_FACES} faces");
            return Err(Problem::new(format!("face {row}"), what, "split the mesh into several files"));
        }
        if coordinates.len() == 2 * corners {
            self.corner_uvs.resize(start, Vec2::ZERO);
            self.corner_uvs.extend(coordinates.chunks_exact(2).map(|t| Vec2::new(t[0], 1.0 - t[1])));
        }
        self.ends.push(self.corners.len() as u32);
        Ok(())
    }

    fn finish(mut self) -> Result<Model, Problem> {
        let vertices = self.model.positions.len();
        let (index, row) = self.largest;
        if !self.corners.is_empty() && index as usize >= vertices {
            let what = format!("it uses vertex {index}, but there are only {vertices} vertices (counting from 0)");
            return Err(Problem::damaged(format!("face {row}"), what));
        }
        if self.thin > 0 {
            self.model.source.notes.push(format!("{} faces with fewer than three corners were left out", self.thin));
        }
        self.model.source.polygons = self.ends.len();
        let (mut faces, polygons) = cut_polygons(&self.ends, |c| self.model.positions[self.corners[c as usize] as usize]);
        if self.corner_uvs.is_empty() {
            faces.as_flattened_mut().iter_mut().for_each(|c| *c = self.corners[*c as usize]);
        } else {
            self.corner_uvs.resize(self.corners.len(), Vec2::ZERO);
            let kept = join_corners(&mut faces, vertices, |c| {
                (self.corners[c as usize], self.corner_uvs[c as usize].to_array().map(f32::to_bits))
            });
            self.model.take_vertices(&kept);
        }
        self.model.faces = faces;
        self.model.polygons = polygons;
        self.model.finish(|v| format!("vertex {v}"))
    }
}

impl Model {
    /// Repeats vertices for the distinct texture coordinates of their corners.
    fn take_vertices(&mut self, kept: &[(u32, Option<[u32; 2]>)]) {
        fn pick<T: Copy>(all: &mut Vec<T>, kept: &[(u32, Option<[u32; 2]>)]) {
            *all = kept.iter().map(|&(v, _)| all[v as usize]).collect();
        }
        pick(&mut self.positions, kept);
        self.normals.iter_mut().for_each(|n| pick(n, kept));
        self.colors.iter_mut().for_each(|c| pick(c, kept));
        self.uvs = Some(kept.iter().map(|&(_, t)| t.map_or(Vec2::ZERO, |t| Vec2::from_array(t.map(f32::from_bits)))).collect());
    }
}
