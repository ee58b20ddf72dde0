//! KEDA's external scaler over real gRPC, on a real coordinator process: a change of the queue is told within five seconds,
//! and who shows no certificate is told nothing.

#![allow(missing_docs, clippy::unwrap_used)] // Its helpers may do what its tests may.
#![cfg(unix)]

use gonio::farm::Farm;
use gonio_proto::scaler::external_scaler_client::ExternalScalerClient;
use gonio_proto::scaler::{GetMetricsRequest, IsActiveResponse, ScaledObjectRef};
use gonio_tests::cluster::{Cluster, command, fitted};
use gonio_tests::pki::Authority;
use std::process::Stdio;
use std::time::{Duration, Instant};
use tonic::transport::{Certificate, Channel, ClientTlsConfig, Endpoint, Identity};
use tonic::{Code, Status, Streaming};

/// Within which KEDA must hear of a change.
const SIGNAL: Duration = Duration::from_secs(5);

const METRIC: &str = "gonio-workers-wanted";

type Client = ExternalScalerClient<Channel>;

/// What KEDA sends along: the trigger's metadata as it is written.
fn trigger(slots: &str) -> ScaledObjectRef {
    let metadata = [("scalerAddress", "gonio-coordinator.gonio.svc:7302"), ("slots", slots)];
    ScaledObjectRef {
        name: "gonio-worker".to_owned(),
        namespace: "gonio".to_owned(),
        scaler_metadata: metadata.map(|(key, value)| (key.to_owned(), value.to_owned())).into(),
    }
}

async fn metric(client: &mut Client, slots: &str, name: &str) -> Result<(f64, i64), Status> {
    let request = GetMetricsRequest { scaled_object_ref: Some(trigger(slots)), metric_name: name.to_owned() };
    let answer = client.get_metrics(request).await?.into_inner();
    assert_eq!((answer.metric_values.len(), answer.metric_values[0].metric_name.as_str()), (1, METRIC));
    Ok((answer.metric_values[0].metric_value_float, answer.metric_values[0].metric_value))
}

/// The next word of the stream, and how long it took.
async fn next(stream: &mut Streaming<IsActiveResponse>) -> (bool, Duration) {
    let begin = Instant::now();
    let message = tokio::time::timeout(2 * SIGNAL, stream.message()).await.expect("no signal came");
    (message.unwrap().expect("the stream ended").result, begin.elapsed())
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_change_of_the_queue_is_a_signal_within_five_seconds() {
    let mut cluster = Cluster::start_with_more(&["--scaler", "127.0.0.1:0"], 0);
    let mut client = Client::connect(cluster.port("scaler").to_owned()).await.unwrap();
    let spec = client.get_metric_spec(trigger("2")).await.unwrap().into_inner().metric_specs;
    assert_eq!((spec.len(), spec[0].metric_name.as_str(), spec[0].target_size_float), (1, METRIC, 1.0));
    let mut stream = client.stream_is_active(trigger("2")).await.unwrap().into_inner();
    assert!(!next(&mut stream).await.0, "nothing is there to do, and that is told at once");
    assert_eq!(metric(&mut client, "2", METRIC).await.unwrap(), (0.0, 0));

    // Work comes, and no worker: all of it is queued.
    let url = cluster.url.clone();
    let fit = tokio::task::spawn_blocking(move || fitted(&Farm::connect(&url).unwrap(), &mut || ()));
    let begin = Instant::now();
    let (active, _) = next(&mut stream).await;
    // From before the client even connected: reading and sending the capture is in it.
    println!("active after {:?}", begin.elapsed());
    assert!(active && begin.elapsed() < SIGNAL);
    assert!(client.is_active(trigger("2")).await.unwrap().into_inner().result);
    let (one, whole) = metric(&mut client, "1", METRIC).await.unwrap();
    let (eighth, up) = metric(&mut client, "8", METRIC).await.unwrap();
    assert!(one >= 10.0 && whole as f64 == one, "{one} tasks");
    assert_eq!((eighth, up), (one / 8.0, (one / 8.0).ceil() as i64));

    // Workers come, the fit ends, and so does the work.
    cluster.add_worker();
    cluster.add_worker();
    fit.await.unwrap();
    let begin = Instant::now();
    // Between a fit's evaluations there is a moment without a task: what counts is the last word.
    let mut active = true;
    while active {
        active = next(&mut stream).await.0;
        assert!(begin.elapsed() < SIGNAL || !active);
        if !active && client.is_active(trigger("2")).await.unwrap().into_inner().result {
            active = true;
        }
    }
    println!("idle after {:?}", begin.elapsed());
    assert_eq!(metric(&mut client, "2", METRIC).await.unwrap(), (0.0, 0));

    let refused = |result: Result<(f64, i64), Status>| result.unwrap_err();
    assert_eq!(refused(metric(&mut client, "none", METRIC).await).code(), Code::InvalidArgument);
    assert_eq!(refused(metric(&mut client, "2", "s0-other").await).code(), Code::NotFound);
    assert!(client.stream_is_active(ScaledObjectRef::default()).await.unwrap_err().message().contains("no slots"));

    // A coordinator that stops ends the stream; KEDA then asks whoever owns the farm.
    cluster.coordinator.signal("TERM");
    let end = tokio::time::timeout(SIGNAL, stream.message()).await.expect("the stream outlives its coordinator");
    assert!(!matches!(end, Ok(Some(_))), "{end:?}");
}

#[tokio::test]
async fn certificates_protect_it_and_no_token_is_asked_for() {
    let folder = tempfile::tempdir().unwrap();
    let authority = Authority::new(folder.path(), "ca");
    let (server, member) = (authority.sign("server"), authority.sign("keda"));
    let text = |path: &std::path::Path| path.to_str().unwrap().to_owned();
    let tokens = folder.path().join("tokens");
    let made = command("gonio-coordinator", &["token", "a", "--roles", "work", "--tokens", tokens.to_str().unwrap()]);
    assert!({ made }.status().unwrap().success());
    let ca = text(&authority.certificate());
    let (cert, key, tokens) = (text(&server.cert), text(&server.key), text(&tokens));
    let tls = ["--tls-cert", &cert, "--tls-key", &key];
    let closed = [&tls[..], &["--client-ca", &ca, "--tokens", &tokens, "--scaler", "127.0.0.1:0"]].concat();
    let cluster = Cluster::start_with_more(&closed, 0);
    let url = cluster.port("scaler").replace("127.0.0.1", "localhost");
    assert!(url.starts_with("https://"));

    let read = |path: &std::path::Path| std::fs::read(path).unwrap();
    let trusting = ClientTlsConfig::new().ca_certificate(Certificate::from_pem(read(&authority.certificate())));
    let shown = trusting.clone().identity(Identity::from_pem(read(&member.cert), read(&member.key)));
    let call = async |tls: ClientTlsConfig| {
        let endpoint = Endpoint::from_shared(url.clone()).unwrap().tls_config(tls).unwrap();
        let mut client = Client::new(endpoint.connect().await.map_err(|error| error.to_string())?);
        client.is_active(trigger("2")).await.map_err(|status| status.to_string())
    };
    assert!(!call(shown).await.unwrap().into_inner().result);
    assert!(call(trusting).await.is_err(), "without a certificate");
    assert!(Client::connect(url.replace("https", "http")).await.unwrap().is_active(trigger("2")).await.is_err());

    // Tokens do not protect it: beyond this machine it asks for an authority.
    let open = [&tls[..], &["--tokens", &tokens, "--scaler", "0.0.0.0:0", "--listen", "127.0.0.1:0"]].concat();
    let mut open = command("gonio-coordinator", &[&open[..], &["--store", "memory://"]].concat());
    let output = open.stderr(Stdio::piped()).output().unwrap();
    assert!(!output.status.success());
    let message = String::from_utf8(output.stderr).unwrap();
    assert!(message.contains("--scaler 0.0.0.0:0") && message.contains("--client-ca"), "{message}");
}
