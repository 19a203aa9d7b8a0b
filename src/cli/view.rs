//! `lapped view`: the window in which a texture is seen, steered and changed live.

use super::Common;
use crate::viewer::{ViewOptions, run as open};
use clap::Args;
use std::path::PathBuf;

/// Arguments of `lapped view`.
#[derive(Debug, Clone, Args)]
#[command(after_help = "\
Examples:
  lapped view                            an empty window: pick a demo, or drop a mesh and an image into it
  lapped view bunny.obj bricks.png       bricks on the bunny, live
  lapped view bunny.glb                  a record that `lapped paste` wrote
  lapped view bunny.lapped               a project saved in the window

In the window: drag turns, Shift and drag moves, the wheel brings nearer; F frames, Y shows pasted and synthesised side by side, F1
shows all keys.")]
pub struct ViewArgs {
    /// What to open: a mesh or record, exemplar images or folders of material maps, or a project (.lapped)
    #[arg(value_name = "FILE")]
    pub files: Vec<PathBuf>,
    /// Graphics adapter: a number or a part of a name as `lapped inspect --gpu` lists them
    #[arg(long, value_name = "NAME")]
    pub adapter: Option<String>,
    /// Size of the window in points, like 1280x720
    #[arg(long, value_name = "WxH")]
    pub size: Option<super::picture::Size>,
    /// When the window is closed, write how long changes took to be seen and how long the interface stood still
    #[arg(long, value_name = "FILE.json")]
    pub trace: Option<PathBuf>,
    /// Where settings and unsaved work are kept [default: the system's place for them]
    #[arg(long, value_name = "DIR")]
    pub home: Option<PathBuf>,
    /// Ask for the names of files in the window, where the system has no dialogs for that
    #[arg(long)]
    pub own_dialogs: bool,
    /// See [`Common`].
    #[command(flatten)]
    pub common: Common,
}

/// Runs the command.
///
/// # Errors
/// If there is no display or no graphics adapter that can show a window.
pub fn run(args: &ViewArgs) -> anyhow::Result<()> {
    let size = args.size.map(|size| size.0.map(|s| s as f32));
    let ViewArgs { files, adapter, trace, home, own_dialogs, .. } = args.clone();
    Ok(open(ViewOptions { files, adapter, size, trace, home, own_dialogs })?)
}
