//! Shaders, what they are given, and the state they are drawn with.

use super::context::Gpu;
use std::collections::BTreeMap;
use std::sync::{Mutex, PoisonError};
use wgpu::{BindingType, BlendComponent, BlendFactor, BlendState, BufferBindingType, CompareFunction, ShaderStages, TextureFormat};

/// The shaders' texts: what is shared, then the passes.
pub mod shaders {
    /// Camera, mesh, and where rays meet faces.
    pub const FRAME: &str = include_str!("../../../shaders/frame.wgsl");
    /// What one paste shows.
    pub const PASTE: &str = include_str!("../../../shaders/paste.wgsl");
    /// All pastes at a sample.
    pub const COMPOSITE: &str = include_str!("../../../shaders/composite.wgsl");
    /// How light meets the surface.
    pub const SHADE: &str = include_str!("../../../shaders/shade.wgsl");
    /// One triangle over everything.
    pub const FULL: &str = include_str!("../../../shaders/full.wgsl");
    /// Every pass: its name and the texts it is made of.
    pub const PASSES: [(&str, &[&str]); 10] = [
        ("single", &[FRAME, PASTE, SHADE, COMPOSITE, include_str!("../../../shaders/single.wgsl")]),
        ("depth", &[FRAME, include_str!("../../../shaders/depth.wgsl")]),
        ("layered", &[FRAME, PASTE, include_str!("../../../shaders/layered.wgsl")]),
        ("light", &[FRAME, SHADE, include_str!("../../../shaders/light.wgsl")]),
        ("points", &[FRAME, include_str!("../../../shaders/points.wgsl")]),
        ("obscure", &[FRAME, FULL, include_str!("../../../shaders/obscure.wgsl")]),
        ("smooth", &[FRAME, FULL, include_str!("../../../shaders/smooth.wgsl")]),
        ("finish", &[FRAME, FULL, include_str!("../../../shaders/finish.wgsl")]),
        ("texels", &[FRAME, PASTE, SHADE, COMPOSITE, include_str!("../../../shaders/texels.wgsl")]),
        ("coverage", &[include_str!("../../../shaders/coverage.wgsl")]),
    ];
}

/// Displayed light of samples.
pub(super) const LIGHT: TextureFormat = TextureFormat::Rgba16Float;
/// Depth of samples.
pub(super) const DEPTH: TextureFormat = TextureFormat::Depth32Float;
/// Depth and face of samples.
pub(super) const KEY: TextureFormat = TextureFormat::Rg32Uint;
/// Surface points.
pub(super) const POINTS: TextureFormat = TextureFormat::Rgba32Uint;
/// Openness of pixels.
pub(super) const OPENNESS: TextureFormat = TextureFormat::R16Float;
/// Finished pixels.
pub(super) const PIXELS: TextureFormat = TextureFormat::Rgba8Unorm;
/// Groups of blended material: base colour, normal, gloss, emission, opacity.
pub(super) const MATERIAL: usize = 5;

/// What groups of bindings hold.
#[derive(Debug)]
pub(super) struct Layouts {
    pub(super) scene: wgpu::BindGroupLayout,
    pub(super) page: wgpu::BindGroupLayout,
    pub(super) patches: wgpu::BindGroupLayout,
    pub(super) openness: wgpu::BindGroupLayout,
    pub(super) light: wgpu::BindGroupLayout,
    pub(super) depth: wgpu::BindGroupLayout,
    pub(super) obscure: wgpu::BindGroupLayout,
    pub(super) smooth: wgpu::BindGroupLayout,
    pub(super) finish: wgpu::BindGroupLayout,
    pub(super) points: wgpu::BindGroupLayout,
}

const fn storage() -> BindingType {
    BindingType::Buffer { ty: BufferBindingType::Storage { read_only: true }, has_dynamic_offset: false, min_binding_size: None }
}

const fn uniform() -> BindingType {
    BindingType::Buffer { ty: BufferBindingType::Uniform, has_dynamic_offset: false, min_binding_size: None }
}

const fn texture(sample_type: wgpu::TextureSampleType, view_dimension: wgpu::TextureViewDimension) -> BindingType {
    BindingType::Texture { sample_type, view_dimension, multisampled: false }
}

const fn loaded() -> BindingType {
    texture(wgpu::TextureSampleType::Float { filterable: false }, wgpu::TextureViewDimension::D2)
}

const fn loaded_bits() -> BindingType {
    texture(wgpu::TextureSampleType::Uint, wgpu::TextureViewDimension::D2)
}

impl Layouts {
    pub(super) fn new(gpu: &Gpu) -> Self {
        use wgpu::TextureViewDimension::D2Array;
        let layout = |label: &str, bindings: &[(BindingType, ShaderStages)]| {
            let entries: Vec<wgpu::BindGroupLayoutEntry> = bindings
                .iter()
                .enumerate()
                .map(|(i, &(ty, visibility))| wgpu::BindGroupLayoutEntry { binding: i as u32, visibility, ty, count: None })
                .collect();
            gpu.device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: Some(label), entries: &entries })
        };
        let (vertex, fragment) = (ShaderStages::VERTEX, ShaderStages::FRAGMENT);
        // What pastes show is asked in fragments and, for baking, at points of the surface.
        let (shown, all) = (fragment | ShaderStages::COMPUTE, ShaderStages::VERTEX_FRAGMENT | ShaderStages::COMPUTE);
        let sampled = (texture(wgpu::TextureSampleType::Float { filterable: true }, D2Array), shown);
        let filter = (BindingType::Sampler(wgpu::SamplerBindingType::Filtering), shown);
        let answered = BindingType::Buffer {
            ty: BufferBindingType::Storage { read_only: false },
            has_dynamic_offset: false,
            min_binding_size: None,
        };
        Self {
            scene: layout("scene", &[(uniform(), all), (storage(), all), (storage(), shown)]),
            page: layout(
                "page",
                &[(storage(), all), (storage(), vertex), (storage(), shown), (storage(), all), (storage(), vertex)],
            ),
            patches: layout(
                "patches",
                &[(storage(), shown), (storage(), shown), sampled, sampled, sampled, sampled, sampled, filter],
            ),
            openness: layout("openness", &[(loaded(), fragment)]),
            light: layout("light", &[(loaded(), fragment); 1 + MATERIAL]),
            depth: layout("depth", &[(loaded_bits(), fragment), (uniform(), fragment)]),
            obscure: layout("obscure", &[(loaded_bits(), fragment)]),
            smooth: layout("smooth", &[(loaded_bits(), fragment), (loaded(), fragment)]),
            finish: layout("finish", &[(loaded(), fragment), (loaded(), fragment)]),
            points: layout("points", &[(answered, ShaderStages::COMPUTE)]),
        }
    }
}

/// What a pass is drawn onto.
#[derive(Debug, Clone)]
pub(super) struct Onto<'a> {
    pub(super) targets: &'a [Option<wgpu::ColorTargetState>],
    /// Format, comparison, and whether depth is written.
    pub(super) depth: Option<(TextureFormat, CompareFunction, bool)>,
    pub(super) samples: u32,
}

/// The shader of a pass.
pub(super) fn module(gpu: &Gpu, name: &'static str) -> wgpu::ShaderModule {
    let text = shaders::PASSES.iter().find(|(n, _)| *n == name).map(|(_, parts)| parts.concat()).unwrap_or_default();
    let source = wgpu::ShaderSource::Wgsl(text.into());
    gpu.device.create_shader_module(wgpu::ShaderModuleDescriptor { label: Some(name), source })
}

/// A pass's shader with the bindings it uses.
#[derive(Debug)]
pub(super) struct Pass {
    name: &'static str,
    module: wgpu::ShaderModule,
    layout: wgpu::PipelineLayout,
}

impl Pass {
    pub(super) fn new(gpu: &Gpu, name: &'static str, groups: [Option<&wgpu::BindGroupLayout>; 4]) -> Self {
        let module = module(gpu, name);
        let descriptor = wgpu::PipelineLayoutDescriptor { label: Some(name), bind_group_layouts: &groups, immediate_size: 0 };
        Self { name, module, layout: gpu.device.create_pipeline_layout(&descriptor) }
    }

    /// The pass with a choice of constants and targets. Without targets only depth is drawn.
    pub(super) fn pipeline(&self, gpu: &Gpu, constants: &[(&str, f64)], onto: &Onto<'_>) -> wgpu::RenderPipeline {
        let options = wgpu::PipelineCompilationOptions { constants, ..Default::default() };
        let fragment = wgpu::FragmentState {
            module: &self.module,
            entry_point: Some("fragment"),
            compilation_options: options,
            targets: onto.targets,
        };
        gpu.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some(self.name),
            layout: Some(&self.layout),
            vertex: wgpu::VertexState {
                module: &self.module,
                entry_point: Some("vertex"),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                buffers: &[],
            },
            primitive: wgpu::PrimitiveState::default(),
            depth_stencil: onto.depth.map(|(format, compare, write)| wgpu::DepthStencilState {
                format,
                depth_write_enabled: Some(write),
                depth_compare: Some(compare),
                stencil: wgpu::StencilState::default(),
                bias: wgpu::DepthBiasState::default(),
            }),
            multisample: wgpu::MultisampleState { count: onto.samples, ..Default::default() },
            fragment: (!onto.targets.is_empty()).then_some(fragment),
            multiview_mask: None,
            cache: None,
        })
    }
}

/// A target that is overwritten.
pub(super) fn plain(format: TextureFormat) -> Option<wgpu::ColorTargetState> {
    Some(wgpu::ColorTargetState { format, blend: None, write_mask: wgpu::ColorWrites::ALL })
}

/// A target of premultiplied colour that new colour is laid over.
pub(super) fn over(format: TextureFormat) -> Option<wgpu::ColorTargetState> {
    let blend = Some(BlendState::PREMULTIPLIED_ALPHA_BLENDING);
    Some(wgpu::ColorTargetState { format, blend, write_mask: wgpu::ColorWrites::ALL })
}

/// A target of premultiplied colour that new colour is laid under.
pub(super) fn under(format: TextureFormat) -> Option<wgpu::ColorTargetState> {
    let operation = wgpu::BlendOperation::Add;
    let part = BlendComponent { src_factor: BlendFactor::OneMinusDstAlpha, dst_factor: BlendFactor::One, operation };
    let blend = Some(BlendState { color: part, alpha: part });
    Some(wgpu::ColorTargetState { format, blend, write_mask: wgpu::ColorWrites::ALL })
}

/// All passes with the state in which whole pictures are drawn.
#[derive(Debug)]
pub(super) struct Pipelines {
    pub(super) single_pass: Pass,
    /// Opaque: nearest face wins.
    pub(super) single: wgpu::RenderPipeline,
    /// Translucent: only where depth is drawn already, below what is there.
    pub(super) single_under: wgpu::RenderPipeline,
    pub(super) depth: wgpu::RenderPipeline,
    pub(super) key: wgpu::RenderPipeline,
    pub(super) key_behind: wgpu::RenderPipeline,
    layered_pass: Pass,
    /// The layered pass for each choice of groups that was drawn so far: compiling one takes longer than a frame.
    layered: Mutex<BTreeMap<[bool; MATERIAL], wgpu::RenderPipeline>>,
    pub(super) light: wgpu::RenderPipeline,
    pub(super) points: wgpu::RenderPipeline,
    pub(super) obscure: wgpu::RenderPipeline,
    pub(super) smooth: wgpu::RenderPipeline,
    pub(super) finish: wgpu::RenderPipeline,
    anisotropic: f64,
}

impl Pipelines {
    pub(super) fn new(gpu: &Gpu, layouts: &Layouts, anisotropic: bool) -> Self {
        let Layouts { scene, page, patches, .. } = layouts;
        let (scene, page, patches) = (Some(scene), Some(page), Some(patches));
        let single_pass = Pass::new(gpu, "single", [scene, page, patches, Some(&layouts.openness)]);
        let depth_pass = Pass::new(gpu, "depth", [scene, page, None, Some(&layouts.depth)]);
        let layered_pass = Pass::new(gpu, "layered", [scene, page, patches, None]);
        let light_pass = Pass::new(gpu, "light", [scene, page, None, Some(&layouts.light)]);
        let points_pass = Pass::new(gpu, "points", [scene, page, None, None]);
        let obscure_pass = Pass::new(gpu, "obscure", [scene, None, None, Some(&layouts.obscure)]);
        let smooth_pass = Pass::new(gpu, "smooth", [scene, None, None, Some(&layouts.smooth)]);
        let finish_pass = Pass::new(gpu, "finish", [scene, None, None, Some(&layouts.finish)]);
        let anisotropic = f64::from(u8::from(anisotropic));
        let filter = [("ANISOTROPIC", anisotropic)];
        let nearest = Some((DEPTH, CompareFunction::Less, true));
        let same = Some((DEPTH, CompareFunction::Equal, false));
        let draw = |pass: &Pass, constants: &[(&str, f64)], target: Option<wgpu::ColorTargetState>, depth| {
            let targets = if target.is_some() { vec![target] } else { Vec::new() };
            pass.pipeline(gpu, constants, &Onto { targets: &targets, depth, samples: 1 })
        };
        Self {
            single: draw(&single_pass, &filter, plain(LIGHT), nearest),
            single_under: draw(&single_pass, &filter, under(LIGHT), same),
            depth: draw(&depth_pass, &[], None, nearest),
            key: draw(&depth_pass, &[], plain(KEY), nearest),
            key_behind: draw(&depth_pass, &[("BEHIND", 1.0)], plain(KEY), nearest),
            light: draw(&light_pass, &[], under(LIGHT), same),
            points: draw(&points_pass, &[], plain(POINTS), nearest),
            obscure: draw(&obscure_pass, &[], plain(OPENNESS), None),
            smooth: draw(&smooth_pass, &[], plain(OPENNESS), None),
            finish: draw(&finish_pass, &[], plain(PIXELS), None),
            single_pass,
            layered_pass,
            layered: Mutex::default(),
            anisotropic,
        }
    }

    /// The layered pass onto those groups of material that are there.
    pub(super) fn layered(&self, gpu: &Gpu, groups: [bool; MATERIAL]) -> wgpu::RenderPipeline {
        let make = || {
            let targets = groups.map(|there| if there { over(LIGHT) } else { None });
            let onto = Onto { targets: &targets, depth: Some((DEPTH, CompareFunction::Equal, false)), samples: 1 };
            self.layered_pass.pipeline(gpu, &[("ANISOTROPIC", self.anisotropic)], &onto)
        };
        let mut made = self.layered.lock().unwrap_or_else(PoisonError::into_inner);
        made.entry(groups).or_insert_with(make).clone()
    }

    /// The single pass onto somebody else's target.
    pub(super) fn forward(&self, gpu: &Gpu, color: TextureFormat, depth: TextureFormat, samples: u32) -> wgpu::RenderPipeline {
        let encoded = f64::from(u8::from(!color.is_srgb()));
        let constants = [("ANISOTROPIC", self.anisotropic), ("ENCODED", encoded)];
        let onto = Onto { targets: &[plain(color)], depth: Some((depth, CompareFunction::Less, true)), samples };
        self.single_pass.pipeline(gpu, &constants, &onto)
    }
}
