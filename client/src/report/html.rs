//! Text as HTML, and numbers as text.

/// `text` with everything escaped that HTML gives a meaning to, in content and in quoted attributes.
pub(super) fn escape(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            '\'' => out.push_str("&#39;"),
            // Control characters are no HTML text.
            c if c.is_control() && c != '\n' && c != '\t' => out.push('\u{fffd}'),
            c => out.push(c),
        }
    }
    out
}

/// An integer with thin spaces between groups of three digits.
pub(super) fn grouped(n: u64) -> String {
    let digits = n.to_string();
    let mut out = String::new();
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            out.push('\u{202f}');
        }
        out.push(digit);
    }
    out
}

/// A number with so many significant digits, without an exponent where it stays readable.
pub(super) fn significant(x: f64, digits: usize) -> String {
    if !x.is_finite() {
        return "–".to_owned();
    }
    if x == 0.0 {
        return "0".to_owned();
    }
    if !(1e-4..1e6).contains(&x.abs()) {
        return minus(&format!("{x:.*e}", digits.saturating_sub(1)));
    }
    minus(&format!("{x:.*}", decimals(x, digits)))
}

/// An estimate with as many decimals as its error has with two significant digits.
pub(super) fn with_error(value: f64, error: Option<f64>) -> String {
    match error {
        Some(error) if error > 0.0 && (1e-4..1e6).contains(&value.abs()) => {
            minus(&format!("{value:.*}", decimals(error, 2).min(9)))
        }
        _ => significant(value, 5),
    }
}

/// Decimals that show `digits` significant digits of `x`.
fn decimals(x: f64, digits: usize) -> usize {
    let magnitude = x.abs().log10().floor();
    #[allow(clippy::cast_possible_truncation)]
    let places = digits as i64 - 1 - magnitude as i64;
    usize::try_from(places).unwrap_or(0)
}

/// A hyphen as a minus sign.
fn minus(text: &str) -> String {
    text.replace('-', "\u{2212}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_written_for_people() {
        assert_eq!(grouped(1_234_567), "1\u{202f}234\u{202f}567");
        assert_eq!(significant(0.012_345, 3), "0.0123");
        assert_eq!(significant(-1234.6, 3), "\u{2212}1235");
        assert_eq!(significant(1.5e-7, 2), "1.5e\u{2212}7");
        assert_eq!(significant(f64::NAN, 2), "–");
        assert_eq!(with_error(0.412_345, Some(0.001_2)), "0.4123");
        assert_eq!(with_error(0.412_345, None), "0.41235");
    }
}
