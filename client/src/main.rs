//! The `gonio` command line.

use std::process::ExitCode;

fn main() -> ExitCode {
    ExitCode::from(gonio::run(std::env::args_os()))
}
