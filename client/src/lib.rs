//! What the `gonio` command line and the Python package are made of: the commands, the farm that evaluates, the reports.
//!
//! [`run`] is the command line as a function. Below it, [`commands`] holds what a command does apart from what it writes and
//! tells, so that a program gets the same bits from it as a user of the command line from its files.

mod arguments;
pub mod commands;
mod failure;
pub mod farm;
mod input;
mod interrupt;
mod output;
mod program;
mod progress;
mod relocate;
pub mod report;
mod watch;

pub use arguments::{DiagnoseOptions, FarmArguments, FitOptions, RenderOptions, SweepOptions, parse};
pub use failure::Failure;
pub use input::Input;
pub use interrupt::Interrupt;
pub use program::run;
pub use progress::Console;
