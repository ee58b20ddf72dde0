//! Bearer tokens: random secrets of which the coordinator keeps SHA-256 digests alone.

use super::{Roles, SecurityError, read};
use base64::Engine;
use base64::engine::general_purpose::URL_SAFE_NO_PAD;
use sha2::{Digest, Sha256};
use std::collections::HashMap;
use std::path::Path;

/// How a token begins, so that scanners of leaked secrets know it.
const PREFIX: &str = "gonio_";
/// The option that names the file.
const OPTION: &str = "--tokens";

/// Who holds which roles, by the digests of their tokens.
///
/// The file has a line for each token: a name, roles with commas between, and the SHA-256 digest of the token in
/// hexadecimal digits; `#` starts a comment. A digest is enough to recognise a token of 256 random bits and useless to make
/// one, so that neither the file nor the time that a search in it takes tells anything.
#[derive(Debug, Default)]
pub struct Tokens(HashMap<[u8; 32], Grant>);

/// What a token grants.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Grant {
    /// Whose token it is, for logs.
    pub name: String,
    /// What it may be used for.
    pub roles: Roles,
}

impl Tokens {
    /// Reads a file of tokens.
    ///
    /// # Errors
    /// The file cannot be read, holds a line of another form, or no token.
    pub fn read(path: &Path) -> Result<Self, SecurityError> {
        let refuse =
            |problem: String, mend| SecurityError::Content { option: OPTION, path: path.to_owned(), problem, mend };
        let text = String::from_utf8(read(OPTION, path)?)
            .map_err(|_| refuse("is no text".to_owned(), "name a file that `gonio-coordinator token` wrote"))?;
        let mut tokens = HashMap::new();
        for (i, line) in text.lines().enumerate() {
            let line = line.split('#').next().unwrap_or_default().trim();
            if line.is_empty() {
                continue;
            }
            let (digest, grant) = entry(line).map_err(|problem| {
                refuse(
                    format!("line {}: {problem}", i + 1),
                    "write NAME ROLES SHA256, as `gonio-coordinator token` does",
                )
            })?;
            if tokens.insert(digest, grant).is_some() {
                return Err(refuse(
                    format!("line {}: the same token again", i + 1),
                    "give a token its roles on one line",
                ));
            }
        }
        if tokens.is_empty() {
            return Err(refuse("holds no token".to_owned(), "add some with `gonio-coordinator token`"));
        }
        Ok(Self(tokens))
    }

    /// What a token grants; nothing where it is unknown.
    #[must_use]
    pub fn grant(&self, token: &str) -> Option<&Grant> {
        self.0.get(&digest(token))
    }
}

/// A new token, and the line of the file that grants it `roles`.
///
/// # Errors
/// The system gives no random numbers.
pub fn fresh(name: &str, roles: Roles) -> Result<(String, String), SecurityError> {
    let mut secret = [0; 32];
    getrandom::fill(&mut secret).map_err(|error| SecurityError::Random(error.to_string()))?;
    let token = format!("{PREFIX}{}", URL_SAFE_NO_PAD.encode(secret));
    let digits: String = digest(&token).iter().map(|byte| format!("{byte:02x}")).collect();
    Ok((token, format!("{name} {roles} {digits}\n")))
}

fn digest(token: &str) -> [u8; 32] {
    Sha256::digest(token.as_bytes()).into()
}

fn entry(line: &str) -> Result<([u8; 32], Grant), String> {
    let words: Vec<&str> = line.split_whitespace().collect();
    let [name, roles, digits] = words[..] else { return Err(format!("has {} words, not 3", words.len())) };
    let mut digest = [0; 32];
    let bytes = digits.as_bytes();
    let fits = bytes.len() == 64 && bytes.iter().all(u8::is_ascii_hexdigit);
    if !fits {
        return Err("its third word is no SHA-256 digest of 64 hexadecimal digits".to_owned());
    }
    for (byte, pair) in digest.iter_mut().zip(bytes.chunks(2)) {
        let pair = std::str::from_utf8(pair).unwrap_or_default();
        *byte = u8::from_str_radix(pair, 16).map_err(|error| error.to_string())?;
    }
    Ok((digest, Grant { name: name.to_owned(), roles: roles.parse()? }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::security::Role;

    fn of(text: &str) -> Result<Tokens, SecurityError> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("tokens");
        std::fs::write(&path, text).unwrap();
        Tokens::read(&path)
    }

    #[test]
    fn a_token_is_known_by_the_line_that_came_with_it_and_by_nothing_else() {
        let roles = Roles::of(&[Role::Work]);
        let (token, line) = fresh("render-1", roles).unwrap();
        let tokens = of(&format!("# workers\n\n{line}")).unwrap();
        assert_eq!(tokens.grant(&token), Some(&Grant { name: "render-1".to_owned(), roles }));
        let line_digest = line.split_whitespace().last().unwrap();
        for wrong in [String::new(), token.to_uppercase(), format!("{token} "), line_digest.to_owned()] {
            assert_eq!(tokens.grant(&wrong), None);
        }
        assert!(!line.contains(&token) && !format!("{tokens:?}").contains(&token));
        assert_ne!(fresh("a", roles).unwrap().0, fresh("a", roles).unwrap().0);
    }

    #[test]
    fn broken_files_are_refused_with_their_line() {
        let (_, good) = fresh("a", Roles::of(&Role::ALL)).unwrap();
        let digits = "0".repeat(63);
        let cases = [
            ("", "holds no token"),
            ("alice submit\n", "line 1: has 2 words"),
            (&format!("{good}bob submit {digits}\n"), "line 2: its third word"),
            (&format!("{good}bob sumbit {digits}0\n"), "line 2: \"sumbit\" is no role"),
            (&format!("{good}{good}"), "line 2: the same token again"),
            (&format!("a submit {}é\n", "0".repeat(62)), "line 1: its third word"),
        ];
        for (text, expected) in cases {
            let error = of(text).unwrap_err().to_string();
            assert!(error.contains(expected), "{error}");
        }
    }
}
