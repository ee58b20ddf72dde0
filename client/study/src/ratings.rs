//! The table of answers: `observer,image,truth,rating`.

use crate::{LEVELS, StudyError};
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};

/// What an image is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Truth {
    /// A photograph: the noise of detection theory.
    Real,
    /// A rendered image: its signal.
    Synthetic,
}

impl Truth {
    /// The word in the table.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Self::Real => "real",
            Self::Synthetic => "synthetic",
        }
    }

    /// The truth that a word names.
    #[must_use]
    pub fn parse(word: &str) -> Option<Self> {
        [Self::Real, Self::Synthetic].into_iter().find(|truth| truth.word() == word)
    }
}

/// One answer.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Rating {
    /// Who gave it.
    pub observer: String,
    /// The image's name.
    pub image: String,
    /// What the image is.
    pub truth: Truth,
    /// 1 ("definitely real") to 5 ("definitely synthetic").
    pub rating: u8,
}

/// All answers of a study.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Ratings {
    /// In the file's order.
    pub rows: Vec<Rating>,
}

const COLUMNS: [&str; 4] = ["observer", "image", "truth", "rating"];

impl Ratings {
    /// Reads a table with a header; further columns are passed over, so that a study may keep more.
    ///
    /// # Errors
    /// A missing column, an empty name, a truth or rating that is none, an image with two truths; errors name `file`, the
    /// line and the column.
    pub fn parse(file: &str, text: &str) -> Result<Self, StudyError> {
        let mut reader = csv::ReaderBuilder::new().trim(csv::Trim::All).from_reader(text.as_bytes());
        let malformed = |error: &csv::Error| {
            StudyError::new(file, format!("is no table: {error}"), "write one line of comma-separated values an answer")
        };
        let header = reader.headers().map_err(|error| malformed(&error))?.clone();
        let mut places = [0; 4];
        for (place, column) in places.iter_mut().zip(COLUMNS) {
            // A byte order mark is what a spreadsheet writes before the first name.
            *place = header.iter().position(|name| name.trim_start_matches('\u{feff}') == column).ok_or_else(|| {
                let found = header.iter().collect::<Vec<_>>().join(",");
                let problem = format!("is not among the columns ({found})");
                StudyError::new(file, problem, format!("begin with the line {}", COLUMNS.join(","))).of(column)
            })?;
        }
        let mut rows = Vec::new();
        for record in reader.records() {
            let record = record.map_err(|error| malformed(&error))?;
            let line = record.position().map_or(0, csv::Position::line);
            let [observer, image, truth, rating] = places.map(|place| record.get(place).unwrap_or_default());
            for (column, value) in [("observer", observer), ("image", image)] {
                if value.is_empty() {
                    return Err(StudyError::new(file, "is empty", "write a name").at(line, column));
                }
            }
            let truth = Truth::parse(truth).ok_or_else(|| {
                StudyError::new(file, format!("is \"{truth}\""), "write real or synthetic").at(line, "truth")
            })?;
            let rating = rating.parse().ok().filter(|rating| (1..=LEVELS as u8).contains(rating)).ok_or_else(|| {
                let mend = format!("write a whole number from 1 (definitely real) to {LEVELS} (definitely synthetic)");
                StudyError::new(file, format!("is \"{rating}\""), mend).at(line, "rating")
            })?;
            rows.push(Rating { observer: observer.to_owned(), image: image.to_owned(), truth, rating });
        }
        let ratings = Self { rows };
        ratings.check(file)?;
        Ok(ratings)
    }

    /// Every observer once, sorted by name.
    #[must_use]
    pub fn observers(&self) -> Vec<&str> {
        self.rows.iter().map(|row| row.observer.as_str()).collect::<BTreeSet<_>>().into_iter().collect()
    }

    fn check(&self, file: &str) -> Result<(), StudyError> {
        let mut truths = BTreeMap::new();
        for row in &self.rows {
            if *truths.entry(row.image.as_str()).or_insert(row.truth) != row.truth {
                let problem = format!("is both real and synthetic for the image \"{}\"", row.image);
                return Err(StudyError::new(file, problem, "correct it, or rename one of the images").of("truth"));
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reads_columns_by_name_in_any_order() {
        let text = "\u{feff}rating,truth,extra,image,observer\n5, synthetic ,x,\"a,b.png\",Ann\n";
        let ratings = Ratings::parse("r.csv", text).unwrap();
        let row = Rating { observer: "Ann".into(), image: "a,b.png".into(), truth: Truth::Synthetic, rating: 5 };
        assert_eq!(ratings.rows, [row]);
    }

    #[test]
    fn every_mistake_names_file_line_and_column() {
        let head = "observer,image,truth,rating\n";
        for (text, says) in [
            ("observer,image,rating\n", "r.csv: truth: is not among the columns"),
            (&format!("{head}a,x,real,6\n"), "r.csv: line 2: rating: is \"6\""),
            (&format!("{head}a,x,real,3\na,y,real,\n"), "r.csv: line 3: rating: is \"\""),
            (&format!("{head}a,x,fake,3\n"), "r.csv: line 2: truth: is \"fake\""),
            (&format!("{head},x,real,3\n"), "r.csv: line 2: observer: is empty"),
            (&format!("{head}a,x,real\n"), "r.csv: is no table"),
            (&format!("{head}a,x,real,3\nb,x,synthetic,3\n"), "r.csv: truth: is both real and synthetic"),
        ] {
            let error = Ratings::parse("r.csv", text).unwrap_err().to_string();
            assert!(error.starts_with(says), "{error}");
            assert_eq!(error.lines().count(), 1, "{error}");
        }
    }
}
