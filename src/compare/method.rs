//! The methods that are compared.

use serde::{Serialize, Serializer};
use std::str::FromStr;

/// A way to texture a surface.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Method {
    /// Lapped pastes composited at run time.
    Pasted,
    /// The same as the paper has it: no windows, cuts, overlays and pruning.
    Plain,
    /// The first's pastes baked into an atlas.
    Baked,
    /// Synthesis after Wei and Levoy, with the fast search.
    WeiLevoy,
    /// Synthesis after Chen and Dong.
    ChenDong,
    /// Triplanar projection.
    Triplanar,
    /// Hexagons on triplanar planes.
    Hex,
    /// Plain tiling over automatic charts.
    Tiling,
}

impl Method {
    /// All of them, in the order they are shown.
    pub const ALL: [Self; 8] =
        [Self::Pasted, Self::Plain, Self::Baked, Self::WeiLevoy, Self::ChenDong, Self::Triplanar, Self::Hex, Self::Tiling];

    /// Those that are compared if nobody says which.
    pub const USUAL: [Self; 7] =
        [Self::Pasted, Self::Baked, Self::WeiLevoy, Self::ChenDong, Self::Triplanar, Self::Hex, Self::Tiling];

    /// Its name at the command line, in reports and in files.
    #[must_use]
    pub const fn key(self) -> &'static str {
        match self {
            Self::Pasted => "pasted",
            Self::Plain => "plain",
            Self::Baked => "baked",
            Self::WeiLevoy => "wei-levoy",
            Self::ChenDong => "chen-dong",
            Self::Triplanar => "triplanar",
            Self::Hex => "hex",
            Self::Tiling => "tiling",
        }
    }

    /// Its name for people.
    #[must_use]
    pub const fn label(self) -> &'static str {
        match self {
            Self::Pasted => "Pasted, run time",
            Self::Plain => "Pasted, plain",
            Self::Baked => "Pasted, baked",
            Self::WeiLevoy => "Wei & Levoy",
            Self::ChenDong => "Chen & Dong",
            Self::Triplanar => "Triplanar",
            Self::Hex => "Hex-tiling",
            Self::Tiling => "Tiling",
        }
    }

    /// What it does, in a sentence.
    #[must_use]
    pub const fn says(self) -> &'static str {
        match self {
            Self::Pasted => {
                "Overlapping, soft-edged pastes of the exemplar along the field, composited as the picture is drawn \
                 (Praun, Finkelstein, Hoppe 2000)."
            }
            Self::Plain => "The paper's own pastes: nothing is done about their borders but their soft edges and sorting.",
            Self::Baked => "The first's pastes, resampled into one atlas over automatic charts.",
            Self::WeiLevoy => {
                "Every vertex of an evenly re-tiled mesh takes the place of the exemplar whose neighbourhood fits best \
                 (Wei, Levoy 2001; our fast search)."
            }
            Self::ChenDong => "The same idea on the mesh's own vertices, with round neighbourhoods (Chen, Dong 2008).",
            Self::Triplanar => "The exemplar projected along the three axes, repeated, and blended by the normal.",
            Self::Hex => "The same planes, tiled by hexagons of random places of the exemplar (Mikkelsen 2022).",
            Self::Tiling => "The exemplar repeated over automatic charts, one scale for all: unwrap, tile, done.",
        }
    }
}

impl std::fmt::Display for Method {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.key())
    }
}

impl FromStr for Method {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let known = || Self::ALL.map(Self::key).join(", ");
        Self::ALL.into_iter().find(|m| m.key() == text).ok_or_else(|| format!("{text:?} is no method: there are {}", known()))
    }
}

impl Serialize for Method {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.key())
    }
}
