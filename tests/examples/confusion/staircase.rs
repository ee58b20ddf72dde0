//! Which strength an effect is hidden at next: up after a miss, down after a find (Dixon and Mood 1948, "A method for
//! obtaining and analyzing sensitivity data"), so that trials gather where half are found.

use crate::threshold::Trial;

/// The least strength that is tried; the most depends on the effect.
pub const LEAST: f64 = 1.0 / 64.0;
/// The strength of an effect that nothing is known of.
const FIRST: f64 = 1.0;
/// Factors between strengths: until there are a find and a miss, then once, and from then on.
const FACTORS: [f64; 3] = [4.0, 2.0, std::f64::consts::SQRT_2];

/// The next strength by what is known: trials of the matrix, from strong to weak, and those of the staircase, in turn. `None`
/// where it would be a bound that has twice given the same answer.
pub fn next(matrix: &[Trial], steps: &[Trial], most: f64) -> Option<f64> {
    // It begins from the weakest of the matrix that was found, or the strongest, if none was.
    let weakest = matrix.iter().rev().find(|t| t.found).or(matrix.first());
    let Some(last) = steps.last().or(weakest) else { return Some(FIRST.min(most)) };
    let all: Vec<&Trial> = matrix.iter().chain(steps).collect();
    let alike = all.iter().take_while(|t| t.found == all[0].found).count();
    let factor = FACTORS[(all.len() - alike).min(FACTORS.len() - 1)];
    let at = if last.found { last.strength / factor } else { last.strength * factor }.clamp(LEAST, most);
    let same = steps.iter().filter(|t| t.strength == at && t.found == last.found).count();
    (last.strength != at || same < 2).then_some(at)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::SQRT_2;

    /// Strengths of a staircase of at most `count` steps, with an effect that is found from `half` on.
    fn strengths(matrix: &[f64], half: f64, most: f64, count: usize) -> Vec<f64> {
        let trial = |strength: f64| Trial { strength, found: strength >= half };
        let matrix: Vec<Trial> = matrix.iter().copied().map(trial).collect();
        let mut steps = Vec::new();
        while steps.len() < count
            && let Some(at) = next(&matrix, &steps, most)
        {
            steps.push(trial(at));
        }
        steps.iter().map(|t| t.strength).collect()
    }

    fn near(found: &[f64], expected: &[f64]) {
        assert_eq!(found.len(), expected.len(), "{found:?}");
        assert!(found.iter().zip(expected).all(|(a, b)| (a / b - 1.0).abs() < 1e-9), "{found:?}");
    }

    #[test]
    fn steps_shorten_about_the_half() {
        // Down by 4, up by 2, and from then on by the root of 2.
        near(&strengths(&[1.0, 0.35], 0.03, 4.0, 5), &[0.0875, 0.021875, 0.04375, 0.0309359217, 0.021875]);
        // The matrix has it between its two strengths: from the one that was found.
        near(&strengths(&[1.0, 0.35], 0.6, 4.0, 4), &[0.5, 0.5 * SQRT_2, 0.5, 0.5 * SQRT_2]);
        near(&strengths(&[], 0.6, 4.0, 2), &[1.0, 0.25]);
    }

    #[test]
    fn a_bound_is_tried_twice() {
        near(&strengths(&[1.0, 0.35], 9.0, 4.0, 9), &[4.0, 4.0]);
        near(&strengths(&[1.0, 0.35], 0.0, 4.0, 9), &[0.0875, 0.021875, LEAST, LEAST]);
        near(&strengths(&[1.0], 9.0, 1.25, 9), &[1.25, 1.25]);
    }
}
