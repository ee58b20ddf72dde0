//! The strength at which half is found, as a section of the page.

use crate::outcome::{SWEPT, is_found, strength};
use crate::threshold::{Threshold, Trial, threshold};
use gonio_diagnose::effects::CATALOGUE;
use gonio_tests::hidden::unit;
use serde_json::Value;
use std::fmt::Write;

/// Every trial of an effect: those of the matrix, from strong to weak, and those of its staircase, in turn.
pub fn trials(outcomes: &[Value], effect: &str) -> [Vec<Trial>; 2] {
    let of = |swept: bool| -> Vec<Trial> {
        let these = outcomes.iter().filter(|o| o["effect"] == effect && (o["strength"] == SWEPT) == swept);
        these.filter_map(|o| Some(Trial { strength: strength(o)?, found: is_found(o) })).collect()
    };
    let mut matrix = of(false);
    matrix.sort_by(|a, b| b.strength.total_cmp(&a.strength));
    [matrix, of(true)]
}

/// The section; nothing where no strength was swept.
pub fn section(outcomes: &[Value]) -> String {
    let mut text = String::new();
    if !outcomes.iter().any(|o| o["strength"] == SWEPT) {
        return text;
    }
    text += "\n## Strength at which half is found\n\n\
         Found: the hidden effect is in the set of the first or the second finding. Every step of a sweep is a capture of its\n\
         own seed, weaker after a find and stronger after a miss; both rows of the matrix count too. Strength: by maximum\n\
         likelihood of a logistic function of given slope (a tenth to nine tenths in a factor of 3), with its 68 % interval;\n\
         *below*, *above*: found, or missed, every time, at this strength among others. Chi-square: reduced, before any effect\n\
         is added, of the capture nearest to that strength; 1 is noise alone. A failed diagnosis is a miss.\n\n\
         | # | effect | strength | found | chi-square there | that is | strength 1 is |\n\
         | --- | --- | --- | --- | --- | --- | --- |\n";
    for (number, effect) in CATALOGUE.iter().enumerate() {
        let all = trials(outcomes, effect.name).concat();
        let Some(threshold) = threshold(&all) else { continue };
        let (before, said) = match threshold {
            Threshold::Below(at) => ("below ", digits(at)),
            Threshold::Above(at) => ("above ", digits(at)),
            Threshold::At { half, low, high } => {
                ("", format!("{} ({} to {})", digits(half), digits(low), digits(high)))
            }
        };
        let chi =
            chi_near(outcomes, effect.name, threshold.strength()).map_or(String::new(), |chi| format!("{chi:.3}"));
        let found = all.iter().filter(|t| t.found).count();
        let unit = unit(effect.name);
        // Beyond the most, an estimate is no amount that there could be.
        let amount = |at: f64| unit.as_ref().filter(|u| at <= u.most).map_or(String::new(), |u| digits((u.amount)(at)));
        let _ = writeln!(
            text,
            "| {} | `{}` | {before}{said} | {found} of {} | {chi} | {} | {} {} |",
            number + 1,
            effect.name,
            all.len(),
            amount(threshold.strength()),
            amount(1.0),
            unit.as_ref().map_or("", |unit| unit.noun),
        );
    }
    text += "\nIn `strengths.png` a dot is a find, a ring a miss, a bar the interval about the estimate; a bar that ends at the edge\n\
             has no other end.\n";
    text
}

/// The base model's chi-square in the capture of an effect whose strength is nearest.
fn chi_near(outcomes: &[Value], effect: &str, at: f64) -> Option<f64> {
    let these = outcomes.iter().filter(|o| o["effect"] == effect);
    let each = these.filter_map(|o| Some((libm::log(strength(o)? / at).abs(), o["chi_before"].as_f64()?)));
    each.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, chi)| chi)
}

/// A positive number to two digits, without an exponent.
fn digits(value: f64) -> String {
    let places = (1.0 - libm::floor(libm::log10(value))).clamp(0.0, 6.0);
    format!("{value:.*}", places as usize)
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn numbers_have_two_digits() {
        assert_eq!([0.0309, 0.35, 1.0, 25.0, 102.0].map(digits), ["0.031", "0.35", "1.0", "25", "102"]);
    }

    #[test]
    fn every_effect_has_a_unit() {
        for effect in CATALOGUE {
            let unit = unit(effect.name).unwrap();
            assert!(unit.most >= 1.0 && (unit.amount)(1.0) > 0.0, "{}", effect.name);
        }
    }

    #[test]
    fn the_section_counts_rows_of_the_matrix_and_of_the_sweep() {
        let row = |strength: &str, at: Option<f64>, named: &str, chi: f64| json!({ "effect": "vignetting", "strength": strength, "at": at, "seed": 1, "named": [[named]], "chi_before": chi });
        let matrix = [row("moderate", None, "vignetting", 3.0), row("weak", None, "vignetting", 1.25)];
        assert_eq!(section(&matrix), "");
        let swept = [row(SWEPT, Some(0.0875), "vignetting", 1.03), row(SWEPT, Some(0.021875), "none", 1.01)];
        let text = section(&[matrix.as_slice(), &swept].concat());
        let line = text.lines().find(|line| line.starts_with("| 19 | `vignetting`")).unwrap();
        assert!(
            line.contains("| 0.044 (0.0")
                && line.contains("| 3 of 4 | ")
                && line.contains(" | 1.1 | 25 % of the light"),
            "{line}"
        );
        assert_eq!([0.02, 0.08].map(|at| chi_near(&swept, "vignetting", at)), [Some(1.01), Some(1.03)]);
    }
}
