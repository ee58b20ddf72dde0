//! The coordinator's certificate, and whose certificates it asks of others.

use super::{SecurityError, read};
use std::path::{Path, PathBuf};
use std::time::Duration;
use tonic::transport::{Certificate, ServerTlsConfig};

/// How long a connection may take until it is encrypted.
const HANDSHAKE: Duration = Duration::from_secs(10);

/// What a coordinator shows of itself, and whom it lets in.
#[derive(Debug, Clone)]
pub struct Identity {
    /// Its certificate, with those in between, as PEM.
    pub certificate: PathBuf,
    /// The certificate's key, as PEM.
    pub key: PathBuf,
    /// Authorities, as PEM, by one of which others' certificates must be signed; absent, none is asked for.
    pub client_ca: Option<PathBuf>,
}

/// The TLS configuration of a server with this identity.
///
/// # Errors
/// A file cannot be read, or is no PEM of its kind.
pub fn server(identity: &Identity) -> Result<ServerTlsConfig, SecurityError> {
    let certificate = pem("--tls-cert", &identity.certificate, "CERTIFICATE")?;
    let key = pem("--tls-key", &identity.key, "PRIVATE KEY")?;
    let mut config =
        ServerTlsConfig::new().identity(tonic::transport::Identity::from_pem(certificate, key)).timeout(HANDSHAKE);
    if let Some(path) = &identity.client_ca {
        config = config.client_ca_root(Certificate::from_pem(pem("--client-ca", path, "CERTIFICATE")?));
    }
    Ok(config)
}

/// A PEM file that holds at least one block of a kind. A key's contents are never part of an error.
pub(crate) fn pem(option: &'static str, path: &Path, kind: &str) -> Result<Vec<u8>, SecurityError> {
    let bytes = read(option, path)?;
    if gonio_proto::pem::holds(&bytes, kind) {
        return Ok(bytes);
    }
    let problem = format!("has no {} block", kind.to_lowercase());
    Err(SecurityError::Content { option, path: path.to_owned(), problem, mend: "write it as PEM" })
}
