//! Who may not, cannot: real programs, and callers without a token, with another role, another authority's certificate, an
//! expired one, none at all, or nothing sensible to say.

#![allow(clippy::unwrap_used)] // Its helpers may do what its tests may.
#![cfg(unix)]

use gonio::farm::{Access, Farm};
use gonio_proto::wire;
use gonio_tests::cluster::{Cluster, PROGRAMS, Process, command, fitted};
use gonio_tests::pki::{Authority, Signed};
use std::collections::BTreeMap;
use std::io::{Read, Write};
use std::net::TcpStream;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;
use tonic::codegen::http::uri::PathAndQuery;
use tonic::{Code, Request, Status};

/// A coordinator with a certificate and tokens, and the files that go with it.
struct Closed {
    cluster: Cluster,
    authority: Authority,
    folder: tempfile::TempDir,
}

impl Closed {
    /// `mutual` also asks for certificates.
    fn new(mutual: bool) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let authority = Authority::new(folder.path(), "ca");
        let server = authority.sign("server");
        let tokens = folder.path().join("tokens");
        for roles in ["submit", "work", "watch"] {
            let made = Command::new(PROGRAMS.join("gonio-coordinator"))
                .args(["token", roles, "--roles", roles, "--tokens", tokens.to_str().unwrap()])
                .output()
                .unwrap();
            assert!(made.status.success());
            std::fs::write(folder.path().join(roles), made.stdout).unwrap();
        }
        let path = |path: &Path| path.to_str().unwrap().to_owned();
        let mut arguments =
            vec!["--tls-cert".to_owned(), path(&server.cert), "--tls-key".to_owned(), path(&server.key)];
        arguments.extend(["--tokens".to_owned(), path(&tokens)]);
        if mutual {
            arguments.extend(["--client-ca".to_owned(), path(&authority.certificate())]);
        }
        let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
        let cluster = Cluster::start_logged(&arguments, &folder.path().join("log"));
        Self { cluster, authority, folder }
    }

    fn token(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// Access with this token and no certificate.
    fn with_token(&self, name: &str) -> Access {
        Access { token: Some(self.token(name)), ca: Some(self.authority.certificate()), ..Access::default() }
    }

    /// The whole access of somebody who belongs.
    fn member(&self, signed: &Signed, role: &str) -> Access {
        Access { token: Some(self.token(role)), ..signed.access(&self.authority) }
    }

    fn port(&self) -> u16 {
        self.cluster.url.rsplit(':').next().unwrap().parse().unwrap()
    }
}

/// Calls every method; which of them a token was let through to.
async fn allowed(url: &str, access: &Access) -> BTreeMap<&'static str, bool> {
    let client = access.client(url).unwrap();
    let passed = |result: Result<(), Status>| match result.map_err(|status| status.code()) {
        Err(Code::PermissionDenied | Code::Unauthenticated) => false,
        Err(Code::Unavailable | Code::Unknown) => panic!("no answer"),
        // Whatever the method itself says of an empty message.
        _ => true,
    };
    let mut c = client.clone();
    BTreeMap::from([
        ("work", passed(c.work(futures::stream::empty()).await.map(|_| ()))),
        ("beat", passed(c.beat(wire::Heartbeat::default()).await.map(|_| ()))),
        ("evaluate", passed(c.evaluate(wire::EvaluationRequest::default()).await.map(|_| ()))),
        ("jobs", passed(c.jobs(wire::JobsRequest::default()).await.map(|_| ()))),
        ("cancel", passed(c.cancel(wire::CancelRequest::default()).await.map(|_| ()))),
        ("missing", passed(c.missing_blobs(wire::BlobDigests::default()).await.map(|_| ()))),
        ("put", passed(c.put_blob(futures::stream::empty()).await.map(|_| ()))),
        ("get", passed(c.get_blob(wire::BlobDigest::default()).await.map(|_| ()))),
    ])
}

#[tokio::test]
async fn every_call_asks_for_its_role() {
    let closed = Closed::new(false);
    let url = &closed.cluster.url;
    let through = async |access: &Access| -> Vec<&'static str> {
        allowed(url, access).await.into_iter().filter(|(_, passed)| *passed).map(|(name, _)| name).collect()
    };
    assert_eq!(through(&closed.with_token("submit")).await, ["cancel", "evaluate", "get", "jobs", "missing", "put"]);
    assert_eq!(through(&closed.with_token("work")).await, ["beat", "get", "work"]);
    assert_eq!(through(&closed.with_token("watch")).await, ["jobs", "missing"]);
    let none = Access { ca: Some(closed.authority.certificate()), ..Access::default() };
    assert!(through(&none).await.is_empty());
    let guessed = closed.token("guessed");
    std::fs::write(&guessed, "gonio_AAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAA").unwrap();
    assert!(through(&Access { token: Some(guessed), ..none }).await.is_empty());
}

#[test]
fn certificates_are_asked_for_and_a_fit_through_all_of_it_has_the_same_bits() {
    let expected = fitted(&Farm::embedded(2).unwrap(), &mut || ());
    let mut closed = Closed::new(true);
    let url = closed.cluster.url.clone();
    let refused = |access: &Access, why: &str| {
        let Err(error) = Farm::connect_by(&url, access) else { panic!("{why}: connected") };
        error.to_string()
    };
    refused(&closed.with_token("submit"), "no certificate");
    let stranger = Authority::new(closed.folder.path(), "stranger");
    let foreign = stranger.sign("client");
    let mut access = closed.member(&foreign, "submit");
    refused(&access, "signed by somebody else");
    access.ca = Some(stranger.certificate());
    refused(&access, "the coordinator itself is not who it should be");
    let expired = closed.authority.sign_until("expired", 2020);
    refused(&closed.member(&expired, "submit"), "expired");
    let client = closed.authority.sign("client");
    let message = refused(&closed.member(&client, "watch-is-no-file"), "no token file");
    assert!(message.contains("watch-is-no-file"), "{message}");
    let message = refused(&closed.member(&client, "work"), "another role");
    assert!(message.contains("work"), "{message}");
    let plain = url.replace("https://", "http://");
    assert!(Farm::connect(&plain).is_err(), "without encryption");

    let (cert, key, ca) = (client.cert.clone(), client.key.clone(), closed.authority.certificate());
    let token = closed.token("work");
    let mut options = Vec::new();
    for (option, path) in [("--cert", &cert), ("--key", &key), ("--ca", &ca), ("--token", &token)] {
        options.extend([option, path.to_str().unwrap()]);
    }
    for _ in 0..2 {
        closed.cluster.add_worker_with(&options);
    }
    let farm = Farm::connect_by(&url, &closed.member(&client, "submit")).unwrap();
    assert_eq!(fitted(&farm, &mut || ()), expected);
}

/// Sends bytes that are no call and waits until the connection is closed, or has said something.
fn shout(port: u16, bytes: &[u8]) {
    let mut stream = TcpStream::connect(("127.0.0.1", port)).unwrap();
    stream.set_read_timeout(Some(Duration::from_secs(15))).unwrap();
    // It may have been closed already.
    let _ = stream.write_all(bytes);
    let mut answer = [0; 64];
    let ended = stream.read(&mut answer);
    assert!(!matches!(ended.map_err(|e| e.kind()), Err(std::io::ErrorKind::WouldBlock)), "the connection stays open");
}

#[tokio::test]
async fn nonsense_harms_nobody() {
    let closed = Closed::new(false);
    let port = closed.port();
    let shouting = tokio::task::spawn_blocking(move || {
        shout(port, b"GET / HTTP/1.1\r\nHost: farm\r\n\r\n");
        shout(port, &[0x16, 0x03, 0x01, 0xff, 0xff, 1, 2, 3]);
        shout(port, &[0xff; 4096]);
    });
    shouting.await.unwrap();

    let access = closed.with_token("submit");
    let mut client = access.client(&closed.cluster.url).unwrap();
    // A message that is no message of its method: bytes where a number belongs.
    let channel = access.channel(&closed.cluster.url).unwrap();
    let mut raw = tonic::client::Grpc::new(channel);
    raw.ready().await.unwrap();
    let path = PathAndQuery::from_static("/gonio.farm.v1.Farm/Evaluate");
    let codec = tonic_prost::ProstCodec::<wire::CancelRequest, wire::EvaluationEvent>::default();
    let wrong = wire::CancelRequest { key: vec![0xff; 33].into(), client: "\u{1}".repeat(70) };
    let answer = raw.unary(Request::new(wrong), path, codec).await;
    assert!(answer.is_err());
    // A chunk above the limit of a message.
    let chunk =
        wire::BlobChunk { data: vec![0; gonio_proto::limits::MESSAGE_BYTES + 1].into(), ..wire::BlobChunk::default() };
    let answer = client.put_blob(futures::stream::iter([chunk])).await.unwrap_err();
    assert!(matches!(answer.code(), Code::OutOfRange | Code::ResourceExhausted | Code::InvalidArgument), "{answer:?}");
    // More headers than are read.
    let mut request = Request::new(wire::BlobDigests::default());
    request.metadata_mut().insert("x-long", "a".repeat(64 << 10).parse().unwrap());
    assert!(client.missing_blobs(request).await.is_err());
    // And it still answers.
    let mut client = access.client(&closed.cluster.url).unwrap();
    client.missing_blobs(wire::BlobDigests::default()).await.unwrap();
}

#[test]
fn a_coordinator_does_not_open_itself_to_others_by_accident() {
    let refused = |more: &[&str]| {
        let mut open = command("gonio-coordinator", &["--listen", "0.0.0.0:0", "--store", "memory://"]);
        let output = open.args(more).stderr(std::process::Stdio::piped()).output().unwrap();
        assert!(!output.status.success());
        String::from_utf8(output.stderr).unwrap()
    };
    assert!(refused(&[]).contains("--insecure"));
    let folder = tempfile::tempdir().unwrap();
    let server = Authority::new(folder.path(), "ca").sign("server");
    let (cert, key) = (server.cert.to_str().unwrap(), server.key.to_str().unwrap());
    // Encrypted, but for everybody.
    assert!(refused(&["--tls-cert", cert, "--tls-key", key]).contains("--insecure"));
    let swapped = refused(&["--tls-cert", key, "--tls-key", cert, "--insecure"]);
    assert!(swapped.contains("--tls-cert") && swapped.contains("certificate"), "{swapped}");
    let empty = folder.path().join("tokens");
    std::fs::write(&empty, "").unwrap();
    let message = refused(&["--tls-cert", cert, "--tls-key", key, "--tokens", empty.to_str().unwrap()]);
    assert!(message.contains("holds no token"), "{message}");
}

#[test]
fn a_worker_that_is_refused_ends_and_no_log_holds_a_token() {
    let logs = tempfile::tempdir().unwrap();
    let mut closed = Closed::new(false);
    let (ca, submit) = (closed.authority.certificate(), closed.token("submit"));
    let log = logs.path().join("worker");
    let options = ["--ca", ca.to_str().unwrap(), "--token", submit.to_str().unwrap()];
    closed.cluster.add_logged_worker(&options, &[("RUST_LOG", "trace")], &log);
    let worker: &mut Process = closed.cluster.workers.last_mut().unwrap();
    let status = worker.wait_for(Duration::from_secs(20)).expect("it tries for ever");
    assert!(!status.success());
    let text = std::fs::read_to_string(&log).unwrap();
    assert!(text.contains("submit"), "it does not say why: {text}");
    let coordinator = std::fs::read_to_string(closed.folder.path().join("log")).unwrap();
    assert!(coordinator.contains("not among the token's roles"), "{coordinator}");
    for role in ["submit", "work", "watch"] {
        let token = std::fs::read_to_string(closed.token(role)).unwrap();
        assert!(!text.contains(token.trim()) && !coordinator.contains(token.trim()), "{role}");
    }
}
