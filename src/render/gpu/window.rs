//! Windows: a surface that the machine shows, and what becomes of it as windows are resized, hidden and lost.
//!
//! What to do next is decided by [`Step::after`] from what the surface says and nothing else. A window whose size is zero
//! (minimised) shows nothing until it has one again.

use super::error::GpuError;
use wgpu::{CurrentSurfaceTexture, PresentMode, Surface, SurfaceConfiguration, SurfaceTexture, TextureFormat};

/// What to do when a surface has been asked for its next texture.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Step {
    /// Draw onto it.
    Draw,
    /// Draw onto it, and configure the surface before the next frame.
    DrawThenConfigure,
    /// Configure the surface and ask again.
    Configure,
    /// Draw nothing this time.
    Skip,
    /// The surface is gone: make a new one of the window.
    Recreate,
    /// The driver refused: ask the device what it said.
    Refused,
}

/// What a surface says, without the texture.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[allow(missing_docs, reason = "they are those of `wgpu::CurrentSurfaceTexture`")]
pub enum SurfaceStatus {
    Success,
    Suboptimal,
    Timeout,
    Occluded,
    Outdated,
    Lost,
    Validation,
}

impl Step {
    /// What to do after a surface has said this; `again`: it has been configured for this frame already.
    #[must_use]
    pub const fn after(status: SurfaceStatus, again: bool) -> Self {
        match status {
            SurfaceStatus::Success => Self::Draw,
            SurfaceStatus::Suboptimal => Self::DrawThenConfigure,
            SurfaceStatus::Timeout | SurfaceStatus::Occluded => Self::Skip,
            // A window that is being dragged may be outdated for ever: once a frame is enough.
            SurfaceStatus::Outdated if again => Self::Skip,
            SurfaceStatus::Outdated => Self::Configure,
            SurfaceStatus::Lost => Self::Recreate,
            SurfaceStatus::Validation => Self::Refused,
        }
    }
}

/// What wgpu says of a device that works for other threads for so long that its surface cannot be configured now. A later frame can.
const BUSY: &str = "wait for GPU to come idle";

/// A window's surface.
#[derive(Debug)]
pub struct Window<'w> {
    surface: Surface<'w>,
    config: SurfaceConfiguration,
    /// The size that the window has.
    size: [u32; 2],
    longest: u32,
    stale: bool,
}

impl<'w> Window<'w> {
    /// The surface of a window of `size` pixels, shown by the adapter that the device was opened on, in step with the screen.
    /// `light`: what is drawn onto it is linear light, which its format encodes where there is one that does so; else it is
    /// encoded already, as user interfaces are.
    ///
    /// # Errors
    /// If the adapter cannot show this surface.
    pub fn new(
        surface: Surface<'w>,
        adapter: &wgpu::Adapter,
        device: &wgpu::Device,
        size: [u32; 2],
        light: bool,
    ) -> Result<Self, GpuError> {
        let config = surface.get_default_config(adapter, size[0].max(1), size[1].max(1));
        let mut config = config.ok_or_else(|| GpuError::Surface { adapter: adapter.get_info().name })?;
        let formats = surface.get_capabilities(adapter).formats;
        let fits = |format: &TextureFormat| match light {
            true => format.is_srgb(),
            false => matches!(format, TextureFormat::Rgba8Unorm | TextureFormat::Bgra8Unorm),
        };
        config.format = formats.iter().copied().find(fits).unwrap_or(config.format);
        config.present_mode = PresentMode::AutoVsync;
        Ok(Self { surface, config, size, longest: device.limits().max_texture_dimension_2d, stale: true })
    }

    /// The format of its textures, for a [`super::Screen`].
    #[must_use]
    pub const fn format(&self) -> TextureFormat {
        self.config.format
    }

    /// The window has another size now.
    pub fn resize(&mut self, size: [u32; 2]) {
        self.stale |= self.size != size;
        self.size = size;
    }

    /// Takes a new surface of the window, after the old one was lost.
    pub fn replace(&mut self, surface: Surface<'w>) {
        self.surface = surface;
        self.stale = true;
    }

    /// True if the surface is to be configured before the next frame, which should come soon.
    #[must_use]
    pub const fn is_stale(&self) -> bool {
        self.stale
    }

    /// The texture for the next frame, to be drawn onto (see [`super::Screen::draw`]) and presented; `None` if there is nothing to be
    /// drawn now.
    ///
    /// # Errors
    /// [`GpuError::SurfaceLost`] if a new surface is needed ([`Window::replace`]); or if the driver refuses.
    pub fn next(&mut self, device: &wgpu::Device) -> Result<Option<SurfaceTexture>, GpuError> {
        if self.size.contains(&0) {
            return Ok(None);
        }
        for again in [false, true] {
            if self.stale || again {
                [self.config.width, self.config.height] = self.size.map(|s| s.min(self.longest));
                let scope = device.push_error_scope(wgpu::ErrorFilter::Validation);
                self.surface.configure(device, &self.config);
                if let Some(error) = pollster::block_on(scope.pop()) {
                    let reason = error.to_string();
                    self.stale = true;
                    return if reason.contains(BUSY) { Ok(None) } else { Err(GpuError::Refused { reason }) };
                }
                self.stale = false;
            }
            let (status, texture) = match self.surface.get_current_texture() {
                CurrentSurfaceTexture::Success(texture) => (SurfaceStatus::Success, Some(texture)),
                CurrentSurfaceTexture::Suboptimal(texture) => (SurfaceStatus::Suboptimal, Some(texture)),
                CurrentSurfaceTexture::Timeout => (SurfaceStatus::Timeout, None),
                CurrentSurfaceTexture::Occluded => (SurfaceStatus::Occluded, None),
                CurrentSurfaceTexture::Outdated => (SurfaceStatus::Outdated, None),
                CurrentSurfaceTexture::Lost => (SurfaceStatus::Lost, None),
                CurrentSurfaceTexture::Validation => (SurfaceStatus::Validation, None),
            };
            let step = Step::after(status, again);
            self.stale = step == Step::DrawThenConfigure;
            match step {
                Step::Draw | Step::DrawThenConfigure | Step::Skip => return Ok(texture),
                Step::Configure => {}
                Step::Recreate => return Err(GpuError::SurfaceLost),
                Step::Refused => return Err(GpuError::Refused { reason: "the window's surface gave no texture".to_owned() }),
            }
        }
        Ok(None)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_state_of_a_surface_leads_on() {
        use SurfaceStatus::{Lost, Occluded, Outdated, Suboptimal, Success, Timeout, Validation};
        for again in [false, true] {
            assert_eq!(Step::after(Success, again), Step::Draw, "all is well");
            assert_eq!(Step::after(Suboptimal, again), Step::DrawThenConfigure, "good enough for this frame");
            assert_eq!(Step::after(Timeout, again), Step::Skip, "too late");
            assert_eq!(Step::after(Occluded, again), Step::Skip, "nobody sees it");
            assert_eq!(Step::after(Lost, again), Step::Recreate, "configuring does not bring it back");
            assert_eq!(Step::after(Validation, again), Step::Refused, "told, not tried for ever");
        }
        assert_eq!(Step::after(Outdated, false), Step::Configure, "resized meanwhile");
        assert_eq!(Step::after(Outdated, true), Step::Skip, "once a frame, not for ever");
    }
}
