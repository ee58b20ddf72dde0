//! A fit's events and result on the page.

use super::Watch;
use super::board::Board;
use crate::report::Panel;
use gonio_fit::{FitEvent, FitResult};
use gonio_scene::Capture;
use serde_json::json;

impl Watch {
    /// Shows one event.
    pub fn fit(&self, event: &FitEvent) {
        if let Some(board) = self.board() {
            board.fit(event, "");
        }
    }

    /// Shows the result, whose numbers are those that are written.
    pub fn result(&self, result: &FitResult) {
        if let Some(board) = self.board() {
            board.result(result);
        }
    }

    /// Shows the report's panels in place of those of before.
    pub fn panels(&self, capture: &Capture, panels: &[Panel]) {
        let Some(board) = self.board() else { return };
        for panel in panels {
            if let Some(photo) = capture.photos.iter().position(|photo| photo.name() == panel.name) {
                board.panel(photo, panel, None);
            }
        }
    }
}

impl Board {
    /// Shows a fit's event; `stage` is what the fit is for, where it is a part of something.
    pub(super) fn fit(&self, event: &FitEvent, stage: &str) {
        match event {
            FitEvent::Started { solver, parameters, start, fit_photos, held_out_photos, resumed } => {
                self.clear(&["iterations", "result"]);
                self.set("names", parameters.clone());
                self.set("start", start.clone());
                self.set(
                    "fit",
                    json!({ "solver": solver, "photos": fit_photos, "held_out": held_out_photos, "resumed": resumed }),
                );
                if stage.is_empty() {
                    self.set("phase", "Fitting");
                }
            }
            FitEvent::EvaluationProgress(progress) => {
                let label = if stage.is_empty() { "Evaluation" } else { stage };
                self.advance(label, progress);
            }
            FitEvent::IterationDone(i) => self.put(
                "iterations",
                &i.iteration.to_string(),
                json!({
                    "loss": i.loss, "error": i.standard_error, "samples": i.samples, "values": i.parameters,
                    "accepted": i.accepted || i.iteration == 1,
                }),
            ),
            FitEvent::StandardErrors { iteration, standard_errors } => {
                self.amend("iterations", &iteration.to_string(), "errors", json!(standard_errors));
            }
            FitEvent::HeldOut { photos } => {
                if stage.is_empty() {
                    self.set("phase", format!("Scoring {photos} held out"));
                }
            }
            FitEvent::Finished { .. } => {}
        }
    }

    /// Shows a fit's result.
    pub(super) fn result(&self, result: &FitResult) {
        self.set(
            "result",
            json!({
                "converged": result.converged,
                "iterations": result.iterations,
                "seconds": result.seconds,
                "reduced_chi_square": result.fit.reduced_chi_square,
                "held_out": result.held_out.map(|score| score.reduced_chi_square),
                "parameters": result.parameters,
                "warnings": result.warnings,
            }),
        );
    }
}
