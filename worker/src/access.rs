//! How a farm is reached that does not take everybody: by TLS, a certificate, a token.

use clap::Args;
use gonio_proto::limits;
use gonio_proto::wire::farm_client::FarmClient;
use std::path::{Path, PathBuf};
use std::time::Duration;
use tonic::metadata::{Ascii, MetadataValue};
use tonic::service::Interceptor;
use tonic::service::interceptor::InterceptedService;
use tonic::transport::{Certificate, Channel, ClientTlsConfig, Endpoint, Identity};
use tonic::{Request, Status};

/// A client of the farm.
pub type Client = FarmClient<InterceptedService<Channel, Bearer>>;

/// What a farm asks of those who connect. Nothing by default.
#[derive(Debug, Clone, Default, Args)]
pub struct Access {
    /// File that holds the token which the farm asks for
    #[arg(long, value_name = "FILE", env = "GONIO_TOKEN_FILE", hide_env_values = true)]
    pub token: Option<PathBuf>,
    /// Authorities, as PEM, that the coordinator's certificate must be signed by; the address then begins with https://
    #[arg(long, value_name = "PEM", env = "GONIO_CA")]
    pub ca: Option<PathBuf>,
    /// Certificate to show to the coordinator, as PEM
    #[arg(long, value_name = "PEM", env = "GONIO_CERT", requires = "key")]
    pub cert: Option<PathBuf>,
    /// The certificate's private key, as PEM
    #[arg(long, value_name = "PEM", env = "GONIO_KEY", requires = "cert")]
    pub key: Option<PathBuf>,
}

/// Why a farm cannot be asked at all.
#[derive(Debug, thiserror::Error)]
pub enum AccessError {
    /// The address is none.
    #[error("{url}: no usable address ({cause}); write http://HOST:PORT or https://HOST:PORT")]
    Address {
        /// What was given.
        url: String,
        /// Why.
        cause: tonic::transport::Error,
    },
    /// The address and the options contradict each other.
    #[error("{url}: {problem}; {mend}")]
    Scheme {
        /// What was given.
        url: String,
        /// What is wrong.
        problem: &'static str,
        /// What to do.
        mend: &'static str,
    },
    /// A file cannot be read, or used.
    #[error("{option} {}: {problem}; {mend}", path.display())]
    File {
        /// The option that names it.
        option: &'static str,
        /// The file.
        path: PathBuf,
        /// What is wrong; never a secret.
        problem: String,
        /// What to do.
        mend: &'static str,
    },
}

/// Adds a token to every call.
#[derive(Clone)]
pub struct Bearer(Option<MetadataValue<Ascii>>);

impl Interceptor for Bearer {
    fn call(&mut self, mut request: Request<()>) -> Result<Request<()>, Status> {
        if let Some(token) = &self.0 {
            request.metadata_mut().insert("authorization", token.clone());
        }
        Ok(request)
    }
}

impl Access {
    /// A client of the coordinator at `url`, connected at the first call.
    ///
    /// # Errors
    /// See [`AccessError`].
    pub fn client(&self, url: &str) -> Result<Client, AccessError> {
        let client = FarmClient::new(self.channel(url)?);
        Ok(client.max_decoding_message_size(limits::MESSAGE_BYTES))
    }

    /// What a client of the coordinator at `url` calls through.
    ///
    /// # Errors
    /// See [`AccessError`].
    pub fn channel(&self, url: &str) -> Result<InterceptedService<Channel, Bearer>, AccessError> {
        let keepalive = Duration::from_secs(5);
        let address = |cause| AccessError::Address { url: url.to_owned(), cause };
        let mut endpoint = Endpoint::from_shared(url.to_owned())
            .map_err(address)?
            .connect_timeout(Duration::from_secs(10))
            .tcp_nodelay(true)
            .http2_keep_alive_interval(keepalive)
            .keep_alive_timeout(keepalive)
            .keep_alive_while_idle(true)
            .initial_stream_window_size(limits::STREAM_WINDOW_BYTES)
            .initial_connection_window_size(2 * limits::STREAM_WINDOW_BYTES)
            .max_frame_size(limits::FRAME_BYTES);
        if let Some(tls) = self.tls(url)? {
            endpoint = endpoint.tls_config(tls).map_err(address)?;
        }
        Ok(InterceptedService::new(endpoint.connect_lazy(), self.bearer()?))
    }

    fn tls(&self, url: &str) -> Result<Option<ClientTlsConfig>, AccessError> {
        let refuse = |problem, mend| Err(AccessError::Scheme { url: url.to_owned(), problem, mend });
        let encrypted = url.starts_with("https://");
        let Some(ca) = &self.ca else {
            if encrypted {
                return refuse("no authority is named for its certificate", "name a PEM file with --ca");
            }
            if self.cert.is_some() {
                return refuse(
                    "a certificate is shown over TLS alone",
                    "name the authority with --ca, and write https://",
                );
            }
            return Ok(None);
        };
        if !encrypted {
            return refuse("--ca is for an encrypted connection", "write https://, or leave --ca out");
        }
        let mut config = ClientTlsConfig::new().ca_certificate(Certificate::from_pem(pem("--ca", ca, "CERTIFICATE")?));
        if let (Some(cert), Some(key)) = (&self.cert, &self.key) {
            let (cert, key) = (pem("--cert", cert, "CERTIFICATE")?, pem("--key", key, "PRIVATE KEY")?);
            config = config.identity(Identity::from_pem(cert, key));
        }
        Ok(Some(config))
    }

    fn bearer(&self) -> Result<Bearer, AccessError> {
        let Some(path) = &self.token else { return Ok(Bearer(None)) };
        let text = String::from_utf8_lossy(&read("--token", path)?).trim().to_owned();
        let mut value: MetadataValue<Ascii> = format!("Bearer {text}").parse().map_err(|_| AccessError::File {
            option: "--token",
            path: path.clone(),
            problem: "holds no token".to_owned(),
            mend: "write into it what `gonio-coordinator token` printed",
        })?;
        // Nothing that logs headers shows it.
        value.set_sensitive(true);
        Ok(Bearer(Some(value)))
    }
}

fn read(option: &'static str, path: &Path) -> Result<Vec<u8>, AccessError> {
    std::fs::read(path).map_err(|cause| AccessError::File {
        option,
        path: path.to_owned(),
        problem: cause.to_string(),
        mend: "name a file that can be read",
    })
}

fn pem(option: &'static str, path: &Path, kind: &'static str) -> Result<Vec<u8>, AccessError> {
    let bytes = read(option, path)?;
    if gonio_proto::pem::holds(&bytes, kind) {
        return Ok(bytes);
    }
    let problem = format!("has no {} block", kind.to_lowercase());
    Err(AccessError::File { option, path: path.to_owned(), problem, mend: "write it as PEM" })
}
