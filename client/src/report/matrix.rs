//! The correlation matrix as a coloured table.

use super::html::escape;
use gonio_fit::FitResult;

/// Shades per sign.
const SHADES: i32 = 10;

/// The section; empty where there is nothing to correlate.
pub(super) fn section(result: &FitResult) -> String {
    if result.correlations.len() < 2 {
        return String::new();
    }
    let heads: String = result
        .parameters
        .iter()
        .enumerate()
        .map(|(i, p)| format!("<th scope=\"col\"><abbr title=\"{}\">{}</abbr></th>", escape(&p.name), i + 1))
        .collect();
    let rows: String = result
        .parameters
        .iter()
        .zip(&result.correlations)
        .enumerate()
        .map(|(i, (p, row))| {
            let cells: String = row.iter().map(|c| cell(*c)).collect();
            format!("<tr><th scope=\"row\">{} <code>{}</code></th>{cells}</tr>\n", i + 1, escape(&p.name))
        })
        .collect();
    format!(
        "<section>\n<h2>Correlations</h2>\n<div class=\"wide\"><table class=\"matrix\">\n<caption>How much the errors of two \
         estimates go together. Near +1 (red) or \u{2212}1 (blue) the photos hardly tell the two apart.</caption>\n\
         <thead><tr><th scope=\"col\">Parameter</th>{heads}</tr></thead>\n<tbody>\n{rows}</tbody>\n</table></div>\n</section>\n"
    )
}

fn cell(correlation: f64) -> String {
    if !correlation.is_finite() {
        return "<td>–</td>".to_owned();
    }
    #[allow(clippy::cast_possible_truncation)]
    let shade = (correlation.clamp(-1.0, 1.0) * f64::from(SHADES)).round() as i32;
    let sign = if shade < 0 { 'n' } else { 'p' };
    format!("<td class=\"{sign}{}\">{}</td>", shade.abs(), format!("{correlation:+.2}").replace('-', "\u{2212}"))
}

/// One class per shade: the policy allows no style attributes.
pub(super) fn style() -> String {
    let mut css = String::new();
    for shade in 1..=SHADES {
        let alpha = 0.09 * f64::from(shade);
        let text = if shade >= 7 { ";color:#fff" } else { "" };
        css += &format!(".matrix .p{shade}{{background:rgba(178,24,43,{alpha:.2}){text}}}");
        css += &format!(".matrix .n{shade}{{background:rgba(33,102,172,{alpha:.2}){text}}}\n");
    }
    css
}
