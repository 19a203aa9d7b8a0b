//! Circles kept in a file, so that a mesh is marched about once for all textures and directions.
//!
//! Little-endian: the magic and the version; the mesh's key, the pixel, the radii; what marching met; the three tables; a checksum of all
//! before it. A file that is not whole, or was made by another version or for another mesh, is told from one that fits.

use super::marching::{Arc, Marching, MarchingStatistics};
use crate::mesh::Mesh;

const MAGIC: [u8; 8] = *b"LAPPEDMC";
const VERSION: u32 = 1;

/// Bytes before the radii, and of the five counts and three lengths after them.
const HEAD: usize = 8 + 4 + 8 + 8 + 4;
const COUNTS: usize = 8 * 8;

/// Why bytes are not the circles of a mesh.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum CacheError {
    /// Something else.
    #[error("this is not a file of marched circles")]
    Other,
    /// Another version's.
    #[error("these circles are of version {0}, and version {VERSION} is read: march again")]
    Version(u32),
    /// Another mesh's.
    #[error("these circles were marched on another mesh: march again")]
    Mesh,
    /// Other circles of the same mesh.
    #[error("these circles are of another scale, or are not those of as many levels: march again")]
    Circles,
    /// Cut short, or changed.
    #[error("the file of circles is damaged: march again")]
    Damaged,
}

/// A hash (Fowler, Noll, Vo, by words) of numbers.
fn hash(start: u64, words: impl Iterator<Item = u32>) -> u64 {
    words.fold(start, |h, w| (h ^ u64::from(w)).wrapping_mul(0x0000_0100_0000_01B3).rotate_left(23))
}

const START: u64 = 0xCBF2_9CE4_8422_2325;

/// What marching depends on of a mesh, in a number: its positions, bit by bit, and its faces.
#[must_use]
pub fn mesh_key(mesh: &Mesh) -> u64 {
    let places = mesh.positions.iter().flat_map(|p| p.to_array().map(f32::to_bits));
    let counts = [mesh.vertex_count() as u32, mesh.face_count() as u32];
    hash(hash(START, counts.into_iter().chain(places)), mesh.faces.iter().flatten().copied())
}

fn checksum(bytes: &[u8]) -> u64 {
    let (words, rest) = bytes.as_chunks::<4>();
    hash(hash(START, words.iter().map(|w| u32::from_le_bytes(*w))), rest.iter().map(|&b| u32::from(b)))
}

/// Reads numbers off the front of bytes.
struct Taker<'a>(&'a [u8]);

impl<'a> Taker<'a> {
    fn bytes(&mut self, count: usize) -> Result<&'a [u8], CacheError> {
        let (taken, rest) = self.0.split_at_checked(count).ok_or(CacheError::Damaged)?;
        self.0 = rest;
        Ok(taken)
    }

    fn array<const N: usize>(&mut self) -> Result<[u8; N], CacheError> {
        self.bytes(N)?.try_into().map_err(|_| CacheError::Damaged)
    }

    fn u32(&mut self) -> Result<u32, CacheError> {
        Ok(u32::from_le_bytes(self.array()?))
    }

    fn u64(&mut self) -> Result<u64, CacheError> {
        Ok(u64::from_le_bytes(self.array()?))
    }

    fn words(&mut self, count: u64) -> Result<Vec<u32>, CacheError> {
        let bytes = usize::try_from(count).ok().and_then(|c| c.checked_mul(4)).ok_or(CacheError::Damaged)?;
        Ok(self.bytes(bytes)?.as_chunks::<4>().0.iter().map(|w| u32::from_le_bytes(*w)).collect())
    }
}

impl Marching {
    /// The bytes of a file.
    #[must_use]
    pub fn to_bytes(&self) -> Vec<u8> {
        let mut out = Vec::with_capacity(HEAD + COUNTS + 8 + 4 * self.radii.len() + self.bytes());
        out.extend(MAGIC);
        out.extend(VERSION.to_le_bytes());
        out.extend(self.key.to_le_bytes());
        out.extend(self.pixel.to_le_bytes());
        out.extend((self.radii.len() as u32).to_le_bytes());
        self.radii.iter().for_each(|r| out.extend(r.to_le_bytes()));
        let s = self.statistics;
        let lengths = [self.starts.len(), self.arcs.len(), self.crossings.len()].map(|l| l as u64);
        [s.closed, s.open, s.missing, s.incomplete, s.crossings]
            .into_iter()
            .chain(lengths)
            .for_each(|n| out.extend(n.to_le_bytes()));
        self.starts.iter().for_each(|s| out.extend(s.to_le_bytes()));
        self.arcs.iter().for_each(|a| [a.half_edge, a.first, a.length.to_bits()].iter().for_each(|w| out.extend(w.to_le_bytes())));
        self.crossings.iter().for_each(|c| out.extend(c.to_le_bytes()));
        let sum = checksum(&out);
        out.extend(sum.to_le_bytes());
        out
    }

    /// The circles in a file's bytes, if they are of this mesh.
    ///
    /// # Errors
    /// If they are not, or are damaged.
    pub fn from_bytes(bytes: &[u8], mesh: &Mesh) -> Result<Self, CacheError> {
        let mut take = Taker(bytes);
        if take.bytes(MAGIC.len()).is_ok_and(|m| m != MAGIC) || bytes.len() < MAGIC.len() {
            return Err(CacheError::Other);
        }
        let version = take.u32()?;
        if version != VERSION {
            return Err(CacheError::Version(version));
        }
        let (content, sum) = bytes.split_at_checked(bytes.len().saturating_sub(8)).ok_or(CacheError::Damaged)?;
        if sum != checksum(content).to_le_bytes() {
            return Err(CacheError::Damaged);
        }
        let key = take.u64()?;
        if key != mesh_key(mesh) {
            return Err(CacheError::Mesh);
        }
        let pixel = f64::from_le_bytes(take.array()?);
        let count = take.u32()?;
        let radii = take.words(count.into())?;
        let mut counts = [0; 8];
        for c in &mut counts {
            *c = take.u64()?;
        }
        let [closed, open, missing, incomplete, crossings, ..] = counts;
        let statistics = MarchingStatistics { closed, open, missing, incomplete, crossings };
        let starts = take.words(counts[5])?;
        let arcs = take.words(counts[6].saturating_mul(3))?;
        let arc = |w: &[u32; 3]| Arc { half_edge: w[0], first: w[1], length: f32::from_bits(w[2]) };
        let arcs: Vec<Arc> = arcs.as_chunks::<3>().0.iter().map(arc).collect();
        let crossings = take.words(counts[7])?;
        let half_edges = mesh.opposite.len();
        let sound = take.0.len() == 8
            && starts.len() == mesh.vertex_count() * radii.len() + 1
            && starts.is_sorted()
            && starts.last() == Some(&(arcs.len() as u32))
            && arcs.iter().all(|a| (a.half_edge as usize) < half_edges && (a.first as usize) < crossings.len());
        if !sound {
            return Err(CacheError::Damaged);
        }
        Ok(Self { key, pixel, radii, starts, arcs, crossings, statistics })
    }
}
