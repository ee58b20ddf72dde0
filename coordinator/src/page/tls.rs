//! The coordinator's certificate for browsers.

use crate::security::{Identity, SecurityError, pem};
use std::path::Path;
use std::sync::Arc;
use tokio_rustls::rustls::crypto::ring;
use tokio_rustls::rustls::pki_types::pem::PemObject;
use tokio_rustls::rustls::pki_types::{CertificateDer, PrivateKeyDer};
use tokio_rustls::rustls::server::WebPkiClientVerifier;
use tokio_rustls::rustls::{RootCertStore, ServerConfig};

/// The TLS of a page whose coordinator has this identity: whoever needs a certificate to connect there needs one here.
///
/// # Errors
/// A file cannot be read, or is no certificate or key of its kind.
pub(super) fn server(identity: &Identity) -> Result<Arc<ServerConfig>, SecurityError> {
    let provider = Arc::new(ring::default_provider());
    let refused = |option, path: &Path, mend| {
        let path = path.to_owned();
        move |problem: String| SecurityError::Content { option, path, problem, mend }
    };
    let of_cert =
        || refused("--tls-cert", &identity.certificate, "write certificates as PEM, the coordinator's own first");
    let of_key = || refused("--tls-key", &identity.key, "name the private key of --tls-cert, as PEM");
    let chain = certificates("--tls-cert", &identity.certificate)?;
    let key = pem("--tls-key", &identity.key, "PRIVATE KEY")?;
    let key = PrivateKeyDer::from_pem_slice(&key).map_err(|error| of_key()(error.to_string()))?;
    let builder = ServerConfig::builder_with_provider(Arc::clone(&provider))
        .with_safe_default_protocol_versions()
        .map_err(|error| of_cert()(error.to_string()))?;
    let builder = match &identity.client_ca {
        None => builder.with_no_client_auth(),
        Some(path) => {
            let of_ca = || refused("--client-ca", path, "name authorities' certificates, as PEM");
            let mut roots = RootCertStore::empty();
            for authority in certificates("--client-ca", path)? {
                roots.add(authority).map_err(|error| of_ca()(error.to_string()))?;
            }
            let verifier = WebPkiClientVerifier::builder_with_provider(Arc::new(roots), provider).build();
            builder.with_client_cert_verifier(verifier.map_err(|error| of_ca()(error.to_string()))?)
        }
    };
    let mut config = builder.with_single_cert(chain, key).map_err(|error| of_key()(error.to_string()))?;
    config.alpn_protocols = vec![b"http/1.1".to_vec()];
    Ok(Arc::new(config))
}

fn certificates(option: &'static str, path: &Path) -> Result<Vec<CertificateDer<'static>>, SecurityError> {
    let bytes = pem(option, path, "CERTIFICATE")?;
    let list: Result<Vec<_>, _> = CertificateDer::pem_slice_iter(&bytes).collect();
    list.map_err(|error| SecurityError::Content {
        option,
        path: path.to_owned(),
        problem: error.to_string(),
        mend: "write it as PEM",
    })
}
