//! What may be written on the command line.

mod prepare;

pub use prepare::{
    ChartArguments, CompositeArguments, DevelopArguments, HdrArguments, MatteArguments, NoiseArguments, PlanArguments,
    camera, colour,
};

use crate::failure::Failure;
use crate::watch::WatchArguments;
use clap::{Args, Parser, Subcommand};
use gonio_fit::SolverName;
use gonio_worker::access::Access;
use std::path::PathBuf;

/// Paragraphs are one line each: clap wraps them to the terminal.
const EXIT_CODES: &str = "\
Exit codes:
  0    done; a fit that ran out of iterations says so in its warnings and in fit.json (\"converged\")
  1    the farm or the machine failed: another try may succeed
  2    bad input or usage: the message names the file, the key and the mend
  130  interrupted: what a fit had reached is kept, and `gonio fit --resume` continues it; a sweep keeps its frames, and \
the same command renders the others

CAPTURE is a capture's folder or its capture.toml. Results go to stdout, progress and errors to stderr. With --json, \
stdout is one JSON object and stderr one JSON event per line. RUST_LOG=info shows what the farm logs.";

/// Fits light and material to photographs by analysis-by-synthesis over a render farm.
#[derive(Debug, Parser)]
#[command(name = "gonio", version = gonio_operations::VERSION, after_help = EXIT_CODES, disable_help_subcommand = true)]
pub struct Arguments {
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
}

/// The subcommands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Render a capture's photos as OpenEXR: photo values, 32-bit float RGB
    #[command(after_help = EXIT_CODES)]
    Render(RenderArguments),
    /// Fit a capture's free parameters to its photographs and report the result
    #[command(after_help = EXIT_CODES)]
    Fit(FitArguments),
    /// Show what the simulation of a capture gets wrong: name the cause, extend the model, measure the gain
    #[command(after_help = EXIT_CODES)]
    Diagnose(DiagnoseArguments),
    /// Render a capture at many values of its numbers, from many views, into a folder or bucket with a table
    #[command(after_help = EXIT_CODES)]
    Sweep(SweepArguments),
    /// Merge a stack of exposures into a radiance map, and learn the camera's response
    #[command(after_help = EXIT_CODES)]
    Hdr(HdrArguments),
    /// Develop a camera's RAW file to linear light: black and white level, demosaicing, colours by the file's matrices
    #[command(after_help = EXIT_CODES)]
    Develop(DevelopArguments),
    /// Find a camera's colour matrix from a photo of a chart of 24 patches
    #[command(after_help = EXIT_CODES)]
    Chart(ChartArguments),
    /// Measure a camera's read and shot noise from a burst, even fields, or one photo's flat patches
    #[command(after_help = EXIT_CODES)]
    Noise(NoiseArguments),
    /// Cut a part out of two photos before different backdrops: soft silhouette and unmixed colour
    #[command(after_help = EXIT_CODES)]
    Matte(MatteArguments),
    /// List views over a hemisphere from which to photograph a part
    #[command(after_help = EXIT_CODES)]
    Plan(PlanArguments),
    /// Blend the nearest photographed view of a part into pictures
    #[command(after_help = EXIT_CODES)]
    Composite(CompositeArguments),
    /// Validate a capture and everything that it names, and summarise it
    #[command(after_help = EXIT_CODES)]
    Check(CheckArguments),
    /// List what runs on a farm: clients, their evaluations, how far they are
    #[command(after_help = EXIT_CODES)]
    Jobs(JobsArguments),
    /// Follow what a client of a farm has under way: progress and loss, until it ends
    #[command(after_help = EXIT_CODES)]
    Attach(ClientArguments),
    /// End what a client of a farm has under way; its program stops, and keeps what it had done
    #[command(after_help = EXIT_CODES)]
    Cancel(ClientArguments),
    /// Tell from people's ratings how well they know rendered images from photographs: d', d_a, per observer and image
    #[command(after_help = EXIT_CODES)]
    Dprime(crate::commands::dprime::DprimeArguments),
    /// Serve a page on which people rate images from "definitely real" to "definitely synthetic"
    #[command(after_help = EXIT_CODES)]
    Study(crate::commands::study::StudyArguments),
    /// Make a capture of poses that COLMAP, NeRF tools or the BOP benchmark estimated
    #[command(after_help = EXIT_CODES)]
    Import(crate::commands::import::ImportArguments),
    /// Make a capture of meshes and photos, with every guess marked
    #[command(after_help = EXIT_CODES)]
    New(crate::commands::new::NewArguments),
    /// Find where a part stands: from points that were clicked in photos, and from the masks' outlines
    #[command(after_help = EXIT_CODES)]
    Align(crate::commands::align::AlignArguments),
    /// Write masks of photos: white where objects are seen, by the capture's meshes and poses
    #[command(after_help = EXIT_CODES)]
    Mask(crate::commands::mask::MaskArguments),
    /// Estimate the poses of a BOP dataset's objects in its images, with the estimator that is built in or any program
    #[command(after_help = EXIT_CODES)]
    Estimate(crate::commands::estimate::EstimateArguments),
    /// Hold estimated poses against a BOP dataset: VSD, MSSD, MSPD, ADD(-S), recalls, average precision
    #[command(after_help = EXIT_CODES)]
    Evaluate(crate::commands::evaluate::EvaluateArguments),
    /// Tell whether synthetic images predict an estimator's recall on real ones, and which effects that hangs on
    #[command(after_help = EXIT_CODES)]
    Predict(crate::commands::predict::PredictArguments),
    /// Write a capture for other programs: Mitsuba, Blender, USD, glTF, pbrt; says which numbers were kept
    #[command(after_help = EXIT_CODES)]
    Export(crate::commands::export::ExportArguments),
    /// Calibrate a camera from photos of a ChArUco board
    #[command(after_help = EXIT_CODES)]
    Calibrate(crate::commands::calibrate::CalibrateArguments),
}

/// What every command that renders accepts.
#[derive(Debug, Args)]
pub struct FarmArguments {
    /// Render threads of the embedded farm; 0 takes all cores
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub threads: usize,
    /// Coordinator of a farm, such as http://host:7300; absent, the farm is embedded in this process
    #[arg(long, value_name = "URL", env = "GONIO_FARM", conflicts_with = "threads")]
    pub farm: Option<String>,
    /// What the farm asks of those who connect.
    #[command(flatten)]
    pub access: Access,
    /// Write results and events as JSON
    #[arg(long)]
    pub json: bool,
}

/// `gonio render`.
#[derive(Debug, Args)]
pub struct RenderArguments {
    /// The capture's folder or its capture.toml; the photographs' files need not exist
    pub capture: PathBuf,
    /// Folder to write <photo name>.exr to; created if need be
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
    /// What to render.
    #[command(flatten)]
    pub options: RenderOptions,
    /// Where to render.
    #[command(flatten)]
    pub farm: FarmArguments,
}

/// What is rendered of a capture.
#[derive(Debug, Args)]
pub struct RenderOptions {
    /// Samples per pixel; even, because half of them go to each of two independent halves
    #[arg(long, value_name = "N", default_value_t = 64, value_parser = samples)]
    pub samples: u32,
    /// Seed of every random number
    #[arg(long, value_name = "S", default_value_t = 0)]
    pub seed: u64,
    /// Write <photo name>.buffers.exr too: depth, normal, object, position, half and incidence angle of the first hit
    #[arg(long)]
    pub buffers: bool,
    /// Names of the photos to render, such as 00,03; all of them where absent
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    pub photos: Vec<String>,
}

/// `gonio fit`.
#[derive(Debug, Args)]
pub struct FitArguments {
    /// The capture's folder or its capture.toml
    pub capture: PathBuf,
    /// Folder to write capture.toml, fit.json, report.html and checkpoint.json to; created if need be
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
    /// How to fit.
    #[command(flatten)]
    pub options: FitOptions,
    /// Also write residual-NAME.exr for every photo, at full size: photo minus render, in photo values
    #[arg(long)]
    pub residuals: bool,
    /// Continue from checkpoint.json in DIR, with the same capture, start, solver and seed
    #[arg(long, conflicts_with = "accuracy")]
    pub resume: bool,
    /// What to serve meanwhile.
    #[command(flatten)]
    pub watch: WatchArguments,
    /// Where to render.
    #[command(flatten)]
    pub farm: FarmArguments,
}

/// How a capture is fitted.
#[derive(Debug, Args)]
pub struct FitOptions {
    /// Optimiser: gauss-newton, nelder-mead, l-bfgs or particle-swarm
    #[arg(long, value_name = "NAME", default_value_t = SolverName::default())]
    pub solver: SolverName,
    /// Most samples per pixel of any iteration; even. The first iterations take fewer
    #[arg(long, value_name = "MAX", default_value_t = 64, value_parser = samples)]
    pub samples: u32,
    /// Pixels to compare, of all photos together: a number, or all. Drawn by what lies behind them, so that they stand for all.
    /// Absent, all of a capture of up to 524288 pixels, and 196608 of a larger one
    #[arg(long, value_name = "N|all", default_value = "", hide_default_value = true, value_parser = pixels)]
    pub pixels: Pixels,
    /// Relative standard error wanted of every freed number, such as 0.002: begins with few pixels and takes as many as that needs,
    /// unless what photos disagree about allows no better
    #[arg(long, value_name = "R", conflicts_with = "pixels", value_parser = relative)]
    pub accuracy: Option<f64>,
    /// Seed of every random number
    #[arg(long, value_name = "S", default_value_t = 0)]
    pub seed: u64,
    /// Start from another value than the capture's: a freed number, or a colour for all its channels; may be repeated
    #[arg(long, value_name = "NAME=VALUE", value_parser = assignment)]
    pub start: Vec<(String, f64)>,
    /// Names to free instead of the capture's fit.parameters, such as material.shell.roughness,material.shell.ior
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    pub free: Option<Vec<String>>,
    /// Colours among the freed that keep their ratio, instead of the capture's fit.gray
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    pub gray: Option<Vec<String>>,
    /// Most iterations; absent, as many as the solver usually needs
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    pub max_iterations: Option<u32>,
}

/// `gonio diagnose`.
#[derive(Debug, Args)]
pub struct DiagnoseArguments {
    /// The capture's folder or its capture.toml
    #[arg(required_unless_present = "evidence")]
    pub capture: Option<PathBuf>,
    /// Folder to write diagnosis.json, evidence.json, capture.toml and report.html to; created if need be
    #[arg(long, value_name = "DIR", required_unless_present = "evidence")]
    pub out: Option<PathBuf>,
    /// Decide again from an evidence.json that a diagnosis has written, without a render: prints the decision as JSON, or what
    /// it would need to know
    #[arg(long, value_name = "FILE", conflicts_with_all = ["capture", "out", "samples", "seed", "without", "watch", "farm"])]
    pub evidence: Option<PathBuf>,
    /// What to look for.
    #[command(flatten)]
    pub options: DiagnoseOptions,
    /// What to serve meanwhile.
    #[command(flatten)]
    pub watch: WatchArguments,
    /// Where to render.
    #[command(flatten)]
    pub farm: FarmArguments,
}

/// What a diagnosis looks for.
#[derive(Debug, Args)]
pub struct DiagnoseOptions {
    /// A TOML file with numbers of the policy that are to differ from the defaults, such as `accident = 0.1`
    #[arg(long, value_name = "FILE")]
    pub policy: Option<PathBuf>,
    /// Most samples per pixel of any fit's iteration; even
    #[arg(long, value_name = "MAX", default_value_t = 64, value_parser = samples)]
    pub samples: u32,
    /// Seed of every random number
    #[arg(long, value_name = "S", default_value_t = 0)]
    pub seed: u64,
    /// Smallest gain of interest, as a part of chi-square above the noise floor [default: 0.02]
    #[arg(long, value_name = "PART")]
    pub smallest_gain: Option<f64>,
    /// Smallest gain of interest where there is measured reflectance alone, as a part of the error on files left out [default: 0.1]
    #[arg(long, value_name = "PART")]
    pub smallest_file_gain: Option<f64>,
    /// Effects to leave out of the catalogue, such as defocus,bumps
    #[arg(long, value_name = "EFFECTS", value_delimiter = ',')]
    pub without: Vec<String>,
}

/// `gonio sweep`.
#[derive(Debug, Args)]
pub struct SweepArguments {
    /// The sweep's file: which capture, which numbers, which views, what to write
    #[arg(value_name = "SWEEP.toml")]
    pub sweep: PathBuf,
    /// Folder, or s3://BUCKET/PREFIX, to write frames and tables to; frames that are there already are not rendered again
    #[arg(long, value_name = "DIR|URL")]
    pub out: String,
    /// What to render.
    #[command(flatten)]
    pub options: SweepOptions,
    /// What to write besides the frames: nothing, or a dataset in the layout of the BOP benchmark (needs [[model]] and the output
    /// "rgb" in the sweep's file)
    #[arg(long, value_enum, default_value = "frames")]
    pub format: Format,
    /// Say how many frames there are, how large, and for about how long they render; write nothing
    #[arg(long)]
    pub dry_run: bool,
    /// What to serve meanwhile.
    #[command(flatten)]
    pub watch: WatchArguments,
    /// Where to render.
    #[command(flatten)]
    pub farm: FarmArguments,
}

/// What a sweep renders, and how much at a time.
#[derive(Debug, Args)]
pub struct SweepOptions {
    /// Render as if an effect that a diagnosis found were not there: its numbers at their nulls (needs --diagnosis); may be repeated.
    /// `gonio predict --contrast` then tells what the effect changes
    #[arg(long, value_name = "EFFECT", requires = "diagnosis")]
    pub without: Vec<String>,
    /// The diagnosis.json that found the effects of --without
    #[arg(long, value_name = "FILE", requires = "without")]
    pub diagnosis: Option<PathBuf>,
    /// Evaluations under way at once, for a farm of many machines twice its threads; absent, 16, or fewer of large frames
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub in_flight: Option<u16>,
}

/// What a sweep writes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum Format {
    /// Frames, tables, a contact sheet
    Frames,
    /// Besides, models, depth, masks and poses as BOP has them
    Bop,
}

/// `gonio check`.
#[derive(Debug, Args)]
pub struct CheckArguments {
    /// The capture's folder or its capture.toml
    pub capture: PathBuf,
    /// List every number's dotted name with value and bounds
    #[arg(long)]
    pub names: bool,
    /// Write the summary as one JSON object
    #[arg(long)]
    pub json: bool,
}

/// `gonio jobs`.
#[derive(Debug, Args)]
pub struct JobsArguments {
    /// Coordinator of the farm, such as http://host:7300
    #[arg(long, value_name = "URL", env = "GONIO_FARM")]
    pub farm: String,
    /// What the farm asks of those who connect.
    #[command(flatten)]
    pub access: Access,
    /// Write one JSON object
    #[arg(long)]
    pub json: bool,
}

/// `gonio attach` and `gonio cancel`.
#[derive(Debug, Args)]
pub struct ClientArguments {
    /// The client's name, as `gonio jobs` lists it
    pub client: String,
    /// Which farm.
    #[command(flatten)]
    pub farm: JobsArguments,
}

/// Reads `words` as the options of a command would be read, such as `["--samples", "16"]`, the environment included.
///
/// # Errors
/// A word that is no option of these, or a value that is out of its range, in the command line's own words.
pub fn parse<A: Args>(words: &[String]) -> Result<A, Failure> {
    // The whole text ends with hints at a usage that nobody sees here.
    let refuse = |error: &clap::Error| {
        let text = error.to_string();
        Failure::Input(text.lines().next().unwrap_or_default().trim_start_matches("error: ").to_owned())
    };
    let command = A::augment_args(clap::Command::new("gonio").no_binary_name(true));
    let matches = command.try_get_matches_from(words).map_err(|error| refuse(&error))?;
    A::from_arg_matches(&matches).map_err(|error| refuse(&error))
}

fn samples(text: &str) -> Result<u32, String> {
    let most = gonio_proto::limits::SAMPLES;
    match text.parse::<u32>() {
        Ok(n) if n >= 2 && n % 2 == 0 && n <= most => Ok(n),
        _ => Err(format!("write an even number from 2 to {most}: each of two halves takes as many")),
    }
}

fn relative(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(error) if error > 0.0 && error < 1.0 => Ok(error),
        _ => Err("write a number between 0 and 1: a standard error over the value".to_owned()),
    }
}

/// How many pixels a fit compares.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Pixels {
    /// By the size of the capture.
    AsNeeded,
    /// All of them.
    All,
    /// About so many of all photos together.
    Some(u64),
}

fn pixels(text: &str) -> Result<Pixels, String> {
    match text {
        "" => Ok(Pixels::AsNeeded),
        "all" => Ok(Pixels::All),
        number => match number.parse::<u64>() {
            Ok(n) if n >= FEWEST_PIXELS => Ok(Pixels::Some(n)),
            _ => Err(format!("write all, or a number of at least {FEWEST_PIXELS}: fewer say nothing about errors")),
        },
    }
}

/// Fewest pixels that can be asked for: some tens of each stratum of a photo.
const FEWEST_PIXELS: u64 = 1_000;

fn assignment(text: &str) -> Result<(String, f64), String> {
    let mend = "write NAME=VALUE, such as material.shell.roughness=0.4";
    let (name, value) = text.split_once('=').ok_or(mend)?;
    match value.trim().parse::<f64>() {
        Ok(value) if value.is_finite() && !name.trim().is_empty() => Ok((name.trim().to_owned(), value)),
        _ => Err(mend.to_owned()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn the_definition_is_sound() {
        Arguments::command().debug_assert();
    }

    #[test]
    fn options_alone_are_read_as_in_a_command() {
        let words = |words: &[&str]| words.iter().map(|&word| word.to_owned()).collect::<Vec<_>>();
        let fit: FitOptions = parse(&words(&["--samples", "16", "--start", "a.b=2", "--pixels", "5000"])).unwrap();
        assert_eq!((fit.samples, fit.pixels, fit.start), (16, Pixels::Some(5000), vec![("a.b".to_owned(), 2.0)]));
        let refused = |bad: &[&str]| parse::<FitOptions>(&words(bad)).unwrap_err().to_string();
        let text = refused(&["--samples", "7"]);
        assert!(text.starts_with("invalid value '7' for '--samples <MAX>': write an even number"), "{text}");
        assert!(!text.contains('\n'), "{text}");
        assert!(refused(&["--pixels", "all", "--accuracy", "0.1"]).contains("--accuracy"), "both at once");
        assert!(refused(&["--out", "x"]).contains("--out"));
    }

    #[test]
    fn halves_need_an_even_number() {
        assert_eq!(samples("64"), Ok(64));
        for bad in ["0", "1", "7", "-2", "x", "99999998"] {
            assert!(samples(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn a_start_is_a_name_and_a_finite_value() {
        assert_eq!(assignment("a.b = 0.5"), Ok(("a.b".to_owned(), 0.5)));
        for bad in ["a.b", "=1", "a=", "a=nan", "a=inf", "a=1=2"] {
            assert!(assignment(bad).is_err(), "{bad}");
        }
    }
}
