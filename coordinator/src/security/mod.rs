//! Who may do what: transport security, bearer tokens with roles, and bounds on connections.

mod connection;
mod guard;
mod role;
mod tls;
mod tokens;

pub use connection::bounded;
pub use guard::Guard;
pub use role::{Role, Roles};
pub(crate) use tls::pem;
pub use tls::{Identity, server};
pub use tokens::{Tokens, fresh};

use std::path::PathBuf;

/// What is wrong with a certificate, a key or a file of tokens.
#[derive(Debug, thiserror::Error)]
pub enum SecurityError {
    /// A file cannot be read.
    #[error("{option} {}: {cause}", path.display())]
    File {
        /// The option that names it.
        option: &'static str,
        /// The file.
        path: PathBuf,
        /// Why.
        cause: std::io::Error,
    },
    /// A file does not hold what it should.
    #[error("{option} {}: {problem}; {mend}", path.display())]
    Content {
        /// The option that names it.
        option: &'static str,
        /// The file.
        path: PathBuf,
        /// What is wrong; never a secret.
        problem: String,
        /// What to do.
        mend: &'static str,
    },
    /// The system gives no random numbers.
    #[error("cannot make a token: {0}")]
    Random(String),
}

fn read(option: &'static str, path: &std::path::Path) -> Result<Vec<u8>, SecurityError> {
    std::fs::read(path).map_err(|cause| SecurityError::File { option, path: path.to_owned(), cause })
}
