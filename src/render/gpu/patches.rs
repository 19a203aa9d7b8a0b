//! Exemplars and texture patches on the device.
//!
//! All exemplars lie in the layers of one array for each group of channels, all masks in squares of one array (see
//! [`super::packing`]). Pastes name patches by number, so another set of exemplars and patches can stand under the same
//! pastes: the texture changes at once, nothing is pasted again.

use super::context::Gpu;
use super::error::GpuError;
use super::packing::pack;
use super::renderer::Filter;
use super::shape::words;
use super::texture::{Code, Layers, Part, fill};
use crate::exemplar::{Channel, ChannelSet, Exemplar, Frames, FramesBy, TexturePatch, Wrap};
use crate::render::picture::to_byte;
use wgpu::TextureFormat;

/// The finest probes along a stretched sample that filtering takes.
const ANISOTROPY: u16 = 8;

/// Exemplars and texture patches ready to be drawn with.
#[derive(Debug)]
pub struct PatchTextures {
    pub(super) bindings: wgpu::BindGroup,
    pub(super) channels: ChannelSet,
    patches: usize,
    bytes: u64,
    warnings: Vec<String>,
    /// What each patch is, `PATCH_WORDS` numbers each.
    table: wgpu::Buffer,
    timed: Vec<Timed>,
}

/// An exemplar that changes with time.
#[derive(Debug)]
struct Timed {
    /// Its first frame in the table of exemplars.
    first: u32,
    /// The patches that show it.
    patches: Vec<u32>,
    /// When which frame shows.
    frames: Frames,
}

/// Numbers of a patch in its table, and the place of its exemplar among them (`Patch` in shaders/paste.wgsl).
const PATCH_WORDS: u64 = 10;
const PATCH_EXEMPLAR: u64 = 7;

/// The channel groups: their names and, for each, the channels.
const GROUPS: [(&str, &[Channel]); 4] = [
    ("base colours", &[Channel::BaseColor, Channel::Opacity]),
    ("normal maps", &[Channel::Normal, Channel::Height]),
    ("roughness maps", &[Channel::Roughness, Channel::Metallic, Channel::Occlusion]),
    ("emission maps", &[Channel::Emissive]),
];

impl PatchTextures {
    pub(super) fn new(
        gpu: &Gpu,
        layout: &wgpu::BindGroupLayout,
        filter: Filter,
        exemplars: &[Exemplar],
        patches: &[TexturePatch],
    ) -> Result<Self, GpuError> {
        let longest = gpu.limits.max_texture_dimension_2d;
        let mut warnings = Vec::new();
        let layers = gpu.limits.max_texture_array_layers as usize;
        let (frames, first) = with_frames(exemplars, layers, &mut warnings);
        let (arrays, exemplar_table) = upload_exemplars(gpu, &frames, longest, &mut warnings)?;
        let (masks, patch_table) = upload_masks(gpu, patches, &first, longest, &mut warnings)?;
        let patch_table = words(gpu, "patches", bytemuck::cast_slice(&patch_table));
        let exemplar_table = words(gpu, "exemplars", bytemuck::cast_slice(&exemplar_table));
        // Software adapters do not follow the gradients they are given, and look as far as they may: slow, and blurred.
        let software = gpu.device.adapter_info().device_type == wgpu::DeviceType::Cpu;
        let anisotropy = if filter == Filter::Anisotropic && !software { ANISOTROPY } else { 1 };
        let sampler = gpu.device.create_sampler(&wgpu::SamplerDescriptor {
            label: Some("filtered"),
            mag_filter: wgpu::FilterMode::Linear,
            min_filter: wgpu::FilterMode::Linear,
            mipmap_filter: wgpu::MipmapFilterMode::Linear,
            anisotropy_clamp: anisotropy,
            ..Default::default()
        });
        let views: Vec<wgpu::TextureView> = std::iter::once(&masks).chain(&arrays).map(Layers::view).collect();
        let mut entries = vec![
            wgpu::BindGroupEntry { binding: 0, resource: patch_table.as_entire_binding() },
            wgpu::BindGroupEntry { binding: 1, resource: exemplar_table.as_entire_binding() },
        ];
        let texture =
            |(i, view)| wgpu::BindGroupEntry { binding: 2 + i as u32, resource: wgpu::BindingResource::TextureView(view) };
        entries.extend(views.iter().enumerate().map(texture));
        entries.push(wgpu::BindGroupEntry { binding: 7, resource: wgpu::BindingResource::Sampler(&sampler) });
        let bindings =
            gpu.device.create_bind_group(&wgpu::BindGroupDescriptor { label: Some("patches"), layout, entries: &entries });
        let bytes = std::iter::once(&masks).chain(&arrays).map(Layers::bytes).sum::<u64>();
        gpu.queue.submit([]);
        gpu.check()?;
        let of = |number: usize| {
            (0_u32..).zip(patches).filter(move |(_, p)| usize::from(p.exemplar) == number).map(|(i, _)| i).collect()
        };
        let whole = |number: usize| first.get(number + 1).map_or(frames.len(), |&next| next as usize) - first[number] as usize;
        let timed = exemplars.iter().enumerate().filter_map(|(number, exemplar)| {
            let shown = exemplar.frames().filter(|f| f.by() == FramesBy::Time && f.count() == whole(number))?;
            Some(Timed { first: first[number], patches: of(number), frames: shown.clone() })
        });
        Ok(Self {
            timed: timed.collect(),
            bindings,
            channels: exemplars.iter().fold(ChannelSet::default(), |set, e| set.union(e.channels())),
            patches: patches.len(),
            bytes: bytes + patch_table.size() + exemplar_table.size(),
            table: patch_table,
            warnings,
        })
    }

    /// Shows exemplars that change with time as they are so many seconds after their first frame, wherever these patches stand under pastes,
    /// from the next commands on. How many seconds that goes on being right: without end if nothing changes.
    pub(super) fn set_time(&self, gpu: &Gpu, seconds: f64) -> f64 {
        let mut left = f64::INFINITY;
        for timed in &self.timed {
            let (frame, rest) = timed.frames.moment(seconds);
            left = left.min(rest);
            let exemplar = timed.first + frame as u32;
            for &patch in &timed.patches {
                let at = 4 * (PATCH_WORDS * u64::from(patch) + PATCH_EXEMPLAR);
                gpu.queue.write_buffer(&self.table, at, &exemplar.to_le_bytes());
            }
        }
        left
    }

    /// How many texture patches there are.
    #[must_use]
    pub const fn patch_count(&self) -> usize {
        self.patches
    }

    /// Bytes on the device.
    #[must_use]
    pub const fn bytes(&self) -> u64 {
        self.bytes
    }

    /// What did not fit and was made smaller.
    #[must_use]
    pub fn warnings(&self) -> &[String] {
        &self.warnings
    }
}

/// Levels to leave out so that a side fits.
fn levels_over(side: u32, longest: u32) -> u32 {
    (0..32).find(|&drop| side.div_ceil(1 << drop).next_power_of_two() <= longest.max(1)).unwrap_or(0)
}

type Table = Vec<u32>;

/// A frame of an exemplar, and the flags that say how many follow it and when they show.
struct Framed<'a> {
    exemplar: &'a Exemplar,
    flags: u32,
}

/// Exemplars, each followed by its other frames; and where each begins. Of those that go by time only the first frame is kept if there
/// are more of all frames than `most`.
fn with_frames<'a>(exemplars: &'a [Exemplar], most: usize, warnings: &mut Vec<String>) -> (Vec<Framed<'a>>, Vec<u32>) {
    let count = |e: &Exemplar| e.frames().map_or(1, Frames::count);
    let fit = exemplars.iter().map(count).sum::<usize>() <= most;
    let mut all = Vec::with_capacity(exemplars.len());
    let mut first = Vec::with_capacity(exemplars.len());
    for exemplar in exemplars {
        first.push(all.len() as u32);
        let repeats = u32::from(exemplar.wrap == Wrap::Repeat);
        let frames = exemplar.frames().filter(|f| fit || f.by() != FramesBy::Time);
        if let (None, Some(left_out)) = (frames, exemplar.frames()) {
            let (name, count) = (&exemplar.name, left_out.count());
            warnings
                .push(format!("exemplar {name}: its {count} frames are more than this graphics adapter takes; the first is shown"));
        }
        let others = frames.map_or(&[][..], Frames::others);
        let by = match frames.map(Frames::by) {
            Some(FramesBy::View) => BY_VIEW,
            Some(FramesBy::Light) => BY_LIGHT,
            Some(FramesBy::Time) | None => 0,
        };
        all.push(Framed { exemplar, flags: repeats | by | (others.len() as u32) << FRAMES });
        all.extend(others.iter().map(|exemplar| Framed { exemplar, flags: repeats }));
    }
    (all, first)
}

/// Flags of an exemplar, as in shaders/paste.wgsl: its frames change with the view, with the light; and above, how many follow it.
const BY_VIEW: u32 = 4;
const BY_LIGHT: u32 = 8;
const FRAMES: u32 = 8;

fn upload_exemplars<'g>(
    gpu: &'g Gpu,
    frames: &[Framed<'_>],
    longest: u32,
    warnings: &mut Vec<String>,
) -> Result<(Vec<Layers<'g>>, Table), GpuError> {
    let exemplars: Vec<&Exemplar> = frames.iter().map(|f| f.exemplar).collect();
    // The largest power of two that a layer may have.
    let longest = 1 << longest.max(1).ilog2();
    let drops: Vec<u32> = exemplars.iter().map(|e| levels_over(e.size()[0].max(e.size()[1]), longest)).collect();
    for (exemplar, &drop) in exemplars.iter().zip(&drops).filter(|(_, drop)| **drop > 0) {
        let [w, h] = exemplar.size();
        let parts = 1 << drop;
        let name = &exemplar.name;
        warnings.push(format!(
            "exemplar {name}: {w} x {h} pixels are more than this graphics adapter takes; it is drawn at 1/{parts} of that size"
        ));
    }
    let mut table: Table = Vec::new();
    for (Framed { exemplar, flags }, &drop) in frames.iter().zip(&drops) {
        let [w, h] = exemplar.size().map(|s| (s as f32).to_bits());
        let heights = u32::from(exemplar.channel(Channel::Height).is_some());
        let flags = flags | heights << 1;
        table.extend([w, h, 0.5_f32.powi(drop as i32).to_bits(), flags, u32::MAX, u32::MAX, u32::MAX, u32::MAX]);
    }
    let mut arrays = Vec::new();
    for (group, (name, channels)) in GROUPS.iter().enumerate() {
        let has = |e: &&Exemplar| channels.iter().any(|&c| e.channel(c).is_some());
        let with: Vec<usize> = (0..exemplars.len()).filter(|&i| has(&exemplars[i])).collect();
        let side = |axis: usize| {
            let sides = with.iter().map(|&i| exemplars[i].size()[axis].div_ceil(1 << drops[i]).next_power_of_two());
            sides.max().unwrap_or(1)
        };
        let size = [side(0), side(1)];
        let levels = size[0].max(size[1]).ilog2() + 1;
        let light = matches!(channels[0], Channel::BaseColor | Channel::Emissive);
        let format = if light { TextureFormat::Rgba8UnormSrgb } else { TextureFormat::Rgba8Unorm };
        let layers = Layers::new(gpu, name, size, with.len().max(1) as u32, levels, format)?;
        for (layer, &i) in with.iter().enumerate() {
            let exemplar = &exemplars[i];
            let mut at = 0;
            let parts: Vec<Part<'_>> = channels
                .iter()
                .map(|&channel| {
                    let (code, otherwise) = match channel {
                        Channel::BaseColor | Channel::Emissive => (Code::Light, 0),
                        Channel::Normal => (Code::Signed, 0),
                        // As `Texel::empty` has them.
                        Channel::Roughness => (Code::Plain, 204),
                        Channel::Metallic => (Code::Plain, 0),
                        // Height at the surface: without heights nothing is shifted.
                        Channel::Height | Channel::Occlusion | Channel::Opacity => (Code::Plain, 255),
                    };
                    let bytes = [at, channel.components()];
                    at += channel.components();
                    Part { chain: exemplar.channel(channel), code, bytes, otherwise }
                })
                .collect();
            fill(&layers, layer as u32, drops[i], &parts);
            table[8 * i + 4 + group] = layer as u32;
        }
        arrays.push(layers);
    }
    Ok((arrays, table))
}

fn upload_masks<'g>(
    gpu: &'g Gpu,
    patches: &[TexturePatch],
    first: &[u32],
    longest: u32,
    warnings: &mut Vec<String>,
) -> Result<(Layers<'g>, Table), GpuError> {
    let longest = 1 << longest.max(1).ilog2();
    let longer = |p: &TexturePatch| p.mask.size()[0].max(p.mask.size()[1]);
    let drops: Vec<u32> = patches.iter().map(|p| levels_over(longer(p), longest)).collect();
    if drops.iter().any(|&drop| drop > 0) {
        warnings.push("masks larger than this graphics adapter's textures are drawn at a part of their size".to_owned());
    }
    let sides: Vec<u32> = patches.iter().zip(&drops).map(|(p, &drop)| longer(p).div_ceil(1 << drop).next_power_of_two()).collect();
    let packing = pack(&sides, longest);
    let levels = sides.iter().copied().max().unwrap_or(1).ilog2() + 1;
    let layers = Layers::new(gpu, "masks", [packing.side; 2], packing.layers, levels, TextureFormat::R8Unorm)?;
    let coarsest: Vec<u32> = patches
        .iter()
        .zip(&drops)
        .map(|(p, &drop)| {
            let bordered = p.mask.levels().iter().rposition(|level| level.size().iter().any(|&s| s > 2)).unwrap_or(0) as u32;
            bordered.saturating_sub(drop)
        })
        .collect();
    let mut in_layer = vec![Vec::new(); packing.layers as usize];
    packing.places.iter().enumerate().for_each(|(i, place)| in_layer[place.layer as usize].push(i));
    for (layer, members) in in_layer.iter().enumerate() {
        for level in 0..levels {
            let across = layers.level(level)[0] as usize;
            let mut data = vec![0; across * across];
            // A mask without room or border at this level is never read there, and must not reach into its neighbours.
            for &i in members.iter().filter(|&&i| level <= coarsest[i]) {
                let image = &patches[i].mask.levels()[(level + drops[i]) as usize];
                let [x, y] = packing.places[i].at.map(|a| (a >> level) as usize);
                for (row, values) in image.data().chunks_exact(image.size()[0] as usize).enumerate() {
                    let to = &mut data[(y + row) * across + x..][..values.len()];
                    to.iter_mut().zip(values).for_each(|(to, &alpha)| *to = to_byte(alpha));
                }
            }
            layers.write(layer as u32, level, &data);
        }
    }
    let mut table = Table::new();
    for (i, patch) in patches.iter().enumerate() {
        let [w, h] = patch.mask.size().map(|s| s as f32);
        let [x, y] = packing.places[i].at.map(|a| a as f32);
        let [u, v] = patch.origin.map(|o| o as f32);
        table.extend([w, h, x, y, u, v].map(f32::to_bits));
        table.extend([packing.places[i].layer, first[usize::from(patch.exemplar)]]);
        table.extend([coarsest[i] as f32, 0.5_f32.powi(drops[i] as i32)].map(f32::to_bits));
    }
    Ok((layers, table))
}
