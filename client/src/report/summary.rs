//! The first sentences: how the fit ended, how well it matches, what to beware of.

use super::html::{escape, significant};
use super::{Panel, ReflectancePanel};
use gonio_fit::FitResult;

/// The opening section.
pub(super) fn section(result: &FitResult, panels: &[Panel], files: &[ReflectancePanel]) -> String {
    let ended = if result.converged {
        format!("The fit converged after {} iterations in {:.1} s.", result.iterations, result.seconds)
    } else {
        format!(
            "The fit did not converge: it ended after {} iterations and {:.1} s, and the values below are those it had reached.",
            result.iterations, result.seconds
        )
    };
    let of_files = panels.is_empty() && !files.is_empty();
    let mut text = format!("<p class=\"summary\"><strong>{ended}</strong> {}", matches(result, of_files));
    if let Some(held) = &result.held_out {
        let psnr = held.psnr.map(|psnr| format!(", PSNR {psnr:.1} dB")).unwrap_or_default();
        text += &format!(
            " On the held-out {}, which it has not seen, reduced chi-square is {}{psnr}.",
            if of_files { "files" } else { "photos" },
            significant(held.reduced_chi_square, 4)
        );
    }
    text += "</p>\n";
    if panels.is_empty() && files.is_empty() {
        text += "<p>There are no pictures: the command was interrupted or failed before they were rendered.</p>\n";
    }
    text + &warnings(&result.warnings)
}

fn matches(result: &FitResult, of_files: bool) -> String {
    let chi = result.fit.reduced_chi_square;
    let verdict = match chi {
        x if x < 0.8 => "The renders match the fitted photos better than the stated noise allows: it is overstated",
        x if x < 1.1 => "The renders match the fitted photos to within their noise",
        x if x < 1.5 => "The renders match the fitted photos slightly worse than noise explains",
        _ => "The model does not explain the fitted photos, or their noise is understated",
    };
    if of_files {
        let verdict = if chi < 1.1 {
            "explains the measured reflectance to within its stated noise"
        } else {
            "leaves more of the measured reflectance than its stated noise explains, as any model of few numbers does"
        };
        let chi = significant(chi, 4);
        return format!("The model {verdict} (reduced chi-square {chi}).");
    }
    format!(
        "{verdict} (reduced chi-square {}, RMSE {} in photo values).",
        significant(chi, 4),
        significant(result.fit.rmse, 3)
    )
}

fn warnings(warnings: &[String]) -> String {
    if warnings.is_empty() {
        return String::new();
    }
    let items: String = warnings.iter().map(|warning| format!("<li>{}</li>\n", escape(warning))).collect();
    format!("<section class=\"warnings\">\n<h2>Warnings</h2>\n<ul>\n{items}</ul>\n</section>\n")
}
