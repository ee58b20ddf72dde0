//! What a sweep tells at its end.

use super::{CAPTURE_FILE, SHEET, TABLE, TIMINGS};
use crate::failure::Failure;
use crate::output::{tell, to_json};
use crate::progress::{count, metric, plural};
use serde::Serialize;

/// A sweep's outcome, as `--json` writes it.
#[derive(Serialize)]
pub(super) struct Summary<'a> {
    pub sweep: String,
    pub capture: &'a str,
    pub out: &'a str,
    pub points: usize,
    pub frames: usize,
    /// Frames that show different things: no other is rendered.
    pub distinct: usize,
    /// Distinct frames that were there before.
    pub finished_before: usize,
    pub rendered: usize,
    /// Most bytes that the frames' files have.
    pub bytes_at_most: u64,
    /// In a dry run.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub estimated_seconds: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub seconds: Option<f64>,
}

impl Summary<'_> {
    /// Writes it for programs or for people; `left` camera samples were to be traced.
    ///
    /// # Errors
    /// None that a summary could cause.
    pub fn tell(&self, json: bool, left: u64) -> Result<(), Failure> {
        if json {
            tell(&to_json(self)?);
            return Ok(());
        }
        if let Some(seconds) = self.estimated_seconds {
            tell(&format!(
                "{} from {}, {} different; {} to render, {} there already",
                plural(self.frames, "frame"),
                plural(self.points, "point"),
                self.distinct,
                self.distinct - self.finished_before,
                self.finished_before,
            ));
            let (samples, bytes) = (metric(count(left)), metric(count(self.bytes_at_most)));
            tell(&format!("{samples} samples, about {}; files of at most {bytes}B in all", duration(seconds)));
            return Ok(());
        }
        tell(&format!(
            "rendered {}, {} there before; wrote {}, {TIMINGS}, {}, {CAPTURE_FILE} and frames to {}: {:.1} s",
            plural(self.rendered, "frame"),
            self.finished_before,
            TABLE.join(", "),
            SHEET.join(", "),
            self.out,
            self.seconds.unwrap_or_default(),
        ));
        Ok(())
    }
}

/// A time in the unit that suits it.
fn duration(seconds: f64) -> String {
    let minutes = (seconds / 60.0).round();
    match seconds {
        s if s < 100.0 => format!("{s:.0} s"),
        s if s < 6000.0 => format!("{minutes:.0} min"),
        s => format!("{:.1} h", s / 3600.0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_have_the_unit_that_suits_them() {
        assert_eq!([3.2, 99.0, 100.0, 5400.0, 9000.0].map(duration), ["3 s", "99 s", "2 min", "90 min", "2.5 h"]);
    }
}
