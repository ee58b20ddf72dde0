//! Numbers as programs and people write them into text.

/// The number that `token` stands for: all that Rust reads (`-.12`, `0.`, `1e-3`, `nan`), the not-a-numbers and infinities
/// of older C libraries (`-1.#IND`, `1.#QNAN`, `1.#INF`, `nan(ind)`), and Fortran's exponents (`1.5D-03`). `None` for
/// anything else.
pub(super) fn number(token: &[u8]) -> Option<f64> {
    let text = std::str::from_utf8(token).ok()?;
    if let Ok(value) = text.parse() {
        return Some(value);
    }
    let lower = text.to_ascii_lowercase();
    let (sign, size) = lower.strip_prefix('-').map_or((1.0, lower.trim_start_matches('+')), |size| (-1.0, size));
    if size.starts_with("1.#inf") {
        return Some(sign * f64::INFINITY);
    }
    if size.starts_with("1.#") || (size.starts_with("nan(") && size.ends_with(')')) {
        return Some(f64::NAN);
    }
    lower.replacen('d', "e", 1).parse().ok()
}

/// `bytes` without the mark that says UTF-8, which some editors put before a text.
pub(super) fn without_mark(bytes: &[u8]) -> &[u8] {
    bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes)
}

#[cfg(test)]
mod tests {
    use super::number;

    #[test]
    fn numbers_as_they_are_written() {
        for (text, value) in [
            ("-.12", -0.12),
            ("0.", 0.0),
            ("+3", 3.0),
            ("1.5D-03", 1.5e-3),
            ("-1d2", -100.0),
            ("-1.#INF", -f64::INFINITY),
        ] {
            assert_eq!(number(text.as_bytes()), Some(value), "{text}");
        }
        for text in ["nan", "-NaN", "-1.#IND", "1.#QNAN00", "-nan(ind)", "1.#SNAN"] {
            assert!(number(text.as_bytes()).is_some_and(f64::is_nan), "{text}");
        }
        for text in ["", "x", "1,5", "0x10", "1 2", "d", "--1"] {
            assert_eq!(number(text.as_bytes()), None, "{text}");
        }
    }
}
