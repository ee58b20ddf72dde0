//! The file of answers as it grows: one line each, appended.

use crate::Rating;

/// The first line of a file of answers.
pub const HEADER: &str = "observer,image,truth,rating\n";

/// An answer as a line of the file, its end included.
///
/// Names must hold no line breaks: what lies between two of them is one answer, or what a kill left of one.
#[must_use]
pub fn line(rating: &Rating) -> String {
    let quoted = |text: &str| {
        let plain = !text.contains(['"', ',']) && text.trim() == text;
        if plain { text.to_owned() } else { format!("\"{}\"", text.replace('"', "\"\"")) }
    };
    let Rating { observer, image, truth, rating } = rating;
    format!("{},{},{},{rating}\n", quoted(observer), quoted(image), truth.word())
}

/// Bytes of `file` up to the last line break: what follows was being written when the process was killed, and was never
/// confirmed to whoever gave it.
#[must_use]
pub fn whole_lines(file: &[u8]) -> usize {
    file.iter().rposition(|&byte| byte == b'\n').map_or(0, |last| last + 1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Ratings, Truth};

    #[test]
    fn lines_read_back_and_torn_ones_are_dropped() {
        let rows: Vec<_> = ["plain", "with, comma", "with \"quotes\""]
            .map(|name| Rating { observer: name.into(), image: name.into(), truth: Truth::Real, rating: 2 })
            .into();
        let mut text = HEADER.to_owned();
        rows.iter().for_each(|row| text += &line(row));
        let whole = text.len();
        text += "torn,im";
        assert_eq!(whole_lines(text.as_bytes()), whole);
        assert_eq!(Ratings::parse("f", &text[..whole]).unwrap().rows, rows);
        assert_eq!(whole_lines(b"observer,im"), 0);
    }
}
