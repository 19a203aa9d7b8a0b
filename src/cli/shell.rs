//! `lapped completions` and `lapped man`: made from the same definitions as the flags, so that they never disagree.

use super::{Cli, Common};
use anyhow::Context;
use clap::{Args, CommandFactory};
use clap_complete::Shell;
use std::io::Write;
use std::path::PathBuf;

/// Arguments of `lapped completions`.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  lapped completions bash > ~/.local/share/bash-completion/completions/lapped
  lapped completions zsh > ~/.zfunc/_lapped
  lapped completions fish > ~/.config/fish/completions/lapped.fish")]
pub struct CompletionsArgs {
    /// The shell
    #[arg(value_enum)]
    pub shell: Shell,
    /// See [`Common`].
    #[command(flatten)]
    pub common: Common,
}

/// Arguments of `lapped man`.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  lapped man | man -l -               read the manual page
  lapped man -o ~/.local/share/man/man1   a page for every command")]
pub struct ManArgs {
    /// Folder to write a page for every command to, instead of the page of the program to stdout
    #[arg(short, long, value_name = "DIR")]
    pub output: Option<PathBuf>,
    /// See [`Common`].
    #[command(flatten)]
    pub common: Common,
}

/// Writes a completion script to stdout.
///
/// # Errors
/// If nobody reads it.
pub fn completions(args: &CompletionsArgs) -> anyhow::Result<()> {
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut Cli::command(), "lapped", &mut script);
    std::io::stdout().write_all(&script)?;
    Ok(())
}

/// Writes manual pages.
///
/// # Errors
/// If a page cannot be written.
pub fn man(args: &ManArgs) -> anyhow::Result<()> {
    let mut command = Cli::command();
    command.build();
    let page = |command: &clap::Command| -> anyhow::Result<Vec<u8>> {
        let mut text = Vec::new();
        clap_mangen::Man::new(command.clone()).render(&mut text).context("the manual page cannot be made")?;
        Ok(text)
    };
    let Some(folder) = &args.output else {
        std::io::stdout().write_all(&page(&command)?)?;
        return Ok(());
    };
    let write = |name: &str, command: &clap::Command| -> anyhow::Result<()> {
        let text = page(command)?;
        crate::format::write_file(&folder.join(format!("{name}.1")), |out| out.write_all(&text))?;
        Ok(())
    };
    write("lapped", &command)?;
    for sub in command.get_subcommands().filter(|s| !s.is_hide_set() && s.get_name() != "help") {
        write(&format!("lapped-{}", sub.get_name()), sub)?;
    }
    Ok(())
}
