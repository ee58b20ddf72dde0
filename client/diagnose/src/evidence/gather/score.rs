//! The score test: how much an effect would lower chi-square if it were added, and by how much of it, from derivatives at
//! the null alone (Rao 1948; expected parameter change: Sorbom 1989).

use crate::evidence::Promise;
use crate::evidence::gather::cross::per_observation;
use crate::evidence::gather::probe::{Candidate, Probe};
use crate::evidence::gather::quadratic::Quadratic;
use gonio_scene::PhotoStatistics;
use nalgebra::DVector;
use statrs::distribution::{ChiSquared, ContinuousCDF};

/// What the derivatives at the null say about one candidate.
#[derive(Debug, Clone)]
pub struct Score {
    /// Index into [`Probe::candidates`].
    pub candidate: usize,
    /// Decrease of the fitted photos' chi-square that it promises, over the noise's own dispersion: chi-square distributed
    /// with `freedom` degrees where the effect is absent.
    pub score: f64,
    /// Directions that the data determine.
    pub freedom: usize,
    /// Chance of such a score where the effect is absent.
    pub p_value: f64,
    /// What it promises.
    pub promise: Promise,
    /// Expected change of each direction from its null, in its own unit.
    pub change: Vec<f64>,
}

/// Scores every candidate of a probe from the per-photo statistics of its evaluation.
///
/// `dispersion` is what a score comes to per degree of freedom without any effect, the render's noise aside: 1 for independent
/// observations. What `beside` explains, one of the
/// probe's candidates, is taken for explained.
#[must_use]
pub fn scores(probe: &Probe, photos: &[PhotoStatistics], dispersion: f64, beside: Option<&Candidate>) -> Vec<Score> {
    let observations: u64 = photos.iter().map(|p| p.observations).sum();
    let all = probe.candidates.iter().enumerate();
    all.filter_map(|(index, c)| score(index, c, probe.own, beside, photos, dispersion, observations)).collect()
}

/// A candidate's columns among all of a probe's, and their factors: 0 where a direction is another photo's.
fn places(candidate: &Candidate, own: usize, photo: usize) -> impl Iterator<Item = (usize, f64)> + '_ {
    let each = candidate.columns.iter().zip(&candidate.scales).zip(&candidate.variant.directions);
    each.map(move |((i, scale), direction)| {
        let absent = direction.of_photo.as_ref().is_some_and(|(own, _)| *own != photo);
        (own + i, if absent { 0.0 } else { *scale })
    })
}

fn score(
    index: usize,
    candidate: &Candidate,
    own: usize,
    beside: Option<&Candidate>,
    photos: &[PhotoStatistics],
    dispersion: f64,
    observations: u64,
) -> Option<Score> {
    let quadratic = |photo: &PhotoStatistics| {
        let model = (0..own).map(|i| (i, 1.0)).chain(beside.into_iter().flat_map(|c| places(c, own, photo.photo)));
        Quadratic::new(photo, &model.chain(places(candidate, own, photo.photo)).collect::<Vec<_>>())
    };
    let each: Vec<Quadratic> = photos.iter().map(quadratic).collect();
    let own = own + beside.map_or(0, |c| c.columns.len());
    let total = Quadratic::sum(&each)?;
    let (raw, freedom) = constrained(&total, own, candidate);
    let projected = total.projected(own);
    let dispersion = dispersion * projected.dispersion();
    let score = (-projected.change(&raw)).max(0.0) / dispersion;
    let gains: Vec<f64> = (0..each.len()).map(|out| left_out(&each, &total, out, own, candidate)).collect();
    let (cross_gain, cross_error) = per_observation(&gains, observations);
    let explained = score * dispersion / (observations as f64).max(1.0);
    let change = raw.iter().zip(&candidate.variant.directions).map(|(x, d)| physical(*x, d.power)).collect();
    Some(Score {
        candidate: index,
        score,
        freedom,
        p_value: tail_probability(score, freedom),
        promise: Promise { candidate: index, explained, cross_gain, cross_error },
        change,
    })
}

/// A change of the number from a change of its power.
pub fn physical(change: f64, power: i32) -> f64 {
    if power == 2 { change.max(0.0).sqrt() } else { change }
}

/// The best move of a candidate's directions with the model's own fitted along; one-sided directions that would go the
/// wrong way stay at their null, and none goes beyond what is sensible.
fn constrained(total: &Quadratic, own: usize, candidate: &Candidate) -> (DVector<f64>, usize) {
    let directions = &candidate.variant.directions;
    let all = total.projected(own);
    let before = total.matrix.diagonal().rows(own, directions.len()).into_owned();
    let mut keep: Vec<usize> = (0..directions.len()).collect();
    loop {
        let (step, rank) = all.select(&keep).minimum(&DVector::from_fn(keep.len(), |i, _| before[keep[i]]));
        let wrong: Vec<usize> = (0..keep.len()).filter(|i| directions[keep[*i]].one_sided && step[*i] < 0.0).collect();
        if wrong.is_empty() {
            let mut full = DVector::zeros(directions.len());
            for (i, k) in keep.iter().enumerate() {
                let most = directions[*k].most.powi(directions[*k].power);
                full[*k] = step[i].clamp(-most, most);
            }
            return (full, rank.max(1));
        }
        keep = keep.iter().enumerate().filter(|(i, _)| !wrong.contains(i)).map(|(_, k)| *k).collect();
        if keep.is_empty() {
            return (DVector::zeros(directions.len()), 1);
        }
    }
}

/// Decrease of photo `out`'s chi-square by adding the candidate, both models fitted to the other photos.
fn left_out(each: &[Quadratic], total: &Quadratic, out: usize, own: usize, candidate: &Candidate) -> f64 {
    let photo = &each[out];
    let Some(rest) = Quadratic::sum(each.iter().enumerate().filter(|(i, _)| *i != out).map(|(_, q)| q)) else {
        return 0.0;
    };
    let rest = rest.reminded_of(total);
    let own_columns: Vec<usize> = (0..own).collect();
    let base = rest.select(&own_columns).solve();
    let before = photo.select(&own_columns).change(&base);
    // A number of this photo alone follows from no other: it is fitted here, at the cost of its own degree of freedom.
    let known = if candidate.variant.of_photos { total } else { &rest };
    let extra = constrained(known, own, candidate).0;
    // The model's own parameters move along with the candidate's.
    let coupled = rest.matrix.view((0, own), (own, extra.len())) * &extra + rest.gradient.rows(0, own);
    let joint = Quadratic { gradient: coupled, ..rest.select(&own_columns) }.solve();
    let step = DVector::from_fn(own + extra.len(), |i, _| if i < own { joint[i] } else { extra[i - own] });
    before - photo.change(&step)
}

/// The upper tail of the chi-square distribution.
#[must_use]
pub fn tail_probability(score: f64, freedom: usize) -> f64 {
    ChiSquared::new(freedom.max(1) as f64).map_or(1.0, |d| d.sf(score.max(0.0)))
}
