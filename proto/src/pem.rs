//! PEM files, as far as both ends of a connection must know them.

/// Whether a file holds a block of this kind, such as `CERTIFICATE`; `PRIVATE KEY` has kinds of its own (`EC PRIVATE KEY`).
#[must_use]
pub fn holds(file: &[u8], kind: &str) -> bool {
    let end = format!("{kind}-----");
    file.split(|byte| *byte == b'\n').any(|line| {
        let line = String::from_utf8_lossy(line);
        line.starts_with("-----BEGIN ") && line.trim_end().ends_with(&end)
    })
}

#[cfg(test)]
mod tests {
    use super::holds;

    #[test]
    fn blocks_are_told_apart() {
        let key = b"text\n-----BEGIN EC PRIVATE KEY-----\r\nAAAA\n-----END EC PRIVATE KEY-----\n";
        assert!(holds(key, "PRIVATE KEY") && !holds(key, "CERTIFICATE"));
        assert!(!holds(b"-----END CERTIFICATE-----", "CERTIFICATE") && !holds(b"\xff\xfe", "CERTIFICATE"));
    }
}
