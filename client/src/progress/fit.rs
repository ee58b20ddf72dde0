//! A fit's events, as they appear on the console.

use super::{Console, count, metric, plural};
use gonio_fit::{FitEvent, Iteration};

/// Values of one iteration that fit on a line.
const SHOWN: usize = 12;

/// Shows a fit's events on a console.
pub struct FitConsole<'c> {
    console: &'c mut Console,
    iteration: u32,
    held_out: bool,
    /// Whether the bar stands for the evaluation under way.
    evaluating: bool,
}

impl<'c> FitConsole<'c> {
    /// Shows on `console`.
    pub fn new(console: &'c mut Console) -> Self {
        Self { console, iteration: 0, held_out: false, evaluating: false }
    }

    /// Shows one event.
    pub fn show(&mut self, event: &FitEvent) {
        match event {
            FitEvent::Started { solver, parameters, start, fit_photos, held_out_photos, resumed } => {
                let again = if *resumed { ", resumed" } else { "" };
                self.console.line(&format!(
                    "fitting {} to {} by {solver}{again}; {held_out_photos} held out",
                    plural(parameters.len(), "parameter"),
                    plural(*fit_photos, "photo")
                ));
                let names: Vec<_> =
                    parameters.iter().zip(start).map(|(n, v)| format!("  {n} = {}", short(*v))).collect();
                self.console.line(&names.join("\n"));
            }
            FitEvent::EvaluationProgress(progress) => {
                if !self.evaluating {
                    let label =
                        if self.held_out { "held out".to_owned() } else { format!("iteration {}", self.iteration + 1) };
                    self.console.begin(&label);
                }
                self.evaluating = progress.tasks == 0 || progress.tasks_done < progress.tasks;
                self.console.advance(progress.tasks_done, progress.tasks, progress);
                return;
            }
            FitEvent::IterationDone(iteration) => {
                self.iteration = iteration.iteration;
                self.console.line(&line(iteration));
            }
            FitEvent::StandardErrors { .. } => {}
            FitEvent::HeldOut { photos } => {
                self.held_out = true;
                self.console.line(&format!("scoring {photos} held out"));
            }
            FitEvent::Finished { iterations, primary_samples, seconds, .. } => {
                let samples = metric(count(*primary_samples));
                self.console.line(&format!("{iterations} iterations, {samples} samples, {seconds:.1} s"));
            }
        }
        self.evaluating = false;
        self.console.event(event);
    }
}

fn line(i: &Iteration) -> String {
    let values: Vec<String> = i.parameters.iter().take(SHOWN).map(|v| short(*v)).collect();
    let more = if i.parameters.len() > SHOWN { " ..." } else { "" };
    let refused = if i.accepted || i.iteration == 1 { "" } else { " (refused)" };
    format!(
        "{:4}  {:5} spp  loss {:.4} ± {:.4}  step {:.1e}{refused}  [{}{more}]",
        i.iteration,
        i.samples,
        i.loss,
        i.standard_error,
        i.step,
        values.join(" ")
    )
}

/// A value with five digits.
fn short(x: f64) -> String {
    if x == 0.0 || (1e-3..1e5).contains(&x.abs()) { format!("{x:.5}") } else { format!("{x:.4e}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_iteration_is_one_line() {
        let i = Iteration {
            iteration: 3,
            samples: 16,
            loss: 1.25,
            standard_error: 0.01,
            step: 0.5,
            accepted: true,
            parameters: vec![0.25; 20],
        };
        let text = line(&i);
        assert!(text.starts_with("   3     16 spp  loss 1.2500 ± 0.0100  step 5.0e-1  [0.25000 "), "{text}");
        assert!(text.ends_with("0.25000 ...]") && !text.contains('\n'), "{text}");
    }
}
