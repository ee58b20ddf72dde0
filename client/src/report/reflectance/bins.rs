//! Samples in bins: by angle of incidence, then by half angle.

/// A file with more angles of incidence shows ranges of them, as many.
pub(super) const GROUPS: usize = 4;
/// Width of a bin of half angles, degrees.
pub(super) const BIN: f64 = 1.5;

/// Samples of about one angle of incidence.
#[derive(Debug, Clone)]
pub(super) struct Group {
    /// Smallest and largest, degrees.
    pub incidence: [f64; 2],
    /// By half angle.
    pub bins: Vec<Bin>,
}

/// Samples of about one half angle.
#[derive(Debug, Clone, Copy)]
pub(super) struct Bin {
    /// Mean half angle, degrees.
    pub half: f64,
    /// Mean, smallest and largest compared value over the panel's scale, means over the channels.
    pub measured: [f64; 3],
    /// The model's mean.
    pub model: f64,
    /// Mean residual in standard deviations.
    pub residual: f64,
}

/// One sample: angle of incidence and half angle in degrees, compared values over the scale, residual.
pub(super) struct Sample {
    pub incidence: f64,
    pub half: f64,
    pub measured: f64,
    pub model: f64,
    pub residual: f64,
}

/// Samples by angle of incidence, each by half angle.
pub(super) fn groups(samples: Vec<Sample>) -> Vec<Group> {
    let mut angles: Vec<f64> = samples.iter().map(|s| s.incidence.round()).collect();
    angles.sort_by(f64::total_cmp);
    angles.dedup();
    let number = angles.len().min(GROUPS);
    let mut sorted: Vec<Vec<Sample>> = (0..number).map(|_| Vec::new()).collect();
    for sample in samples {
        let place = angles.partition_point(|a| *a < sample.incidence.round());
        sorted[(place * number / angles.len()).min(number - 1)].push(sample);
    }
    sorted.into_iter().map(group).collect()
}

fn group(mut samples: Vec<Sample>) -> Group {
    samples.sort_by(|a, b| a.half.total_cmp(&b.half));
    let reach = |f: fn(f64, f64) -> f64, start| samples.iter().map(|s| s.incidence).fold(start, f);
    let incidence = [reach(f64::min, f64::INFINITY), reach(f64::max, f64::NEG_INFINITY)];
    let bins = samples.chunk_by(|a, b| (a.half / BIN).floor() == (b.half / BIN).floor()).map(bin).collect();
    Group { incidence, bins }
}

fn bin(samples: &[Sample]) -> Bin {
    #[allow(clippy::cast_precision_loss)]
    let number = samples.len() as f64;
    let mean = |value: fn(&Sample) -> f64| samples.iter().map(value).sum::<f64>() / number;
    let of_measured = |f: fn(f64, f64) -> f64, start| samples.iter().map(|s| s.measured).fold(start, f);
    Bin {
        half: mean(|s| s.half),
        measured: [
            mean(|s| s.measured),
            of_measured(f64::min, f64::INFINITY),
            of_measured(f64::max, f64::NEG_INFINITY),
        ],
        model: mean(|s| s.model),
        residual: mean(|s| s.residual),
    }
}
