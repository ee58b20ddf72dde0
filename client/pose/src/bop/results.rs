//! Estimates as a table: `scene_id,im_id,obj_id,score,R,t,time`.

use super::unit::{metres, millimetres};
use crate::Pose;
use gonio_scene::{Result, SceneError};
use std::fmt::Write;

/// The table's first line.
pub const HEADER: &str = "scene_id,im_id,obj_id,score,R,t,time";

/// One pose that an estimator found.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimate {
    /// Number of the scene.
    pub scene: u32,
    /// Number of the image.
    pub image: u32,
    /// Number of the object.
    pub object: u32,
    /// Higher is surer; of no unit.
    pub score: f64,
    /// From the model to the camera.
    pub pose: Pose,
    /// Seconds that the whole image took; `None` where unknown (-1 in the file).
    pub seconds: Option<f64>,
}

/// Reads the table `text`; `file` is named in errors. Blank lines are passed over; so is a missing header.
///
/// # Errors
/// A line with another number of columns, or a value that is none.
pub fn parse_results(file: &str, text: &str) -> Result<Vec<Estimate>> {
    let mut reader = csv::ReaderBuilder::new()
        .has_headers(false)
        .flexible(true)
        .trim(csv::Trim::All)
        .from_reader(text.trim_start_matches('\u{feff}').as_bytes());
    let mut estimates = Vec::new();
    for (index, record) in reader.records().enumerate() {
        let record = record.map_err(|error| {
            SceneError::new(file, format!("is no table: {error}"), "write scene_id,im_id,obj_id,score,R,t,time")
        })?;
        if index == 0 && record.get(0) == Some("scene_id") {
            continue;
        }
        let line = record.position().map_or(0, csv::Position::line);
        estimates.push(estimate(&record).map_err(|(column, problem, mend)| {
            SceneError::new(file, problem, mend).at(format!("line {line}: {column}"))
        })?);
    }
    Ok(estimates)
}

type Refusal = (&'static str, String, &'static str);

fn estimate(record: &csv::StringRecord) -> std::result::Result<Estimate, Refusal> {
    if record.len() != 7 {
        let problem = format!("has {} columns", record.len());
        return Err(("columns", problem, "write scene_id,im_id,obj_id,score,R,t,time"));
    }
    let cell = |index: usize| record.get(index).unwrap_or_default();
    let whole = |index: usize, name: &'static str| {
        cell(index).parse::<u32>().map_err(|_| (name, format!("is {:?}", cell(index)), "write a whole number"))
    };
    let real = |index: usize, name: &'static str| match cell(index).parse::<f64>() {
        Ok(value) if value.is_finite() => Ok(value),
        _ => Err((name, format!("is {:?}", cell(index)), "write a finite number")),
    };
    let rows: [f64; 9] = numbers(cell(4)).ok_or(("R", "is no list".to_owned(), "write nine numbers with spaces"))?;
    let shift: [f64; 3] =
        numbers(cell(5)).ok_or(("t", "is no list".to_owned(), "write three numbers with spaces, in millimetres"))?;
    let pose = Pose::from_rows(&rows, shift.map(metres)).ok_or((
        "R",
        "is no rotation".to_owned(),
        "write a rotation matrix row by row",
    ))?;
    let seconds = real(6, "time")?;
    Ok(Estimate {
        scene: whole(0, "scene_id")?,
        image: whole(1, "im_id")?,
        object: whole(2, "obj_id")?,
        score: real(3, "score")?,
        pose,
        seconds: (seconds >= 0.0).then_some(seconds),
    })
}

/// `N` finite numbers between spaces.
fn numbers<const N: usize>(text: &str) -> Option<[f64; N]> {
    let values: Option<Vec<f64>> =
        text.split_whitespace().map(|word| word.parse().ok().filter(|x: &f64| x.is_finite())).collect();
    values?.try_into().ok()
}

/// The table of `estimates`, in their order.
#[must_use]
pub fn write_results(estimates: &[Estimate]) -> String {
    let mut text = format!("{HEADER}\n");
    for e in estimates {
        let words = |values: &[f64]| values.iter().map(f64::to_string).collect::<Vec<_>>().join(" ");
        let (rows, shift) = (words(&e.pose.rows()), words(&e.pose.translation.to_array().map(millimetres)));
        let (scene, image, object, score, seconds) = (e.scene, e.image, e.object, e.score, e.seconds.unwrap_or(-1.0));
        let _ = writeln!(text, "{scene},{image},{object},{score},{rows},{shift},{seconds}");
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    const ROW: &str = "2,3,5,0.5,1 0 0 0 1 0 0 0 1,10 -20.5 900,1.25";

    #[test]
    fn a_table_survives_reading_and_writing() {
        let read = parse_results("r.csv", &format!("{HEADER}\n{ROW}\n")).unwrap();
        assert_eq!(read[0].pose.translation.to_array(), [0.01, -0.0205, 0.9]);
        assert_eq!((read[0].scene, read[0].image, read[0].object, read[0].seconds), (2, 3, 5, Some(1.25)));
        let again = parse_results("r.csv", &write_results(&read)).unwrap();
        assert!((again[0].pose.translation - read[0].pose.translation).length() < 1e-15);
        assert_eq!(parse_results("r.csv", ROW).unwrap(), read);
    }

    #[test]
    fn a_bad_line_is_named() {
        for (bad, named) in [
            ("2,3,5,x,1 0 0 0 1 0 0 0 1,1 2 3,1", "score"),
            ("2,3,5,1,1 0 0 0 1 0 0 0,1 2 3,1", "R"),
            ("2,3,5,1,1 0 0 0 1 0 0 0 -1,1 2 3,1", "R"),
            ("2,3,5,1,1 0 0 0 1 0 0 0 1,1 nan 3,1", "t"),
            ("-2,3,5,1,1 0 0 0 1 0 0 0 1,1 2 3,1", "scene_id"),
            ("2,3,5,1", "columns"),
        ] {
            let error = parse_results("r.csv", &format!("{HEADER}\n{ROW}\n{bad}\n")).unwrap_err();
            assert_eq!(error.key.as_deref(), Some(format!("line 3: {named}").as_str()), "{error}");
        }
    }
}
