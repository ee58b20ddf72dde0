//! What coordinator and worker take alike.

use crate::{Log, Probe, serve};
use clap::Args;
use std::io;
use std::net::SocketAddr;
use std::sync::Arc;

/// How a program shows itself to those who run it.
#[derive(Debug, Clone, Args)]
pub struct OperationsArguments {
    /// Address for probes (/healthz/startup, /healthz/ready, /healthz/live) and /metrics, over plain HTTP and for everybody
    /// who reaches it; port 0 takes a free one, which is printed
    #[arg(long, value_name = "ADDRESS")]
    operations: Option<SocketAddr>,
    /// How the log is written to stderr: for people, or one JSON object per line
    #[arg(long, value_enum, value_name = "FORMAT", default_value_t)]
    pub log: Log,
}

impl OperationsArguments {
    /// Answers for `probe`, if an address was given, for as long as the process lives; prints the address.
    ///
    /// # Errors
    /// The address cannot be listened on.
    pub fn serve(&self, probe: &Arc<impl Probe>) -> io::Result<()> {
        let Some(address) = self.operations else { return Ok(()) };
        let named = |error: io::Error| {
            io::Error::new(error.kind(), format!("--operations {address}: {error}; choose another address"))
        };
        let address = serve(address, Arc::clone(probe) as Arc<dyn Probe>).map_err(named)?;
        println!("operations on http://{address}");
        Ok(())
    }
}
