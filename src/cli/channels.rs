//! Flags that name the images of single channels.

use crate::exemplar::{Channel, FramesBy};
use crate::format::{ExemplarOptions, FrameOptions, FrameSource, NormalConvention};
use clap::Args;
use std::collections::BTreeMap;
use std::path::PathBuf;

/// Images of single channels, and how to read the normal map.
#[derive(Debug, Clone, Default, Args)]
#[command(next_help_heading = "Channels")]
pub struct ChannelArgs {
    /// Normal map of the exemplar, instead of one found by name
    #[arg(long, value_name = "FILE")]
    pub normal: Option<PathBuf>,
    /// Height map, bright is outward
    #[arg(long, value_name = "FILE")]
    pub height: Option<PathBuf>,
    /// Roughness map
    #[arg(long, value_name = "FILE")]
    pub roughness: Option<PathBuf>,
    /// Metallic map
    #[arg(long, value_name = "FILE")]
    pub metallic: Option<PathBuf>,
    /// Ambient occlusion map
    #[arg(long, value_name = "FILE")]
    pub occlusion: Option<PathBuf>,
    /// Emissive map, a colour
    #[arg(long, value_name = "FILE")]
    pub emissive: Option<PathBuf>,
    /// Opacity map
    #[arg(long, value_name = "FILE")]
    pub opacity: Option<PathBuf>,
    /// Which way green points in normal maps: up (opengl) or down (directx); auto goes by the file's name, then by its slopes
    #[arg(long, value_enum, value_name = "WAY", default_value_t = ConventionArg::Auto)]
    pub normal_convention: ConventionArg,
    /// Take slow changes of light out of each exemplar's colour, as of a photograph that is lit from one side
    #[arg(long)]
    pub equalize: bool,
    /// What an exemplar's frames change with: time, the angle to the eye (view), to the main lamp (light); first takes only the first
    /// [default: time, if the image is animated]
    #[arg(long, value_enum, value_name = "BY")]
    pub frames: Option<FramesArg>,
    /// The frames are files that are numbered on from the one named, like fire_01.png
    #[arg(long, conflicts_with = "sprites")]
    pub sequence: bool,
    /// The frames are cells of the image, so many across and down
    #[arg(long, value_name = "COLSxROWS", value_parser = cells)]
    pub sprites: Option<[u32; 2]>,
    /// Frames a second, where the file does not say [default: 12]
    #[arg(long, value_name = "N", value_parser = per_second)]
    pub fps: Option<f64>,
}

/// What [`ChannelArgs::frames`] may say.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum FramesArg {
    /// Seconds
    Time,
    /// The angle between the surface and the eye
    View,
    /// The angle between the surface and the main lamp
    Light,
    /// Nothing: the first frame alone
    First,
}

/// Cells of a sheet, across and down.
fn cells(text: &str) -> Result<[u32; 2], String> {
    let [across, down] = text.parse::<super::picture::Size>().map_err(|_| "say how many cells there are, as in 4x2".to_owned())?.0;
    Ok([across, down])
}

fn per_second(text: &str) -> Result<f64, String> {
    let number = text.parse::<f64>().ok().filter(|n| *n > 0.0 && n.is_finite());
    number.ok_or_else(|| "give a number of frames above 0".to_owned())
}

/// Names of [`NormalConvention`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, clap::ValueEnum)]
pub enum ConventionArg {
    /// By the file's name, then by its slopes
    #[default]
    Auto,
    /// Green is up
    Opengl,
    /// Green is down
    Directx,
}

impl ChannelArgs {
    /// The files named, by channel.
    #[must_use]
    pub fn files(&self) -> BTreeMap<Channel, PathBuf> {
        let named = [
            (Channel::Normal, &self.normal),
            (Channel::Height, &self.height),
            (Channel::Roughness, &self.roughness),
            (Channel::Metallic, &self.metallic),
            (Channel::Occlusion, &self.occlusion),
            (Channel::Emissive, &self.emissive),
            (Channel::Opacity, &self.opacity),
        ];
        named.into_iter().filter_map(|(channel, file)| Some((channel, file.clone()?))).collect()
    }

    /// How to read an exemplar.
    ///
    /// # Errors
    /// If flags contradict each other.
    pub fn options(&self, alone: bool) -> anyhow::Result<ExemplarOptions> {
        if self.frames == Some(FramesArg::First) && (self.sequence || self.sprites.is_some()) {
            let flag = if self.sequence { "--sequence" } else { "--sprites" };
            anyhow::bail!(
                "--frames first takes the first picture of an animated file, {flag} asks for more: leave out one of them"
            );
        }
        let normal = match self.normal_convention {
            ConventionArg::Auto => None,
            ConventionArg::Opengl => Some(NormalConvention::OpenGl),
            ConventionArg::Directx => Some(NormalConvention::DirectX),
        };
        let from = match (self.frames, self.sprites) {
            (Some(FramesArg::First), _) => FrameSource::First,
            (_, Some(cells)) => FrameSource::Sprites(cells),
            _ if self.sequence => FrameSource::Sequence,
            _ => FrameSource::File,
        };
        let by = match self.frames {
            Some(FramesArg::Time) => Some(FramesBy::Time),
            Some(FramesArg::View) => Some(FramesBy::View),
            Some(FramesArg::Light) => Some(FramesBy::Light),
            Some(FramesArg::First) | None => None,
        };
        let frames = FrameOptions { from, by, per_second: self.fps };
        let (channels, equalize) = (self.files(), self.equalize);
        Ok(ExemplarOptions { channels, alone, normal, equalize, frames, ..ExemplarOptions::default() })
    }
}
