//! Exemplars: example images with all their channels aligned, and the texture patches cut from them. Knows no mesh.
//!
//! Pixel coordinates are continuous: (0, 0) is the top left corner of the top left pixel, whose centre is (0.5, 0.5).

pub mod auto;
mod collapse;
mod coverage_mask;
mod detail;
pub mod distance;
mod equalize;
pub mod extend;
pub mod frames;
pub mod hull;
pub mod image;
pub mod mask;
pub mod outline;
pub mod patch;
mod slow;
mod smaller;
pub mod snap;
mod splotch;
pub mod srgb;
pub mod stack;
pub mod symmetry;
mod untangle;

pub use coverage_mask::ERODED_RADII;
pub use detail::{DETAIL, Slowly, take_detail};
pub use equalize::{Evened, equalize};
pub use frames::{Frames, FramesBy};
pub use hull::Hull;
pub use image::{Image, MipChain};
pub use mask::CoverageMask;
pub use outline::Outline;
pub use patch::{PatchOptions, PatchShape, PatchSource, PatchSpec, make_patches, opacity_is_outline};
pub use snap::{Edges, Wire};
pub use untangle::TOLERANCE as OUTLINE_TOLERANCE;

use glam::Vec2;

/// What a channel of an exemplar holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "camelCase")]
pub enum Channel {
    /// Colour, three components, linear light.
    BaseColor,
    /// Tangent-space normal, three components in -1 to 1, y up along the image (the OpenGL convention).
    Normal,
    /// Height, one component, 0 to 1, bright is outward.
    Height,
    /// Roughness, one component.
    Roughness,
    /// Metallic, one component.
    Metallic,
    /// Ambient occlusion, one component.
    Occlusion,
    /// Emitted light, three components, linear.
    Emissive,
    /// Opacity, one component.
    Opacity,
}

impl Channel {
    /// All channels, in the order of their discriminants.
    pub const ALL: [Self; 8] = [
        Self::BaseColor,
        Self::Normal,
        Self::Height,
        Self::Roughness,
        Self::Metallic,
        Self::Occlusion,
        Self::Emissive,
        Self::Opacity,
    ];

    /// Components per pixel: 3 or 1.
    #[must_use]
    pub const fn components(self) -> usize {
        match self {
            Self::BaseColor | Self::Normal | Self::Emissive => 3,
            _ => 1,
        }
    }

    /// The name used in records, reports and file names.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::BaseColor => "baseColor",
            Self::Normal => "normal",
            Self::Height => "height",
            Self::Roughness => "roughness",
            Self::Metallic => "metallic",
            Self::Occlusion => "occlusion",
            Self::Emissive => "emissive",
            Self::Opacity => "opacity",
        }
    }
}

/// A set of channels.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct ChannelSet(u8);

impl ChannelSet {
    /// True if the channel is in the set.
    #[must_use]
    pub const fn has(self, channel: Channel) -> bool {
        self.0 & (1 << channel as u8) != 0
    }

    /// The set with one channel more.
    #[must_use]
    pub const fn with(self, channel: Channel) -> Self {
        Self(self.0 | 1 << channel as u8)
    }

    /// All channels of both sets.
    #[must_use]
    pub const fn union(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    /// The channels that both sets have.
    #[must_use]
    pub const fn intersection(self, other: Self) -> Self {
        Self(self.0 & other.0)
    }

    /// The channels in the set, in order.
    pub fn iter(self) -> impl Iterator<Item = Channel> {
        Channel::ALL.into_iter().filter(move |&c| self.has(c))
    }
}

/// What lies beyond an exemplar's edge.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Wrap {
    /// The nearest edge pixel.
    #[default]
    Clamp,
    /// The image again.
    Repeat,
}

/// An example image with its aligned channels.
#[derive(Debug, Clone, PartialEq)]
pub struct Exemplar {
    /// What to call it: usually the file's stem.
    pub name: String,
    /// What lies beyond its edge.
    pub wrap: Wrap,
    size: [u32; 2],
    channels: Vec<(Channel, MipChain)>,
    frames: Option<Frames>,
    symmetry: symmetry::Remembered,
}

impl Exemplar {
    /// An exemplar with a base colour.
    #[must_use]
    pub fn new(name: impl Into<String>, base_color: Image) -> Self {
        let size = base_color.size();
        Self {
            name: name.into(),
            wrap: Wrap::Clamp,
            size,
            channels: vec![(Channel::BaseColor, MipChain::new(base_color))],
            frames: None,
            symmetry: symmetry::Remembered::default(),
        }
    }

    /// Adds a channel, to all frames, or replaces one; of one that changes, of its first frame.
    ///
    /// # Errors
    /// If its size or number of components does not fit.
    pub fn set(&mut self, channel: Channel, image: Image) -> Result<(), ExemplarError> {
        if image.size() != self.size {
            return Err(ExemplarError::SizeDiffers { channel: channel.name(), found: image.size(), expected: self.size });
        }
        if image.components() != channel.components() {
            return Err(ExemplarError::Components {
                channel: channel.name(),
                found: image.components(),
                expected: channel.components(),
            });
        }
        let chain = MipChain::new(image);
        self.symmetry = symmetry::Remembered::default();
        match self.channels.binary_search_by_key(&channel, |(c, _)| *c) {
            Ok(i) => self.channels[i].1 = chain,
            Err(i) => {
                // All frames have the same channels.
                let others = self.frames.iter_mut().flat_map(Frames::others_mut);
                others.for_each(|other| other.channels.insert(i, (channel, chain.clone())));
                self.channels.insert(i, (channel, chain));
            }
        }
        Ok(())
    }

    /// Takes a channel out, of all frames; the base colour stays.
    pub fn remove(&mut self, channel: Channel) {
        self.channels.retain(|(c, _)| *c != channel || *c == Channel::BaseColor);
        self.symmetry = symmetry::Remembered::default();
        let Ok(()) = self.change_others(|other| {
            other.remove(channel);
            Ok::<(), std::convert::Infallible>(())
        });
    }

    /// Width and height in pixels.
    #[must_use]
    pub const fn size(&self) -> [u32; 2] {
        self.size
    }

    /// A channel, if the exemplar has it.
    #[must_use]
    pub fn channel(&self, channel: Channel) -> Option<&MipChain> {
        self.channels.iter().find(|(c, _)| *c == channel).map(|(_, m)| m)
    }

    /// The channels it has.
    #[must_use]
    pub fn channels(&self) -> ChannelSet {
        self.channels.iter().fold(ChannelSet::default(), |set, (c, _)| set.with(*c))
    }
}

/// A region of an exemplar: an alpha mask over a rectangle of its pixels. The exemplar's images stay whole beneath it.
#[derive(Debug, Clone, PartialEq)]
pub struct TexturePatch {
    /// Which exemplar it was cut from.
    pub exemplar: u16,
    /// Top left corner of the mask's rectangle, pixels of the exemplar (may lie outside it).
    pub origin: [i32; 2],
    /// Alpha, one component, 0 to 1. Its border pixels are 0, and so are those of every mip level finer than 2x2 (LT 4).
    pub mask: MipChain,
    /// Conservative hull of all that has alpha under bilinear filtering, pixels of the exemplar (LT 3.3).
    pub hull: Hull,
    /// Deepest point of the opaque part, pixels of the exemplar. Alpha is 1 here.
    pub centre: Vec2,
    /// How often it is chosen, relative to the others. Positive.
    pub weight: f32,
    /// True if its outline follows nothing in the exemplar, so that another part may show under it.
    pub slides: bool,
}

/// Why an exemplar or a texture patch cannot be made.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ExemplarError {
    /// A channel of another size.
    #[error("the {channel} image is {}x{}, the base colour {}x{}: resize it", found[0], found[1], expected[0], expected[1])]
    SizeDiffers {
        /// Channel name.
        channel: &'static str,
        /// Its size.
        found: [u32; 2],
        /// Size of the base colour.
        expected: [u32; 2],
    },
    /// A channel with the wrong number of components.
    #[error("the {channel} image has {found} components, {expected} are needed")]
    Components {
        /// Channel name.
        channel: &'static str,
        /// Its components.
        found: usize,
        /// Components needed.
        expected: usize,
    },
    /// A mask with nothing opaque in it.
    #[error("{what} has no opaque part of at least {need} pixels across: {remedy}")]
    NothingOpaque {
        /// Which mask.
        what: String,
        /// Pixels needed.
        need: f32,
        /// What to do.
        remedy: String,
    },
    /// Frames that do not belong together.
    #[error("{what}: {remedy}")]
    BadFrames {
        /// What is wrong.
        what: String,
        /// What to do.
        remedy: String,
    },
    /// A patch that cannot be asked for.
    #[error("{what} is {found}: {remedy}")]
    BadPatch {
        /// Which setting.
        what: String,
        /// Its value.
        found: String,
        /// What to do.
        remedy: String,
    },
    /// An outline that is no polygon.
    #[error("the outline {what}: {reason}: give simple polygons as lists of [x, y]")]
    BadOutline {
        /// Where it came from.
        what: String,
        /// What is wrong.
        reason: String,
    },
}
