//! Lists of points: a CSV file whose header names numbers, with one point in each line below.

use super::axis::numbers_of;
use crate::MOST_FRAMES;
use crate::points::Points;
use gonio_scene::capture::Range;
use gonio_scene::files::Files;
use gonio_scene::{Capture, Result, SceneError};

/// Reads the points of the file `path`. Empty lines and those that begin with `#` are passed over; a name or number may
/// stand in double quotes.
pub(super) fn read(path: &str, capture: &Capture, files: &dyn Files) -> Result<Points> {
    let refuse = |problem: String, mend: &str| SceneError::new(path, problem, mend);
    let bytes = files.read(path)?;
    let text = std::str::from_utf8(&bytes).map_err(|e| refuse(format!("is not UTF-8 ({e})"), "save it as UTF-8"))?;
    let text = text.trim_start_matches('\u{feff}');
    let filled = |(_, line): &(usize, &str)| !line.trim().is_empty() && !line.trim_start().starts_with('#');
    let mut lines = text.lines().enumerate().map(|(i, line)| (i + 1, line)).filter(filled);
    let header = "write dotted names, such as material.shell.roughness,light.led.intensity";
    let (number, line) = lines.next().ok_or_else(|| refuse("is empty".to_owned(), header))?;
    let columns: Vec<Vec<(String, Range)>> = cells(line)
        .into_iter()
        .map(|name| numbers_of(capture, name).map_err(|e| e.of(path, &format!("line {number}"))))
        .collect::<Result<_>>()?;
    let mut rows = Vec::new();
    for (number, line) in lines {
        let at = |problem: String, mend: &str| refuse(problem, mend).at(format!("line {number}"));
        let cells = cells(line);
        if cells.len() != columns.len() {
            let problem = format!("has {} columns, the header {}", cells.len(), columns.len());
            return Err(at(problem, "write one number for each column"));
        }
        let mut row = Vec::new();
        for (cell, column) in cells.iter().zip(&columns) {
            let value: Option<f64> = cell.parse().ok().filter(|value: &f64| value.is_finite());
            let value = value.ok_or_else(|| {
                at(format!("has \"{cell}\", which is no finite number"), "mend the line or remove it")
            })?;
            for (name, range) in column {
                if !range.holds(value) {
                    return Err(at(format!("sets {name} to {value}"), &format!("it must be {range}")));
                }
                row.push(value);
            }
        }
        rows.push(row);
        if rows.len() as u64 > MOST_FRAMES {
            return Err(refuse(format!("has more than {MOST_FRAMES} points"), "split the file"));
        }
    }
    if rows.is_empty() {
        return Err(refuse("has no point".to_owned(), "write at least one line below the header"));
    }
    Ok(Points { names: columns.into_iter().flatten().map(|(name, _)| name).collect(), rows })
}

fn cells(line: &str) -> Vec<&str> {
    let bare = |cell: &str| cell.len() > 1 && cell.starts_with('"') && cell.ends_with('"');
    line.split(',').map(str::trim).map(|cell| if bare(cell) { &cell[1..cell.len() - 1] } else { cell }).collect()
}
