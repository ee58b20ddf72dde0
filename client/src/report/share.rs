//! What each finding explains of the misfit: one bar from the base model down to the photographs' noise.

use super::html::{escape, significant};
use gonio_diagnose::Diagnosis;
use std::fmt::Write;

/// Width and height of the bar, in pixels.
const BAR: [f64; 2] = [640.0, 26.0];
/// Colours of findings in their order, then again from the first; of good contrast on light and dark ground.
const COLOURS: [&str; 5] = ["#2a7de1", "#c7721d", "#2f9e6e", "#a8509e", "#8a8f2a"];
/// The colour of what nothing explains.
const LEFT: &str = "#8c8c8c";

/// The bar with its list; empty where nothing was found.
#[must_use]
pub fn section(diagnosis: &Diagnosis) -> String {
    let noise = diagnosis.noise.map_or(1.0, |n| n.iter().map(|c| c.variance.max(1.0)).sum::<f64>() / 3.0);
    let misfit = diagnosis.base.fit.reduced_chi_square - noise;
    if diagnosis.found.is_empty() || misfit <= 0.0 {
        return String::new();
    }
    let named = diagnosis.found.iter().zip(COLOURS.iter().cycle());
    let mut parts: Vec<(String, f64, &str)> =
        named.map(|(f, colour)| (f.effects.join(" or "), (f.gain / misfit).clamp(0.0, 1.0), *colour)).collect();
    let explained: f64 = parts.iter().map(|p| p.1).sum();
    parts.push(("nothing of the catalogue".to_owned(), (1.0 - explained).max(0.0), LEFT));
    let all = parts.iter().map(|p| p.1).sum::<f64>().max(1e-9);
    let (mut x, mut bar, mut list) = (0.0, String::new(), String::new());
    for (name, part, colour) in &parts {
        let width = BAR[0] * part / all;
        let _ =
            write!(bar, "<rect x=\"{x:.1}\" y=\"0\" width=\"{width:.1}\" height=\"{}\" fill=\"{colour}\"/>", BAR[1]);
        let percent = significant(100.0 * part, 2);
        let _ = writeln!(list, "<li><span style=\"color:{colour}\">\u{25a0}</span> {}: {percent} %</li>", escape(name));
        x += width;
    }
    let label: Vec<String> = parts.iter().map(|(name, part, _)| format!("{name} {:.0} %", 100.0 * part)).collect();
    format!(
        "<section>\n<h2>What explains the misfit</h2>\n<p>Of the base model's chi-square above the photographs' noise ({} above {}), by how much \
         better photos are predicted that each cause was not fitted to.</p>\n<svg viewBox=\"0 0 {} {}\" width=\"{}\" height=\"{}\" role=\"img\" \
         aria-label=\"{}\">{bar}</svg>\n<ul>\n{list}</ul>\n</section>\n",
        significant(diagnosis.base.fit.reduced_chi_square, 4),
        significant(noise, 3),
        BAR[0],
        BAR[1],
        BAR[0],
        BAR[1],
        escape(&label.join(", "))
    )
}
