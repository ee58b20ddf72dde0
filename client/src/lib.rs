//! What the `gonio` command line is made of: the farm that evaluates, and the report of a fit.

pub mod farm;
pub mod report;
