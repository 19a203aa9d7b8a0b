//! The command line: parses arguments, prints errors; nothing else.

use clap::Parser;
use std::process::ExitCode;

fn main() -> ExitCode {
    lapped::cli::run(lapped::cli::Cli::parse())
}
