//! The command line as a function: of the `gonio` program, and of what calls it inside of another process.

use crate::arguments::{Arguments, Command};
use crate::commands;
use crate::failure::Failure;
use clap::Parser;
use std::ffi::OsString;
use std::sync::OnceLock;

/// What the process was asked for; absent where nobody has run a command.
static WORDS: OnceLock<Vec<String>> = OnceLock::new();

/// Does what `words` say, of which the first is the program's name, and gives the process's exit code: 0 done, 1 failed, 2 bad input,
/// 130 interrupted. Logs, listens for signals and writes to the standard streams, so a process may call it once.
pub fn run(words: impl IntoIterator<Item = OsString>) -> u8 {
    let words: Vec<OsString> = words.into_iter().collect();
    let _ = WORDS.set(words.iter().map(|word| word.to_string_lossy().into_owned()).collect());
    let _logging = match gonio_operations::Log::Text.start("gonio", "error") {
        Ok(logging) => logging,
        Err(error) => {
            eprintln!("{error}");
            return 2;
        }
    };
    let arguments = match Arguments::try_parse_from(words) {
        Ok(arguments) => arguments,
        Err(said) => {
            // Help and version, too, are "errors" of clap, with exit code 0; a reader that is gone needs neither.
            let _ = said.print();
            return u8::try_from(said.exit_code()).unwrap_or(2);
        }
    };
    let (result, json) = dispatch(&arguments.command);
    match result {
        Ok(()) => 0,
        Err(failure) => failure.tell(json),
    }
}

/// The words of the command that this process runs, the program's name first; empty in a process that runs none.
pub(crate) fn words() -> &'static [String] {
    WORDS.get().map_or(&[], Vec::as_slice)
}

/// Runs a command; says, too, whether it was asked to write JSON.
fn dispatch(command: &Command) -> (Result<(), Failure>, bool) {
    match command {
        Command::Render(arguments) => (commands::render::run(arguments), arguments.farm.json),
        Command::Fit(arguments) => (commands::fit::run(arguments), arguments.farm.json),
        Command::Diagnose(arguments) => (commands::diagnose::run(arguments), arguments.farm.json),
        Command::Sweep(arguments) => (commands::sweep::run(arguments), arguments.farm.json),
        Command::Jobs(arguments) => (commands::jobs::list(arguments), arguments.json),
        Command::Attach(arguments) => (commands::jobs::attach(arguments), arguments.farm.json),
        Command::Cancel(arguments) => (commands::jobs::cancel(arguments), arguments.farm.json),
        Command::Hdr(arguments) => (commands::prepare::hdr::run(arguments), arguments.json),
        Command::Develop(arguments) => (commands::prepare::develop::run(arguments), arguments.json),
        Command::Chart(arguments) => (commands::prepare::chart::run(arguments), arguments.json),
        Command::Noise(arguments) => (commands::prepare::noise::run(arguments), arguments.json),
        Command::Matte(arguments) => (commands::prepare::matte::run(arguments), arguments.json),
        Command::Plan(arguments) => (commands::prepare::plan::run(arguments), false),
        Command::Composite(arguments) => (commands::prepare::composite::run(arguments), arguments.json),
        Command::Check(arguments) => (commands::check::run(arguments), arguments.json),
        Command::Dprime(arguments) => (commands::dprime::run(arguments), arguments.json),
        Command::Estimate(arguments) => (commands::estimate::run(arguments), arguments.json),
        Command::Evaluate(arguments) => (commands::evaluate::run(arguments), arguments.json),
        Command::Export(arguments) => (commands::export::run(arguments), arguments.json),
        Command::Predict(arguments) => (commands::predict::run(arguments), arguments.json),
        Command::Study(arguments) => (commands::study::run(arguments), arguments.json),
        Command::Import(arguments) => (commands::import::run(arguments), arguments.json),
        Command::Align(arguments) => (commands::align::run(arguments), arguments.json),
        Command::Mask(arguments) => (commands::mask::run(arguments), arguments.farm.json),
        Command::New(arguments) => (commands::new::run(arguments), arguments.json),
        Command::Calibrate(arguments) => (commands::calibrate::run(arguments), arguments.json),
    }
}
