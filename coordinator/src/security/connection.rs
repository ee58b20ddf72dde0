//! At most so many connections at a time, none of which waits for its first byte for ever.

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

/// How long a connection may be silent before it says anything.
const FIRST_WORD: Duration = Duration::from_secs(10);

/// A connection that counts.
pub struct Connection {
    stream: TcpStream,
    /// Until the first byte.
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
            Ok(Connection { stream, patience, _place: place })
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
        let read = Pin::new(&mut this.stream).poll_read(context, into);
        if read.is_ready() {
            this.patience = None;
        } else if this.patience.as_mut().is_some_and(|patience| patience.as_mut().poll(context).is_ready()) {
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
    async fn who_says_nothing_is_let_go_and_who_spoke_is_not() {
        let (listener, address) = listener().await;
        let mut incoming = Box::pin(bounded(listener, 2));
        let _silent = TcpStream::connect(address).await.unwrap();
        let mut silent = incoming.next().await.unwrap().unwrap();
        let speaker = TcpStream::connect(address).await.unwrap();
        speaker.writable().await.unwrap();
        speaker.try_write(b"x").unwrap();
        let mut spoken = incoming.next().await.unwrap().unwrap();
        let mut byte = [0; 1];
        spoken.read_exact(&mut byte).await.unwrap();
        tokio::time::pause();
        assert_eq!(silent.read(&mut byte).await.unwrap_err().kind(), io::ErrorKind::TimedOut);
        assert!(tokio::time::timeout(10 * FIRST_WORD, spoken.read(&mut byte)).await.is_err());
    }
}
