//! The `gonio` command line.

mod arguments;
mod commands;
mod failure;
mod input;
mod interrupt;
mod output;
mod progress;
mod relocate;
mod watch;

use arguments::{Arguments, Command};
use clap::Parser;
use std::process::ExitCode;

fn main() -> ExitCode {
    let _logging = match gonio_operations::Log::Text.start("gonio", "error") {
        Ok(logging) => logging,
        Err(error) => {
            eprintln!("{error}");
            return ExitCode::from(2);
        }
    };
    let (result, json) = match Arguments::parse().command {
        Command::Render(arguments) => (commands::render::run(&arguments), arguments.farm.json),
        Command::Fit(arguments) => (commands::fit::run(&arguments), arguments.farm.json),
        Command::Diagnose(arguments) => (commands::diagnose::run(&arguments), arguments.farm.json),
        Command::Sweep(arguments) => (commands::sweep::run(&arguments), arguments.farm.json),
        Command::Jobs(arguments) => (commands::jobs::list(&arguments), arguments.json),
        Command::Attach(arguments) => (commands::jobs::attach(&arguments), arguments.farm.json),
        Command::Cancel(arguments) => (commands::jobs::cancel(&arguments), arguments.farm.json),
        Command::Hdr(arguments) => (commands::prepare::hdr::run(&arguments), arguments.json),
        Command::Matte(arguments) => (commands::prepare::matte::run(&arguments), arguments.json),
        Command::Plan(arguments) => (commands::prepare::plan::run(&arguments), false),
        Command::Composite(arguments) => (commands::prepare::composite::run(&arguments), arguments.json),
        Command::Check(arguments) => (commands::check::run(&arguments), arguments.json),
        Command::Dprime(arguments) => (commands::dprime::run(&arguments), arguments.json),
        Command::Estimate(arguments) => (commands::estimate::run(&arguments), arguments.json),
        Command::Evaluate(arguments) => (commands::evaluate::run(&arguments), arguments.json),
        Command::Export(arguments) => (commands::export::run(&arguments), arguments.json),
        Command::Predict(arguments) => (commands::predict::run(&arguments), arguments.json),
        Command::Study(arguments) => (commands::study::run(&arguments), arguments.json),
        Command::Import(arguments) => (commands::import::run(&arguments), arguments.json),
        Command::New(arguments) => (commands::new::run(&arguments), arguments.json),
        Command::Calibrate(arguments) => (commands::calibrate::run(&arguments), arguments.json),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => failure.tell(json),
    }
}
