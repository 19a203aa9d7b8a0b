//! Graphics adapters: which there are, which one is taken, and what it says went wrong.
//!
//! An adapter is a driver for a piece of hardware, or a program that stands in for one. Hardware comes before software, and
//! the machine's own interfaces (Vulkan, Metal, DirectX 12) before OpenGL.

use super::error::GpuError;
use std::fmt;
use std::sync::{Arc, Mutex, PoisonError};
use wgpu::{Backend, DeviceType};

/// A graphics adapter of this machine.
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize)]
pub struct AdapterSummary {
    /// What the driver calls it.
    pub name: String,
    /// The interface it is reached through: `vulkan`, `metal`, `dx12` or `gl`.
    pub backend: &'static str,
    /// `discrete`, `integrated`, `virtual`, `software` or `unknown`.
    pub kind: &'static str,
    /// The driver and its version.
    pub driver: String,
    /// The longest side of a texture.
    pub max_texture_side: u32,
    /// The largest buffer that a shader can be given, bytes.
    pub max_binding: u64,
}

impl AdapterSummary {
    fn of(adapter: &wgpu::Adapter) -> Self {
        let (info, limits) = (adapter.get_info(), adapter.limits());
        Self {
            backend: backend_name(info.backend),
            kind: kind_name(info.device_type),
            driver: [info.driver, info.driver_info].join(" ").trim().to_owned(),
            name: info.name,
            max_texture_side: limits.max_texture_dimension_2d,
            max_binding: limits.max_storage_buffer_binding_size,
        }
    }

    /// True if it draws on the processor.
    #[must_use]
    pub fn is_software(&self) -> bool {
        self.kind == kind_name(DeviceType::Cpu)
    }

    fn is_called(&self, name: &str) -> bool {
        let name = name.to_lowercase();
        self.backend == name || self.kind == name || self.to_string().to_lowercase().contains(&name)
    }
}

impl fmt::Display for AdapterSummary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} ({}, {})", self.name, self.backend, self.kind)
    }
}

fn backend_name(backend: Backend) -> &'static str {
    match backend {
        Backend::Vulkan => "vulkan",
        Backend::Metal => "metal",
        Backend::Dx12 => "dx12",
        Backend::Gl => "gl",
        _ => "other",
    }
}

fn kind_name(kind: DeviceType) -> &'static str {
    match kind {
        DeviceType::DiscreteGpu => "discrete",
        DeviceType::IntegratedGpu => "integrated",
        DeviceType::VirtualGpu => "virtual",
        DeviceType::Cpu => "software",
        DeviceType::Other => "unknown",
    }
}

/// Adapters that can run our shaders, best first.
fn candidates(backends: wgpu::Backends) -> Vec<wgpu::Adapter> {
    let without_display = wgpu::InstanceDescriptor::new_without_display_handle();
    usable(&wgpu::Instance::new(wgpu::InstanceDescriptor { backends, ..without_display }), backends)
}

/// The same of an instance that is there already.
fn usable(instance: &wgpu::Instance, backends: wgpu::Backends) -> Vec<wgpu::Adapter> {
    let mut found = pollster::block_on(instance.enumerate_adapters(backends));
    let needed = wgpu::DownlevelFlags::VERTEX_STORAGE | wgpu::DownlevelFlags::FRAGMENT_STORAGE;
    found.retain(|adapter| adapter.get_downlevel_capabilities().flags.contains(needed));
    found.sort_by_key(|adapter| {
        let info = adapter.get_info();
        let kind = match info.device_type {
            DeviceType::DiscreteGpu => 0,
            DeviceType::IntegratedGpu => 1,
            DeviceType::VirtualGpu => 2,
            DeviceType::Other => 3,
            DeviceType::Cpu => 4,
        };
        (kind, info.backend == Backend::Gl)
    });
    found
}

/// The adapters of this machine, best first.
#[must_use]
pub fn adapters() -> Vec<AdapterSummary> {
    candidates(wgpu::Backends::all()).iter().map(AdapterSummary::of).collect()
}

/// Where the kernel of Linux shows graphics hardware: by its own drivers, NVIDIA's, Windows' beneath it, and those of phones.
const DEVICE_NODES: [&str; 5] = ["/dev/dri", "/dev/nvidia0", "/dev/dxg", "/dev/kgsl-3d0", "/dev/mali0"];

/// True if there is graphics hardware. Where the kernel shows none, no driver is asked: on machines without a display they
/// write complaints to stderr by themselves.
#[must_use]
pub fn has_hardware() -> bool {
    kernel_shows_hardware()
        && candidates(wgpu::Backends::PRIMARY).first().is_some_and(|best| !AdapterSummary::of(best).is_software())
}

fn kernel_shows_hardware() -> bool {
    !cfg!(target_os = "linux") || DEVICE_NODES.iter().any(|node| std::path::Path::new(node).exists())
}

/// The adapters among which the best one is, best first. OpenGL is not even looked at where it cannot win.
fn best_candidates() -> Vec<wgpu::Adapter> {
    let native = candidates(wgpu::Backends::PRIMARY);
    match native.first() {
        Some(best) if !kernel_shows_hardware() || !AdapterSummary::of(best).is_software() => native,
        _ => candidates(wgpu::Backends::all()),
    }
}

/// Which device to open.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct GpuOptions {
    /// The adapter: its place in [`adapters`] (from 0), a part of its name, its interface (`vulkan`, `gl`, ..) or its kind
    /// (`discrete`, `software`, ..). `None` takes the best.
    pub adapter: Option<String>,
    /// Limits to keep to; `None` asks for all that the adapter has.
    pub limits: Option<wgpu::Limits>,
}

/// What went wrong on a device since it was opened.
#[derive(Debug, Default)]
struct Faults {
    lost: Option<String>,
    refused: Option<String>,
}

/// An open graphics device.
#[derive(Debug, Clone)]
pub struct Gpu {
    /// The device.
    pub device: wgpu::Device,
    /// Its queue.
    pub queue: wgpu::Queue,
    /// What it may hold.
    pub limits: wgpu::Limits,
    faults: Arc<Mutex<Faults>>,
}

impl Gpu {
    /// Opens a device. What the driver refuses from now on is kept for [`Gpu::check`] instead of ending the program.
    ///
    /// # Errors
    /// If there is no such adapter, or it gives no device.
    pub fn new(options: &GpuOptions) -> Result<Self, GpuError> {
        let found = if options.adapter.is_some() { candidates(wgpu::Backends::all()) } else { best_candidates() };
        Ok(Self::among(&found, options)?.0)
    }

    /// Opens a device on the best adapter that can show a window's surface, or on the one asked for, and says which it is.
    /// The surface must be one of the instance's.
    ///
    /// # Errors
    /// As [`Gpu::new`].
    pub fn showing(
        options: &GpuOptions,
        instance: &wgpu::Instance,
        surface: &wgpu::Surface<'_>,
    ) -> Result<(Self, wgpu::Adapter), GpuError> {
        let mut found = usable(instance, wgpu::Backends::all());
        found.retain(|adapter| adapter.is_surface_supported(surface));
        let (gpu, place) = Self::among(&found, options)?;
        Ok((gpu, found.swap_remove(place)))
    }

    /// Opens a device on one of the adapters found, best first, and says on which.
    fn among(found: &[wgpu::Adapter], options: &GpuOptions) -> Result<(Self, usize), GpuError> {
        let summaries: Vec<AdapterSummary> = found.iter().map(AdapterSummary::of).collect();
        if found.is_empty() {
            return Err(GpuError::NoAdapter);
        }
        let place = match &options.adapter {
            None => Some(0),
            Some(name) => match name.parse::<usize>() {
                Ok(number) => (number < found.len()).then_some(number),
                Err(_) => summaries.iter().position(|summary| summary.is_called(name)),
            },
        };
        let Some(place) = place else {
            let listed = |(i, summary): (usize, &AdapterSummary)| format!("{i}: {summary}");
            let there = summaries.iter().enumerate().map(listed).collect::<Vec<_>>().join(", ");
            return Err(GpuError::NoSuchAdapter { wanted: options.adapter.clone().unwrap_or_default(), there });
        };
        let adapter = &found[place];
        let limits = options.limits.clone().unwrap_or_else(|| adapter.limits());
        let descriptor = wgpu::DeviceDescriptor { label: Some("lapped"), required_limits: limits, ..Default::default() };
        let (device, queue) = pollster::block_on(adapter.request_device(&descriptor))
            .map_err(|e| GpuError::Device { adapter: summaries[place].to_string(), reason: e.to_string() })?;
        let gpu = Self::from_device(device, queue);
        let faults = Arc::clone(&gpu.faults);
        gpu.device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| {
            let mut faults = faults.lock().unwrap_or_else(PoisonError::into_inner);
            faults.refused.get_or_insert_with(|| error.to_string());
        }));
        let faults = Arc::clone(&gpu.faults);
        gpu.device.set_device_lost_callback(move |reason, message| {
            let mut faults = faults.lock().unwrap_or_else(PoisonError::into_inner);
            faults.lost.get_or_insert_with(|| if message.is_empty() { format!("{reason:?}") } else { message });
        });
        Ok((gpu, place))
    }

    /// A device that somebody else has opened and whose errors they handle.
    #[must_use]
    pub fn from_device(device: wgpu::Device, queue: wgpu::Queue) -> Self {
        Self { limits: device.limits(), device, queue, faults: Arc::default() }
    }

    /// The adapter of the device.
    #[must_use]
    pub fn adapter(&self) -> String {
        let info = self.device.adapter_info();
        format!("{} ({}, {})", info.name, backend_name(info.backend), kind_name(info.device_type))
    }

    /// Asks whether all went well so far.
    ///
    /// # Errors
    /// If the device is lost, or the driver or its validation refused anything.
    pub fn check(&self) -> Result<(), GpuError> {
        let mut faults = self.faults.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(reason) = &faults.lost {
            return Err(GpuError::Lost { reason: reason.clone() });
        }
        faults.refused.take().map_or(Ok(()), |reason| Err(GpuError::Refused { reason }))
    }

    /// Waits until the device has done all it was given.
    ///
    /// # Errors
    /// As [`Gpu::check`].
    pub fn wait(&self) -> Result<(), GpuError> {
        let waited = self.device.poll(wgpu::PollType::wait_indefinitely());
        self.check()?;
        waited.map(|_| ()).map_err(|e| GpuError::Lost { reason: e.to_string() })
    }
}
