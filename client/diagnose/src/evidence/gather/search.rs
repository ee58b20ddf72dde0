//! The place of something that a gradient cannot find, because the image of an edge far from its place has no slope
//! towards it.

use crate::effects::Variant;
use crate::evidence::gather::quadratic::Quadratic;
use crate::evidence::gather::reduced::reduced;
use crate::overlay::AddedFile;
use crate::workshop::{Observer, Workshop, evaluate, tell};
use crate::{DiagnoseError, DiagnoseEvent};
use gonio_fit::{Evaluate, Space};
use gonio_scene::capture::Range;
use gonio_scene::parameter::{Parameter, Term};
use gonio_scene::{Capture, EvaluationRequest, Output, Stream};
use nalgebra::DVector;
use std::collections::BTreeMap;
use std::ops::RangeInclusive;

/// Samples per pixel of an evaluation.
const SAMPLES: u32 = 16;
/// The same of its finite differences. With 4, the products of the two halves were so noisy that the moves led nowhere.
const DIFFERENCES: u32 = 16;
/// Rows or columns, about, of the coarser photos that are searched; the finer have twice as many.
const COARSE: u32 = 30;
/// Halvings of the first step that the coarser photos are searched with.
const COARSE_HALVINGS: RangeInclusive<u32> = 0..=4;
/// The same of the finer.
const FINE_HALVINGS: RangeInclusive<u32> = 3..=6;
/// Moves with one step, at most.
const MOVES: u32 = 30;
/// Steps that one move may go.
const REACH: f64 = 2.0;
/// Dampings of a move that are tried, as parts of the curvature (Marquardt 1963): from Gauss-Newton's own to a short one along
/// the slope.
const DAMPINGS: [f64; 4] = [0.0, 0.1, 1.0, 10.0];
/// A move that gains less deviance per observation leads nowhere, ...
const LEAST: f64 = 1e-4;
/// ... nor does one that gains less than this part of what there was to begin with: the render's noise at 16 samples is about that.
const WORTHWHILE: f64 = 5e-4;

/// What a search is to do.
#[derive(Debug, Clone, Copy)]
pub struct Aim {
    /// The first step is the variant's over 2^`round`.
    pub round: u32,
    /// Seed of the renders.
    pub seed: u64,
}

/// Moves the searched numbers to where the deviance, with the candidate's own colours fitted along inside their bounds, is
/// least, in reduced photos: a pixel wide as an edge is far sees it, and costs less. Damped Gauss-Newton (Levenberg 1944,
/// Marquardt 1963) moves all at once, with differences over a step that begins as wide as the place is uncertain and is
/// halved: what lies between two edges a step apart is slope to it. Until that leads anywhere, a pattern search (Hooke and
/// Jeeves 1961) tries the neighbours; later it would lead to nearer minima that Gauss-Newton does not leave again. What else
/// the model has stays where it is: a lamp that no wall has yet hidden would be dimmed without end to make up for one that
/// stands in the way. Chi-square alone would favour places that make the render noisy.
///
/// # Errors
/// A patch that the format refuses, an evaluation that fails, a cancellation.
pub fn search(
    capture: &mut Capture,
    variant: &Variant,
    aim: Aim,
    files: &[AddedFile],
    workshop: &dyn Workshop,
    observer: &mut Observer<'_>,
) -> Result<(), DiagnoseError> {
    let sides = capture.photos.iter().map(|p| capture.camera_of(p)).map(|c| c.width.min(c.height));
    let smallest = sides.min().unwrap_or(COARSE);
    for (rows, halvings) in [(COARSE, COARSE_HALVINGS), (2 * COARSE, FINE_HALVINGS)] {
        let (mut small, files) = reduced(capture, files, (smallest / rows).max(1), workshop.files())?;
        // Far from its place, what the sensor's noise weighs most is dark, and says little of where something stands: all pixels count alike.
        (small.sensor.read_noise, small.sensor.shot_noise) = (small.sensor.variance(1.0).sqrt(), 0.0);
        let mut farm = workshop.open(&small, &files)?;
        let mut search = Search::new(&small, variant, aim, farm.as_mut())?;
        search.lost = rows == COARSE;
        let mut best = search.look(search.start(), None, observer)?;
        search.worthwhile = (WORTHWHILE * best.deviance).max(LEAST);
        for halving in halvings.filter(|h| *h >= aim.round) {
            let text = format!("searching its place in steps of 1/{}, deviance {:.3}", 1_u32 << halving, best.deviance);
            tell(observer, &DiagnoseEvent::Stage { text })?;
            best = search.with_step(best, 0.5_f64.powi(halving as i32), observer)?;
        }
        best.place.extend(best.colours);
        capture.set_numbers(&best.place)?;
    }
    Ok(())
}

/// A place that was looked at.
struct Look {
    /// The searched numbers.
    place: Vec<(String, f64)>,
    /// Chi-square plus the logarithms of the variances, per observation, with the colours fitted.
    deviance: f64,
    /// What the candidate's colours are there.
    colours: Vec<(String, f64)>,
    /// Per damping, how many first steps each move should go by the differences that were asked for; none where none were.
    moves: Vec<Vec<f64>>,
}

struct Search<'a> {
    farm: &'a mut dyn Evaluate,
    /// The candidate's colours.
    colours: Vec<Parameter>,
    /// The searched numbers, with their bounds.
    known: BTreeMap<String, (f64, Range)>,
    /// First steps.
    moves: &'a [Vec<(String, f64)>],
    photos: Vec<usize>,
    aim: Aim,
    /// Whether neighbours are tried where nothing leads on: until Gauss-Newton does.
    lost: bool,
    /// A move that gains less deviance per observation leads nowhere.
    worthwhile: f64,
}

impl<'a> Search<'a> {
    fn new(
        capture: &Capture,
        variant: &'a Variant,
        aim: Aim,
        farm: &'a mut dyn Evaluate,
    ) -> Result<Self, DiagnoseError> {
        let searched = variant.searched();
        let space = Space::new(capture, &[])?;
        let colours = space
            .columns(space.start())
            .into_iter()
            .filter(|c| {
                !searched.contains(c.name.as_str()) && variant.free.iter().any(|f| c.name.starts_with(f.as_str()))
            })
            .filter(|c| c.name.starts_with("material.") || c.name.starts_with("light."))
            .collect();
        let mut known = capture.numbers();
        known.retain(|name, _| searched.contains(name.as_str()));
        let photos = (0..capture.targets().count()).collect();
        Ok(Self { farm, colours, known, moves: &variant.search, photos, aim, lost: false, worthwhile: LEAST })
    }

    fn start(&self) -> Vec<(String, f64)> {
        self.known.iter().map(|(name, (value, _))| (name.clone(), *value)).collect()
    }

    /// `place` moved by so many first steps of each move, inside the bounds.
    fn moved(&self, place: &[(String, f64)], by: &[f64]) -> Vec<(String, f64)> {
        let each = place.iter().map(|(name, value)| {
            let steps = self.moves.iter().zip(by).flat_map(|(m, by)| m.iter().map(move |(n, step)| (n, step * by)));
            let value = value + steps.filter(|(n, _)| *n == name).map(|(_, step)| step).sum::<f64>();
            let (low, high) = self.known.get(name).map_or((value, value), |(_, range)| (range.min, range.max));
            (name.clone(), value.clamp(low, high))
        });
        each.collect()
    }

    /// The columns of the moves at a place, with differences over `scale` of their first steps.
    fn columns(&self, place: &[(String, f64)], scale: f64) -> Vec<Parameter> {
        let column = |step: &Vec<(String, f64)>| {
            let (name, first) = step.first()?;
            let (_, range) = self.known.get(name)?;
            Some(Parameter {
                name: name.clone(),
                value: place.iter().find(|(n, _)| n == name)?.1,
                range: *range,
                terms: step.iter().map(|(n, by)| Term { number: n.clone(), ratio: by / first }).collect(),
                step: Some(scale * first.abs()),
                channel: None,
            })
        };
        self.moves.iter().filter_map(column).collect()
    }

    /// Looks at a place, with differences over this part of the first steps where given.
    fn look(
        &mut self,
        place: Vec<(String, f64)>,
        scale: Option<f64>,
        observer: &mut Observer<'_>,
    ) -> Result<Look, DiagnoseError> {
        let n = self.colours.len();
        let mut columns = self.colours.clone();
        columns.extend(scale.map(|scale| self.columns(&place, scale)).unwrap_or_default());
        let colours = self.colours.iter().flat_map(|c| c.numbers(c.value).collect::<Vec<_>>());
        let request = EvaluationRequest {
            numbers: place.iter().cloned().chain(colours).collect(),
            columns: columns.clone(),
            photos: self.photos.clone(),
            samples: SAMPLES,
            difference_samples: DIFFERENCES,
            forward_samples: 0,
            seed: Stream::Fit.seed(self.aim.seed),
            output: Output::Statistics,
        };
        let found = evaluate(self.farm, &request, observer)?;
        let all: Vec<(usize, f64)> = (0..columns.len()).map(|i| (i, 1.0)).collect();
        let each: Vec<Quadratic> = found.photos.iter().map(|p| Quadratic::new(p, &all)).collect();
        let observations = found.photos.iter().map(|p| p.observations).sum::<u64>().max(1) as f64;
        let mut look = Look {
            place,
            deviance: found.photos.iter().map(gonio_scene::PhotoStatistics::loss).sum::<f64>() / observations,
            colours: Vec::new(),
            moves: Vec::new(),
        };
        if let Some(q) = Quadratic::sum(&each) {
            let inside = |(c, x): (&Parameter, &f64)| x.clamp(c.range.min - c.value, c.range.max - c.value);
            let head = q.select(&(0..n).collect::<Vec<_>>());
            let step = DVector::from_iterator(n, columns.iter().zip(head.solve().iter()).map(inside));
            look.deviance += head.change(&step) / observations;
            look.colours =
                columns.iter().zip(&step).flat_map(|(c, x)| c.numbers(c.value + x).collect::<Vec<_>>()).collect();
            let firsts: Vec<f64> = self.moves.iter().filter_map(|m| m.first()).map(|(_, first)| *first).collect();
            let damped = |damping: f64| {
                let mut q = q.clone();
                (n..columns.len()).for_each(|i| q.matrix[(i, i)] *= 1.0 + damping);
                q.solve().iter().skip(n).zip(&firsts).map(|(x, first)| x / first).collect()
            };
            look.moves = scale.iter().flat_map(|_| DAMPINGS).map(damped).collect();
        }
        Ok(look)
    }

    /// Moves with one step until that leads nowhere.
    fn with_step(&mut self, mut best: Look, scale: f64, observer: &mut Observer<'_>) -> Result<Look, DiagnoseError> {
        for _ in 0..MOVES {
            self.carry(&best);
            best = self.look(best.place, Some(scale), observer)?;
            let mut next = self.newton(&best, scale, observer)?;
            self.lost &= next.is_none();
            if self.lost {
                next = self.neighbour(&best, scale, observer)?;
            }
            match next {
                Some(there) => best = there,
                None => break,
            }
        }
        Ok(best)
    }

    /// Looks from here on begin with the colours that a place was found to have: a quadratic about others may promise what they
    /// do not keep.
    fn carry(&mut self, look: &Look) {
        for colour in &mut self.colours {
            let Some(term) = colour.terms.first() else { continue };
            if let Some((_, value)) = look.colours.iter().find(|(name, _)| *name == term.number) {
                colour.value = value / term.ratio;
            }
        }
    }

    /// Where Gauss-Newton leads from a place, or a more damped move; nowhere where none of these is worth while.
    fn newton(&mut self, from: &Look, scale: f64, observer: &mut Observer<'_>) -> Result<Option<Look>, DiagnoseError> {
        for moves in &from.moves {
            // One factor for all: the direction is what the quadratic knows best.
            let longest = moves.iter().fold(0.0_f64, |m, x| m.max(x.abs())).max(f64::MIN_POSITIVE);
            let by: Vec<f64> = moves.iter().map(|x| x * (REACH * scale / longest).min(1.0)).collect();
            let there = self.look(self.moved(&from.place, &by), None, observer)?;
            if from.deviance - there.deviance > self.worthwhile {
                return Ok(Some(there));
            }
        }
        Ok(None)
    }

    /// The best neighbour that is worth while: the first that is better leads astray where many are.
    fn neighbour(
        &mut self,
        from: &Look,
        scale: f64,
        observer: &mut Observer<'_>,
    ) -> Result<Option<Look>, DiagnoseError> {
        let mut best: Option<Look> = None;
        for i in 0..self.moves.len() {
            for by in [scale, -scale] {
                let mut moves = vec![0.0; self.moves.len()];
                moves[i] = by;
                let there = self.look(self.moved(&from.place, &moves), None, observer)?;
                if there.deviance < best.as_ref().map_or(from.deviance - self.worthwhile, |b| b.deviance) {
                    best = Some(there);
                }
            }
        }
        Ok(best)
    }
}
