//! The page of a farm: what runs and who works, live, for whoever may watch; cancelling and another try for whoever may submit.

mod farm;
mod listener;
mod tls;

pub use farm::FarmPage;

use crate::Coordinator;
use crate::security::{Guard, Identity, SecurityError};
use gonio_page::{Hosts, Page, Show, Viewers, router};
use listener::PageListener;
use std::net::SocketAddr;
use std::sync::Arc;
use tokio::net::TcpListener;
use tokio_rustls::rustls::ServerConfig;

/// Why there is no page.
#[derive(Debug, thiserror::Error)]
pub enum PageError {
    /// The address cannot be served.
    #[error("--page {0}: {1}; choose another address")]
    Address(SocketAddr, std::io::Error),
    /// A certificate or key is at fault.
    #[error(transparent)]
    Security(#[from] SecurityError),
}

/// An open port that will serve the page.
#[derive(Debug)]
pub struct Port {
    listener: TcpListener,
    address: SocketAddr,
    tls: Option<Arc<ServerConfig>>,
}

impl Port {
    /// Listens at `address`, encrypted where there is an `identity`.
    ///
    /// # Errors
    /// The address is taken or not ours; a certificate or key that TLS cannot use.
    pub async fn open(address: SocketAddr, identity: Option<&Identity>) -> Result<Self, PageError> {
        let tls = identity.map(tls::server).transpose()?;
        let failed = |error| PageError::Address(address, error);
        let listener = TcpListener::bind(address).await.map_err(failed)?;
        let address = listener.local_addr().map_err(failed)?;
        Ok(Self { listener, address, tls })
    }

    /// Where the page is.
    #[must_use]
    pub fn url(&self) -> String {
        let scheme = if self.tls.is_some() { "https" } else { "http" };
        format!("{scheme}://{}/", self.address)
    }

    /// Serves the page of `coordinator` to those whom `guard` lets in, until dropped.
    pub async fn serve(self, coordinator: Coordinator, guard: Guard) {
        // A foreign name that points here brings along neither a token nor the certificate's trust.
        let safe = guard.asks() || self.tls.is_some();
        let hosts = if safe { Hosts::Any } else { Hosts::Addresses };
        let show: Arc<dyn Show> = Arc::new(FarmPage::new(coordinator, guard));
        let listener = PageListener::new(self.listener, self.address, self.tls);
        if let Err(error) = gonio_page::serve(listener, router(Page::Farm, show, hosts, Viewers::default())).await {
            tracing::error!(%error, "the page is served no more");
        }
    }
}
