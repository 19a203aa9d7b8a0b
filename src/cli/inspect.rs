//! `lapped inspect`: what is in a file, and what cleaning would do to it.

use super::{Common, report};
use crate::exemplar::symmetry::{Symmetry, exemplar_symmetry};
use crate::exemplar::{Channel, Frames, FramesBy};
use crate::field::{DEFAULT_RATIO, default_scale};
use crate::format::motion::Animation;
use crate::format::{
    ExemplarOptions, FaceGroup, Model, Motion, Record, check_output, holds_record, read_exemplar, read_file, read_model_bytes,
    read_record_bytes,
};
use crate::job::estimate::{self, Estimate, Work};
use crate::mesh::clean::OpenComponent;
use crate::mesh::{CleanOptions, CleanReport, clean};
use anyhow::{Context, bail};
use clap::Args;
use serde::Serialize;
use std::io::Write;
use std::path::{Path, PathBuf};

/// Arguments of `lapped inspect`.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  lapped inspect bunny.obj             counts, flaws, size, and the texture scale that would be chosen
  lapped inspect bunny-lapped.glb      the pastes in a record
  lapped inspect bricks.png --json     the same for programs
  lapped inspect --gpu                 the graphics adapters that `lapped render --adapter` can choose from")]
pub struct InspectArgs {
    /// A mesh, a record or an exemplar
    #[arg(value_name = "FILE", required_unless_present = "gpu")]
    pub file: Option<PathBuf>,
    /// The graphics adapters of this machine instead, best first
    #[arg(long, conflicts_with = "file")]
    pub gpu: bool,
    /// As JSON
    #[arg(long)]
    pub json: bool,
    /// Weld vertices closer than this, world units
    #[arg(long, value_name = "TOL", default_value_t = 0.0)]
    pub weld: f64,
    /// See [`Common`].
    #[command(flatten)]
    pub common: Common,
}

/// What is in a mesh file.
#[derive(Debug, Serialize)]
struct MeshReport {
    kind: &'static str,
    format: String,
    name: String,
    file_vertices: usize,
    file_polygons: usize,
    up: Option<String>,
    unit: Option<String>,
    has_uvs: bool,
    has_colors: bool,
    /// How it moves, if it does.
    motion: Option<MotionReport>,
    groups: Vec<FaceGroup>,
    notes: Vec<String>,
    clean: CleanReport,
    bounds_min: [f32; 3],
    bounds_max: [f32; 3],
    area: f64,
    /// World length of one exemplar width that `paste` would choose for a square exemplar.
    default_scale: f64,
    /// What `paste` would take at that scale with [`USUAL_EXEMPLAR`], following an axis.
    estimate: Estimate,
    lapped: Option<LappedReport>,
}

/// How a model moves.
#[derive(Debug, Serialize)]
struct MotionReport {
    /// Nodes that carry vertices.
    joints: usize,
    /// Names; unnamed ones are empty.
    morph_targets: Vec<String>,
    /// In the order by which `--animation` counts them.
    animations: Vec<AnimationReport>,
}

/// One animation.
#[derive(Debug, Serialize)]
struct AnimationReport {
    name: String,
    seconds: f64,
}

/// What is in a record.
#[derive(Debug, Serialize)]
struct LappedReport {
    generator: String,
    exemplars: Vec<ImageReport>,
    patches: usize,
    pastes: usize,
    /// Names of its layers, from the bottom up.
    layers: Vec<String>,
    /// Which of them are detail over a base.
    bases: Vec<bool>,
    draws_per_face: f64,
    has_field: bool,
    subdivided_faces: usize,
}

/// What is in an exemplar.
#[derive(Debug, Serialize)]
struct ImageReport {
    kind: &'static str,
    name: String,
    width: u32,
    height: u32,
    channels: Vec<&'static str>,
    /// How it changes, if it does.
    #[serde(skip_serializing_if = "Option::is_none")]
    frames: Option<FramesReport>,
    /// How its colour image looks when turned; not looked at in records.
    #[serde(skip_serializing_if = "Option::is_none")]
    symmetry: Option<Symmetry>,
    warnings: Vec<String>,
}

/// The frames of an exemplar.
#[derive(Debug, Serialize)]
struct FramesReport {
    by: FramesBy,
    count: usize,
    /// Until the first comes back; 0 unless they go by time.
    seconds: f64,
}

impl FramesReport {
    fn of(frames: &Frames) -> Self {
        Self { by: frames.by(), count: frames.count(), seconds: frames.duration() }
    }

    fn in_words(&self) -> String {
        match self.by {
            FramesBy::Time => format!("{} frames over {:.2} s", self.count, self.seconds),
            FramesBy::View => format!("{} frames by the angle to the eye", self.count),
            FramesBy::Light => format!("{} frames by the angle to the main lamp", self.count),
        }
    }
}

/// Pixels and components of the exemplar that estimates suppose: a colour image of 512 x 512.
const USUAL_EXEMPLAR: (f64, usize) = (512.0 * 512.0, 3);

/// Groups of faces, and animations, that are told by name.
const MOST_GROUPS: usize = 12;

/// Runs the command.
///
/// # Errors
/// If the file cannot be read as a mesh, a record or an image.
pub fn run(args: &InspectArgs) -> anyhow::Result<()> {
    args.common.report.iter().try_for_each(|p| check_output(p))?;
    if !(args.weld >= 0.0 && args.weld.is_finite()) {
        bail!("--weld is {}: give a length in world units, 0 or more", args.weld);
    }
    let Some(path) = &args.file else {
        return list_adapters(args);
    };
    let is_image = image::ImageFormat::from_path(path).is_ok() || path.is_dir();
    if is_image {
        let (exemplar, warnings) = read_exemplar(path, &ExemplarOptions::default())?;
        let mut found = image_report(&exemplar, warnings.iter().map(ToString::to_string).collect());
        found.symmetry = exemplar_symmetry(&exemplar);
        return show(args, &found, image_text(&found));
    }
    let file = read_file(path, "the file")?;
    let (model, lapped) = if holds_record(&file) {
        let record = read_record_bytes(path, &file)?;
        let lapped = lapped_report(&record);
        (record.model, Some(lapped))
    } else {
        (read_model_bytes(path, &file)?, None)
    };
    let found = mesh_report(args, path, &model, lapped)?;
    show(args, &found, mesh_text(path, &found))
}

#[cfg(feature = "gpu")]
fn list_adapters(args: &InspectArgs) -> anyhow::Result<()> {
    let found = crate::render::gpu::adapters();
    let line = |(i, a): (usize, &crate::render::gpu::AdapterSummary)| {
        let mebibytes = a.max_binding >> 20;
        format!("{i}: {a}\n   {}, textures up to {} pixels, bindings up to {mebibytes} MiB\n", a.driver, a.max_texture_side)
    };
    let text = match &found[..] {
        [] => "there is no graphics adapter here; `lapped render` draws on the processor\n".to_owned(),
        found => found.iter().enumerate().map(line).collect(),
    };
    show(args, &found, text)
}

#[cfg(not(feature = "gpu"))]
fn list_adapters(_args: &InspectArgs) -> anyhow::Result<()> {
    anyhow::bail!("this program was built without graphics adapters (the cargo feature gpu)")
}

fn show(args: &InspectArgs, found: &impl Serialize, text: String) -> anyhow::Result<()> {
    let text = if args.json { serde_json::to_string_pretty(found)? } else { text };
    writeln!(std::io::stdout(), "{}", text.trim_end())?;
    match &args.common.report {
        Some(path) => report::write(path, found),
        None => Ok(()),
    }
}

fn image_report(exemplar: &crate::exemplar::Exemplar, warnings: Vec<String>) -> ImageReport {
    let [width, height] = exemplar.size();
    let channels = exemplar.channels().iter().map(Channel::name).collect();
    let frames = exemplar.frames().map(FramesReport::of);
    ImageReport { kind: "exemplar", name: exemplar.name.clone(), width, height, channels, frames, symmetry: None, warnings }
}

fn lapped_report(record: &Record) -> LappedReport {
    let faces: usize = record.lapped.pastes.iter().map(|p| p.faces.len()).sum();
    let parts = record.source_face.as_ref().map_or(0, |s| s.windows(2).filter(|w| w[0] == w[1]).count());
    LappedReport {
        generator: record.generator.clone(),
        exemplars: record.lapped.exemplars.iter().map(|e| image_report(e, Vec::new())).collect(),
        patches: record.lapped.patches.len(),
        pastes: record.lapped.pastes.len(),
        layers: record.lapped.layers.iter().map(|l| l.name.clone()).collect(),
        bases: record.lapped.layers.iter().map(|l| !l.base.is_empty()).collect(),
        draws_per_face: faces as f64 / record.model.faces.len() as f64,
        has_field: record.field.is_some(),
        subdivided_faces: parts,
    }
}

fn motion_report(motion: &Motion) -> MotionReport {
    let played = |a: &Animation| AnimationReport { name: a.name.clone(), seconds: a.duration() };
    MotionReport {
        joints: motion.joints.len(),
        morph_targets: motion.targets.iter().map(|t| t.name.clone()).collect(),
        animations: motion.animations.iter().map(played).collect(),
    }
}

fn mesh_report(args: &InspectArgs, path: &Path, model: &Model, lapped: Option<LappedReport>) -> anyhow::Result<MeshReport> {
    let options = CleanOptions { weld: args.weld, ..CleanOptions::default() };
    let cleaned = clean(&model.positions, &model.faces, &options).with_context(|| path.display().to_string())?;
    let (low, high) = cleaned.mesh.bounds();
    let source = &model.source;
    Ok(MeshReport {
        kind: if lapped.is_some() { "record" } else { "mesh" },
        format: source.format.clone(),
        name: model.name.clone(),
        file_vertices: source.vertices,
        file_polygons: source.polygons,
        up: source.up.clone(),
        unit: source.unit.clone(),
        has_uvs: model.uvs.is_some(),
        has_colors: model.colors.is_some(),
        motion: model.motion.as_ref().map(motion_report),
        groups: model.groups.clone(),
        notes: source.notes.clone(),
        bounds_min: low.to_array(),
        bounds_max: high.to_array(),
        area: cleaned.mesh.total_area(),
        default_scale: default_scale(&cleaned.mesh, DEFAULT_RATIO, 1.0),
        estimate: Estimate::new(&Work {
            exemplars: vec![USUAL_EXEMPLAR],
            ..Work::new(&cleaned.report, DEFAULT_RATIO, true, true, &[])
        }),
        clean: cleaned.report,
        lapped,
    })
}

fn image_text(found: &ImageReport) -> String {
    let mut text = format!("{}: {}x{} pixels, {}\n", found.name, found.width, found.height, found.channels.join(", "));
    found.frames.iter().for_each(|f| text += &format!("  changes       {}\n", f.in_words()));
    found.symmetry.iter().for_each(|s| text += &format!("  turned        {s}\n"));
    found.warnings.iter().for_each(|w| text += &format!("  note: {w}\n"));
    text
}

fn mesh_text(path: &Path, m: &MeshReport) -> String {
    let c = &m.clean;
    let mut text = format!("{}: {}\n", path.display(), m.format);
    text += &format!("  in the file   {} vertices, {} polygons, {} triangles\n", m.file_vertices, m.file_polygons, c.faces_in);
    text += &format!(
        "  states        up {}, unit {}{}{}\n",
        m.up.as_deref().unwrap_or("not stated"),
        m.unit.as_deref().unwrap_or("not stated"),
        if m.has_uvs { ", texture coordinates" } else { "" },
        if m.has_colors { ", vertex colours" } else { "" },
    );
    text += &format!("  cleaned       {} vertices, {} faces\n", c.vertices, c.faces);
    let done = [
        (c.welded_vertices, "vertices welded"),
        (c.unreferenced_vertices, "vertices without a face left out"),
        (c.degenerate_faces, "faces without area dropped"),
        (c.duplicate_faces, "second copies of faces set aside"),
        (c.flipped_faces, "faces turned"),
        (c.turned_components, "closed components were inside out and are turned"),
        (c.one_sided_components, "components have one side only and are cut open"),
        (c.non_manifold_edges, "edges with more than two faces parted"),
        (c.non_manifold_vertices, "vertices with several fans parted"),
    ];
    done.iter().filter(|(n, _)| *n > 0).for_each(|(n, what)| text += &format!("                {n} {what}\n"));
    text += &format!(
        "  shape         {} component(s), {} open; {} boundary edge(s) in {} loop(s); Euler characteristic {}\n",
        c.components, c.open_components, c.boundary_edges, c.boundary_loops, c.euler_characteristic
    );
    for open in &c.largest_open {
        text += &format!("                open: {}\n", open_text(open, &m.groups));
    }
    if c.open_components > c.largest_open.len() {
        text += &format!("                and {} smaller open ones\n", c.open_components - c.largest_open.len());
    }
    if let Some(motion) = &m.motion {
        text += &format!("  moves         {} joint(s), {} morph target(s)\n", motion.joints, motion.morph_targets.len());
        for (number, a) in motion.animations.iter().enumerate().take(MOST_GROUPS) {
            text += &format!("  animation     {number}: {:?}, {:.2} s\n", a.name, a.seconds);
        }
        if motion.animations.len() > MOST_GROUPS {
            text += &format!("                and {} more animations\n", motion.animations.len() - MOST_GROUPS);
        }
    }
    for group in m.groups.iter().take(MOST_GROUPS) {
        text += &format!("  faces         {}: {}\n", group_text(group), group.count);
    }
    if m.groups.len() > MOST_GROUPS {
        text += &format!("                and {} more groups\n", m.groups.len() - MOST_GROUPS);
    }
    let at = |p: [f32; 3]| format!("({}, {}, {})", p[0], p[1], p[2]);
    text += &format!("  bounds        {} to {}\n", at(m.bounds_min), at(m.bounds_max));
    let size: Vec<String> = (0..3).map(|k| significant(f64::from(m.bounds_max[k] - m.bounds_min[k]))).collect();
    text += &format!("  size          {}, area {}\n", size.join(" x "), significant(m.area));
    match &m.lapped {
        Some(l) => {
            text += &format!(
                "  lapped        {} pastes of {} texture patches, {:.2} draws per face, by {}\n",
                l.pastes, l.patches, l.draws_per_face, l.generator
            );
            let named = |(name, based): (&String, &bool)| match (name.as_str(), based) {
                ("", false) => String::new(),
                ("", true) => "detail over a base".to_owned(),
                (name, false) => name.to_owned(),
                (name, true) => format!("{name} (detail over a base)"),
            };
            let layers: Vec<String> = l.layers.iter().zip(&l.bases).map(named).collect();
            if !layers.is_empty() {
                text += &format!("  layers        {}\n", layers.join(", "));
            }
            for e in &l.exemplars {
                let changes = e.frames.as_ref().map_or_else(String::new, |f| format!("; {}", f.in_words()));
                let channels = e.channels.join(", ");
                text += &format!("  exemplar      {}: {}x{}, {channels}{changes}\n", e.name, e.width, e.height);
            }
        }
        None => {
            let e = &m.estimate;
            text += &format!(
                "  paste         would choose --scale {}; with 512 x 512 pixels of colour about {:.0} pastes, {} of memory, {}\n",
                significant(m.default_scale),
                e.pastes,
                estimate::in_words(e.memory_bytes),
                seconds_text(e.seconds)
            );
        }
    }
    m.notes.iter().for_each(|n| text += &format!("  note          {n}\n"));
    text
}

/// A number with four digits that count, however large or small.
fn significant(number: f64) -> String {
    let digits = 3 - number.abs().log10().floor().clamp(-99.0, 99.0) as i32;
    match number {
        0.0 => "0".to_owned(),
        n if (0..=9).contains(&digits) => format!("{n:.*}", digits as usize),
        n if (-5..0).contains(&digits) => format!("{n:.0}"),
        n => format!("{n:.3e}"),
    }
}

fn seconds_text(seconds: f64) -> String {
    match seconds {
        s if s < 90.0 => format!("{:.0} s", s.ceil()),
        s if s < 5400.0 => format!("{:.0} minutes", s / 60.0),
        s => format!("{:.1} hours", s / 3600.0),
    }
}

/// An open component by its size and, if the file names it, its name.
fn open_text(open: &OpenComponent, groups: &[FaceGroup]) -> String {
    let named = groups.iter().find(|g| (g.start as usize..(g.start + g.count) as usize).contains(&open.first_face));
    let name = named.map_or_else(
        || format!("around face {}", open.first_face),
        |g| format!("{}, around face {}", group_text(g), open.first_face),
    );
    format!("{} faces with {} boundary edges ({name})", open.faces, open.boundary_edges)
}

fn group_text(group: &FaceGroup) -> String {
    let part = |kind: &str, name: &str| (!name.is_empty()).then(|| format!("{kind} {name:?}"));
    let parts = [part("object", &group.object), part("group", &group.group), part("material", &group.material)];
    let parts: Vec<String> = parts.into_iter().flatten().collect();
    if parts.is_empty() { "unnamed".to_owned() } else { parts.join(", ") }
}
