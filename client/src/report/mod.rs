//! The report of a fit: one HTML page that needs nothing besides itself.
//!
//! No script, no external host, nothing but data: pictures; a strict content security policy states as much. Light or dark
//! as the reader's system is.

mod chart;
mod covariates;
mod diagnosis;
mod html;
mod matrix;
mod panel;
mod picture;
mod prediction;
mod reflectance;
mod share;
mod summary;
mod tables;

pub use diagnosis::DiagnosisReport;
pub use panel::{LONGEST, Panel};
pub use prediction::{PairPicture, PredictionReport};
pub use reflectance::ReflectancePanel;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use gonio_fit::FitResult;
use html::escape;
use sha2::{Digest, Sha256};

/// The style of every report.
const STYLE: &str = include_str!("style.css");

/// What a report is about.
#[derive(Debug)]
pub struct Report<'a> {
    /// The fit's outcome.
    pub result: &'a FitResult,
    /// One panel per photo, in the capture's order; empty where the fit was interrupted before they were rendered.
    pub panels: &'a [Panel],
    /// One panel per file of measured reflectance.
    pub files: &'a [ReflectancePanel],
    /// Samples per pixel of the panels' renders.
    pub samples: u32,
    /// The command that made it.
    pub command: &'a str,
    /// The program's version.
    pub version: &'a str,
}

impl Report<'_> {
    /// The page.
    #[must_use]
    pub fn page(&self) -> String {
        let name = escape(&self.result.capture);
        let body = [
            summary::section(self.result, self.panels, self.files),
            tables::parameters(self.result),
            matrix::section(self.result),
            chart::section(&self.result.loss_curve),
            tables::photos(self.panels, self.samples),
            panel::section(self.panels),
            reflectance::table(self.files),
            reflectance::section(self.files, &[]),
            self.footer(),
        ]
        .concat();
        page(&format!("Fit of {name}"), &body)
    }

    fn footer(&self) -> String {
        let result = self.result;
        format!(
            "<footer>\n<p>Made by gonio {} with <code>{}</code></p>\n\
             <p>Solver {}, seed {}, {} iterations, {} camera samples, at the end {} samples per pixel, {:.1} s.</p>\n</footer>\n",
            escape(self.version),
            escape(self.command),
            result.solver,
            result.seed,
            result.iterations,
            html::grouped(result.primary_samples),
            result.samples,
            result.seconds
        )
    }
}

/// A page of ours round `body`; `title` is HTML already.
fn page(title: &str, body: &str) -> String {
    let style = format!("{STYLE}{}", matrix::style());
    // The policy names the style by its digest, so that no style that a capture's text might smuggle in applies.
    let digest = STANDARD.encode(Sha256::digest(style.as_bytes()));
    let policy =
        format!("default-src 'none'; img-src data:; style-src 'sha256-{digest}'; base-uri 'none'; form-action 'none'");
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta http-equiv=\"Content-Security-Policy\" content=\"{policy}\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <meta name=\"color-scheme\" content=\"light dark\">\n\
         <title>{title}</title>\n<style>{style}</style>\n</head>\n<body>\n<main>\n\
         <h1>{title}</h1>\n{body}</main>\n</body>\n</html>\n"
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use gonio_fit::{Estimate, LossPoint, Score, SolverName};

    fn result() -> FitResult {
        let estimate = |name: &str| Estimate {
            name: name.to_owned(),
            start: 0.5,
            value: 0.25,
            standard_error: Some(0.01),
            model_error: Some(0.01),
            between_photos_error: None,
        };
        let score = Score {
            observations: 300,
            reduced_chi_square: 1.02,
            chi_square_error: 0.01,
            rmse: 0.01,
            psnr: Some(30.0),
            log_density: 2.0,
        };
        let point = |iteration, loss| LossPoint { iteration, samples: 4, loss, standard_error: 0.1 };
        FitResult {
            capture: "<script>alert(\"x\")</script>&".to_owned(),
            converged: true,
            iterations: 3,
            seconds: 1.5,
            primary_samples: 1_234_567,
            seed: 0,
            solver: SolverName::GaussNewton,
            samples: 16,
            parameters: vec![estimate("material.<b>.roughness"), estimate("light.led.intensity")],
            fit: score,
            held_out: Some(score),
            correlations: vec![vec![1.0, -0.96], vec![-0.96, 1.0]],
            warnings: vec!["a <i>warning</i>".to_owned()],
            loss_curve: vec![point(1, 120.0), point(2, 3.0), point(3, 1.02)],
            photos: Vec::new(),
        }
    }

    #[test]
    fn text_of_the_capture_cannot_become_markup() {
        let page = Report {
            result: &result(),
            panels: &[],
            files: &[],
            samples: 16,
            command: "gonio fit '<img src=x>'",
            version: "1",
        }
        .page();
        for tag in ["<script", "<b>", "<i>", "<img"] {
            assert!(!page.contains(tag), "{tag}");
        }
        assert!(page.contains("&lt;script&gt;alert(&quot;x&quot;)&lt;/script&gt;&amp;"));
    }

    #[test]
    fn the_page_needs_no_other_host_and_its_policy_allows_its_style() {
        let page =
            Report { result: &result(), panels: &[], files: &[], samples: 16, command: "gonio fit", version: "1" }
                .page();
        for outside in ["src=\"http", "href=", "url(", "@import", "style=\"", "on"] {
            // Every attribute that could load or run something; `on...` handlers only as attributes.
            let found = if outside == "on" {
                page.contains(" onload=") || page.contains(" onclick=")
            } else {
                page.contains(outside)
            };
            assert!(!found, "{outside}");
        }
        let style = page.split("<style>").nth(1).unwrap().split("</style>").next().unwrap();
        let digest = STANDARD.encode(Sha256::digest(style.as_bytes()));
        assert!(page.contains(&format!("style-src 'sha256-{digest}'")));
    }

    #[test]
    fn says_first_how_it_ended() {
        let mut result = result();
        let page = |result: &FitResult| {
            Report { result, panels: &[], files: &[], samples: 16, command: "", version: "" }.page()
        };
        assert!(page(&result).contains("converged after 3 iterations"));
        result.converged = false;
        assert!(page(&result).contains("did not converge"));
    }
}
