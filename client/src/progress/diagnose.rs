//! A diagnosis' events, as they appear on the console.

use super::Console;
use gonio_diagnose::DiagnoseEvent;
use gonio_fit::FitEvent;
use gonio_scene::Progress;

/// Effects that a ranking's line names.
const SHOWN: usize = 6;

/// Shows a diagnosis' events on a console.
pub struct DiagnoseConsole<'c> {
    console: &'c mut Console,
    stage: String,
    /// Whether the bar stands for the evaluation under way.
    evaluating: bool,
}

impl<'c> DiagnoseConsole<'c> {
    /// Shows on `console`.
    pub fn new(console: &'c mut Console) -> Self {
        Self { console, stage: String::new(), evaluating: false }
    }

    /// Shows one event.
    pub fn show(&mut self, event: &DiagnoseEvent) {
        match event {
            DiagnoseEvent::Stage { text } => {
                self.stage.clone_from(text);
                self.console.line(text);
            }
            DiagnoseEvent::EvaluationProgress { tasks_done, tasks, primary_samples } => {
                let progress = Progress {
                    tasks_done: *tasks_done,
                    tasks: *tasks,
                    primary_samples: *primary_samples,
                    ..Progress::default()
                };
                return self.advance(&progress);
            }
            DiagnoseEvent::Fit { fit: FitEvent::EvaluationProgress(progress) } => return self.advance(progress),
            DiagnoseEvent::Fit { fit: FitEvent::Finished { iterations, .. } } => {
                self.console.line(&format!("  {iterations} iterations"));
            }
            DiagnoseEvent::Fit { .. } => {}
            DiagnoseEvent::Ranked { ranking, reduced_chi_square } => {
                let best: Vec<String> =
                    ranking.iter().take(SHOWN).map(|(name, gain)| format!("{name} {gain:.4}")).collect();
                self.console.line(&format!("  chi-square {reduced_chi_square:.4}; promise: {}", best.join(", ")));
            }
            DiagnoseEvent::Refitted { effect, gain, standard_error, reduced_chi_square } => {
                self.console.line(&format!("  {effect} gains {gain:.4} ± {standard_error:.4} per observation, reduced chi-square {reduced_chi_square:.4}"));
            }
            DiagnoseEvent::Extended { effect } => self.console.line(&format!("  the model now has {effect}")),
        }
        self.evaluating = false;
        self.console.event(event);
    }

    fn advance(&mut self, progress: &Progress) {
        if !self.evaluating {
            self.console.begin(&self.stage);
        }
        self.evaluating = progress.tasks == 0 || progress.tasks_done < progress.tasks;
        self.console.advance(progress.tasks_done, progress.tasks, progress);
    }
}
