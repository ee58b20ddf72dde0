//! A sweep's progress, as it appears on the console.

use super::{Console, count, metric};
use crate::watch::Watch;
use serde_json::json;
use std::time::Instant;

/// Shows on a console, and on a page, how a sweep gets on.
pub struct SweepConsole<'c> {
    console: &'c mut Console,
    watch: &'c Watch,
    begun: Instant,
    /// Frames to render.
    frames: usize,
    /// Camera samples of all of them.
    samples: u64,
    rendered: usize,
    /// Tenths of the frames that lines have told of.
    told: usize,
}

impl<'c> SweepConsole<'c> {
    /// Shows on `console` and `watch` how `frames` of `samples` camera samples in all are rendered.
    pub fn new(console: &'c mut Console, watch: &'c Watch, frames: usize, samples: u64) -> Self {
        console.begin("sweep");
        Self { console, watch, begun: Instant::now(), frames, samples, rendered: 0, told: 0 }
    }

    /// A frame is finished.
    pub fn rendered(&mut self, frame: usize, digest: &str) {
        self.rendered += 1;
        self.console.event(&json!({ "event": "frame", "frame": frame, "digest": digest }));
        let tenths = 10 * self.rendered / self.frames.max(1);
        if tenths > self.told {
            self.told = tenths;
            self.console.plain(&format!("{} of {} frames, {:.1} frames/s", self.rendered, self.frames, self.rate()));
        }
    }

    /// `samples` camera samples are traced, those of frames under way included.
    pub fn advance(&mut self, samples: u64) {
        let (rate, seconds) = (self.rate(), self.begun.elapsed().as_secs_f64());
        let samples_per_second = if seconds > 0.0 { count(samples) / seconds } else { 0.0 };
        let left = if samples_per_second > 0.0 {
            Some(count(self.samples.saturating_sub(samples)) / samples_per_second)
        } else {
            None
        };
        let message =
            format!("{}/{}  {rate:.1} frames/s  {} samples/s", self.rendered, self.frames, metric(samples_per_second));
        let (rendered, frames) = (self.rendered, self.frames);
        self.watch.frames(rendered, frames, samples_per_second, left);
        self.console.show(samples, self.samples, &message, || {
            json!({
                "event": "progress",
                "frames_done": rendered,
                "frames": frames,
                "primary_samples": samples,
                "frames_per_second": rate,
                "samples_per_second": samples_per_second,
                "seconds_left": left,
            })
        });
    }

    /// Something that people and programs should know.
    pub fn warn(&mut self, text: &str) {
        self.console.warn(text);
    }

    fn rate(&self) -> f64 {
        let seconds = self.begun.elapsed().as_secs_f64();
        if seconds > 0.0 { count(self.rendered as u64) / seconds } else { 0.0 }
    }
}
