//! `gonio evaluate`: how well a list of estimated poses does on a BOP dataset.

use crate::failure::Failure;
use crate::output::{tell, tell_error, to_json, to_pretty_json};
use clap::Args;
use gonio_pose::bop::{Dataset, Estimate, Models, ModelsFolder, Target, parse_results, parse_targets};
use gonio_pose::evaluate::{self, Evaluation, Scores};
use gonio_scene::files::{DirectoryFiles, Files};
use gonio_scene::image::write_png8;
use gonio_scene::{Result as SceneResult, SceneError};
use std::collections::BTreeSet;
use std::fmt::Write;
use std::path::{Path, PathBuf};

/// `gonio evaluate`.
#[derive(Debug, Args)]
pub struct EvaluateArguments {
    /// A BOP dataset's folder, or a split inside of it
    #[arg(value_name = "DATASET")]
    pub dataset: PathBuf,
    /// Estimates: scene_id,im_id,obj_id,score,R,t,time
    #[arg(value_name = "RESULTS.csv")]
    pub results: PathBuf,
    /// Which split, where the dataset has several; absent, test
    #[arg(long, value_name = "NAME")]
    pub split: Option<String>,
    /// Targets of BOP19 (recalls) or BOP24 (average precision); absent, the dataset's test_targets_bop19.json, or all objects that
    /// are visible by a tenth
    #[arg(long, value_name = "TARGETS.json")]
    pub targets: Option<PathBuf>,
    /// Folder to write scores.json, errors.csv, images.csv, recalls.csv and recalls.svg to; created if need be
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Draw true (green) and estimated (magenta) outlines over every target's image, to DIR/overlay
    #[arg(long, requires = "out")]
    pub overlay: bool,
    /// Write the scores as one JSON object
    #[arg(long)]
    pub json: bool,
}

/// Reads, evaluates, and writes where the arguments name a folder.
///
/// # Errors
/// A dataset, targets or estimates that are missing or bad; a folder that cannot be written to.
pub fn evaluate(arguments: &EvaluateArguments) -> Result<Evaluation, Failure> {
    let dataset = Dataset::open(&arguments.dataset, arguments.split.as_deref())?;
    let models = dataset.models(ModelsFolder::Evaluation)?;
    let targets = targets(&dataset, arguments.targets.as_deref())?;
    let name = arguments.results.display().to_string();
    let text = super::prepare::text(&arguments.results)?;
    let estimates = parse_results(&name, &text)?;
    let evaluation = evaluate::evaluate(&dataset, &models, &targets, &estimates)?;
    if !estimates.is_empty() && evaluation.estimates_without_target == estimates.len() {
        let problem = format!("has {} estimates, and no target of the dataset asks for any of them", estimates.len());
        let mend = "name the estimates of this dataset and split: scene_id, im_id and obj_id must be its own";
        return Err(SceneError::new(name, problem, mend).into());
    }
    if let Some(folder) = &arguments.out {
        write_all(folder, &evaluation)?;
        if arguments.overlay {
            draw(&folder.join("overlay"), &dataset, &models, &targets, &estimates)?;
        }
    }
    Ok(evaluation)
}

/// Evaluates and tells.
///
/// # Errors
/// As [`evaluate()`].
pub fn run(arguments: &EvaluateArguments) -> Result<(), Failure> {
    let evaluation = evaluate(arguments)?;
    if arguments.json {
        tell(&to_json(&evaluation)?);
    } else {
        evaluation.notes.iter().for_each(|note| tell_error(&format!("note: {note}")));
        tell(text_of(&evaluation).trim_end());
    }
    Ok(())
}

fn read(path: &Path) -> SceneResult<std::sync::Arc<[u8]>> {
    DirectoryFiles::new("").read(&path.display().to_string())
}

/// The targets that a command names, or those of the dataset.
pub(super) fn targets(dataset: &Dataset, path: Option<&Path>) -> Result<Vec<Target>, Failure> {
    let beside = dataset.root.join("test_targets_bop19.json");
    match path {
        Some(path) => Ok(parse_targets(&path.display().to_string(), &read(path)?)?),
        None if dataset.split == "test" && beside.is_file() => {
            Ok(parse_targets(&beside.display().to_string(), &read(&beside)?)?)
        }
        None => {
            let all = evaluate::default_targets(dataset);
            if all.is_empty() {
                let problem = "states no pose of a visible object";
                let mend = "use a split whose poses are public (scene_gt.json)";
                return Err(SceneError::new(dataset.root.display().to_string(), problem, mend).into());
            }
            Ok(all)
        }
    }
}

fn write_all(folder: &Path, evaluation: &Evaluation) -> Result<(), Failure> {
    create(folder)?;
    let mut files = vec![
        ("scores.json", to_pretty_json(evaluation)? + "\n"),
        ("errors.csv", evaluate::errors_table(evaluation)),
        ("images.csv", evaluate::images_table(evaluation)),
    ];
    if let Some(svg) = evaluate::plot(evaluation) {
        files.extend([("recalls.csv", evaluate::recalls_table(evaluation)), ("recalls.svg", svg)]);
    }
    for (name, text) in files {
        super::prepare::write(&folder.join(name), text.as_bytes())?;
    }
    Ok(())
}

/// Makes the folder of --out where it is missing.
pub(super) fn create(folder: &Path) -> Result<(), Failure> {
    std::fs::create_dir_all(folder).map_err(|error| {
        let problem = format!("cannot be created: {error}");
        SceneError::new(folder.display().to_string(), problem, "name a folder that can be written to by --out").into()
    })
}

fn draw(
    folder: &Path,
    dataset: &Dataset,
    models: &Models,
    targets: &[Target],
    estimates: &[Estimate],
) -> Result<(), Failure> {
    create(folder)?;
    let images: BTreeSet<(u32, u32)> = targets.iter().map(|target| (target.scene, target.image)).collect();
    for (scene, image) in images {
        let (width, height, pixels) = outlined(dataset, models, estimates, (scene, image))?;
        let path = folder.join(format!("{scene:06}-{image:06}.png"));
        write_png8(&path, width, height, &pixels)?;
    }
    Ok(())
}

/// Width, height and pixels of an image with the outlines of its true and its estimated poses.
pub(super) fn outlined(
    dataset: &Dataset,
    models: &Models,
    estimates: &[Estimate],
    (scene, image): (u32, u32),
) -> Result<(u32, u32, Vec<[u8; 3]>), Failure> {
    let colours = dataset.colour(scene, image)?;
    let posed = |object: u32, pose| models.get(&object).map(|model| (model, pose));
    let here = estimates.iter().filter(|e| (e.scene, e.image) == (scene, image));
    let found: Vec<_> = here.filter_map(|e| posed(e.object, e.pose)).collect();
    let pixels = dataset.frame(scene, image).map(|frame| {
        let truths: Vec<_> = frame.truths.iter().filter_map(|truth| posed(truth.object, truth.pose)).collect();
        evaluate::overlay(&colours, &frame.camera, &truths, &found)
    });
    Ok((colours.width, colours.height, pixels.unwrap_or_default()))
}

fn text_of(evaluation: &Evaluation) -> String {
    let mut text = String::new();
    if let Some(detection) = &evaluation.detection {
        let (ap, mssd, mspd) = (detection.average_precision, detection.mssd, detection.mspd);
        let _ = writeln!(text, "average precision {ap:.4}   MSSD {mssd:.4}   MSPD {mspd:.4}");
        for (object, [mssd, mspd]) in &detection.objects {
            let _ = writeln!(text, "object {object:<4} MSSD {mssd:.4}   MSPD {mspd:.4}");
        }
    }
    if let Some(scores) = &evaluation.scores {
        let head = ["object", "targets", "AR", "VSD", "MSSD", "MSPD", "ADD(-S) 0.1d", "proj 5px", "5deg 5cm"];
        let _ = writeln!(
            text,
            "{:<8}{:>8}{:>8}{:>8}{:>8}{:>8}{:>14}{:>10}{:>10}",
            head[0], head[1], head[2], head[3], head[4], head[5], head[6], head[7], head[8]
        );
        row(&mut text, "all", scores);
        evaluation.objects.iter().for_each(|(object, scores)| row(&mut text, &object.to_string(), scores));
    }
    if let Some(seconds) = evaluation.seconds_per_image {
        let _ = writeln!(text, "{seconds:.3} s per image");
    }
    if evaluation.estimates_without_target > 0 {
        let _ = writeln!(text, "{} estimates that no target asks for", evaluation.estimates_without_target);
    }
    text
}

fn row(text: &mut String, name: &str, s: &Scores) {
    let maybe = |value: Option<f64>| value.map_or("-".to_owned(), |value| format!("{value:.4}"));
    let _ = writeln!(
        text,
        "{name:<8}{:>8}{:>8}{:>8}{:8.4}{:8.4}{:14.4}{:10.4}{:10.4}",
        s.targets,
        maybe(s.average_recall),
        maybe(s.vsd),
        s.mssd,
        s.mspd,
        s.add_or_add_s,
        s.projection,
        s.degrees_5_cm_5
    );
}
