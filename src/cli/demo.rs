//! `lapped demo`: the main job on built-in assets, so that a fresh machine shows what this is in one command.

use super::bar::Bar;
use super::{Common, picture, report};
use crate::assets::{exemplar, mesh};
use crate::exemplar::PatchSource;
use crate::exemplar::PatchSpec;
use crate::format::{check_output, write_record};
use crate::job::bake::default_size;
use crate::job::{BakeJob, Bound, ExemplarInput, JobReport, PasteJob, Scale, Steer, bake_record, paste_model};
use crate::paste::Composite;
use crate::render::{Picture, PreviewStyle, Subject, UpAxis, View, preview};
use anyhow::Context;
use clap::Args;
use glam::DVec3;
use serde::Serialize;
use std::io::Write;
use std::path::PathBuf;
use std::time::Instant;

/// Arguments of `lapped demo`.
#[derive(Debug, Args)]
#[command(after_help = "\
Writes for each model a record with its bake (.glb, opens in any glTF tool and in `lapped render`), a sheet of four views (.png), pictures \
of the method at work on the first one, gallery.png with all of them, and report.json.")]
pub struct DemoArgs {
    /// Folder to write to
    #[arg(short, long, value_name = "DIR", default_value = "lapped-demo")]
    pub output: PathBuf,
    /// See [`Common`].
    #[command(flatten)]
    pub common: Common,
}

/// One thing to show.
struct Show {
    name: &'static str,
    mesh: &'static str,
    exemplars: &'static [&'static str],
    /// Surface area over exemplar area.
    ratio: f64,
    /// `None` for textures that look the same every way.
    up: Option<DVec3>,
    /// Yaw and pitch of its picture in the gallery, degrees.
    view: [f64; 2],
}

const SHOWS: [Show; 8] = [
    Show {
        name: "dragonling-scales",
        mesh: "dragonling_25k",
        exemplars: &["scales"],
        ratio: 60.0,
        up: Some(DVec3::Y),
        view: [32.0, 14.0],
    },
    Show { name: "dragonling-fur", mesh: "dragonling", exemplars: &["fur"], ratio: 40.0, up: Some(DVec3::Y), view: [-35.0, 14.0] },
    Show {
        name: "dragonling-moss-stone",
        mesh: "dragonling",
        exemplars: &["moss", "stone"],
        ratio: 40.0,
        up: None,
        view: [32.0, 14.0],
    },
    Show { name: "knot-weave", mesh: "knot", exemplars: &["weave"], ratio: 60.0, up: Some(DVec3::Y), view: [20.0, 25.0] },
    Show { name: "knot-pebbles", mesh: "knot", exemplars: &["pebbles"], ratio: 30.0, up: None, view: [20.0, 25.0] },
    Show { name: "gear-rust", mesh: "gear", exemplars: &["rust"], ratio: 30.0, up: None, view: [35.0, 30.0] },
    Show { name: "vase-bricks", mesh: "vase", exemplars: &["bricks"], ratio: 30.0, up: Some(DVec3::Y), view: [0.0, 15.0] },
    Show { name: "terrain-leaves", mesh: "terrain", exemplars: &["leaves"], ratio: 60.0, up: None, view: [30.0, 35.0] },
];

/// Width and height of a picture in the gallery, pixels.
const PICTURE: u32 = 400;

/// Texels along each side of the bakes, at most: the demo is to be quick.
const LARGEST_BAKE: u32 = 1024;

/// Width and height of a sheet of four views, pixels.
const SHEET: u32 = 640;

#[derive(Debug, Serialize)]
struct DemoReport {
    command: &'static str,
    version: &'static str,
    models: Vec<ShowReport>,
    seconds: f64,
    peak_memory_bytes: Option<u64>,
}

#[derive(Debug, Serialize)]
struct ShowReport {
    name: &'static str,
    #[serde(flatten)]
    job: JobReport,
    seconds: f64,
}

/// Runs the command.
///
/// # Errors
/// If a file cannot be written.
pub fn run(args: &DemoArgs) -> anyhow::Result<()> {
    let begin = Instant::now();
    args.common.report.iter().try_for_each(|p| check_output(p))?;
    std::fs::create_dir_all(&args.output)
        .with_context(|| format!("{}: the folder cannot be made; choose another with --output", args.output.display()))?;
    let bar = Bar::new(args.common.quiet);
    let columns = 4;
    let rows = SHOWS.len().div_ceil(columns);
    let mut gallery = Picture::filled(columns as u32 * PICTURE, rows as u32 * PICTURE, [255; 4]);
    let mut models = Vec::new();
    for (i, show) in SHOWS.iter().enumerate() {
        let start = Instant::now();
        let (front, job) = one(args, show, i == 0, &bar).with_context(|| show.name)?;
        gallery.paste(&front, (i % columns) as u32 * PICTURE, (i / columns) as u32 * PICTURE);
        let seconds = start.elapsed().as_secs_f64();
        bar.finish();
        if !args.common.quiet {
            writeln!(
                std::io::stdout(),
                "{:22} {:>4} pastes on {:>5} faces, {:.2} draws per face, {seconds:.1} s",
                show.name,
                job.paste.pastes,
                job.clean.faces,
                job.paste.draws_per_face
            )?;
        }
        models.push(ShowReport { name: show.name, job, seconds });
    }
    picture::save(&args.output.join("gallery.png"), &gallery)?;
    let seconds = begin.elapsed().as_secs_f64();
    let found = DemoReport {
        command: "demo",
        version: env!("CARGO_PKG_VERSION"),
        models,
        seconds,
        peak_memory_bytes: report::peak_memory(),
    };
    report::write(&args.output.join("report.json"), &found)?;
    if let Some(path) = &args.common.report {
        report::write(path, &found)?;
    }
    if !args.common.quiet {
        writeln!(std::io::stdout(), "wrote {} in {seconds:.1} s; look at gallery.png first", args.output.display())?;
    }
    Ok(())
}

/// Pastes, writes and draws one show; returns its picture for the gallery.
fn one(args: &DemoArgs, show: &Show, explain: bool, bar: &Bar) -> anyhow::Result<(Picture, JobReport)> {
    let model = mesh(show.mesh)?;
    let input = |name: &&str| -> anyhow::Result<ExemplarInput> {
        Ok(ExemplarInput {
            exemplar: exemplar(name)?,
            weight: 1.0,
            patches: vec![PatchSpec { source: PatchSource::Splotch, weight: 1.0 }],
        })
    };
    let inputs = show.exemplars.iter().map(input).collect::<anyhow::Result<_>>()?;
    let job = PasteJob {
        scale: Scale::Ratio(show.ratio),
        steer: show.up.map_or(Steer::Isotropic(None), Steer::Up),
        ..PasteJob::default()
    };
    let pasted = paste_model(&model, inputs, &job, bar)?;
    let file = |suffix: &str| args.output.join(format!("{}{suffix}", show.name));
    let texture = Composite::new(&pasted.mesh, &pasted.lapped);
    let bound = Bound::new(pasted.record.clone())?;
    let size = default_size(&bound.mesh, &bound.lapped).min(LARGEST_BAKE);
    let (record, ..) = bake_record(pasted.record, &bound, &BakeJob::sized(size), bar)?;
    write_record(&file(".glb"), &record)?;
    let subject = Subject { mesh: &pasted.mesh, texture: &texture, lapped: Some(&pasted.lapped), guide: Some(&pasted.guide) };
    let sheet = picture::views(None, [SHEET; 2], 2, false, UpAxis::Y);
    picture::save(&file(".png"), &preview(&subject, PreviewStyle::Texture, &sheet)?)?;
    if explain {
        for style in PreviewStyle::ALL.into_iter().filter(|&s| s != PreviewStyle::Texture) {
            picture::save(&file(&format!("-{style}.png")), &preview(&subject, style, &sheet)?)?;
        }
    }
    let [yaw, pitch] = show.view;
    let front = picture::views(Some(View::degrees(yaw, pitch)), [PICTURE; 2], 2, false, UpAxis::Y);
    Ok((preview(&subject, PreviewStyle::Texture, &front)?, pasted.report))
}
