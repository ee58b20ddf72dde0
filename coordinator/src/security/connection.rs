//! At most so many connections at a time, none of which takes for ever to begin.

use futures::{Stream, StreamExt};
use std::future::Future;
use std::io;
use std::pin::Pin;
use std::sync::Arc;
use std::task::{Context, Poll};
use std::time::Duration;
use tokio::io::{AsyncRead, AsyncWrite, ReadBuf};
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::{OwnedSemaphorePermit, Semaphore};
use tokio::time::Sleep;
use tokio_stream::wrappers::TcpListenerStream;
use tonic::transport::server::{Connected, TcpConnectInfo};

/// How long a connection may take to begin.
const FIRST_WORD: Duration = Duration::from_secs(10);

/// Bytes after which it has begun: the preface of HTTP/2 and the frame of settings that follows (RFC 9113, 3.4). A TLS
/// handshake, which is longer, has a limit of its own.
const BEGINNING: usize = 24 + 9;

/// A connection that counts.
pub struct Connection {
    stream: TcpStream,
    /// Bytes heard, as far as they are counted.
    heard: usize,
    /// Until it has begun.
    patience: Option<Pin<Box<Sleep>>>,
    _place: OwnedSemaphorePermit,
}

/// The connections of a listener, at most `most` of which are open: others wait in the system's queue for a place.
pub fn bounded(listener: TcpListener, most: usize) -> impl Stream<Item = io::Result<Connection>> {
    let places = Arc::new(Semaphore::new(most));
    TcpListenerStream::new(listener).then(move |accepted| {
        let places = Arc::clone(&places);
        async move {
            let stream = accepted?;
            // Small messages must not wait for more; where it cannot be set, they do.
            let _ = stream.set_nodelay(true);
            let place = places.acquire_owned().await.map_err(io::Error::other)?;
            let patience = Some(Box::pin(tokio::time::sleep(FIRST_WORD)));
            Ok(Connection { stream, heard: 0, patience, _place: place })
        }
    })
}

impl Connected for Connection {
    type ConnectInfo = TcpConnectInfo;

    fn connect_info(&self) -> TcpConnectInfo {
        self.stream.connect_info()
    }
}

impl AsyncRead for Connection {
    fn poll_read(self: Pin<&mut Self>, context: &mut Context<'_>, into: &mut ReadBuf<'_>) -> Poll<io::Result<()>> {
        let this = self.get_mut();
        let before = into.filled().len();
        let read = Pin::new(&mut this.stream).poll_read(context, into);
        this.heard = this.heard.saturating_add(into.filled().len() - before);
        if this.heard >= BEGINNING {
            this.patience = None;
        }
        if read.is_pending()
            && this.patience.as_mut().is_some_and(|patience| patience.as_mut().poll(context).is_ready())
        {
            return Poll::Ready(Err(io::ErrorKind::TimedOut.into()));
        }
        read
    }
}

impl AsyncWrite for Connection {
    fn poll_write(mut self: Pin<&mut Self>, context: &mut Context<'_>, from: &[u8]) -> Poll<io::Result<usize>> {
        Pin::new(&mut self.stream).poll_write(context, from)
    }

    fn poll_write_vectored(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
        from: &[io::IoSlice<'_>],
    ) -> Poll<io::Result<usize>> {
        Pin::new(&mut self.stream).poll_write_vectored(context, from)
    }

    fn is_write_vectored(&self) -> bool {
        self.stream.is_write_vectored()
    }

    fn poll_flush(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<io::Result<()>> {
        Pin::new(&mut self.stream).poll_flush(context)
    }

    fn poll_shutdown(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<io::Result<()>> {
        Pin::new(&mut self.stream).poll_shutdown(context)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use tokio::io::AsyncReadExt;

    async fn listener() -> (TcpListener, std::net::SocketAddr) {
        let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
        let address = listener.local_addr().unwrap();
        (listener, address)
    }

    #[tokio::test]
    async fn a_connection_waits_until_another_has_gone() {
        let (listener, address) = listener().await;
        let mut incoming = Box::pin(bounded(listener, 2));
        let _callers =
            [TcpStream::connect(address).await, TcpStream::connect(address).await, TcpStream::connect(address).await];
        let first = incoming.next().await.unwrap().unwrap();
        let _second = incoming.next().await.unwrap().unwrap();
        let soon = Duration::from_millis(100);
        assert!(tokio::time::timeout(soon, incoming.next()).await.is_err());
        drop(first);
        assert!(tokio::time::timeout(10 * FIRST_WORD, incoming.next()).await.is_ok());
    }

    #[tokio::test]
    async fn who_does_not_begin_is_let_go_and_who_has_is_not() {
        let (listener, address) = listener().await;
        let mut incoming = Box::pin(bounded(listener, 2));
        let stammerer = TcpStream::connect(address).await.unwrap();
        stammerer.writable().await.unwrap();
        stammerer.try_write(b"PRI").unwrap();
        let mut silent = incoming.next().await.unwrap().unwrap();
        silent.read_exact(&mut [0; 3]).await.unwrap();
        let speaker = TcpStream::connect(address).await.unwrap();
        speaker.writable().await.unwrap();
        speaker.try_write(&[0; BEGINNING]).unwrap();
        let mut spoken = incoming.next().await.unwrap().unwrap();
        spoken.read_exact(&mut [0; BEGINNING]).await.unwrap();
        tokio::time::pause();
        let mut byte = [0; 1];
        assert_eq!(silent.read(&mut byte).await.unwrap_err().kind(), io::ErrorKind::TimedOut);
        assert!(tokio::time::timeout(10 * FIRST_WORD, spoken.read(&mut byte)).await.is_err());
    }
}
