//! What a person or a program sees on stderr while a command runs: a bar, plain lines, or JSON events.

mod diagnose;
mod fit;
mod sweep;

pub use diagnose::DiagnoseConsole;
pub use fit::FitConsole;
pub use sweep::SweepConsole;

use crate::output::tell_error;
use gonio_scene::Progress;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use serde::Serialize;
use serde_json::json;
use std::io::IsTerminal;
use std::time::{Duration, Instant};

/// Time between two progress events in JSON: a reader wants no thousand of them per second.
const JSON_INTERVAL: Duration = Duration::from_millis(250);

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Mode {
    /// Standard error is a terminal: a bar, and lines above it.
    Bar,
    /// Standard error is a file or a pipe: lines only.
    Lines,
    /// One JSON object per line.
    Json,
    /// Lines, for the program that this runs in.
    Told,
}

/// Standard error, in the form that its reader wants.
pub struct Console {
    mode: Mode,
    bar: ProgressBar,
    /// When the samples that the rate is about began.
    begun: Instant,
    /// When the last progress event was written.
    written: Option<Instant>,
    /// Who hears lines in place of standard error.
    listener: Option<Listener>,
}

/// Hears a line of progress, without a line break at its end.
type Listener = Box<dyn Fn(&str) + Send>;

impl Console {
    /// The console of a command; `json` as its flag says.
    #[must_use]
    pub fn new(json: bool) -> Self {
        let mode = match (json, std::io::stderr().is_terminal()) {
            (true, _) => Mode::Json,
            (false, true) => Mode::Bar,
            (false, false) => Mode::Lines,
        };
        let target = if mode == Mode::Bar { ProgressDrawTarget::stderr() } else { ProgressDrawTarget::hidden() };
        let bar = ProgressBar::with_draw_target(None, target);
        Self { mode, bar, begun: Instant::now(), written: None, listener: None }
    }

    /// A console that writes nothing and tells `listener` each line that a command would write to a file on standard error.
    #[must_use]
    pub fn telling(listener: impl Fn(&str) + Send + 'static) -> Self {
        let listener: Listener = Box::new(listener);
        let mut console = Self::new(true);
        (console.mode, console.listener) = (Mode::Told, Some(listener));
        console
    }

    /// Begins a piece of work under a `label`; the bar starts at zero.
    pub fn begin(&mut self, label: &str) {
        self.begun = Instant::now();
        if self.mode == Mode::Bar {
            let template = "{prefix} [{bar:28}] {percent:>3} %  {msg}  {eta} left";
            if let Ok(style) = ProgressStyle::with_template(template) {
                self.bar.set_style(style.progress_chars("=> "));
            }
            self.bar.reset();
            self.bar.set_prefix(label.to_owned());
        }
    }

    /// Shows that `position` of `length` parts of the current work are done, and what an evaluation says of itself.
    pub fn advance(&mut self, position: u64, length: u64, progress: &Progress) {
        let message = self.message(progress);
        let rate = self.rate(progress);
        self.show(position, length, &message, || {
            json!({
                "event": "progress",
                "tasks_done": progress.tasks_done,
                "tasks": progress.tasks,
                "primary_samples": progress.primary_samples,
                "samples_per_second": rate,
                "loss": progress.loss,
                "loss_standard_error": progress.loss_standard_error,
                "workers": progress.workers,
            })
        });
    }

    /// Shows that `position` of `length` parts of the current work are done: by a `message` beside the bar, or an `event`,
    /// which is made only if it is time for one.
    pub fn show(&mut self, position: u64, length: u64, message: &str, event: impl FnOnce() -> serde_json::Value) {
        match self.mode {
            Mode::Lines | Mode::Told => {}
            Mode::Bar => {
                self.bar.set_length(length);
                self.bar.set_position(position);
                self.bar.set_message(message.to_owned());
            }
            Mode::Json => {
                if self.written.is_none_or(|last| last.elapsed() >= JSON_INTERVAL) {
                    self.written = Some(Instant::now());
                    tell_error(&event().to_string());
                }
            }
        }
    }

    /// Removes the bar: what follows is the result.
    pub fn end(&self) {
        self.bar.finish_and_clear();
    }

    /// Writes a line for people.
    pub fn line(&self, text: &str) {
        match self.mode {
            Mode::Bar => self.bar.suspend(|| tell_error(text)),
            Mode::Lines => tell_error(text),
            Mode::Json => {}
            Mode::Told => self.listener.iter().for_each(|listener| listener(text)),
        }
    }

    /// Writes a line for people who see no bar.
    pub fn plain(&self, text: &str) {
        if matches!(self.mode, Mode::Lines | Mode::Told) {
            self.line(text);
        }
    }

    /// Writes what people and programs should know, though the work goes on.
    pub fn warn(&self, text: &str) {
        self.line(&format!("warning: {text}"));
        self.event(&json!({ "event": "warning", "message": text }));
    }

    /// Writes an event for programs.
    pub fn event(&self, event: &impl Serialize) {
        if self.mode == Mode::Json
            && let Ok(text) = serde_json::to_string(event)
        {
            tell_error(&text);
        }
    }

    fn rate(&self, progress: &Progress) -> f64 {
        let seconds = self.begun.elapsed().as_secs_f64();
        if seconds > 0.0 { count(progress.primary_samples) / seconds } else { 0.0 }
    }

    fn message(&self, progress: &Progress) -> String {
        let mut text = format!("{} samples/s", metric(self.rate(progress)));
        if progress.loss != 0.0 {
            text += &format!("  debiased loss {:.4} ± {:.4}", progress.loss, progress.loss_standard_error);
        }
        if progress.tasks > 0 && progress.workers != 1 {
            text += &format!("  {} workers", progress.workers);
        }
        text
    }
}

impl Drop for Console {
    /// No half bar stays before an error's message.
    fn drop(&mut self) {
        self.end();
    }
}

/// A count as a float, for rates and means.
pub fn count(n: u64) -> f64 {
    // Above 2^53 the last digit goes, which no rate shows.
    #[allow(clippy::cast_precision_loss)]
    let float = n as f64;
    float
}

/// "1 photo", "2 photos".
pub fn plural(n: usize, noun: &str) -> String {
    format!("{n} {noun}{}", if n == 1 { "" } else { "s" })
}

/// A quantity with three digits and a prefix of the SI.
pub fn metric(x: f64) -> String {
    let scales = [(1e12, " T"), (1e9, " G"), (1e6, " M"), (1e3, " k")];
    match scales.iter().find(|(scale, _)| x.abs() >= *scale) {
        Some((scale, prefix)) => format!("{:.*}{prefix}", if x / scale >= 100.0 { 0 } else { 2 }, x / scale),
        None => format!("{x:.0} "),
    }
    .trim_end()
    .to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantities_are_short() {
        assert_eq!(metric(0.0), "0");
        assert_eq!(metric(999.0), "999");
        assert_eq!(metric(1_234_000.0), "1.23 M");
        assert_eq!(metric(456e9), "456 G");
    }
}
