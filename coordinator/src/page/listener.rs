//! The page's connections: bounded as the farm's own, encrypted where the coordinator has a certificate.

use crate::security::bounded;
use futures::StreamExt;
use std::net::SocketAddr;
use std::sync::Arc;
use std::time::Duration;
use tokio::io::{AsyncRead, AsyncWrite};
use tokio::net::TcpListener;
use tokio::sync::mpsc;
use tokio_rustls::TlsAcceptor;
use tokio_rustls::rustls::ServerConfig;

/// Connections of browsers at the same time.
const CONNECTIONS: usize = 256;

/// How long a connection may take until it is encrypted.
const HANDSHAKE: Duration = Duration::from_secs(10);

/// What bytes come and go by.
pub(super) trait Duplex: AsyncRead + AsyncWrite + Send + Unpin {}

impl<T: AsyncRead + AsyncWrite + Send + Unpin> Duplex for T {}

/// Connections that are ready to be spoken on.
pub(super) struct PageListener {
    address: SocketAddr,
    ready: mpsc::Receiver<Box<dyn Duplex>>,
}

impl PageListener {
    /// Those of `listener`, until this is dropped.
    pub fn new(listener: TcpListener, address: SocketAddr, tls: Option<Arc<ServerConfig>>) -> Self {
        let (sender, ready) = mpsc::channel::<Box<dyn Duplex>>(16);
        tokio::spawn(async move {
            let acceptor = tls.map(TlsAcceptor::from);
            let mut incoming = Box::pin(bounded(listener, CONNECTIONS));
            loop {
                let connection = tokio::select! {
                    connection = incoming.next() => connection,
                    () = sender.closed() => return,
                };
                match (connection, acceptor.clone()) {
                    (None, _) => return,
                    (Some(Err(error)), _) => {
                        // Out of file descriptors, most likely: they come back.
                        tracing::warn!(%error, "a connection to the page failed");
                        tokio::time::sleep(Duration::from_millis(100)).await;
                    }
                    (Some(Ok(plain)), None) => {
                        let _ = sender.send(Box::new(plain)).await;
                    }
                    (Some(Ok(plain)), Some(acceptor)) => {
                        // Beside the others, who need not wait for one that dawdles.
                        let sender = sender.clone();
                        tokio::spawn(async move {
                            if let Ok(Ok(stream)) = tokio::time::timeout(HANDSHAKE, acceptor.accept(plain)).await {
                                let _ = sender.send(Box::new(stream)).await;
                            }
                        });
                    }
                }
            }
        });
        Self { address, ready }
    }
}

impl gonio_page::Listener for PageListener {
    type Io = Box<dyn Duplex>;
    type Addr = SocketAddr;

    async fn accept(&mut self) -> (Self::Io, Self::Addr) {
        match self.ready.recv().await {
            Some(connection) => (connection, self.address),
            // The listener failed for good.
            None => std::future::pending().await,
        }
    }

    fn local_addr(&self) -> std::io::Result<SocketAddr> {
        Ok(self.address)
    }
}
