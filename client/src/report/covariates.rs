//! Residual against each covariate, before and after, with its noise envelope: small charts as inline SVG.

use super::html::{escape, significant};
use gonio_diagnose::Structure;

const WIDTH: f64 = 300.0;
const HEIGHT: f64 = 130.0;
const LEFT: f64 = 34.0;
const BOTTOM: f64 = 22.0;
const TOP: f64 = 8.0;

/// The section, strongest covariate of the base model first.
pub(super) fn section(before: &[Structure], after: &[Structure]) -> String {
    let each: String = before
        .iter()
        .filter(|s| s.covariate != "place in the photo" && s.curve.len() > 1)
        .map(|s| chart(s, after.iter().find(|a| a.covariate == s.covariate)))
        .collect();
    format!(
        "<section>\n<h2>Residual against covariates</h2>\n<p>Mean residual in standard deviations over bins of equal count: the base model's in gray, the \
         final model's in colour; bands are two standard errors. The percentage is the part of the residuals' variance that the covariate predicts in pixels that it \
         was not estimated from.</p>\n<div class=\"small\">\n{each}</div>\n</section>\n"
    )
}

fn chart(before: &Structure, after: Option<&Structure>) -> String {
    let all = || before.curve.iter().chain(after.iter().flat_map(|a| &a.curve));
    let reach = all().map(|p| p[1].abs() + 2.0 * p[2]).filter(|x| x.is_finite()).fold(0.3, f64::max);
    let low = before.curve.first().map_or(0.0, |p| p[0]);
    let high = before.curve.last().map_or(1.0, |p| p[0]);
    let x = |v: f64| LEFT + (v - low) / (high - low).max(1e-12) * (WIDTH - LEFT - 6.0);
    let y = |v: f64| TOP + (1.0 - v / reach) / 2.0 * (HEIGHT - TOP - BOTTOM);
    let line = |s: &Structure, class: &str| {
        let point =
            |(i, p): (usize, &[f64; 3])| format!("{}{:.1} {:.1}", if i == 0 { "M" } else { "L" }, x(p[0]), y(p[1]));
        let upper = s.curve.iter().map(|p| format!("{:.1} {:.1}", x(p[0]), y(p[1] + 2.0 * p[2])));
        let lower = s.curve.iter().rev().map(|p| format!("{:.1} {:.1}", x(p[0]), y(p[1] - 2.0 * p[2])));
        let band = upper.chain(lower).collect::<Vec<_>>().join("L");
        let curve: String = s.curve.iter().enumerate().map(point).collect();
        format!("<path class=\"band {class}\" d=\"M{band}Z\"/><path class=\"curve {class}\" d=\"{curve}\"/>")
    };
    let percent = |s: &Structure| significant(100.0 * s.strength, 2);
    let name = escape(&before.covariate);
    let shares = after.map_or_else(|| percent(before), |a| format!("{} → {}", percent(before), percent(a)));
    let zero = y(0.0);
    format!(
        "<figure><svg class=\"chart\" viewBox=\"0 0 {WIDTH} {HEIGHT}\" role=\"img\" aria-label=\"Residual against {name}\">\
         <path class=\"right\" d=\"M{LEFT} {zero:.1}H{:.0}\"/>\
         <text x=\"{:.0}\" y=\"{:.1}\" text-anchor=\"end\">{}</text><text x=\"{:.0}\" y=\"{:.1}\" text-anchor=\"end\">{}</text>\
         <text x=\"{LEFT}\" y=\"{:.0}\">{}</text><text x=\"{:.0}\" y=\"{:.0}\" text-anchor=\"end\">{}</text>{}{}</svg>\
         <figcaption>{name}: {shares} %</figcaption></figure>\n",
        WIDTH - 6.0,
        LEFT - 4.0,
        y(reach) + 8.0,
        significant(reach, 2),
        LEFT - 4.0,
        y(-reach),
        significant(-reach, 2),
        HEIGHT - 6.0,
        significant(low, 3),
        WIDTH - 6.0,
        HEIGHT - 6.0,
        significant(high, 3),
        line(before, "old"),
        after.map_or_else(String::new, |a| line(a, "new"))
    )
}
