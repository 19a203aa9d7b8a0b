//! The command line: one file a subcommand.
//!
//! Results go to stdout, talk to stderr. Exit codes: 0 done, 1 an error in the input or the job, 2 wrong usage, 130
//! interrupted.

pub mod bake;
pub mod bar;
mod brush;
pub mod channels;
pub mod compare;
mod compare_job;
pub mod demo;
pub mod field;
pub mod inspect;
pub mod job_file;
pub mod paste;
pub mod picture;
pub mod region;
pub mod render;
pub mod report;
pub mod retile;
pub mod shell;
pub mod synth;
pub mod synth_round;
#[cfg(feature = "viewer")]
pub mod view;

use clap::{Args, Parser, Subcommand};
use std::io::{IsTerminal, Write};
use std::path::PathBuf;
use std::process::ExitCode;

/// Puts any example texture on any triangle mesh: no UVs, no cuts, no painting.
#[derive(Debug, Parser)]
#[command(version, about, long_about = LONG_ABOUT, after_help = AFTER_HELP, propagate_version = true)]
pub struct Cli {
    #[command(subcommand)]
    command: Command,
}

const LONG_ABOUT: &str = "Puts any example texture on any triangle mesh: no UVs, no cuts, no painting.\n\n\
    `lapped paste` covers a mesh with overlapping pastes of patches cut from example images (Lapped Textures, Praun, \
    Finkelstein and Hoppe 2000), steered by a direction over the surface. What it writes is a GLB that opens in any glTF tool \
    and holds the pastes for `lapped render`.";

const AFTER_HELP: &str = "Examples:\n  \
    lapped demo                                             pictures and records from built-in assets, into ./lapped-demo/\n  \
    lapped paste bunny.obj bricks.png -o bunny.glb          bricks upright all over the bunny\n  \
    lapped paste rock.ply moss.jpg -o rock.glb --field none --preview rock.png\n  \
    lapped synth torus.obj pebbles.jpg -o torus.glb         a texture that looks like pebbles, vertex by vertex
  \
    lapped compare bunny.obj pebbles.jpg -o compared         how pasting, synthesis and projections do, as a page
  \
    lapped render bunny.glb -o bunny.png --size 1024x1024 --camera yaw=30,pitch=15\n  \
    lapped inspect bunny.obj                                what is in a file, and what would be mended\n\n\
    Every command explains its options and shows examples: lapped paste --help";

#[derive(Debug, Subcommand)]
enum Command {
    /// Make pictures, records and a report from the built-in assets
    Demo(demo::DemoArgs),
    /// Cover a mesh with overlapping pastes of example images
    Paste(Box<paste::PasteArgs>),
    /// Bake a record's texture into an atlas that any tool opens
    Bake(bake::BakeArgs),
    /// Give a re-tiled mesh a texture at its vertices that looks like an example image
    Synth(Box<synth::SynthArgs>),
    /// Put pasted, synthesized and projected textures side by side, in pictures and numbers
    Compare(Box<compare::CompareArgs>),
    /// Draw a record, or a plain mesh
    Render(render::RenderArgs),
    /// Open the window: see, steer and change a texture live
    #[cfg(feature = "viewer")]
    View(view::ViewArgs),
    /// Give a mesh another number of vertices, evenly spread
    Retile(retile::RetileArgs),
    /// Make a smooth field of directions over a mesh
    Field(field::FieldArgs),
    /// Say what is in a mesh, a record or an image, and what cleaning would do
    Inspect(inspect::InspectArgs),
    /// Print a script that completes commands and flags in a shell
    Completions(shell::CompletionsArgs),
    /// Print the manual page
    Man(shell::ManArgs),
}

/// What every command takes.
#[derive(Debug, Clone, Args)]
pub struct Common {
    /// Threads to use; 0 uses one per core. The result is the same for any number
    #[arg(long, value_name = "N", default_value_t = 0, global = true)]
    pub threads: usize,
    /// Say nothing but errors
    #[arg(long, short, global = true)]
    pub quiet: bool,
    /// Write all figures of the run to this file
    #[arg(long, value_name = "FILE.json", global = true)]
    pub report: Option<PathBuf>,
}

impl Common {
    /// Says something on stderr, unless asked for quiet.
    pub fn say(&self, text: &str) {
        if !self.quiet {
            // Nobody is left to be told if stderr is closed.
            let _ = writeln!(std::io::stderr(), "{text}");
        }
    }

    /// Passes on what reading a file told: decisions as notes, the rest as warnings.
    pub fn pass_on(&self, told: &crate::format::Warning) {
        if told.note { self.say(&format!("note: {told}")) } else { self.warn(&told.to_string()) }
    }

    /// Warns on stderr, unless asked for quiet.
    pub fn warn(&self, text: &str) {
        let colour = std::io::stderr().is_terminal();
        self.say(&format!("{}: {text}", if colour { "\x1b[33mwarning\x1b[0m" } else { "warning" }));
    }
}

/// Runs a command line.
#[must_use]
pub fn run(cli: Cli) -> ExitCode {
    stop_cleanly();
    let done = match &cli.command {
        Command::Demo(args) => with_threads(&args.common, || demo::run(args)),
        Command::Paste(args) => with_threads(&args.common, || paste::run(args)),
        Command::Bake(args) => with_threads(&args.common, || bake::run(args)),
        Command::Synth(args) => with_threads(&args.common, || synth::run(args)),
        Command::Compare(args) => with_threads(&args.common, || compare::run(args)),
        Command::Render(args) => with_threads(&args.common, || render::run(args)),
        #[cfg(feature = "viewer")]
        Command::View(args) => on_main_thread(&args.common, || view::run(args)),
        Command::Retile(args) => with_threads(&args.common, || retile::run(args)),
        Command::Field(args) => with_threads(&args.common, || field::run(args)),
        Command::Inspect(args) => with_threads(&args.common, || inspect::run(args)),
        Command::Completions(args) => shell::completions(args),
        Command::Man(args) => shell::man(args),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) if is_closed_pipe(&error) => ExitCode::SUCCESS,
        Err(error) => {
            let _ = writeln!(std::io::stderr(), "error: {error:#}");
            ExitCode::from(1)
        }
    }
}

/// What shells expect of a program that ended on Ctrl-C.
const INTERRUPTED: i32 = 130;

/// Makes interruptions (Ctrl-C, a closing terminal, `kill`) leave no temporary file.
fn stop_cleanly() {
    // Where no handler can be set, the default one ends the program, as ever.
    let _ = ctrlc::set_handler(|| {
        let _nothing_more = crate::format::abandon_outputs();
        let _ = writeln!(std::io::stderr(), "\nerror: interrupted: no unfinished file was left behind; run again for a result");
        std::process::exit(INTERRUPTED);
    });
}

/// Runs on as many threads as asked for.
fn with_threads(common: &Common, work: impl FnOnce() -> anyhow::Result<()> + Send) -> anyhow::Result<()> {
    rayon::ThreadPoolBuilder::new().num_threads(common.threads).build()?.install(work)
}

/// The same for work that systems want from the thread that the program began with, as windows are.
#[cfg(feature = "viewer")]
fn on_main_thread(common: &Common, work: impl FnOnce() -> anyhow::Result<()>) -> anyhow::Result<()> {
    rayon::ThreadPoolBuilder::new().num_threads(common.threads).build_global()?;
    work()
}

/// True if whoever read our output has stopped reading, which is no failure of ours.
fn is_closed_pipe(error: &anyhow::Error) -> bool {
    let io = error.chain().find_map(|e| e.downcast_ref::<std::io::Error>());
    io.is_some_and(|e| e.kind() == std::io::ErrorKind::BrokenPipe)
}

/// Three numbers separated by commas, not all zero.
fn axis(text: &str) -> Result<glam::DVec3, String> {
    let named = match text {
        "x" | "+x" => Some(glam::DVec3::X),
        "y" | "+y" => Some(glam::DVec3::Y),
        "z" | "+z" => Some(glam::DVec3::Z),
        "-x" => Some(-glam::DVec3::X),
        "-y" => Some(-glam::DVec3::Y),
        "-z" => Some(-glam::DVec3::Z),
        _ => None,
    };
    if let Some(axis) = named {
        return Ok(axis);
    }
    let numbers: Vec<f64> = text.split(',').map(|n| n.trim().parse()).collect::<Result<_, _>>().map_err(|_| AXIS.to_owned())?;
    match numbers[..] {
        [x, y, z] if x.is_finite() && y.is_finite() && z.is_finite() && (x, y, z) != (0.0, 0.0, 0.0) => {
            Ok(glam::DVec3::new(x, y, z))
        }
        _ => Err(AXIS.to_owned()),
    }
}

const AXIS: &str = "give x, y, z, -x, -y, -z, or three numbers like 0,1,0 that are not all zero";
