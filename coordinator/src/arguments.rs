//! What may be written on the coordinator's command line.

use anyhow::ensure;
use clap::{Args, Parser, Subcommand};
use gonio_coordinator::page::Port;
use gonio_coordinator::security::{Guard, Identity, Roles, Tokens, fresh, server};
use gonio_coordinator::service::Protection;
use gonio_operations::OperationsArguments;
use std::io::Write;
use std::net::SocketAddr;
use std::path::PathBuf;
use tonic::transport::ServerTlsConfig;

/// Hands out the tasks of evaluations to workers and reduces what they render.
#[derive(Debug, Parser)]
#[command(name = "gonio-coordinator", version = gonio_operations::VERSION, args_conflicts_with_subcommands = true)]
pub struct Arguments {
    #[command(subcommand)]
    pub command: Option<Command>,
    /// Address to listen on; port 0 takes a free one, which is printed
    #[arg(long, default_value = "127.0.0.1:7300")]
    pub listen: String,
    /// Where captures are kept: a folder, memory://, or s3://BUCKET/PREFIX
    #[arg(long, default_value = "gonio-store")]
    pub store: String,
    /// Wait until the coordinator that owns the store's farm stops, or has not been heard of for ten seconds; then listen
    /// and take over
    #[arg(long)]
    pub standby: bool,
    /// Seconds that evaluations which run have to finish once the coordinator is told to stop; then they fail
    #[arg(long, default_value_t = 10.0, value_parser = gonio_proto::limits::seconds)]
    pub grace: f64,
    /// Address at which KEDA is told how many workers there is work for (its external scaler), by the certificates that
    /// --tls-cert and --client-ca name; KEDA has no token to show, and --tokens does not count there
    #[arg(long, value_name = "ADDRESS")]
    pub scaler: Option<SocketAddr>,
    #[command(flatten)]
    pub operations: OperationsArguments,
    /// Address at which a page shows jobs and workers, as encrypted as --listen, to those whose token has the role watch or submit;
    /// the latter may cancel, too
    #[arg(long, value_name = "ADDRESS:PORT")]
    pub page: Option<SocketAddr>,
    #[command(flatten)]
    pub security: SecurityArguments,
}

#[derive(Debug, Subcommand)]
pub enum Command {
    /// Make a token: it is printed, and what grants it its roles is added to a file
    Token(TokenArguments),
}

/// Who may connect, and do what.
#[derive(Debug, Args)]
pub struct SecurityArguments {
    /// The coordinator's certificate, with those between it and its authority, as PEM; connections are then encrypted
    #[arg(long, value_name = "PEM", requires = "tls_key")]
    tls_cert: Option<PathBuf>,
    /// The certificate's private key, as PEM
    #[arg(long, value_name = "PEM", requires = "tls_cert")]
    tls_key: Option<PathBuf>,
    /// Let in only who shows a certificate that an authority of this PEM file has signed
    #[arg(long, value_name = "PEM", requires = "tls_cert")]
    client_ca: Option<PathBuf>,
    /// Let in only who shows a token of this file, to do what its roles allow
    #[arg(long, value_name = "FILE")]
    tokens: Option<PathBuf>,
    /// Listen beyond this machine without encryption, or without asking who connects
    #[arg(long)]
    insecure: bool,
}

/// `gonio-coordinator token`.
#[derive(Debug, Args)]
pub struct TokenArguments {
    /// Whose token it is: a word for logs
    name: String,
    /// What it allows: submit (clients), work (workers), watch (see what runs), with commas between
    #[arg(long, value_name = "ROLES")]
    roles: Roles,
    /// The file that the coordinator reads by --tokens; created if need be
    #[arg(long, value_name = "FILE")]
    tokens: PathBuf,
}

impl SecurityArguments {
    /// The open port of a page at `address`.
    ///
    /// # Errors
    /// As [`Self::protection`]; an address that cannot be served.
    pub async fn page(&self, address: SocketAddr) -> anyhow::Result<Port> {
        let asks = self.tokens.is_some() || self.client_ca.is_some();
        ensure!(
            address.ip().is_loopback() || self.insecure || self.tls_cert.is_some() && asks,
            "--page {address}: others could read along, and anybody cancel; name --tls-cert and --tls-key, and --client-ca or \
             --tokens, or say --insecure where the network is closed to others"
        );
        let identity = match (self.tls_cert.clone(), self.tls_key.clone()) {
            (Some(certificate), Some(key)) => Some(Identity { certificate, key, client_ca: self.client_ca.clone() }),
            _ => None,
        };
        Ok(Port::open(address, identity.as_ref()).await?)
    }

    /// What protects a coordinator that listens at `address`.
    ///
    /// # Errors
    /// A file that is none, or an address beyond this machine that nothing protects.
    pub fn protection(&self, address: SocketAddr) -> anyhow::Result<Protection> {
        let asks = self.tokens.is_some() || self.client_ca.is_some();
        ensure!(
            address.ip().is_loopback() || self.insecure || self.tls_cert.is_some() && asks,
            "--listen {address}: others could read along, and anybody submit; name --tls-cert and --tls-key, and --client-ca \
             or --tokens, or say --insecure where the network is closed to others"
        );
        let tokens = self.tokens.as_deref().map(Tokens::read).transpose()?;
        Ok(Protection { tls: self.tls()?, guard: Guard::new(tokens) })
    }

    /// What encrypts the scaler's port at `address`.
    ///
    /// # Errors
    /// As [`Self::protection`], where certificates alone protect.
    pub fn scaler_tls(&self, address: SocketAddr) -> anyhow::Result<Option<ServerTlsConfig>> {
        ensure!(
            address.ip().is_loopback() || self.insecure || self.client_ca.is_some(),
            "--scaler {address}: anybody could see how much there is to do; name --tls-cert, --tls-key and --client-ca, or \
             say --insecure where the network is closed to others"
        );
        self.tls()
    }

    fn tls(&self) -> anyhow::Result<Option<ServerTlsConfig>> {
        let (Some(certificate), Some(key)) = (self.tls_cert.clone(), self.tls_key.clone()) else { return Ok(None) };
        Ok(Some(server(&Identity { certificate, key, client_ca: self.client_ca.clone() })?))
    }
}

impl TokenArguments {
    /// Makes the token.
    ///
    /// # Errors
    /// The name is no word, or the file cannot be written.
    pub fn make(&self) -> anyhow::Result<()> {
        let word = |c: char| c.is_ascii_alphanumeric() || "-_.@".contains(c);
        ensure!(
            !self.name.is_empty() && self.name.chars().all(word),
            "{:?}: write letters, digits, - _ . @",
            self.name
        );
        let (token, line) = fresh(&self.name, self.roles)?;
        let file = std::fs::OpenOptions::new().create(true).append(true).open(&self.tokens);
        file.and_then(|mut file| file.write_all(line.as_bytes()))
            .map_err(|error| anyhow::anyhow!("--tokens {}: {error}", self.tokens.display()))?;
        println!("{token}");
        Ok(())
    }
}
