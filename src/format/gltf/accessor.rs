//! Numbers out of glTF accessors: every offset, stride and count is checked against the bytes there are.

use super::document::{Accessor, Document};
use crate::format::error::Problem;
use std::borrow::Cow;

/// Elements without bytes of their own are zeros (sparse accessors may replace some). More than this are refused,
/// because a few bytes of file could ask for any amount of memory.
pub(crate) const MOST_IMPLICIT: u64 = 1 << 22;

/// Bytes of the largest element, a matrix.
const LARGEST: usize = 64;

/// A document with its buffers.
#[derive(Debug)]
pub(crate) struct Data<'a> {
    pub(crate) document: &'a Document,
    pub(crate) buffers: &'a [Cow<'a, [u8]>],
}

/// Type of one component.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Component {
    I8,
    U8,
    I16,
    U16,
    U32,
    F32,
}

impl Component {
    fn new(code: u32) -> Option<Self> {
        Some(match code {
            5120 => Self::I8,
            5121 => Self::U8,
            5122 => Self::I16,
            5123 => Self::U16,
            5125 => Self::U32,
            5126 => Self::F32,
            _ => return None,
        })
    }

    const fn size(self) -> u64 {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::U32 | Self::F32 => 4,
        }
    }

    /// A component at the start of `b`, which is long enough.
    #[inline]
    fn float(self, b: &[u8], normalized: bool) -> f32 {
        let scale = |value: f32, most: f32| if normalized { (value / most).max(-1.0) } else { value };
        match self {
            Self::I8 => scale(f32::from(b[0] as i8), 127.0),
            Self::U8 => scale(f32::from(b[0]), 255.0),
            Self::I16 => scale(f32::from(i16::from_le_bytes([b[0], b[1]])), 32767.0),
            Self::U16 => scale(f32::from(u16::from_le_bytes([b[0], b[1]])), 65535.0),
            Self::U32 => u32::from_le_bytes([b[0], b[1], b[2], b[3]]) as f32,
            Self::F32 => f32::from_le_bytes([b[0], b[1], b[2], b[3]]),
        }
    }

    /// The same as a whole number; `None` for types that are none or have a sign.
    #[inline]
    fn index(self, b: &[u8]) -> Option<u32> {
        match self {
            Self::U8 => Some(u32::from(b[0])),
            Self::U16 => Some(u32::from(u16::from_le_bytes([b[0], b[1]]))),
            Self::U32 => Some(u32::from_le_bytes([b[0], b[1], b[2], b[3]])),
            _ => None,
        }
    }
}

/// Where the elements of an accessor lie: `count` of `size` bytes each, `stride` apart.
struct Layout<'a> {
    bytes: &'a [u8],
    count: usize,
    size: usize,
    stride: usize,
}

impl Layout<'_> {
    #[inline]
    fn element(&self, k: usize) -> &[u8] {
        &self.bytes[k * self.stride..k * self.stride + self.size]
    }
}

impl<'a> Data<'a> {
    /// Elements of `N` floats, from components of any type.
    pub(crate) fn floats<const N: usize>(&self, accessor: usize) -> Result<Vec<[f32; N]>, Problem> {
        let a = self.accessor(accessor, N)?;
        let component = self.component(accessor, a.component_type)?;
        let decode = |b: &[u8]| std::array::from_fn(|k| component.float(&b[k * component.size() as usize..], a.normalized));
        self.elements(accessor, a, component, N, decode)
    }

    /// Whole numbers without sign.
    pub(crate) fn indices(&self, accessor: usize) -> Result<Vec<u32>, Problem> {
        Ok(self.whole::<1>(accessor)?.into_iter().map(|[index]| index).collect())
    }

    /// Elements of `N` whole numbers without sign.
    pub(crate) fn whole<const N: usize>(&self, accessor: usize) -> Result<Vec<[u32; N]>, Problem> {
        let a = self.accessor(accessor, N)?;
        let component = self.component(accessor, a.component_type)?;
        if component.index(&[0; 4]).is_none() {
            return Err(Problem::damaged(place(accessor), "its component type cannot hold indices"));
        }
        let size = component.size() as usize;
        let decode = |b: &[u8]| std::array::from_fn(|k| component.index(&b[k * size..]).unwrap_or_default());
        self.elements(accessor, a, component, N, decode)
    }

    /// The bytes of a buffer view.
    pub(crate) fn view(&self, index: usize) -> Result<&'a [u8], Problem> {
        let place = || format!("buffer view {index}");
        let view = self.document.buffer_views.get(index).ok_or_else(|| Problem::damaged(place(), "there is no such view"))?;
        let buffer = self.buffers.get(view.buffer).ok_or_else(|| Problem::damaged(place(), "its buffer does not exist"))?;
        let end = view.byte_offset.checked_add(view.byte_length).filter(|&end| end <= buffer.len() as u64);
        let end = end.ok_or_else(|| Problem::damaged(place(), "it reaches beyond its buffer"))?;
        Ok(&buffer[view.byte_offset as usize..end as usize])
    }

    fn accessor(&self, index: usize, components: usize) -> Result<&'a Accessor, Problem> {
        let a = self.document.accessors.get(index).ok_or_else(|| missing(index))?;
        let has = match a.r#type.as_str() {
            "SCALAR" => 1,
            "VEC2" => 2,
            "VEC3" => 3,
            "VEC4" => 4,
            "MAT4" => 16,
            _ => 0,
        };
        if has != components {
            return Err(Problem::damaged(place(index), format!("its type is {:?}, {components} components are needed", a.r#type)));
        }
        Ok(a)
    }

    fn component(&self, accessor: usize, code: u32) -> Result<Component, Problem> {
        Component::new(code).ok_or_else(|| Problem::damaged(place(accessor), format!("component type {code} does not exist")))
    }

    fn elements<T: Clone>(
        &self,
        index: usize,
        a: &Accessor,
        component: Component,
        components: usize,
        decode: impl Fn(&[u8]) -> T,
    ) -> Result<Vec<T>, Problem> {
        let size = component.size() * components as u64;
        let mut values = match a.buffer_view {
            Some(view) => {
                let layout = self.layout(index, view, a.byte_offset, a.count, size)?;
                (0..layout.count).map(|k| decode(layout.element(k))).collect()
            }
            None if a.sparse.is_none() && a.count > 0 => {
                let what = "it has no data (compressed geometry is not read)";
                return Err(Problem::new(place(index), what, "export the mesh again without compression"));
            }
            None if a.count > MOST_IMPLICIT => {
                return Err(Problem::damaged(place(index), format!("it declares {} elements without data", a.count)));
            }
            None => vec![decode(&[0; LARGEST]); a.count as usize],
        };
        if let Some(sparse) = &a.sparse {
            let kind = self.component(index, sparse.indices.component_type)?;
            let at = self.layout(index, sparse.indices.buffer_view, sparse.indices.byte_offset, sparse.count, kind.size())?;
            let by = self.layout(index, sparse.values.buffer_view, sparse.values.byte_offset, sparse.count, size)?;
            for k in 0..at.count {
                let target = kind.index(at.element(k)).and_then(|t| values.get_mut(t as usize));
                let target = target.ok_or_else(|| Problem::damaged(place(index), format!("sparse index {k} is out of range")))?;
                *target = decode(by.element(k));
            }
        }
        Ok(values)
    }

    fn layout(&self, accessor: usize, view: usize, offset: u64, count: u64, size: u64) -> Result<Layout<'a>, Problem> {
        let bytes = self.view(view)?;
        let stride = self.document.buffer_views[view].byte_stride.unwrap_or(size);
        if stride < size {
            return Err(Problem::damaged(place(accessor), format!("the stride of buffer view {view} is too small")));
        }
        let needed = if count == 0 { Some(0) } else { (count - 1).checked_mul(stride).and_then(|n| n.checked_add(size)) };
        let end = needed.and_then(|n| n.checked_add(offset)).filter(|&end| end <= bytes.len() as u64);
        if end.is_none() {
            let what = format!("its {count} elements reach beyond buffer view {view} of {} bytes", bytes.len());
            return Err(Problem::damaged(place(accessor), what));
        }
        let bytes = if count == 0 { &[] } else { &bytes[offset as usize..] };
        Ok(Layout { bytes, count: count as usize, size: size as usize, stride: stride as usize })
    }
}

fn place(accessor: usize) -> String {
    format!("accessor {accessor}")
}

fn missing(accessor: usize) -> Problem {
    Problem::damaged(place(accessor), "there is no such accessor")
}
