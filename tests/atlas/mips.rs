//! Mip levels: of covered texels alone, and in the file as in memory.

#![allow(clippy::unwrap_used, reason = "a test may fail by panicking")]

use crate::bake::Smooth;
use glam::Vec3;
use lapped::atlas::{BakeOptions, UnwrapOptions, mip_levels};
use lapped::exemplar::{Channel, Image, srgb};
use lapped::format::export::write_mips;
use lapped::job::{BakeJob, bake_model};
use lapped::mesh::{CleanOptions, clean};
use lapped::progress::Silent;
use lapped::random::Random;

/// A page of which a part is covered; what is not covered would be seen at once.
fn page(side: u32) -> (Vec<bool>, Vec<(Channel, Image)>) {
    let mut random = Random::new(7, 0);
    // Whole blocks without any chart, so that some coarse texels have none either.
    let block = |x: u32, y: u32| !(x / 8 + y / 8).is_multiple_of(3);
    let covered: Vec<bool> = (0..side * side).map(|i| block(i % side, i / side) && random.unit() < 0.7).collect();
    let mut value = |i: usize| if covered[i] { random.unit() as f32 } else { 1000.0 };
    let grey: Vec<f32> = (0..covered.len()).map(&mut value).collect();
    let color: Vec<f32> = (0..3 * covered.len()).map(|k| value(k / 3)).collect();
    let images = vec![
        (Channel::BaseColor, Image::new(side, side, 3, color).unwrap()),
        (Channel::Roughness, Image::new(side, side, 1, grey).unwrap()),
    ];
    (covered, images)
}

#[test]
fn each_texel_of_a_level_is_the_mean_of_the_covered_ones_under_it() {
    let side = 64;
    let (covered, images) = page(side);
    let levels = mip_levels(&covered, &images);
    assert_eq!(levels.len(), 6, "32, 16, 8, 4, 2 and 1 texels");
    for (k, level) in levels.iter().enumerate() {
        let coarse = side >> (k + 1);
        let block = side / coarse;
        for (channel, image) in level {
            assert_eq!(image.size(), [coarse; 2], "level {k} of {channel:?}");
            let finest = &images.iter().find(|(c, _)| c == channel).unwrap().1;
            for y in 0..coarse {
                for x in 0..coarse {
                    let under: Vec<f32> = (y * block..(y + 1) * block)
                        .flat_map(|v| (x * block..(x + 1) * block).map(move |u| (v * side + u) as usize))
                        .filter(|&i| covered[i])
                        .map(|i| finest.data()[i * finest.components()])
                        .collect();
                    let found = image.grey(i64::from(x), i64::from(y));
                    assert!((0.0..=1.0).contains(&found), "level {k}, {x} {y}: {found} is on no chart");
                    if !under.is_empty() {
                        let mean = under.iter().sum::<f32>() / under.len() as f32;
                        assert!((found - mean).abs() < 1e-4, "level {k} of {channel:?}, {x} {y}: {found}, not {mean}");
                    }
                }
            }
        }
    }
}

#[test]
fn sides_that_are_no_powers_of_two_lose_no_texel() {
    for side in [50, 37, 17] {
        let (covered, images) = page(side);
        let levels = mip_levels(&covered, &images);
        let sides: Vec<u32> = levels.iter().map(|level| level[0].1.size()[0]).collect();
        let halves: Vec<u32> = std::iter::successors(Some(side / 2), |s| (*s > 1).then_some(s / 2)).collect();
        assert_eq!(sides, halves, "halved and rounded down from {side}");
        let (sum, count) =
            covered.iter().zip(images[1].1.data()).filter(|(c, _)| **c).fold((0.0, 0.0), |(s, n), (_, v)| (s + v, n + 1.0));
        let last = levels.last().unwrap()[1].1.data()[0];
        assert!((last - sum / count).abs() < 1e-4, "{side}: the last texel is {last}, the mean of all {}", sum / count);
    }
}

#[test]
fn normals_of_all_levels_have_unit_length() {
    let (covered, _) = page(32);
    let mut random = Random::new(9, 0);
    let normal = |_| Vec3::new(random.range(-1.0, 1.0) as f32, random.range(-1.0, 1.0) as f32, 0.5).normalize().to_array();
    let data: Vec<f32> = (0..32 * 32).flat_map(normal).collect();
    let levels = mip_levels(&covered, &[(Channel::Normal, Image::new(32, 32, 3, data).unwrap())]);
    for normal in levels.iter().flat_map(|level| level[0].1.data().as_chunks::<3>().0) {
        let length = Vec3::from_array(*normal).length();
        assert!((length - 1.0).abs() < 1e-4, "a normal of length {length}");
    }
}

/// What a KTX 2.0 file says, read as its specification has it.
struct Ktx {
    format: u32,
    /// Side and bytes of each level, the largest first.
    levels: Vec<(u32, Vec<u8>)>,
}

fn read(file: &[u8]) -> Ktx {
    let word = |at: usize| u32::from_le_bytes(file[at..at + 4].try_into().unwrap());
    let long = |at: usize| u64::from_le_bytes(file[at..at + 8].try_into().unwrap()) as usize;
    assert_eq!(&file[..12], b"\xABKTX 20\xBB\r\n\x1A\n", "the identifier");
    let (format, pixel) = (word(12), if word(12) == 70 { 2 } else { 4 });
    assert_eq!(word(16), if format == 70 { 2 } else { 1 }, "bytes of a number");
    assert_eq!((word(28), word(32), word(36)), (0, 0, 1), "no depth, no layers, one face");
    assert_eq!(word(44), 0, "not compressed");
    let (descriptor, entries) = (word(48) as usize, word(56) as usize);
    assert_eq!(word(descriptor), word(52), "the descriptor says its own length");
    let samples = if format == 70 { 1 } else { 4 };
    assert_eq!(word(descriptor + 8), 2 | (24 + 16 * samples) << 16, "a basic block of {samples} channels");
    assert_eq!(u32::from(file[descriptor + 14]), if format == 43 { 2 } else { 1 }, "the transfer function is the format's");
    assert_eq!(u32::from(file[descriptor + 20]), pixel, "bytes of a pixel");
    let key = word(entries) as usize;
    assert_eq!(&file[entries + 4..entries + 4 + key], b"KTXorientation\0rd\0", "rows from the top");
    let mut ends = Vec::new();
    let levels = (0..word(40))
        .map(|k| {
            let at = 80 + 24 * k as usize;
            let (start, length) = (long(at), long(at + 8));
            assert_eq!(length, long(at + 16), "as long as it is uncompressed");
            assert_eq!(start % 4, 0, "at a multiple of four bytes");
            let side = (word(20) >> k).max(1);
            assert_eq!(length as u32, side * side * pixel, "level {k} is whole");
            ends.push(start + length);
            (side, file[start..start + length].to_vec())
        })
        .collect();
    assert_eq!(ends.iter().max(), Some(&file.len()), "nothing after the largest level");
    assert!(ends.windows(2).all(|w| w[0] > w[1]), "the smallest first");
    Ktx { format, levels }
}

#[test]
fn levels_are_written_beside_the_file_as_they_were_made() {
    let folder = tempfile::tempdir().unwrap();
    let model = lapped::assets::mesh("gear").unwrap();
    let cleaned = clean(&model.positions, &model.faces, &CleanOptions::default()).unwrap();
    let texture = Smooth::new(&cleaned.mesh, &Channel::ALL);
    let run = |mips| {
        let unwrap = UnwrapOptions { size: 200, mips: 0, ..UnwrapOptions::default() };
        let job = BakeJob { unwrap, bake: BakeOptions { mips, ..BakeOptions::default() }, ..BakeJob::default() };
        bake_model(&model, &cleaned.mesh, &cleaned.user_faces, &texture, &job, &Silent).unwrap().look
    };
    let path = folder.path().join("gear.glb");
    assert!(write_mips(&path, &run(false)).unwrap().is_empty(), "only when asked for");
    let look = run(true);
    let names = ["color", "orm", "normal", "emissive", "height"];
    let written = write_mips(&path, &look).unwrap();
    assert_eq!(written, names.map(|n| folder.path().join(format!("gear_{n}.ktx2"))), "a file for each map");
    let files = written.iter().map(|file| read(&std::fs::read(file).unwrap())).collect::<Vec<_>>();
    assert_eq!(files.iter().map(|f| f.format).collect::<Vec<_>>(), [43, 37, 37, 43, 70], "light as sRGB, heights of 16 bits");
    for file in &files {
        assert_eq!(file.levels.len(), 8, "200, 100, 50, 25, 12, 6, 3 and 1 texels");
    }
    for level in 0..8 {
        let images = if level == 0 { &look.pages[0] } else { &look.mips[0][level - 1] };
        let of = |channel: Channel| &images.iter().find(|(c, _)| *c == channel).unwrap().1;
        let (side, bytes) = &files[0].levels[level];
        assert_eq!(of(Channel::BaseColor).size(), [*side; 2], "level {level}");
        let (color, opacity) = (of(Channel::BaseColor).data(), of(Channel::Opacity).data());
        for (i, pixel) in bytes.as_chunks::<4>().0.iter().enumerate() {
            let expected = [0, 1, 2].map(|c| srgb::to_byte(color[3 * i + c]));
            assert_eq!(pixel[..3], expected, "level {level}, texel {i}");
            assert_eq!(pixel[3], (opacity[i] * 255.0).round() as u8, "level {level}, texel {i}: opacity");
        }
        let heights = files[4].levels[level].1.as_chunks::<2>().0.iter().map(|&b| u16::from_le_bytes(b));
        for (found, height) in heights.zip(of(Channel::Height).data()) {
            assert_eq!(found, (height * 65535.0).round() as u16, "level {level}: heights");
        }
    }
}
