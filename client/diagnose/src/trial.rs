//! What was tried with each effect of the catalogue.

use crate::effects::Effect;
use crate::ranking::Ranking;
use crate::score::Score;

/// What was tried with one effect.
#[derive(Debug, Clone)]
pub struct Trial {
    /// The effect.
    pub effect: &'static Effect,
    /// Best of its variants in the first ranking; absent where the capture has nothing it could act on.
    pub first: Option<(Score, Vec<(String, f64)>)>,
    /// Why it was not added; absent where it was.
    pub refused_because: Option<String>,
}

impl Trial {
    /// Of an effect that a ranking has found what it says of; refused until it is added.
    #[must_use]
    pub fn of(effect: &'static Effect, ranking: &Ranking) -> Self {
        let score = ranking.best.iter().find(|s| ranking.candidate(s).effect.name == effect.name);
        let first = score.map(|s| {
            let mut changes: Vec<(String, f64)> = Vec::new();
            for (direction, change) in ranking.candidate(s).variant.directions.iter().zip(&s.change) {
                // A number that is scored in each channel by itself changes by the channels' mean.
                let change = if direction.channel.is_some() { change / 3.0 } else { *change };
                match changes.iter_mut().find(|(name, _)| *name == direction.name) {
                    Some((_, sum)) => *sum += change,
                    None => changes.push((direction.name.clone(), change)),
                }
            }
            (s.clone(), changes)
        });
        let why = if first.is_none() { "the capture has nothing that it could act on" } else { "promises too little" };
        Self { effect, first, refused_because: Some(why.to_owned()) }
    }
}

/// Says of an effect why it was not added.
pub fn refuse(trials: &mut [Trial], name: &str, why: &str) {
    if let Some(trial) = trials.iter_mut().find(|t| t.effect.name == name) {
        trial.refused_because = Some(why.to_owned());
    }
}
