//! The frames of an exemplar that changes: where they are found, and what makes them fit each other.

use super::{ExemplarOptions, in_color, in_grey, note, read_picture, warn};
use crate::exemplar::{Channel, Exemplar, ExemplarError, FramesBy, Image};
use crate::format::error::{FormatError, Problem, Warning};
use crate::format::frames::{Timed, decode_frames, sequence, sprite};
use crate::format::picture::{MOST_PIXELS, Transfer, too_large};
use crate::format::read_file;
use std::path::Path;

/// Frames a second of those whose files do not say.
pub const FRAMES_PER_SECOND: f64 = 12.0;

/// Where the frames of an exemplar are.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum FrameSource {
    /// In the base colour's file, if it is animated (GIF, PNG, WebP).
    #[default]
    File,
    /// Nowhere: of an animated file the first picture is taken.
    First,
    /// In files beside it that are numbered on from it.
    Sequence,
    /// In the images' own cells, so many across and down, row by row.
    Sprites([u32; 2]),
}

/// How an exemplar changes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FrameOptions {
    /// Where its frames are.
    pub from: FrameSource,
    /// What they change with. `None`: time, and a file with a single picture is one that does not change.
    pub by: Option<FramesBy>,
    /// Frames a second where the file does not say. `None`: [`FRAMES_PER_SECOND`].
    pub per_second: Option<f64>,
}

impl Default for FrameOptions {
    fn default() -> Self {
        Self { from: FrameSource::File, by: None, per_second: None }
    }
}

/// The pictures that an animated base colour holds, if they are asked for.
pub(super) fn animated(base: &Path, options: &ExemplarOptions) -> Result<Vec<Timed>, FormatError> {
    match options.frames.from {
        FrameSource::File => {
            let file = read_file(base, "an image")?;
            let format = image::guess_format(&file).ok();
            decode_frames(&file, format, Transfer::Srgb).map_err(|problem| FormatError::malformed(base, problem))
        }
        FrameSource::Sequence => {
            let files = sequence(base).map_err(|problem| FormatError::malformed(base, problem))?;
            let mut pictures: Vec<Timed> = Vec::with_capacity(files.len());
            for path in &files {
                let picture = read_picture(path, Transfer::Srgb)?;
                let size = picture.image.size();
                let differs = pictures.first().is_some_and(|(first, _)| first.image.size() != size);
                // All have the size of the first, so it tells what they have together.
                if pictures.is_empty() && pixels(size, files.len()) > MOST_PIXELS {
                    let text = format!("begins a sequence of {} of {} x {}", files.len(), size[0], size[1]);
                    return Err(FormatError::malformed(base, too_large(&text)));
                }
                pictures.push((picture, None));
                if differs {
                    // The rest need not be read to refuse it.
                    break;
                }
            }
            Ok(pictures)
        }
        FrameSource::First | FrameSource::Sprites(_) => Ok(Vec::new()),
    }
}

fn pixels([w, h]: [u32; 2], count: usize) -> u64 {
    (u64::from(w) * u64::from(h)).saturating_mul(count as u64)
}

/// Gives an exemplar its frames: `pictures` of its base colour, the first its own, or the cells of all its channels.
/// `keeps_opacity`: its opacity has a file of its own.
pub(super) fn add(
    exemplar: Exemplar,
    pictures: Vec<Timed>,
    base: &Path,
    options: &ExemplarOptions,
    keeps_opacity: bool,
    warnings: &mut Vec<Warning>,
) -> Result<Exemplar, FormatError> {
    let fail = |source| FormatError::Exemplar { path: base.to_owned(), source };
    let FrameOptions { from, by, per_second } = options.frames;
    if from == FrameSource::First {
        if per_second.is_some() {
            warn(warnings, base, &useless("only its first frame is taken"));
        }
        return Ok(exemplar);
    }
    let mut frames = match from {
        FrameSource::Sprites(cells) => cut(&exemplar, cells, base)?,
        _ => of_pictures(&exemplar, &pictures, keeps_opacity).map_err(fail)?,
    };
    if frames.is_empty() {
        return match by {
            None => {
                if per_second.is_some() {
                    warn(warnings, base, &useless("it holds one picture"));
                }
                Ok(exemplar)
            }
            Some(_) => {
                let remedy =
                    "name an animated GIF, PNG or WebP file, the first of numbered ones (--sequence), or a sheet (--sprites)";
                Err(FormatError::malformed(base, Problem::new("", "it holds one picture, so it has no frames", remedy)))
            }
        };
    }
    let by = by.unwrap_or(FramesBy::Time);
    let usual = 1.0 / per_second.unwrap_or(FRAMES_PER_SECOND);
    if per_second.is_some() {
        let timed = pictures.len() == frames.len() && pictures.iter().all(|(_, seconds)| seconds.is_some());
        match by {
            FramesBy::View | FramesBy::Light => warn(warnings, base, &useless("its frames do not go by time")),
            FramesBy::Time if timed => warn(warnings, base, &useless("its file says how long each frame is shown")),
            FramesBy::Time => {}
        }
    }
    let count = frames.len();
    let seconds: Vec<f64> = match by {
        FramesBy::Time => (0..count).map(|k| pictures.get(k).and_then(|p| p.1).unwrap_or(usual)).collect(),
        FramesBy::View | FramesBy::Light => Vec::new(),
    };
    let how = match by {
        FramesBy::Time => format!("over {:.2} s", seconds.iter().sum::<f64>()),
        FramesBy::View => "from straight above to grazing".to_owned(),
        FramesBy::Light => "from lit straight to grazed by light".to_owned(),
    };
    note(warnings, base, &format!("it has {count} frames, shown {how}; pastes are laid by the first"));
    let others = frames.split_off(1);
    let Some(mut first) = frames.pop() else { return Ok(exemplar) };
    first.set_frames(by, others, seconds).map_err(fail)?;
    Ok(first)
}

fn useless(reason: &str) -> String {
    format!("the frames a second that were given change nothing: {reason}")
}

/// The cells of a sheet, of all channels.
fn cut(sheet: &Exemplar, cells: [u32; 2], base: &Path) -> Result<Vec<Exemplar>, FormatError> {
    let ([w, h], [across, down]) = (sheet.size(), cells);
    let even = across > 0 && down > 0 && w.is_multiple_of(across) && h.is_multiple_of(down);
    if !even || cells == [1, 1] {
        let what = format!("a sheet of {w}x{h} pixels has no {across}x{down} cells of one size");
        let what = if even { "a sheet of one cell has no frames".to_owned() } else { what };
        let problem = Problem::new("", what, "say how many cells it has across and down, as in --sprites 4x2");
        return Err(FormatError::malformed(base, problem));
    }
    let cell = |number: u32| {
        let part = |channel| sheet.channel(channel).map(|image| sprite(image.finest(), cells, number));
        let mut frame = Exemplar::new(
            sheet.name.clone(),
            part(Channel::BaseColor).unwrap_or_else(|| Image::from_fn(1, 1, |_, _| glam::Vec3::ZERO)),
        );
        frame.wrap = sheet.wrap;
        for channel in sheet.channels().iter().filter(|&c| c != Channel::BaseColor) {
            part(channel).map_or(Ok(()), |image| frame.set(channel, image))?;
        }
        Ok(frame)
    };
    (0..across * down).map(cell).collect::<Result<_, _>>().map_err(|source| FormatError::Exemplar { path: base.to_owned(), source })
}

/// An exemplar with each of the pictures as its base colour. Transparency of one is transparency of all, unless opacity came from a
/// file of its own, which goes before it as in a still image; the other channels stay.
fn of_pictures(first: &Exemplar, pictures: &[Timed], keeps_opacity: bool) -> Result<Vec<Exemplar>, ExemplarError> {
    let transparent =
        !keeps_opacity && (first.channel(Channel::Opacity).is_some() || pictures.iter().any(|(p, _)| p.alpha.is_some()));
    let frame = |(number, (picture, _)): (usize, &Timed)| {
        let [w, h] = picture.image.size();
        if picture.image.size() != first.size() {
            let what = format!("frame {} is {w}x{h}, the first {}x{}", number + 1, first.size()[0], first.size()[1]);
            return Err(ExemplarError::BadFrames { what, remedy: "give all frames one size".into() });
        }
        let mut frame = first.clone();
        frame.set(Channel::BaseColor, in_color(picture.image.clone()))?;
        if transparent {
            let opaque = || Image::grey_from_fn(w, h, |_, _| 1.0);
            frame.set(Channel::Opacity, picture.alpha.as_ref().map_or_else(opaque, in_grey))?;
        }
        Ok(frame)
    };
    pictures.iter().enumerate().map(frame).collect()
}
