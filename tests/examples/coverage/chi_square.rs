//! The stated error of reduced chi-square against its scatter between seeds.

use crate::WITHIN;
use gonio::farm::Farm;
use gonio_fit::{Evaluate, Normal};
use gonio_scene::files::DirectoryFiles;
use gonio_scene::{Capture, EvaluationRequest, Output, Stream};
use std::ops::ControlFlow;
use std::path::Path;

const SAMPLES: [u32; 3] = [4, 16, 64];

/// Prints, for each capture and number of samples: mean, scatter, stated error, how much the 64-sample mean differs, and coverage.
pub fn run(captures: &[String], seeds: u64) {
    let farm = Farm::embedded(0).unwrap();
    println!(
        "capture, samples: chi-square, scatter between seeds, stated error (root mean square), intervals that hold"
    );
    for folder in captures {
        let files = DirectoryFiles::new(Path::new(folder));
        let capture = Capture::read(&files).unwrap();
        let mut open = farm.open(&files).unwrap();
        let photos: Vec<usize> = (0..capture.photos.len()).collect();
        let mut at = |samples, seed| {
            let request = EvaluationRequest {
                photos: photos.clone(),
                samples,
                seed: Stream::Fit.seed(seed),
                output: Output::Statistics,
                ..EvaluationRequest::default()
            };
            let found = open.evaluate(&request, &mut |_| ControlFlow::Continue(())).unwrap().photos;
            let total = Normal::new(&found, &[]).total;
            (total.reduced_chi_square(), total.chi_square_error())
        };
        let all = SAMPLES.map(|samples| (0..seeds).map(|seed| at(samples, seed)).collect::<Vec<_>>());
        let mean = |of: &[(f64, f64)]| of.iter().map(|x| x.0).sum::<f64>() / of.len() as f64;
        // The mean of all seeds by the most samples: its own error is a fourteenth of one of them with 200 seeds.
        let truth = mean(&all[SAMPLES.len() - 1]);
        for (samples, of) in SAMPLES.iter().zip(&all) {
            let n = of.len() as f64;
            let scatter = (of.iter().map(|x| (x.0 - mean(of)).powi(2)).sum::<f64>() / (n - 1.0)).sqrt();
            let stated = (of.iter().map(|x| x.1 * x.1).sum::<f64>() / n).sqrt();
            let held = of.iter().filter(|x| (x.0 - truth).abs() < WITHIN * x.1).count() as f64 / n;
            println!(
                "{}, {samples}: {:.4} (64: {truth:.4}), {scatter:.4}, {stated:.4}, {:.1} %",
                capture.name,
                mean(of),
                100.0 * held
            );
        }
    }
}
