//! The GLB container: twelve bytes of header, one chunk of JSON, at most one of binary data.

use crate::format::error::Problem;
use std::io::{self, Write};

const MAGIC: &[u8; 4] = b"glTF";
const JSON: u32 = u32::from_le_bytes(*b"JSON");
const BIN: u32 = u32::from_le_bytes(*b"BIN\0");

/// True if the file is a GLB.
pub(crate) fn is_glb(file: &[u8]) -> bool {
    file.starts_with(MAGIC)
}

/// The JSON and binary chunks of a GLB.
pub(crate) fn split(file: &[u8]) -> Result<(&[u8], Option<&[u8]>), Problem> {
    let word = |at: usize| file.get(at..at + 4).and_then(|b| b.try_into().ok()).map(u32::from_le_bytes);
    let (Some(version), Some(length)) = (word(4), word(8)) else {
        return Err(Problem::damaged("", "the file is shorter than the header of a GLB"));
    };
    if version != 2 {
        let what = format!("it is glTF version {version}, only version 2 is read");
        return Err(Problem::new("", what, "export it again as glTF 2.0"));
    }
    if (length as usize) > file.len() {
        let what = format!("the header declares {length} bytes, but the file has {}", file.len());
        return Err(Problem::damaged("", what));
    }
    let mut rest = &file[12..(length as usize).max(12)];
    let mut json = None;
    let mut bin = None;
    while let Some((head, body)) = rest.split_first_chunk::<8>() {
        let [l0, l1, l2, l3, k0, k1, k2, k3] = *head;
        let (size, kind) = (u32::from_le_bytes([l0, l1, l2, l3]) as usize, u32::from_le_bytes([k0, k1, k2, k3]));
        if size > body.len() {
            let what = format!("a chunk declares {size} bytes, but only {} follow", body.len());
            return Err(Problem::damaged("", what));
        }
        let (chunk, after) = body.split_at(size);
        match kind {
            JSON if json.is_none() => json = Some(chunk),
            BIN if bin.is_none() => bin = Some(chunk),
            _ => {}
        }
        rest = after;
    }
    let json = json.ok_or_else(|| Problem::damaged("", "the GLB has no JSON chunk"))?;
    Ok((json, bin))
}

/// Bytes to append so that `length` becomes a multiple of four.
pub(crate) const fn padding(length: u64) -> usize {
    (length.wrapping_neg() % 4) as usize
}

/// Size of the whole file, if it fits the format's 32 bits.
pub(crate) fn size(json: usize, bin: u64) -> Option<u32> {
    let json = json as u64 + padding(json as u64) as u64;
    u32::try_from(12 + 8 + json + 8 + bin).ok()
}

/// Writes everything before the binary data, which must be `bin` bytes, a multiple of four.
pub(crate) fn write_head(out: &mut dyn Write, json: &[u8], bin: u32, size: u32) -> io::Result<()> {
    out.write_all(MAGIC)?;
    out.write_all(&2_u32.to_le_bytes())?;
    out.write_all(&size.to_le_bytes())?;
    let pad = padding(json.len() as u64);
    out.write_all(&((json.len() + pad) as u32).to_le_bytes())?;
    out.write_all(&JSON.to_le_bytes())?;
    out.write_all(json)?;
    out.write_all(&b"   "[..pad])?;
    out.write_all(&bin.to_le_bytes())?;
    out.write_all(&BIN.to_le_bytes())
}
