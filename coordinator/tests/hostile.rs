//! Peers that break the protocol, over real gRPC: each gets a clear status, and the coordinator goes on serving others.

#![allow(clippy::unwrap_used)] // Its helpers may do what its tests may.

mod support;

use bytes::Bytes;
use futures::StreamExt;
use gonio_coordinator::service;
use gonio_proto::convert::digest::blob_chunks;
use gonio_proto::wire::farm_client::FarmClient;
use gonio_proto::wire::{self, from_worker};
use gonio_proto::{Digest, limits};
use std::time::Duration;
use support::{Script, coordinator, film, request};
use tokio::net::TcpListener;
use tonic::transport::Channel;
use tonic::{Code, Status};

async fn client() -> (FarmClient<Channel>, Digest) {
    let (coordinator, digest) = coordinator().await;
    let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
    let url = format!("http://{}", listener.local_addr().unwrap());
    tokio::spawn(service::serve(coordinator, listener, std::future::pending(), Duration::ZERO));
    (FarmClient::connect(url).await.unwrap(), digest)
}

#[track_caller]
fn refused<T>(result: Result<T, Status>, code: Code, text: &str) {
    let Err(status) = result else { panic!("taken, not refused with {text}") };
    assert!(status.code() == code && status.message().contains(text), "{status:?}");
}

fn hello() -> from_worker::Message {
    from_worker::Message::Hello(wire::Hello {
        name: "w".into(),
        slots: 1,
        version: gonio_proto::VERSION.into(),
        reserved_credits: 0,
    })
}

/// Says `messages` as a worker; how the coordinator ends the stream.
async fn work(client: &mut FarmClient<Channel>, messages: Vec<Option<from_worker::Message>>) -> Result<(), Status> {
    let messages = futures::stream::iter(messages.into_iter().map(|message| wire::FromWorker { message }));
    let mut answers = client.work(messages).await?.into_inner();
    while answers.message().await?.is_some() {}
    Ok(())
}

#[tokio::test]
async fn workers_that_break_the_protocol_are_sent_away() {
    let (mut client, _) = client().await;
    let other = |change: &dyn Fn(&mut wire::Hello)| {
        let from_worker::Message::Hello(mut message) = hello() else { unreachable!() };
        change(&mut message);
        Some(from_worker::Message::Hello(message))
    };
    let id = wire::AttemptId { epoch: 1, evaluation: 1, task: 1, attempt: 0 };
    let id = Some(id);
    use from_worker::Message::{Ask, Chunk, Commit, Failed, Released, Started};
    let cases = [
        (vec![None], "must begin with Hello"),
        (vec![Some(Ask(wire::Ask { credits: 1 }))], "must begin with Hello"),
        (vec![other(&|h| h.slots = 0)], "Hello.slots: is 0"),
        (vec![other(&|h| h.slots = u32::MAX)], "Hello.slots: is 4294967295"),
        (vec![other(&|h| h.name = "x".repeat(100_000))], "Hello.name: has 100000 bytes"),
        (vec![Some(hello()), Some(hello())], "came a second time"),
        (vec![Some(hello()), None], "is absent or unknown here"),
        (vec![Some(hello()), Some(Started(wire::Started::default()))], "Started.id: is absent"),
        (vec![Some(hello()), Some(Chunk(wire::ResultChunk::default()))], "ResultChunk.id: is absent"),
        (vec![Some(hello()), Some(Commit(wire::Commit::default()))], "Commit.id: is absent"),
        (vec![Some(hello()), Some(Failed(wire::TaskFailed::default()))], "TaskFailed.id: is absent"),
        (vec![Some(hello()), Some(Released(wire::Released::default()))], "Released.id: is absent"),
    ];
    for (messages, text) in cases {
        refused(work(&mut client, messages).await, Code::InvalidArgument, text);
    }
    let version = work(&mut client, vec![other(&|h| h.version = "0.0.0".into())]).await;
    refused(version, Code::FailedPrecondition, "the worker 0.0.0");
    // Any number of credits is one number; results of tasks that are not its are late, not hostile.
    let commit = wire::Commit { id, size_bytes: u64::MAX, pixels: u32::MAX, channels: u32::MAX, ..Default::default() };
    let chunk = wire::ResultChunk { id, offset_bytes: u64::MAX, data: Bytes::from_static(b"123") };
    let odd =
        [Ask(wire::Ask { credits: u32::MAX }), Ask(wire::Ask { credits: u32::MAX }), Chunk(chunk), Commit(commit)];
    let odd = std::iter::once(hello()).chain(odd).map(Some).collect();
    work(&mut client, odd).await.unwrap();
    refused(client.beat(wire::Heartbeat { worker: 99, epoch: 1 }).await, Code::NotFound, "there is no worker 99");
}

#[tokio::test]
async fn results_that_break_the_protocol_lose_their_worker_but_not_their_task() {
    let (coordinator, digest) = coordinator().await;
    let events = coordinator.evaluate(request(digest, 1)).unwrap();
    type Change = fn(&mut gonio_scene::film::TileFilm);
    let changes: [(Change, &str); 4] = [
        (|f| f.data[5] = f32::NAN, "NaN at number 5"),
        (|f| f.data.truncate(4), "Commit.size_bytes"),
        (|f| f.data.extend([1.0; 4]), "goes beyond the film's"),
        (|f| f.channels = 6, "the task's is"),
    ];
    for (change, text) in changes {
        let mut worker = Script::join(&coordinator, 1).await;
        let task = worker.task().await;
        let mut film = film(&task);
        change(&mut film);
        worker.sends(task.id, &film).await;
        let status = worker.refusal().await;
        assert!(status.code() == Code::InvalidArgument && status.message().contains(text), "{status:?}");
    }
    let mut honest = Script::join(&coordinator, 2).await;
    for _ in 0..2 {
        let task = honest.task().await;
        honest.commits(&task).await;
    }
    support::answer(events).await.unwrap();
}

#[tokio::test]
async fn requests_and_blobs_that_break_the_protocol_are_refused() {
    let (mut client, digest) = client().await;
    let evaluate = async |client: &mut FarmClient<Channel>, change: &dyn Fn(&mut wire::EvaluationRequest)| {
        let mut message = request(digest, 1);
        change(&mut message);
        client.evaluate(message).await
    };
    refused(evaluate(&mut client, &|r| r.samples = 5).await, Code::InvalidArgument, "EvaluationRequest.samples: is 5");
    refused(evaluate(&mut client, &|r| r.photos.clear()).await, Code::InvalidArgument, "EvaluationRequest.photos");
    refused(evaluate(&mut client, &|r| r.capture_digest.clear()).await, Code::InvalidArgument, "a digest has 32");
    let huge = evaluate(&mut client, &|r| r.photos = vec![0; 5 << 20]).await;
    refused(huge, Code::OutOfRange, "decoded message length too large");
    // A digest of nothing is answered within the stream, as anything that needs the store.
    let nothing = evaluate(&mut client, &|r| r.capture_digest = Digest::of(b"nothing").to_wire()).await;
    let events: Vec<_> = nothing.unwrap().into_inner().collect().await;
    assert!(format!("{:?}", events.last()).contains("there is no blob"), "{events:?}");

    let digests = wire::BlobDigests { digests: vec![Bytes::from_static(b"short")] };
    refused(client.missing_blobs(digests).await, Code::InvalidArgument, "a digest has 32");
    let digests = wire::BlobDigests { digests: vec![digest.to_wire(); limits::DIGESTS + 1] };
    refused(client.missing_blobs(digests).await, Code::InvalidArgument, "the limit is 10000");
    let missing = wire::BlobDigest { digest: Digest::of(b"nothing").to_wire() };
    refused(client.get_blob(missing).await, Code::NotFound, "there is no blob");
    refused(client.get_blob(wire::BlobDigest::default()).await, Code::InvalidArgument, "a digest has 32");

    let put = async |client: &mut FarmClient<Channel>, chunks: Vec<wire::BlobChunk>| {
        client.put_blob(futures::stream::iter(chunks)).await
    };
    let blob = Bytes::from_static(b"content");
    let chunk = |digest: &[u8], size_bytes| wire::BlobChunk {
        digest: Digest::of(digest).to_wire(),
        size_bytes,
        data: Bytes::from_static(b"content"),
    };
    refused(put(&mut client, vec![]).await, Code::InvalidArgument, "never came");
    refused(put(&mut client, vec![chunk(b"other", 7)]).await, Code::InvalidArgument, "has the digest");
    refused(put(&mut client, vec![chunk(b"content", 3)]).await, Code::InvalidArgument, "goes beyond the 3 bytes");
    refused(put(&mut client, vec![chunk(b"content", 9)]).await, Code::InvalidArgument, "ended after 7 of 9");
    refused(put(&mut client, vec![chunk(b"content", u64::MAX)]).await, Code::InvalidArgument, "the limit is");
    let good: Vec<_> = blob_chunks(Digest::of(&blob), blob).collect();
    assert!(!put(&mut client, good.clone()).await.unwrap().get_ref().existed);
    assert!(put(&mut client, good).await.unwrap().get_ref().existed);
}

#[tokio::test]
async fn evaluations_beyond_a_bound_wait_outside_and_known_ones_are_found() {
    let (coordinator, digest) = coordinator().await;
    let keyed = |key: u8| wire::EvaluationRequest { key: vec![key; 16].into(), ..request(digest, 1) };
    let mut streams = vec![coordinator.evaluate(keyed(1)).unwrap()];
    for _ in 1..gonio_coordinator::jobs::MOST {
        streams.push(coordinator.evaluate(request(digest, 1)).unwrap());
    }
    refused(coordinator.evaluate(keyed(2)), Code::ResourceExhausted, "run already");
    // Who asks again for what runs adds nothing.
    streams.push(coordinator.evaluate(keyed(1)).unwrap());
}
