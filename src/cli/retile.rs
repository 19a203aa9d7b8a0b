//! `lapped retile`: the same surface with another number of vertices, evenly spread.

use super::bar::Bar;
use super::{Common, report};
use crate::format::export::{Kind, write_mesh};
use crate::format::{check_output, read_model};
use crate::mesh::pyramid::pyramid;
use crate::mesh::retile::{RetileOptions, RetileStatistics, Retiled, retile};
use crate::mesh::{CleanOptions, CleanReport, clean};
use anyhow::{Context, bail};
use clap::Args;
use serde::Serialize;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Arguments of `lapped retile`.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  lapped retile bunny.obj --vertices 20000 -o even.ply
  lapped retile part.obj --vertices 8000 --crease 30 -o part-even.obj     sharp edges stay sharp
  lapped retile bunny.obj --vertices 24000 --levels 4 -o level.ply        level-0.ply to level-3.ply, a quarter each")]
pub struct RetileArgs {
    /// The mesh: OBJ, PLY, STL, glTF or GLB
    #[arg(value_name = "MESH")]
    pub mesh: PathBuf,
    /// Where to write the new mesh: .obj, .ply or .glb
    #[arg(short, long, value_name = "OUT")]
    pub output: PathBuf,
    /// Vertices of the new mesh
    #[arg(long, value_name = "N")]
    pub vertices: usize,
    /// Keep edges over which the surface bends by more than this; boundaries are always kept
    #[arg(long, value_name = "DEGREES")]
    pub crease: Option<f64>,
    /// Also write coarser levels, each with a quarter of the vertices of the one before; -0, -1, ... is added to the name
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u64).range(1..=16))]
    pub levels: u64,
    /// Seed of where the new vertices start
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u64,
    /// Weld vertices closer than this, world units; 0 welds equal positions only
    #[arg(long, value_name = "TOL", default_value_t = 0.0)]
    pub weld: f64,
    /// See [`Common`].
    #[command(flatten)]
    pub common: Common,
}

#[derive(Debug, Serialize)]
struct RunReport {
    command: &'static str,
    mesh: String,
    clean: CleanReport,
    levels: Vec<RetileStatistics>,
    seconds: f64,
    peak_memory_bytes: Option<u64>,
}

/// Runs the command.
///
/// # Errors
/// If a file cannot be read or written, or so many vertices cannot make this surface.
pub fn run(args: &RetileArgs) -> anyhow::Result<()> {
    let begin = Instant::now();
    let kind = Kind::of(&args.output)?;
    let outputs: Vec<PathBuf> = (0..args.levels).map(|k| level_path(&args.output, k, args.levels)).collect();
    outputs.iter().chain(args.common.report.as_ref()).try_for_each(|p| check_output(p))?;
    if args.crease.is_some_and(|c| !(c > 0.0 && c < 180.0)) {
        bail!("--crease is {}: give an angle between 0 and 180 degrees", args.crease.unwrap_or_default());
    }
    if !(args.weld >= 0.0 && args.weld.is_finite()) {
        bail!("--weld is {}: give a length in world units, 0 or more", args.weld);
    }
    let name = || args.mesh.display().to_string();
    let model = read_model(&args.mesh)?;
    let cleaned =
        clean(&model.positions, &model.faces, &CleanOptions { weld: args.weld, ..CleanOptions::default() }).with_context(name)?;
    let options = RetileOptions {
        vertices: args.vertices,
        crease: args.crease.map(f64::to_radians),
        seed: args.seed,
        ..RetileOptions::default()
    };
    let bar = Bar::new(args.common.quiet);
    let levels: Result<Vec<Retiled>, _> = if args.levels == 1 {
        retile(&cleaned.mesh, &options, &bar).map(|made| vec![made])
    } else {
        pyramid(&cleaned.mesh, &options, args.levels as usize, &bar).map(|made| made.levels)
    };
    bar.finish();
    let levels = levels.with_context(name)?;
    for (made, path) in levels.iter().zip(&outputs) {
        write_mesh(path, kind, &model.name, &made.mesh, None)?;
        told(args, path, made);
    }
    if let Some(path) = &args.common.report {
        let report = RunReport {
            command: "retile",
            mesh: name(),
            clean: cleaned.report,
            levels: levels.iter().map(|l| l.statistics).collect(),
            seconds: begin.elapsed().as_secs_f64(),
            peak_memory_bytes: report::peak_memory(),
        };
        report::write(path, &report)?;
    }
    Ok(())
}

fn told(args: &RetileArgs, path: &Path, made: &Retiled) {
    let (s, e) = (&made.statistics, &made.statistics.evenness);
    if s.vertices.abs_diff(s.asked) * 100 > s.asked {
        args.common.warn(&format!(
            "{}: {} vertices instead of {}: the others hold its lines or parts together",
            path.display(),
            s.vertices,
            s.asked
        ));
    }
    if !args.common.quiet {
        let _ = writeln!(
            std::io::stdout(),
            "{}: {} vertices, {} faces, edges {:.4} long, give or take {:.0} %, smallest angle {:.0} degrees, {:.2} edges off at most",
            path.display(),
            s.vertices,
            made.mesh.face_count(),
            e.mean_edge,
            100.0 * e.edge_variation,
            e.least_angle,
            s.farthest / e.mean_edge,
        );
    }
}

/// The name of one level's file.
fn level_path(output: &Path, level: u64, levels: u64) -> PathBuf {
    if levels == 1 {
        return output.to_owned();
    }
    let part = |p: Option<&std::ffi::OsStr>| p.map(|s| s.to_string_lossy().into_owned()).unwrap_or_default();
    output.with_file_name(format!("{}-{level}.{}", part(output.file_stem()), part(output.extension())))
}
