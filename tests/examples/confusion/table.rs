//! The outcomes as a page.

use crate::outcome::{is_right, named, programs};
use crate::strengths;
use gonio_diagnose::effects::CATALOGUE;
use gonio_tests::hidden::STRENGTHS;
use serde_json::Value;
use std::fmt::Write;

pub fn page(outcomes: &[Value]) -> String {
    let mut page = String::from(
        "# What a diagnosis takes for what\n\n\
         Written by `cargo run --release -p gonio-tests --example confusion`: one capture of 64x48 pixels, 5 photos to fit\n\
         and 1 held out, per effect and strength. *right*: the hidden effect is in the set of the first finding; *alone*: that\n\
         set has no other. Gain: log predictive density per held-out observation, nats. Chi-square: reduced, of the fitted\n\
         photos, before and after.\n\n",
    );
    for (label, _) in STRENGTHS {
        let these: Vec<&Value> = outcomes.iter().filter(|o| o["strength"] == label).collect();
        let right = these.iter().filter(|o| is_right(o)).count();
        let alone = these.iter().filter(|o| is_right(o) && named(o)[0].len() == 1).count();
        let silent = these.iter().filter(|o| named(o).is_empty()).count();
        let wrong = these.len() - right - silent;
        let _ = writeln!(
            page,
            "- {label}: {} of {} effects run; {right} right ({alone} alone), {wrong} misnamed, {silent} not named",
            these.len(),
            CATALOGUE.len()
        );
    }
    let nulls: Vec<&Value> = outcomes.iter().filter(|o| o["effect"] == "none").collect();
    let verdicts = |v: &str| nulls.iter().filter(|o| o["verdict"] == v).count();
    let _ = writeln!(
        page,
        "- no effect: {} captures run; {} named, {} unexplained, {} failed\n\n{}\n",
        nulls.len(),
        verdicts("named"),
        verdicts("unexplained"),
        verdicts("failed"),
        programs(outcomes)
    );
    page += "| # | effect | strength | verdict | named | gain | chi-square | hidden effect refused because |\n";
    page += "| --- | --- | --- | --- | --- | --- | --- | --- |\n";
    for (number, effect) in CATALOGUE.iter().enumerate() {
        for (label, _) in STRENGTHS {
            for o in outcomes.iter().filter(|o| o["effect"] == effect.name && o["strength"] == label) {
                page += &row(o, number + 1, label);
            }
        }
    }
    for o in nulls.iter().filter(|o| o["verdict"] != "none") {
        page += &row(o, 0, &format!("seed {}", o["seed"]));
    }
    page += "\nIn `confusion.png` row and column numbers are those of the table: a row for what was hidden (the last: nothing),\n\
             a column for what was named first (the last two: unexplained, none). Dark: named first; light: in the same set.\n\
             The left half of a cell is the moderate strength, the right half the weak one.\n";
    page += &strengths::section(outcomes);
    page
}

fn row(o: &Value, number: usize, label: &str) -> String {
    let sets: Vec<String> = named(o).iter().map(|set| set.join(" or ")).collect();
    let digits = |key: &str, n: usize| o[key].as_f64().map_or(String::new(), |x| format!("{x:.n$}"));
    let refused = if is_right(o) { "" } else { o["refused"].as_str().unwrap_or_default() };
    let verdict = if is_right(o) { "right" } else { o["verdict"].as_str().unwrap_or_default() };
    format!(
        "| {number} | `{}` | {label} | {verdict} | {} | {} | {} -> {} | {refused} |\n",
        o["effect"].as_str().unwrap_or_default(),
        sets.join("; "),
        digits("gain", 4),
        digits("chi_before", 3),
        digits("chi_after", 3)
    )
}
