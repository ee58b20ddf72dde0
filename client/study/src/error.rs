//! What is wrong with a study's data.

/// Bad ratings, displayed as one line: `answers.csv: line 7: rating: is "6"; write a whole number from 1 to 5`.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{file}: {place}{problem}; {mend}")]
pub struct StudyError {
    /// The file at fault, as the caller named it.
    pub file: String,
    /// Line and column inside it, each followed by ": "; empty where the whole file is meant.
    pub place: String,
    /// What is wrong there, with the value found.
    pub problem: String,
    /// What to do about it.
    pub mend: String,
}

impl StudyError {
    /// An error about the whole of `file`.
    pub fn new(file: &str, problem: impl Into<String>, mend: impl Into<String>) -> Self {
        Self { file: file.to_owned(), place: String::new(), problem: problem.into(), mend: mend.into() }
    }

    /// The same at a column of a line, counted from 1.
    #[must_use]
    pub fn at(mut self, line: u64, column: &str) -> Self {
        self.place = format!("line {line}: {column}: ");
        self
    }

    /// The same about a column as a whole.
    #[must_use]
    pub fn of(mut self, column: &str) -> Self {
        self.place = format!("{column}: ");
        self
    }
}
