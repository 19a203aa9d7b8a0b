//! The command line: parses arguments, prints errors; nothing else.

fn main() {}
