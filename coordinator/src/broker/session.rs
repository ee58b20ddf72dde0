//! One worker's stream: checks what it says, and turns it into calls of the broker.

use super::{Broker, Loss, ToWorker};
use gonio_proto::convert::film::{FilmAssembly, FilmShape};
use gonio_proto::convert::task::{AttemptId, Hello};
use gonio_proto::wire::from_worker::Message;
use gonio_proto::{WireError, wire};
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;
use std::time::Duration;
use tokio::sync::mpsc;
use tokio::task::{JoinError, JoinSet};
use tokio_stream::wrappers::UnboundedReceiverStream;
use tokio_stream::{Stream, StreamExt};
use tonic::Status;

/// How long a worker may take to say hello.
const HELLO_TIMEOUT: Duration = Duration::from_secs(10);

/// Results of one worker that are decoded and reduced at the same time; more wait in its stream, which slows it down.
const COMMITS_AT_ONCE: usize = 4;

type FromWorker = Result<wire::FromWorker, Status>;

/// Serves one worker until its stream ends or it breaks the protocol; the answer ends with the reason.
pub fn serve<S>(broker: Arc<Broker>, inbound: S) -> UnboundedReceiverStream<ToWorker>
where
    S: Stream<Item = FromWorker> + Send + Unpin + 'static,
{
    let (outbound, receiver) = mpsc::unbounded_channel();
    tokio::spawn(async move {
        let result = tokio::select! {
            result = session(&broker, inbound, &outbound) => result,
            () = outbound.closed() => Ok(()),
            () = broker.closed() => Err(Status::unavailable("the coordinator stops")),
        };
        if let Err(status) = result {
            tracing::warn!(reason = status.message(), "a worker's stream broke");
            let _ = outbound.send(Err(status));
        }
    });
    UnboundedReceiverStream::new(receiver)
}

/// Tells the broker that the worker is gone, however its session ends.
struct Joined<'b> {
    broker: &'b Broker,
    worker: u64,
    /// How its leases end: by a death, unless something better is known.
    loss: Loss,
}

impl Drop for Joined<'_> {
    fn drop(&mut self) {
        self.broker.leave(self.worker, self.loss);
    }
}

async fn session<S>(
    broker: &Arc<Broker>,
    mut inbound: S,
    outbound: &mpsc::UnboundedSender<ToWorker>,
) -> Result<(), Status>
where
    S: Stream<Item = FromWorker> + Send + Unpin,
{
    let first = tokio::time::timeout(HELLO_TIMEOUT, inbound.next()).await;
    let first = first.map_err(|_| Status::deadline_exceeded("no Hello came"))?;
    let Some(first) = first.transpose()? else { return Ok(()) };
    let Some(Message::Hello(hello)) = first.message else {
        return Err(WireError::new("FromWorker", "must begin with Hello").into());
    };
    let hello = Hello::try_from(hello)?;
    if hello.version != gonio_proto::VERSION {
        let text = format!("this coordinator is version {}, the worker {}", gonio_proto::VERSION, hello.version);
        return Err(Status::failed_precondition(text));
    }
    let worker = broker.join(hello, outbound.clone());
    let mut joined = Joined { broker, worker, loss: Loss::Died };
    let mut films = Films {
        broker: Arc::clone(broker),
        worker,
        open: BTreeMap::new(),
        sent: BTreeSet::new(),
        commits: JoinSet::new(),
    };
    loop {
        tokio::select! {
            message = inbound.next(), if films.commits.len() < COMMITS_AT_ONCE => match message {
                Some(message) => films.receive(message?).map_err(|error| joined.ban(error))?,
                None => break,
            },
            Some(result) = films.commits.join_next() => films.committed(result).map_err(|error| joined.ban(error))?,
        }
    }
    // What has come completely is accepted before the worker's leases end.
    while let Some(result) = films.commits.join_next().await {
        films.committed(result).map_err(|error| joined.ban(error))?;
    }
    Ok(())
}

impl Joined<'_> {
    /// The worker itself is sent away: its tasks are no suspects of having killed it.
    fn ban(&mut self, error: impl Into<Status>) -> Status {
        self.loss = Loss::Banned;
        error.into()
    }
}

/// The results that a worker is sending.
struct Films {
    broker: Arc<Broker>,
    worker: u64,
    /// Films of which chunks have come. Bounded: only for leases that the worker holds.
    open: BTreeMap<AttemptId, FilmAssembly>,
    /// Attempts among `commits`. What else comes of them is late: it must not overtake the first on another thread.
    sent: BTreeSet<AttemptId>,
    /// Films complete, being decoded and reduced off the I/O threads.
    commits: JoinSet<Result<AttemptId, WireError>>,
}

impl Films {
    fn receive(&mut self, message: wire::FromWorker) -> Result<(), WireError> {
        let Some(message) = message.message else {
            return Err(WireError::new("FromWorker.message", "is absent or unknown here"));
        };
        let (broker, worker) = (&self.broker, self.worker);
        match message {
            Message::Hello(_) => return Err(WireError::new("FromWorker.hello", "came a second time")),
            Message::Ask(ask) => broker.ask(worker, ask.credits),
            Message::Leaving(_) => broker.stops(worker),
            Message::Started(started) => broker.start(worker, AttemptId::from_wire("Started.id", started.id)?),
            Message::Chunk(chunk) => self.add(chunk)?,
            Message::Commit(commit) => self.commit(commit)?,
            Message::Failed(failed) => {
                let id = AttemptId::from_wire("TaskFailed.id", failed.id)?;
                self.open.remove(&id);
                broker.fail(worker, id, &failed.text);
            }
            Message::Released(released) => {
                let id = AttemptId::from_wire("Released.id", released.id)?;
                self.open.remove(&id);
                broker.release(worker, id, &gonio_proto::convert::text(&released.text));
            }
        }
        Ok(())
    }

    /// Notes that a commit has been decided on.
    fn committed(&mut self, result: Result<Result<AttemptId, WireError>, JoinError>) -> Result<(), Status> {
        let id = result.map_err(|error| Status::internal(error.to_string()))??;
        self.sent.remove(&id);
        Ok(())
    }

    /// The shape of the film of an attempt that may still be sent.
    fn expected(&self, id: AttemptId) -> Option<FilmShape> {
        if self.sent.contains(&id) { None } else { self.broker.expected_film(self.worker, id) }
    }

    fn add(&mut self, chunk: wire::ResultChunk) -> Result<(), WireError> {
        let id = AttemptId::from_wire("ResultChunk.id", chunk.id)?;
        self.broker.traffic.films.add(chunk.data.len());
        match self.expected(id) {
            Some(shape) => self.open.entry(id).or_insert_with(|| FilmAssembly::new(shape)).add(chunk),
            // Late: the lease ran out or the evaluation is over. The commit that follows will be counted.
            None => {
                self.open.remove(&id);
                Ok(())
            }
        }
    }

    fn commit(&mut self, commit: wire::Commit) -> Result<(), WireError> {
        let id = AttemptId::from_wire("Commit.id", commit.id)?;
        let open = self.open.remove(&id);
        let Some(shape) = self.expected(id) else {
            self.broker.refuse(self.worker, id, self.sent.contains(&id));
            return Ok(());
        };
        let film = open.unwrap_or_else(|| FilmAssembly::new(shape));
        let (broker, worker) = (Arc::clone(&self.broker), self.worker);
        self.sent.insert(id);
        self.commits.spawn_blocking(move || {
            let film = film.finish(&commit)?;
            let render_time = Duration::from_micros(commit.render_microseconds);
            let Some((active, part)) = broker.commit(worker, id, render_time) else { return Ok(id) };
            let reduced = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| active.add(&part, film)));
            if reduced.is_err() {
                active.end(Err(super::Failure::of_farm(format!("the reduction of {id} panicked"))));
            }
            Ok(id)
        });
        Ok(())
    }
}
