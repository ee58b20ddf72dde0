//! `gonio dprime`: how well people tell rendered images from photographs.

use crate::failure::Failure;
use crate::output::{tell, to_json};
use clap::Args;
use gonio_study::{Estimate, Options, Ratings, StudyError, Summary, plot};
use std::fmt::Write;
use std::path::PathBuf;

/// `gonio dprime`.
#[derive(Debug, Args)]
pub struct DprimeArguments {
    /// Answers: observer,image,truth (real or synthetic),rating (1 "definitely real" to 5 "definitely synthetic")
    #[arg(value_name = "RATINGS.csv")]
    pub ratings: PathBuf,
    /// Lowest rating that counts as "synthetic" for d'
    #[arg(long, value_name = "R", default_value_t = 4, value_parser = clap::value_parser!(u8).range(2..=5))]
    pub criterion: u8,
    /// File to draw the zROC to, as SVG
    #[arg(long, value_name = "FILE.svg")]
    pub plot: Option<PathBuf>,
    /// Studies drawn anew from the observers, for the standard errors
    #[arg(long, value_name = "N", default_value_t = 2000, value_parser = clap::value_parser!(u32).range(100..=1_000_000))]
    pub resamples: u32,
    /// Seed of the resampling
    #[arg(long, value_name = "S", default_value_t = 0)]
    pub seed: u64,
    /// Write the result as one JSON object
    #[arg(long)]
    pub json: bool,
}

impl From<StudyError> for Failure {
    fn from(error: StudyError) -> Self {
        Self::Input(error.to_string())
    }
}

/// Reads, summarises and tells.
///
/// # Errors
/// Ratings that are missing or bad; a plot that cannot be written.
pub fn run(arguments: &DprimeArguments) -> Result<(), Failure> {
    let file = arguments.ratings.display().to_string();
    let text = std::fs::read_to_string(&arguments.ratings).map_err(|error| {
        StudyError::new(&file, format!("cannot be read: {error}"), "name a table of observer,image,truth,rating")
    })?;
    let DprimeArguments { criterion, resamples, seed, .. } = *arguments;
    let summary = Summary::new(&file, &Ratings::parse(&file, &text)?, &Options { criterion, resamples, seed })?;
    if let Some(path) = &arguments.plot {
        std::fs::write(path, plot(&summary))
            .map_err(|error| Failure::Failed(format!("{}: cannot be written: {error}", path.display())))?;
    }
    if arguments.json {
        tell(&to_json(&summary)?);
    } else {
        tell(text_of(&summary).trim_end());
    }
    Ok(())
}

fn text_of(summary: &Summary) -> String {
    let mut text = String::new();
    let line = |name: &str, e: &Estimate| {
        format!("{name:<12}{:7.3}  +- {:.3}  95 % [{:.3}, {:.3}]\n", e.value, e.error, e.low, e.high)
    };
    let people = summary.observers.len();
    let _ = writeln!(text, "{people} observers, {} images", summary.images.len());
    text += &line("d'", &summary.d_prime);
    let _ = writeln!(text, "{:<12}{:7}  +- {:.3}  (Miller 1996: their few trials alone)", "", "", summary.within_error);
    match (&summary.d_a, &summary.slope, summary.area) {
        (Some(d_a), Some(slope), Some(area)) => {
            text += &line("d_a", d_a);
            text += &line("zROC slope", slope);
            let _ = writeln!(text, "{:<12}{area:7.3}", "area");
        }
        _ => text += "d_a         not determined: fewer than three levels were used\n",
    }
    let _ = writeln!(text, "\n{:<24}{:>8}{:>8}{:>8}{:>10}{:>10}", "observer", "d'", "+-", "c", "hits", "false");
    for row in &summary.observers {
        let counts = row.counts;
        let (hits, false_alarms) =
            (format!("{}/{}", counts.hits, counts.synthetic), format!("{}/{}", counts.false_alarms, counts.real));
        let (name, d, error, c) = (&row.observer, row.d_prime, row.error, row.criterion);
        let _ = writeln!(text, "{name:<24}{d:8.2}{error:8.2}{c:8.2}{hits:>10}{false_alarms:>10}");
    }
    let _ =
        writeln!(text, "\n{:<32}{:>10}{:>8}{:>8}{:>11}{:>8}", "image", "truth", "answers", "mean", "synthetic", "d'");
    for row in &summary.images {
        let (share, d) = (100.0 * row.called_synthetic, row.d_prime);
        let (image, truth, answers, mean) = (&row.image, row.truth.word(), row.answers, row.mean);
        let _ = writeln!(text, "{image:<32}{truth:>10}{answers:8}{mean:8.2}{share:9.0} %{d:8.2}");
    }
    text
}
