//! `gonio predict`: whether synthetic images tell how an estimator does on real ones.

mod named;
mod pictures;

use super::estimate::{Job, MethodArguments};
use crate::failure::Failure;
use crate::interrupt::Interrupt;
use crate::output::{tell, to_json, to_pretty_json};
use crate::progress::Console;
use crate::report::PredictionReport;
use clap::Args;
use gonio_pose::bop::{Dataset, Estimate, Models, ModelsFolder, Target, parse_results};
use gonio_pose::evaluate;
use gonio_pose::predict::{Options, Prediction, Series, predict};
use gonio_scene::SceneError;
use named::{Contrast, Setting};
use std::fmt::Write;
use std::path::{Path, PathBuf};

/// `gonio predict`.
#[derive(Debug, Args)]
pub struct PredictArguments {
    /// A BOP dataset of real images, or one of its splits
    #[arg(value_name = "REAL")]
    pub real: PathBuf,
    /// A BOP dataset of synthetic images of the same scenes and images, such as `gonio sweep --format bop` writes
    #[arg(value_name = "SYNTHETIC")]
    pub synthetic: PathBuf,
    /// Folder to write prediction.json, report.html and the estimates to; created if need be
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
    /// Estimates on the real images; absent, they are made, as `gonio estimate` does
    #[arg(long, value_name = "RESULTS.csv")]
    pub real_results: Option<PathBuf>,
    /// Estimates on the synthetic images; absent, they are made
    #[arg(long, value_name = "RESULTS.csv")]
    pub synthetic_results: Option<PathBuf>,
    /// Another synthetic dataset of the same images, such as one without an effect or with the first guess in place of the fit, and
    /// its estimates if they are there; may be repeated, and the set that changes the recall most comes first
    #[arg(long, value_name = "NAME=DATASET[,RESULTS.csv]")]
    pub contrast: Vec<Contrast>,
    /// Estimates by another setting of the estimator, on the real and the synthetic images; may be repeated: do both rank the
    /// settings alike?
    #[arg(long, value_name = "NAME=REAL.csv,SYNTHETIC.csv")]
    pub setting: Vec<Setting>,
    /// Difference of average recalls that does not matter
    #[arg(long, value_name = "RECALL", default_value_t = 0.05)]
    pub margin: f64,
    /// Seed of the bootstrap
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub seed: u64,
    /// How to estimate
    #[command(flatten)]
    pub method: MethodArguments,
    /// Keep the estimates of a run before in DIR
    #[arg(long)]
    pub resume: bool,
    /// Write the prediction as one JSON object
    #[arg(long)]
    pub json: bool,
}

/// A dataset with its estimates.
pub(super) struct Estimated {
    pub dataset: Dataset,
    pub models: Models,
    pub targets: Vec<Target>,
    pub estimates: Vec<Estimate>,
    pub series: Series,
}

/// Estimates where it has to, compares and writes; gives the report, too, which says which `command` made it.
///
/// # Errors
/// Datasets or estimates that are missing or bad, sets without a common image, an estimator that fails, an interruption (what was
/// estimated stays, and --resume goes on).
pub fn compare(
    arguments: &PredictArguments,
    console: Console,
    interrupt: &Interrupt,
    command: &str,
) -> Result<(Prediction, String), Failure> {
    if !(arguments.margin > 0.0 && arguments.margin < 1.0) {
        return Err(Failure::Input("--margin: write a recall between 0 and 1, such as 0.05".to_owned()));
    }
    super::evaluate::create(&arguments.out)?;
    let runner = Runner { arguments, interrupt, console: console.into() };
    let real = runner.estimated(&arguments.real, arguments.real_results.as_deref(), "real")?;
    let synthetic = runner.estimated(&arguments.synthetic, arguments.synthetic_results.as_deref(), "synthetic")?;
    let mut contrasts = Vec::new();
    for Contrast { name, dataset, results } in &arguments.contrast {
        let other = runner.estimated(dataset, results.as_deref(), &format!("contrast-{name}"))?;
        contrasts.push((name.clone(), other.series));
    }
    let mut settings = Vec::new();
    for Setting { name, real: on_real, synthetic: on_synthetic } in &arguments.setting {
        settings.push((name.clone(), runner.again(&real, on_real)?, runner.again(&synthetic, on_synthetic)?));
    }
    let options = Options { margin: arguments.margin, seed: arguments.seed, ..Options::default() };
    let prediction = predict(&real.series, &synthetic.series, &contrasts, &settings, &options).ok_or_else(|| {
        let mend = "write both with the same numbers of scenes and images: a [[view]] of kind \"bop\" keeps them";
        let path = arguments.synthetic.display().to_string();
        Failure::from(SceneError::new(path, "has no image that the real dataset has too", mend))
    })?;
    let out = |name: &str| arguments.out.join(name);
    super::prepare::write(&out("prediction.json"), (to_pretty_json(&prediction)? + "\n").as_bytes())?;
    let report = PredictionReport {
        prediction: &prediction,
        pictures: &pictures::chosen(&real, &synthetic)?,
        command,
        version: env!("CARGO_PKG_VERSION"),
    };
    let page = report.page();
    super::prepare::write(&out("report.html"), page.as_bytes())?;
    Ok((prediction, page))
}

/// Compares and tells.
///
/// # Errors
/// As [`compare`].
pub fn run(arguments: &PredictArguments) -> Result<(), Failure> {
    let interrupt = Interrupt::listen("stopping; --resume goes on")?;
    let (prediction, _) = compare(arguments, Console::new(arguments.json), &interrupt, &super::command())?;
    if arguments.json {
        tell(&to_json(&prediction)?);
    } else {
        tell(text_of(&prediction).trim_end());
        tell(&format!("wrote prediction.json, report.html and estimates to {}", arguments.out.display()));
    }
    Ok(())
}

struct Runner<'a> {
    arguments: &'a PredictArguments,
    interrupt: &'a Interrupt,
    console: std::cell::RefCell<Console>,
}

impl Runner<'_> {
    fn estimated(&self, path: &Path, results: Option<&Path>, name: &str) -> Result<Estimated, Failure> {
        let dataset = Dataset::open(path, None)?;
        let models = dataset.models(ModelsFolder::Evaluation)?;
        let targets = super::evaluate::targets(&dataset, None)?;
        let estimates = match results {
            Some(results) => parse_results(&results.display().to_string(), &super::prepare::text(results)?)?,
            None => {
                let out = self.arguments.out.join(format!("{name}.csv"));
                self.console.borrow().line(&format!("{name}: {} images", path.display()));
                let job = Job { dataset: &dataset, targets: &targets, out: &out, resume: self.arguments.resume };
                job.run(&self.arguments.method, self.interrupt, &mut self.console.borrow_mut())?.1
            }
        };
        let evaluation = evaluate::evaluate(&dataset, &models, &targets, &estimates)?;
        Ok(Estimated { series: Series::of(&evaluation), dataset, models, targets, estimates })
    }

    /// The images of `set` with other estimates, those of the file `results`.
    fn again(&self, set: &Estimated, results: &Path) -> Result<Series, Failure> {
        let estimates = parse_results(&results.display().to_string(), &super::prepare::text(results)?)?;
        let evaluation = evaluate::evaluate(&set.dataset, &set.models, &set.targets, &estimates)?;
        if evaluation.estimates_without_target > 0 {
            let (file, count) = (results.display(), evaluation.estimates_without_target);
            self.console.borrow().line(&format!("note: {file}: {count} estimates that no target asks for"));
        }
        Ok(Series::of(&evaluation))
    }
}

fn text_of(p: &Prediction) -> String {
    let mut text = String::new();
    let row = |text: &mut String, name: &str, i: &gonio_pose::predict::Interval| {
        let _ = writeln!(text, "{name:<34}{:>8.4}   [{:.4}, {:.4}]", i.value, i.low, i.high);
    };
    let _ =
        writeln!(text, "{} images in both sets; average recall of MSSD and its 95 % interval over images", p.images);
    row(&mut text, "real", &p.real);
    row(&mut text, "synthetic", &p.synthetic);
    row(&mut text, "synthetic less real, paired", &p.gap);
    let _ = writeln!(
        text,
        "the synthetic curve is {} the real one's band ({:.0} % of the thresholds in their own); {} to {}",
        if p.inside { "inside" } else { "NOT inside" },
        100.0 * p.inside_share,
        if p.equivalent { "equivalent" } else { "not shown equivalent" },
        p.margin,
    );
    if let Some(spearman) = p.agreement.spearman {
        let _ = writeln!(text, "rank correlation of the images' errors {spearman:.3}");
    }
    for contrast in &p.contrasts {
        row(&mut text, &format!("{} less synthetic", contrast.name), &contrast.change);
        row(&mut text, &format!("{} less real", contrast.name), &contrast.gap);
    }
    if let Some(tau) = p.settings.as_ref().and_then(|settings| settings.kendall) {
        let _ = writeln!(text, "rank agreement over settings (Kendall's tau-b) {tau:.3}");
    }
    text
}
