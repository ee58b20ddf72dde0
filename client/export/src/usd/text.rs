//! Values as USD writes them.

use crate::matrix::{Matrix, columns};

/// A matrix: USD's points are rows, so its rows are a capture's columns.
pub fn matrix(m: &Matrix) -> String {
    let c = columns(m);
    let row = |i: usize| format!("({}, {}, {}, {})", c[4 * i], c[4 * i + 1], c[4 * i + 2], c[4 * i + 3]);
    format!("( {}, {}, {}, {} )", row(0), row(1), row(2), row(3))
}

/// Three numbers.
pub fn triple<T: std::fmt::Display>([a, b, c]: [T; 3]) -> String {
    format!("({a}, {b}, {c})")
}

/// A list of triples.
pub fn triples(values: &[[f32; 3]]) -> String {
    format!("[{}]", values.iter().map(|v| triple(*v)).collect::<Vec<_>>().join(", "))
}

/// A list of pairs.
pub fn pairs(values: &[[f32; 2]]) -> String {
    format!("[{}]", values.iter().map(|[a, b]| format!("({a}, {b})")).collect::<Vec<_>>().join(", "))
}

/// Text in quotes.
pub fn quoted(text: &str) -> String {
    format!("\"{}\"", text.replace('\\', "\\\\").replace('"', "\\\""))
}
