//! Named sets of the command line.

use std::path::PathBuf;
use std::str::FromStr;

/// `NAME=DATASET[,RESULTS.csv]`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Contrast {
    /// Letters, digits, `-`, `_`, `.`: files are called by it.
    pub name: String,
    /// A BOP dataset.
    pub dataset: PathBuf,
    /// Its estimates, if they are there.
    pub results: Option<PathBuf>,
}

/// `NAME=REAL.csv,SYNTHETIC.csv`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Setting {
    /// As of a contrast.
    pub name: String,
    /// Estimates on the real images.
    pub real: PathBuf,
    /// Estimates on the synthetic images.
    pub synthetic: PathBuf,
}

/// What stands before and behind the first `=`.
fn named(text: &str) -> Result<(String, &str), String> {
    let (name, rest) = text.split_once('=').ok_or("write NAME=...")?;
    let plain = |c: char| c.is_ascii_alphanumeric() || "-_.".contains(c);
    if name.is_empty() || name.starts_with('.') || !name.chars().all(plain) {
        return Err(format!("{name:?} is no name: use letters, digits, - and _"));
    }
    Ok((name.to_owned(), rest))
}

impl FromStr for Contrast {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (name, rest) = named(text)?;
        let (dataset, results) = match rest.split_once(',') {
            Some((dataset, results)) => (dataset, Some(PathBuf::from(results))),
            None => (rest, None),
        };
        if dataset.is_empty() {
            return Err("name a dataset behind the =".to_owned());
        }
        Ok(Self { name, dataset: dataset.into(), results })
    }
}

impl FromStr for Setting {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (name, rest) = named(text)?;
        let (real, synthetic) = rest.split_once(',').ok_or("name two files behind the =: REAL.csv,SYNTHETIC.csv")?;
        Ok(Self { name, real: real.into(), synthetic: synthetic.into() })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_and_paths_are_taken_apart() {
        let contrast: Contrast = "base=out/base,b.csv".parse().unwrap();
        assert_eq!((contrast.name.as_str(), contrast.results), ("base", Some("b.csv".into())));
        assert_eq!("base=a=b".parse::<Contrast>().unwrap().dataset, PathBuf::from("a=b"));
        for bad in ["base", "=x", "../x=y", "a b=c", "a="] {
            assert!(bad.parse::<Contrast>().is_err(), "{bad}");
        }
        assert!("a=b".parse::<Setting>().is_err());
    }
}
