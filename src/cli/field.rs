//! `lapped field`: n directions at each face of a mesh, smooth, along curvature or creases, or through constraints.

use super::bar::Bar;
use super::{Common, report};
use crate::field::nway::align::{constraints, creases, least_curvature};
use crate::field::nway::{Combed, NWayOptions, NWaySingularity, NWaySolver, NWayStatistics, Over, Start, comb};
use crate::field::{Constraints, DEFAULT_RATIO, default_scale};
use crate::format::export::{Kind, write_mesh};
use crate::format::{check_output, read_file, read_model, write_file};
use crate::mesh::curvature::curvature;
use crate::mesh::{CleanOptions, CleanReport, Mesh, clean};
use anyhow::{Context, bail};
use clap::Args;
use glam::{DVec2, DVec3, Vec3};
use serde::Serialize;
use std::io::Write;
use std::path::PathBuf;
use std::time::Instant;

/// Arguments of `lapped field`.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  lapped field bunny.obj -o field.json                         one smooth direction, for `lapped paste --field field.json`
  lapped field cat.obj -n 4 --curvature 1 -o cross.json        four ways, along the least curvature
  lapped field part.obj -n 2 --crease 30 -o arrows.glb         two ways, along sharp edges, as arrows to look at
  lapped field cat.obj --constraints cat.json -o field.json    through wishes at a few places (docs/fields.md)")]
pub struct FieldArgs {
    /// The mesh: OBJ, PLY, STL, glTF or GLB
    #[arg(value_name = "MESH")]
    pub mesh: PathBuf,
    /// Where to write: .json for a field file, .glb for arrows to look at
    #[arg(short, long, value_name = "OUT")]
    pub output: PathBuf,
    /// Directions at each place, a full turn over N apart
    #[arg(short = 'n', long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=12))]
    pub ways: u32,
    /// Follow the direction in which the surface bends least, this strongly (1 is about as strong as smoothness); needs an even N
    #[arg(long, value_name = "STRENGTH", default_value_t = 0.0)]
    pub curvature: f64,
    /// Follow edges over which the surface bends by more than this; needs an even N
    #[arg(long, value_name = "DEGREES")]
    pub crease: Option<f64>,
    /// Wishes at places, in a file of constraints
    #[arg(long, value_name = "FILE.json")]
    pub constraints: Option<PathBuf>,
    /// Start from random directions instead of the smoothest
    #[arg(long)]
    pub random: bool,
    /// Relax the error of Wei and Levoy too
    #[arg(long)]
    pub nearest: bool,
    /// World length of one exemplar width, the length of the vectors
    #[arg(long, value_name = "LENGTH")]
    pub scale: Option<f64>,
    /// Seed of random directions
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u64,
    /// See [`Common`].
    #[command(flatten)]
    pub common: Common,
}

#[derive(Debug, Serialize)]
struct RunReport {
    command: &'static str,
    mesh: String,
    clean: CleanReport,
    ways: u32,
    field: NWayStatistics,
    singularities: Vec<NWaySingularity>,
    cut: crate::field::nway::Cut,
    seconds: f64,
    peak_memory_bytes: Option<u64>,
}

/// Runs the command.
///
/// # Errors
/// If a file cannot be read or written, or the wishes do not fit the number of directions.
pub fn run(args: &FieldArgs) -> anyhow::Result<()> {
    let begin = Instant::now();
    let arrows = match args.output.extension().map(|e| e.to_string_lossy().to_ascii_lowercase()).as_deref() {
        Some("json") => false,
        Some("glb") => true,
        _ => {
            bail!("{}: fields are written as .json, or .glb to look at: give the name one of these endings", args.output.display())
        }
    };
    [Some(&args.output), args.common.report.as_ref()].into_iter().flatten().try_for_each(|p| check_output(p))?;
    if !(args.curvature >= 0.0 && args.curvature.is_finite()) {
        bail!("--curvature is {}: give a number, 0 or more", args.curvature);
    }
    if args.crease.is_some_and(|c| !(c > 0.0 && c < 180.0)) {
        bail!("--crease is {}: give an angle between 0 and 180 degrees", args.crease.unwrap_or_default());
    }
    if args.ways % 2 == 1 && (args.curvature > 0.0 || args.crease.is_some()) {
        bail!("curvature and creases know lines, not directions: give an even number with -n, such as 2 or 4");
    }
    let name = || args.mesh.display().to_string();
    let model = read_model(&args.mesh)?;
    let cleaned = clean(&model.positions, &model.faces, &CleanOptions::default()).with_context(name)?;
    let mesh = &cleaned.mesh;
    let scale = args.scale.unwrap_or_else(|| default_scale(mesh, DEFAULT_RATIO, 1.0));
    let bar = Bar::new(args.common.quiet);
    let solver = NWaySolver::new(mesh, Over::Faces, args.ways);
    let mut wishes = vec![DVec2::ZERO; mesh.face_count()];
    if args.curvature > 0.0 {
        least_curvature(mesh, &solver.table, args.ways, &mut wishes, &curvature(mesh), args.curvature);
    }
    if let Some(crease) = args.crease {
        creases(mesh, &solver.table, args.ways, &mut wishes, crease.to_radians(), 1.0);
    }
    if let Some(path) = &args.constraints {
        let file = || path.display().to_string();
        let bytes = read_file(path, "the file of constraints")?;
        let text = String::from_utf8(bytes).with_context(file)?;
        let found = Constraints::from_json(&text).with_context(file)?;
        let anchors = found.anchors(mesh, Some(&cleaned.user_faces), found.axis(DVec3::Y), scale).with_context(file)?;
        constraints(mesh, &solver.table, args.ways, &mut wishes, &anchors);
    }
    if wishes.iter().all(|w| *w == DVec2::ZERO) {
        wishes.clear();
    }
    let start = if args.random { Start::Random } else { Start::Smooth };
    let options = NWayOptions { start, nearest: args.nearest, seed: args.seed, ..NWayOptions::default() };
    let (found, statistics) = solver.solve(&wishes, &options, &bar);
    bar.finish();
    let singularities = solver.singularities(&found);
    let Combed { field, cut } = comb(mesh, &solver, &found, scale)?;
    if arrows {
        let directions = solver.directions(&found);
        let (shown, along) = arrow_mesh(mesh, &field.up, &directions, args.ways, scale);
        write_mesh(&args.output, Kind::Glb, &model.name, &shown, Some(along))?;
    } else {
        let text = field.to_json()?;
        write_file(&args.output, |out| out.write_all(text.as_bytes()))?;
    }
    if !args.common.quiet {
        let _ = writeln!(
            std::io::stdout(),
            "{}: {} ways on {} faces, {} singularities, indices sum to {:.2}; error {:.4}; one direction jumps over {} edges",
            args.output.display(),
            args.ways,
            mesh.face_count(),
            statistics.singularities,
            statistics.index_sum as f64 / f64::from(args.ways),
            statistics.nearest_errors.last().copied().unwrap_or_default(),
            cut.edges,
        );
    }
    if let Some(path) = &args.common.report {
        let report = RunReport {
            command: "field",
            mesh: name(),
            clean: cleaned.report,
            ways: args.ways,
            field: statistics,
            singularities,
            cut,
            seconds: begin.elapsed().as_secs_f64(),
            peak_memory_bytes: report::peak_memory(),
        };
        report::write(path, &report)?;
    }
    Ok(())
}

/// Arrows at most; on meshes with more faces they stand at some of them.
const ARROWS: usize = 20_000;

/// The mesh with flat arrows a little above its faces, and a direction for each face of both.
fn arrow_mesh(mesh: &Mesh, up: &[Vec3], directions: &[DVec3], ways: u32, scale: f64) -> (Mesh, Vec<Vec3>) {
    let every = mesh.face_count().div_ceil(ARROWS);
    let spacing = (mesh.total_area() * every as f64 / mesh.face_count() as f64).sqrt().min(scale);
    let (mut out, mut all) = (mesh.clone(), up.to_vec());
    for f in (0..mesh.face_count()).step_by(every) {
        let normal = mesh.normal(f as u32);
        let from = mesh.centroid(f as u32) + normal * (0.1 * spacing);
        for way in 0..ways {
            let turn = std::f64::consts::TAU * f64::from(way) / f64::from(ways);
            let (sine, cosine) = turn.sin_cos();
            let unit = directions[f] * cosine + normal.cross(directions[f]) * sine;
            let along = unit * (0.45 * spacing);
            let side = normal.cross(along) * 0.12;
            let first = out.positions.len() as u32;
            out.positions.extend([from - side, from + along, from + side].map(|p: DVec3| -> Vec3 { p.as_vec3() }));
            // The front of an arrow looks outward.
            out.faces.push([first, first + 2, first + 1]);
            out.opposite.extend([crate::mesh::NONE; 3]);
            all.push((unit * scale).as_vec3());
        }
    }
    (out, all)
}
