//! Structure that is left in the residuals: how much of their variance each covariate predicts in pixels that it was not
//! estimated from.

use crate::evidence::gather::covariates::{COVARIATES, Pixel, pixels};
use crate::evidence::gather::measured;
use crate::evidence::gather::model::Model;
use crate::evidence::gather::noise::Differences;
use crate::evidence::{ChannelNoise, Structure};
use crate::overlay::Overlay;
use crate::workshop::{Observer, Workshop, evaluate, tell};
use crate::{DiagnoseError, DiagnoseEvent, Options};
use gonio_scene::capture::Target;
use gonio_scene::reflectance::{Directions, Pair};
use gonio_scene::{EvaluationRequest, Film, Output, Photograph, Stream};

/// Bins of equal count per covariate, at most.
const BINS: usize = 24;
/// Fewest pixels of a bin in each half.
const FEWEST: usize = 24;
/// Residuals beyond so many standard deviations count as that far: caustics' fireflies. Where no photo is, and the stated
/// noise says little of what is left, beyond so many of their own.
const CUT: f64 = 5.0;
/// A photo seen for the report: its film, its photograph, what its pixels hit first.
#[derive(Debug, Clone)]
pub struct Seen {
    /// The photo's film.
    pub film: Film,
    /// Its comparison.
    pub statistics: gonio_scene::PhotoStatistics,
    /// What was measured.
    pub photograph: Photograph,
    /// The directions of the samples, where it is measured reflectance.
    pub pairs: Vec<Pair>,
}

/// The fitted photos beside their renders.
#[derive(Debug, Clone)]
pub struct Look {
    /// What each covariate explains, strongest first.
    pub structures: Vec<Structure>,
    /// What was seen.
    pub seen: Vec<Seen>,
    /// Mean square of the residuals in standard deviations of the sensor, each cut as for the structure: what fireflies
    /// cannot raise, but the render's noise does.
    pub cut_chi_square: f64,
    /// Red, green and blue noise of the photographs; none where too few pixels count.
    pub noise: Option<[ChannelNoise; 3]>,
}

/// Renders the fitted photos at a model and says what is left.
///
/// # Errors
/// A photograph that cannot be read, a farm that fails, a cancellation.
pub fn structure(
    model: &Model,
    options: &Options,
    workshop: &dyn Workshop,
    observer: &mut Observer<'_>,
) -> Result<Look, DiagnoseError> {
    tell(observer, &DiagnoseEvent::Stage { text: "looking at what is left".to_owned() })?;
    let capture = &model.capture;
    let mut farm = workshop.open(capture, &model.files)?;
    let photos: Vec<usize> = (0..capture.targets().count()).collect();
    let request = EvaluationRequest {
        photos: photos.clone(),
        samples: options.samples,
        seed: Stream::Fit.seed(options.seed.wrapping_add(3)),
        output: Output::StatisticsAndFilms,
        ..EvaluationRequest::default()
    };
    let films = evaluate(farm.as_mut(), &request, observer)?;
    // A second render, of other random numbers, tells the render's noise from the photographs'.
    let other = EvaluationRequest {
        seed: Stream::Fit.seed(options.seed.wrapping_add(4)),
        ..EvaluationRequest { output: Output::StatisticsAndFilms, ..request.clone() }
    };
    let others = evaluate(farm.as_mut(), &other, observer)?;
    let mut differences = Differences::default();
    let hits = evaluate(farm.as_mut(), &EvaluationRequest { output: Output::FirstHit, ..request }, observer)?;
    let files = Overlay { files: workshop.files(), added: &model.files };
    let mut seen = Vec::new();
    let mut all: Vec<Pixel> = Vec::new();
    let pairs = films.films.into_iter().zip(&others.films);
    for (((film, other), hit), statistics) in pairs.zip(&hits.films).zip(films.photos) {
        let Some(target) = capture.target(film.photo) else { continue };
        let photograph = Photograph::of(capture, target, &files)?;
        let mut pairs = Vec::new();
        match target {
            Target::Photo(_) => {
                all.extend(pixels(capture, &film, hit, &photograph));
                differences.add(capture, [&film, other], &photograph);
            }
            Target::Reflectance(file) => {
                pairs = Directions::read(&files, &file.file)?.pairs;
                all.extend(measured::pixels(capture, &film, &pairs, &photograph));
            }
        }
        seen.push(Seen { film, statistics, photograph, pairs });
    }
    let cut = CUT * if measured::alone(capture) { mean_square(&all, f64::INFINITY).sqrt().max(1.0) } else { 1.0 };
    let explained = |(i, name): (usize, &&str)| explained(&all, i, name, cut);
    let mut found: Vec<Structure> = COVARIATES.iter().enumerate().map(explained).collect();
    found.sort_by(|a, b| b.strength.total_cmp(&a.strength));
    Ok(Look { structures: found, seen, cut_chi_square: mean_square(&all, cut), noise: differences.noise() })
}

/// Mean squared residual, each residual cut at `cut`.
fn mean_square(pixels: &[Pixel], cut: f64) -> f64 {
    let squares: f64 = pixels.iter().flat_map(|p| p.residual).map(|r| r.clamp(-cut, cut).powi(2)).sum();
    squares / (3.0 * pixels.len() as f64).max(1.0)
}

/// How much of the residuals' variance the means over a covariate's bins, taken in one half of the image blocks, predict in
/// the other half.
fn explained(pixels: &[Pixel], covariate: usize, name: &str, cut: f64) -> Structure {
    let mut values: Vec<f64> = pixels.iter().map(|p| p.covariates[covariate]).filter(|v| v.is_finite()).collect();
    values.sort_by(f64::total_cmp);
    // Few samples, as of measured reflectance, fill fewer bins.
    let bins = BINS.min(values.len() / (3 * FEWEST)).max(1);
    let mut edges: Vec<f64> = (1..bins).filter_map(|i| values.get(i * values.len() / bins).copied()).collect();
    edges.dedup();
    let bin = |p: &Pixel| {
        let v = p.covariates[covariate];
        v.is_finite().then(|| edges.partition_point(|e| *e <= v))
    };
    // Per bin and half: pixels, sum, sum of squares of the residual, sum of the covariate; per channel.
    let mut sums = vec![[[[0.0_f64; 3]; 3]; 2]; edges.len() + 1];
    for pixel in pixels {
        let Some(b) = bin(pixel) else { continue };
        for (residual, cell) in pixel.residual.iter().zip(&mut sums[b][usize::from(pixel.odd)]) {
            let z = residual.clamp(-cut, cut);
            cell[0] += 1.0;
            cell[1] += z;
            cell[2] += z * z;
        }
    }
    let (mut gain, mut total) = (0.0, 0.0);
    for cell in &sums {
        for half in 0..2 {
            for (this, other) in cell[half].iter().zip(&cell[1 - half]) {
                let ([n, sum, squares], [other, other_sum, _]) = (*this, *other);
                total += squares;
                if other as usize >= FEWEST {
                    let mean = other_sum / other;
                    gain += 2.0 * mean * sum - n * mean * mean;
                }
            }
        }
    }
    let mut middles = vec![[0.0; 2]; sums.len()];
    for pixel in pixels {
        if let Some(b) = bin(pixel) {
            middles[b][0] += 1.0;
            middles[b][1] += pixel.covariates[covariate];
        }
    }
    let curve = sums
        .iter()
        .zip(&middles)
        .filter(|(_, m)| m[0] > 0.0)
        .map(|(cell, m)| {
            let add = |k: usize| cell.iter().flatten().map(|c| c[k]).sum::<f64>();
            let (n, sum, squares) = (add(0).max(1.0), add(1), add(2));
            let mean = sum / n;
            // The three channels of a pixel share the render's noise: a third as many independent ones.
            [m[1] / m[0], mean, (3.0 * (squares / n - mean * mean).max(0.0) / n).sqrt()]
        })
        .collect();
    Structure { covariate: name.to_owned(), strength: if total > 0.0 { gain / total } else { 0.0 }, curve }
}
