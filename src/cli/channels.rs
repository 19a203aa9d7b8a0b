//! Flags that name the images of single channels.

use crate::exemplar::Channel;
use crate::format::{ExemplarOptions, NormalConvention};
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
    #[must_use]
    pub fn options(&self, alone: bool) -> ExemplarOptions {
        let normal = match self.normal_convention {
            ConventionArg::Auto => None,
            ConventionArg::Opengl => Some(NormalConvention::OpenGl),
            ConventionArg::Directx => Some(NormalConvention::DirectX),
        };
        ExemplarOptions { channels: self.files(), alone, normal, equalize: self.equalize, ..ExemplarOptions::default() }
    }
}
