//! KTX 2.0: an image with its mip levels, uncompressed, as game engines and texture tools take it.
//!
//! Based on: Khronos Texture 2.0 specification and the Khronos Data Format Specification 1.3 (basic descriptor block).
//!
//! Levels are listed from the largest and stored from the smallest, each at a multiple of the pixel's bytes and of four.

use super::pixels::{Pixels, Slot};
use image::ExtendedColorType;

const IDENTIFIER: [u8; 12] = [0xAB, b'K', b'T', b'X', b' ', b'2', b'0', 0xBB, b'\r', b'\n', 0x1A, b'\n'];

/// Numbers of Vulkan's formats.
const R8G8B8A8_UNORM: u32 = 37;
const R8G8B8A8_SRGB: u32 = 43;
const R16_UNORM: u32 = 70;

/// Names of channels in a descriptor, and the bit of one that is linear where the others are not.
const CHANNELS: [u8; 4] = [0, 1, 2, 15];
const LINEAR: u8 = 0x10;

/// Key and value of the entries in front of the data.
const ENTRIES: [(&str, &str); 2] = [("KTXorientation", "rd"), ("KTXwriter", concat!("lapped ", env!("CARGO_PKG_VERSION")))];

/// Bytes before the index of levels, and of each entry there.
const HEAD: usize = 80;
const LEVEL: usize = 24;

/// The file of one slot's levels, the largest first.
pub(crate) fn encode(slot: Slot, levels: &[Pixels]) -> Vec<u8> {
    let light = matches!(slot, Slot::Color | Slot::Emissive);
    let deep = slot == Slot::Height;
    let (format, pixel) = match (deep, light) {
        (true, _) => (R16_UNORM, 2),
        (_, true) => (R8G8B8A8_SRGB, 4),
        _ => (R8G8B8A8_UNORM, 4),
    };
    let descriptor = descriptor(light, deep);
    let entries: Vec<u8> = ENTRIES.iter().flat_map(|(key, value)| entry(key, value)).collect();
    let [width, height] = levels.first().map_or([0; 2], |l| l.size);
    let after_index = HEAD + LEVEL * levels.len();
    let mut out = Vec::new();
    out.extend(IDENTIFIER);
    let head = [format, if deep { 2 } else { 1 }, width, height, 0, 0, 1, levels.len() as u32, 0];
    let places = [after_index, descriptor.len(), after_index + descriptor.len(), entries.len()].map(|v| v as u32);
    out.extend(head.into_iter().chain(places).flat_map(u32::to_le_bytes));
    out.extend([0; 16]);
    let mut at = after_index + descriptor.len() + entries.len();
    let mut index = vec![[0_u64; 2]; levels.len()];
    for (level, place) in levels.iter().zip(&mut index).rev() {
        at = at.next_multiple_of(4);
        let length = level.size.map(|s| s as usize).iter().product::<usize>() * pixel;
        *place = [at as u64, length as u64];
        at += length;
    }
    out.extend(index.iter().flat_map(|&[at, length]| [at, length, length]).flat_map(u64::to_le_bytes));
    out.extend(descriptor);
    out.extend(entries);
    for level in levels.iter().rev() {
        out.resize(out.len().next_multiple_of(4), 0);
        append(&mut out, level);
    }
    out
}

/// The descriptor: what the bits of a pixel are.
fn descriptor(light: bool, deep: bool) -> Vec<u8> {
    let samples: &[u8] = if deep { &CHANNELS[..1] } else { &CHANNELS };
    let (bits, most): (u16, u32) = if deep { (16, 65535) } else { (8, 255) };
    let block = 24 + 16 * samples.len() as u32;
    let mut out = Vec::new();
    out.extend((4 + block).to_le_bytes());
    // Khronos, basic; version 2 and the block's length.
    out.extend([0, 2 | block << 16].into_iter().flat_map(u32::to_le_bytes));
    // RGB and alpha apart, primaries of BT.709, linear or sRGB, alpha not multiplied in; blocks of one pixel.
    out.extend([1, 1, if light { 2 } else { 1 }, 0, 0, 0, 0, 0]);
    out.extend([if deep { 2 } else { 4 }, 0, 0, 0, 0, 0, 0, 0]);
    for (k, &channel) in samples.iter().enumerate() {
        let kind = if light && channel == CHANNELS[3] { channel | LINEAR } else { channel };
        out.extend((k as u16 * bits).to_le_bytes());
        out.extend([bits as u8 - 1, kind, 0, 0, 0, 0]);
        out.extend([0, most].into_iter().flat_map(u32::to_le_bytes));
    }
    out
}

fn entry(key: &str, value: &str) -> Vec<u8> {
    let text = format!("{key}\0{value}\0").into_bytes();
    let mut out = (text.len() as u32).to_le_bytes().to_vec();
    out.extend(text);
    out.resize(out.len().next_multiple_of(4), 0);
    out
}

/// The bytes of a level: numbers of 16 bits with the low byte first, colours with their alpha.
fn append(out: &mut Vec<u8>, level: &Pixels) {
    let bytes = &level.bytes;
    match level.color {
        ExtendedColorType::L16 => {
            out.extend(bytes.as_chunks::<2>().0.iter().flat_map(|&b| u16::from_ne_bytes(b).to_le_bytes()));
        }
        ExtendedColorType::Rgb8 => out.extend(bytes.as_chunks::<3>().0.iter().flat_map(|&[r, g, b]| [r, g, b, 255])),
        _ => out.extend(bytes),
    }
}
