//! Tables as text.

use super::Column;
use std::fmt::Write;

/// Header and rows.
pub(super) fn write(columns: &[(String, Column)]) -> Vec<u8> {
    let mut text = columns.iter().map(|(name, _)| quoted(name)).collect::<Vec<_>>().join(",");
    text.push('\n');
    let rows = columns.first().map_or(0, |(_, column)| match column {
        Column::Whole(values) => values.len(),
        Column::Number(values) => values.len(),
        Column::Text(values) => values.len(),
    });
    for row in 0..rows {
        for (i, (_, column)) in columns.iter().enumerate() {
            if i > 0 {
                text.push(',');
            }
            // Writing to a string does not fail.
            let _ = match column {
                Column::Whole(values) => write!(text, "{}", values[row]),
                Column::Number(values) => write!(text, "{}", values[row]),
                Column::Text(values) => write!(text, "{}", quoted(&values[row])),
            };
        }
        text.push('\n');
    }
    text.into_bytes()
}

fn quoted(text: &str) -> String {
    if text.contains([',', '"', '\n', '\r']) { format!("\"{}\"", text.replace('"', "\"\"")) } else { text.to_owned() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_read_back_and_texts_are_quoted_where_they_must() {
        let columns = [
            ("a,b".to_owned(), Column::Number(vec![0.1, 1e-300, -0.0])),
            ("n".to_owned(), Column::Whole(vec![0, 7, u64::MAX])),
            ("t".to_owned(), Column::Text(vec!["x".to_owned(), "say \"no\"".to_owned(), String::new()])),
        ];
        let text = String::from_utf8(write(&columns)).unwrap();
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(lines[0], "\"a,b\",n,t");
        assert_eq!(lines[1], "0.1,0,x");
        assert_eq!(lines[2].split(',').next().unwrap().parse::<f64>().unwrap(), 1e-300);
        assert!(lines[2].ends_with("7,\"say \"\"no\"\"\""));
        assert_eq!(lines[3], "-0,18446744073709551615,");
    }
}
