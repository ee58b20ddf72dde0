//! What the solvers minimise: the loss of the fitted photos ([`gonio_scene::statistics`]), as a function of the coordinates.
//!
//! Its weights are fixed by the photos and the render's noise adds nothing to it in expectation, so it is comparable between
//! parameters and between sample counts.

use crate::checkpoint::{Entry, Journal};
use crate::event::Iteration;
use crate::uncertainty::Uncertainty;
use crate::{Evaluate, EvaluateError, FitError, FitEvent, Normal, Options, Space};
use argmin::core::{CostFunction, Error, Gradient};
use gonio_scene::capture::Target;
use gonio_scene::{Capture, EvaluationRequest, Output, PhotoStatistics, Stream};
use std::cell::{Cell, RefCell};
use std::ops::ControlFlow;

/// Sees a fit's events; breaks to cancel it.
pub type Observer<'a> = dyn FnMut(&FitEvent) -> ControlFlow<()> + 'a;

/// The fit is over before its end; [`Objective::reason`] says why.
#[derive(Debug, Clone, Copy, thiserror::Error)]
#[error("the fit was stopped")]
pub(crate) struct Stopped;

/// The loss over one capture's fitted photos, with the memory of all that was evaluated.
pub(crate) struct Objective<'a> {
    pub space: &'a Space,
    capture: &'a Capture,
    photos: Vec<usize>,
    seed: u64,
    /// Most samples per pixel of finite differences.
    difference_samples: u32,
    /// Most samples per pixel of derivatives that are carried along the paths; 0: all.
    forward_samples: u32,
    /// Samples per pixel of [`CostFunction::cost`] and [`Gradient::gradient`].
    samples: Cell<u32>,
    /// Coordinate per unit of a solver's parameter, so that solvers without a metric of their own see a round bowl.
    metric: RefCell<Vec<f64>>,
    inner: RefCell<Inner<'a>>,
}

struct Inner<'a> {
    evaluate: &'a mut dyn Evaluate,
    observer: &'a mut Observer<'a>,
    journal: Journal,
    iterations: Vec<Iteration>,
    /// Where the fit stands: coordinates and samples.
    position: Option<(Vec<f64>, u32)>,
    reason: Option<FitError>,
}

impl<'a> Objective<'a> {
    pub fn new(
        capture: &'a Capture,
        space: &'a Space,
        photos: Vec<usize>,
        options: &Options,
        journal: Journal,
        evaluate: &'a mut dyn Evaluate,
        observer: &'a mut Observer<'a>,
    ) -> Self {
        let inner = Inner { evaluate, observer, journal, iterations: Vec::new(), position: None, reason: None };
        let metric = RefCell::new(vec![1.0; space.len()]);
        Self {
            space,
            capture,
            photos,
            seed: Stream::Fit.seed(options.seed),
            difference_samples: options.difference_samples,
            forward_samples: options.forward_samples,
            samples: Cell::new(2),
            metric,
            inner: RefCell::new(inner),
        }
    }

    /// Sets what the next solver sees: samples per pixel and coordinates per unit of its parameters.
    pub fn set_stage(&self, samples: u32, metric: Vec<f64>) {
        self.samples.set(samples);
        *self.metric.borrow_mut() = metric;
    }

    /// Coordinates of a solver's parameters.
    pub fn coordinates(&self, parameters: &[f64]) -> Vec<f64> {
        parameters.iter().zip(self.metric.borrow().iter()).map(|(p, m)| p * m).collect()
    }

    /// A solver's parameters at coordinates.
    pub fn parameters(&self, u: &[f64]) -> Vec<f64> {
        u.iter().zip(self.metric.borrow().iter()).map(|(u, m)| u / m).collect()
    }

    /// Statistics of the fitted photos at coordinates `u`.
    pub fn statistics(&self, u: &[f64], samples: u32, columns: bool) -> Result<Vec<PhotoStatistics>, Stopped> {
        let mut inner = self.inner.borrow_mut();
        if inner.reason.is_some() {
            return Err(Stopped);
        }
        let values = self.space.values(u);
        if let Some(known) = inner.journal.find(&values, samples, columns) {
            return Ok(known.photos.clone());
        }
        let request = EvaluationRequest {
            numbers: self.space.numbers(&values),
            columns: if columns { self.space.columns(&values) } else { Vec::new() },
            photos: self.photos.clone(),
            samples,
            difference_samples: self.difference_samples.min(samples),
            forward_samples: self.forward_samples.min(samples),
            seed: self.seed,
            output: Output::Statistics,
        };
        inner
            .run(&request)
            .and_then(|(photos, primary_samples)| {
                self.check(&request, &photos, &values)?;
                inner.journal.push(Entry { values, samples, columns, primary_samples, photos: photos.clone() })?;
                Ok(photos)
            })
            .map_err(|reason| inner.stop(reason))
    }

    /// The normal equations in coordinates at `u`.
    pub fn normal(&self, u: &[f64], samples: u32) -> Result<Normal, Stopped> {
        Ok(Normal::new(&self.statistics(u, samples, true)?, &self.space.slopes(u)))
    }

    /// The normal equations as [`Objective::normal`], of the parameters that no bound holds back.
    pub fn movable(&self, u: &[f64], samples: u32) -> Result<Normal, Stopped> {
        let normal = self.normal(u, samples)?;
        Ok(normal.restricted(&self.space.movable(u, normal.gradient.as_slice(), normal.matrix.diagonal().as_slice())))
    }

    /// How sure the coordinates at `u` are.
    pub fn uncertainty(&self, u: &[f64], samples: u32) -> Result<Uncertainty, Stopped> {
        Ok(Uncertainty::new(&self.statistics(u, samples, true)?, &self.space.slopes(u)))
    }

    /// Scores photos that no iteration has seen, at the very end.
    pub fn score(&self, u: &[f64], samples: u32, photos: Vec<usize>) -> Result<(PhotoStatistics, u64), Stopped> {
        let mut inner = self.inner.borrow_mut();
        let values = self.space.values(u);
        let request = EvaluationRequest {
            numbers: self.space.numbers(&values),
            columns: Vec::new(),
            photos,
            samples,
            difference_samples: self.difference_samples.min(samples),
            forward_samples: self.forward_samples.min(samples),
            seed: self.seed,
            output: Output::Statistics,
        };
        let event = FitEvent::HeldOut { photos: request.photos.len() };
        inner
            .tell(&event)
            .and_then(|()| inner.run(&request))
            .and_then(|(photos, primary_samples)| {
                self.check(&request, &photos, &values)?;
                let mut total = PhotoStatistics::default();
                for photo in &photos {
                    total.add(photo);
                }
                Ok((total, primary_samples))
            })
            .map_err(|reason| inner.stop(reason))
    }

    /// A solver's iteration has ended at coordinates `u`.
    pub fn iteration_done(&self, u: &[f64], samples: u32) -> Result<(), Stopped> {
        let photos = self.statistics(u, samples, false)?;
        let normal = Normal::new(&photos, &[]);
        let mut inner = self.inner.borrow_mut();
        let step = inner
            .position
            .as_ref()
            .map_or(0.0, |(before, _)| before.iter().zip(u).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max));
        let iteration = Iteration {
            iteration: u32::try_from(inner.iterations.len()).unwrap_or(u32::MAX).saturating_add(1),
            samples,
            loss: normal.total.reduced_chi_square(),
            standard_error: normal.total.chi_square_error(),
            step,
            accepted: step > 0.0,
            parameters: self.space.values(u),
        };
        inner.position = Some((u.to_vec(), samples));
        inner.iterations.push(iteration.clone());
        let errors = inner.standard_errors(&iteration);
        inner
            .journal
            .note(&iteration)
            .and_then(|()| inner.tell(&FitEvent::IterationDone(iteration)))
            .and_then(|()| errors.map_or(Ok(()), |errors| inner.tell(&errors)))
            .map_err(|reason| inner.stop(reason))
    }

    /// Tells the observer.
    pub fn tell(&self, event: &FitEvent) -> Result<(), Stopped> {
        let mut inner = self.inner.borrow_mut();
        inner.tell(event).map_err(|reason| inner.stop(reason))
    }

    /// Sets where the fit stands without counting an iteration.
    pub fn place(&self, u: &[f64], samples: u32) {
        self.inner.borrow_mut().position = Some((u.to_vec(), samples));
    }

    /// Where the fit stands: coordinates, samples per pixel.
    pub fn position(&self) -> Option<(Vec<f64>, u32)> {
        self.inner.borrow().position.clone()
    }

    /// Iterations so far.
    pub fn iterations(&self) -> Vec<Iteration> {
        self.inner.borrow().iterations.clone()
    }

    /// Number of iterations so far.
    pub fn iteration_count(&self) -> u32 {
        u32::try_from(self.inner.borrow().iterations.len()).unwrap_or(u32::MAX)
    }

    /// Camera samples of the fitted photos' evaluations, those of a resumed fit's past included.
    pub fn primary_samples(&self) -> u64 {
        self.inner.borrow().journal.primary_samples()
    }

    /// What was evaluated at coordinates `u`, without evaluating: for what is left when a fit was stopped.
    pub fn known(&self, u: &[f64]) -> Option<Entry> {
        let values = self.space.values(u);
        let inner = self.inner.borrow();
        let here = || inner.journal.entries().iter().filter(|e| e.values == values);
        here().max_by_key(|e| (e.columns, e.samples)).cloned()
    }

    /// Why the fit was stopped, if it was; asked for once.
    pub fn reason(&self) -> Option<FitError> {
        self.inner.borrow_mut().reason.take()
    }

    /// Refuses an answer that no solver can go on from.
    fn check(&self, request: &EvaluationRequest, photos: &[PhotoStatistics], values: &[f64]) -> Result<(), FitError> {
        let side = request.columns.len() + 1;
        let answers = photos.len() == request.photos.len()
            && photos.iter().zip(&request.photos).all(|(p, asked)| {
                p.photo == *asked && [&p.gram, &p.noise].iter().all(|sums| sums.len() == side * side)
            });
        if !answers {
            let got: Vec<String> = photos.iter().map(|p| format!("{} ({} sums)", p.photo, p.gram.len())).collect();
            let got = format!("for photos [{}]", got.join(", "));
            return Err(FitError::Answer { got, asked: format!("for {:?} with {} sums", request.photos, side * side) });
        }
        if photos.iter().map(|p| p.observations).sum::<u64>() == 0 {
            return Err(FitError::NoObservations);
        }
        for p in photos {
            let gram = p.gram.iter().copied().find(|g| !g.is_finite());
            let sums = [("noise floor", p.noise_floor), ("squared error", p.squared_error)];
            let noise = p.noise.iter().copied().find(|n| !n.is_finite()).map(|n| ("render noise", n));
            let bad = sums.into_iter().find(|s| !s.1.is_finite()).or(gram.map(|g| ("Gram matrix", g))).or(noise);
            if let Some((name, value)) = bad {
                let photo = self.capture.target(p.photo).map_or("?", Target::name).to_owned();
                let parameters = self.space.describe(values);
                return Err(FitError::NotFinite { photo, what: format!("{value} ({name})"), parameters });
            }
        }
        Ok(())
    }
}

impl Inner<'_> {
    fn run(&mut self, request: &EvaluationRequest) -> Result<(Vec<PhotoStatistics>, u64), FitError> {
        let observer = &mut *self.observer;
        let mut cancelled = false;
        let answer = self.evaluate.evaluate(request, &mut |progress| {
            let flow = observer(&FitEvent::EvaluationProgress(*progress));
            cancelled |= flow.is_break();
            flow
        });
        match answer {
            // Whoever wants to stop does not want the next evaluation either, even if this one came to its end.
            _ if cancelled => Err(FitError::Cancelled),
            Ok(done) => Ok((done.photos, done.primary_samples)),
            Err(EvaluateError::Cancelled) => Err(FitError::Cancelled),
            Err(error) => Err(FitError::Evaluate(error)),
        }
    }

    fn tell(&mut self, event: &FitEvent) -> Result<(), FitError> {
        if (self.observer)(event).is_break() { Err(FitError::Cancelled) } else { Ok(()) }
    }

    /// How sure the values of an iteration are, where derivatives were evaluated there.
    fn standard_errors(&self, i: &Iteration) -> Option<FitEvent> {
        let known = self.journal.find(&i.parameters, i.samples, true)?;
        let errors = Uncertainty::new(&known.photos, &vec![1.0; i.parameters.len()]).standard_errors;
        let standard_errors = errors.into_iter().map(|error| error.is_finite().then_some(error)).collect();
        Some(FitEvent::StandardErrors { iteration: i.iteration, standard_errors })
    }

    fn stop(&mut self, reason: FitError) -> Stopped {
        self.reason = Some(reason);
        Stopped
    }
}

impl CostFunction for &Objective<'_> {
    type Param = Vec<f64>;
    type Output = f64;

    /// Half of the loss' excess over its expectation.
    fn cost(&self, parameters: &Self::Param) -> Result<f64, Error> {
        let photos = self.statistics(&self.coordinates(parameters), self.samples.get(), false)?;
        Ok(photos.iter().map(|p| 0.5 * (p.loss() - p.noise_floor)).sum())
    }
}

impl Gradient for &Objective<'_> {
    type Param = Vec<f64>;
    type Gradient = Vec<f64>;

    /// J'Wr: the gradient of half of the loss.
    fn gradient(&self, parameters: &Self::Param) -> Result<Vec<f64>, Error> {
        let normal = self.normal(&self.coordinates(parameters), self.samples.get())?;
        Ok(normal.gradient.iter().zip(self.metric.borrow().iter()).map(|(g, m)| g * m).collect())
    }
}
