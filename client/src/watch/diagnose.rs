//! A diagnosis' events and verdict on the page.

use super::Watch;
use super::board::Board;
use gonio_diagnose::{DiagnoseEvent, Diagnosis, Verdict};
use gonio_scene::Progress;
use serde_json::{Map, Value, json};

impl Watch {
    /// Shows one event of a diagnosis.
    pub fn diagnose(&self, event: &DiagnoseEvent) {
        if let Some(board) = self.board() {
            board.diagnose(event);
        }
    }

    /// Shows what a diagnosis has come to, and the numbers of its last model.
    pub fn diagnosis(&self, diagnosis: &Diagnosis) {
        let Some(board) = self.board() else { return };
        let (text, more) = verdict(diagnosis);
        board.set("verdict", json!({ "text": text, "more": more }));
        board.set("names", diagnosis.last.parameters.iter().map(|p| p.name.clone()).collect::<Vec<_>>());
        board.result(&diagnosis.last);
    }
}

impl Board {
    fn diagnose(&self, event: &DiagnoseEvent) {
        match event {
            DiagnoseEvent::Stage { text } => self.set("phase", text.clone()),
            DiagnoseEvent::Fit { fit } => self.fit(fit, "Fit"),
            DiagnoseEvent::EvaluationProgress { tasks_done, tasks, primary_samples } => {
                let progress = Progress {
                    tasks_done: *tasks_done,
                    tasks: *tasks,
                    primary_samples: *primary_samples,
                    ..Progress::default()
                };
                self.advance("Evaluation", &progress);
            }
            DiagnoseEvent::Ranked { ranking, reduced_chi_square } => {
                let ranked: Map<String, Value> = (0..)
                    .zip(ranking)
                    .map(|(i, (effect, gain)): (u32, _)| (i.to_string(), json!({ "effect": effect, "gain": gain })))
                    .collect();
                // All of them: the effects that an earlier ranking has and this has not are gone.
                self.set("ranking", ranked);
                self.set("ranked_at", *reduced_chi_square);
            }
            DiagnoseEvent::Refitted { effect, gain, standard_error, reduced_chi_square } => self.put(
                "tried",
                effect,
                json!({
                    "effect": effect, "gain": gain, "standard_error": standard_error, "chi_square": reduced_chi_square,
                }),
            ),
            DiagnoseEvent::Extended { effect } => self.amend("tried", effect, "added", true.into()),
        }
    }
}

fn verdict(diagnosis: &Diagnosis) -> (String, Vec<String>) {
    let mut more: Vec<String> = diagnosis.found.iter().map(|f| format!("To be sure: {}", f.separate_by)).collect();
    if let Some(held) = diagnosis.found.first().and_then(|found| found.held_out) {
        more.push(format!(
            "Held out: reduced chi-square {:.4} before, {:.4} after.",
            held.reduced_chi_square_before, held.reduced_chi_square_after
        ));
    }
    if let Some(left) = &diagnosis.unexplained {
        more.push(format!(
            "Left: {} predicts {:.1} % of the residuals' variance.",
            left.covariate,
            100.0 * left.strength
        ));
    }
    let text = match diagnosis.verdict {
        Verdict::None => "None: what is left looks like noise.".to_owned(),
        Verdict::Unexplained => "Unexplained: something is left that no effect of the catalogue explains.".to_owned(),
        Verdict::Named => {
            let found: Vec<String> = diagnosis.found.iter().map(|found| found.effects.join(" or ")).collect();
            format!("Found: {}.", found.join("; "))
        }
    };
    (text, more)
}
