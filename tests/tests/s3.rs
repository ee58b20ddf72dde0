//! Captures in a bucket: a coordinator and a worker that share `s3://`, and a whole fit with the bits of the embedded farm.
//!
//! `cargo test --release -p gonio-tests --features s3 --test s3`. It starts `moto_server` (`pip install 'moto[server]'`) on
//! a free port, and skips where there is none, or without the feature, which costs a build with TLS.

#![allow(clippy::unwrap_used)] // Its helpers may do what its tests may.
#![cfg(unix)]

use gonio::farm::Farm;
use gonio_tests::cluster::{Cluster, PROGRAMS, Process, fitted};
use std::io::{Read, Write};
use std::net::{SocketAddr, TcpListener, TcpStream};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// A server of S3's protocol in this machine's memory.
struct Server {
    address: SocketAddr,
    _process: Process,
}

impl Server {
    /// `None`, and why on stderr, where there is none to be had.
    fn start() -> Option<Self> {
        if !cfg!(feature = "s3") {
            eprintln!("skipped: built without --features s3");
            return None;
        }
        let address = TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap();
        let port = address.port().to_string();
        let mut command = Command::new("moto_server");
        command.args(["-H", "127.0.0.1", "-p", &port]).stdout(Stdio::null()).stderr(Stdio::null());
        let Ok(mut child) = command.spawn() else {
            eprintln!("skipped: there is no moto_server (pip install 'moto[server]')");
            return None;
        };
        let begin = Instant::now();
        while TcpStream::connect(address).is_err() {
            if let Some(status) = child.try_wait().unwrap() {
                eprintln!("skipped: moto_server ended at once, {status} (pip install 'moto[server]')");
                return None;
            }
            assert!(begin.elapsed() < Duration::from_secs(120), "moto_server does not listen");
            std::thread::sleep(Duration::from_millis(100));
        }
        Some(Self { address, _process: Process::from(child) })
    }

    /// One request without a body, unsigned: this server asks for no signature.
    fn ask(&self, method: &str, path: &str) -> String {
        let mut stream = TcpStream::connect(self.address).unwrap();
        let head = format!("{method} {path} HTTP/1.1\r\nHost: {}\r\nContent-Length: 0\r\n", self.address);
        write!(stream, "{head}Connection: close\r\n\r\n").unwrap();
        let mut answer = String::new();
        stream.read_to_string(&mut answer).unwrap();
        answer
    }
}

#[test]
fn a_fit_over_a_bucket_has_the_bits_of_the_embedded_farm() {
    let Some(server) = Server::start() else { return };
    assert!(server.ask("PUT", "/gonio").starts_with("HTTP/1.1 200"));
    let endpoint = format!("http://{}", server.address);
    let environment = [
        ("AWS_ENDPOINT_URL", endpoint.as_str()),
        ("AWS_ALLOW_HTTP", "true"),
        ("AWS_REGION", "us-east-1"),
        ("AWS_ACCESS_KEY_ID", "id"),
        ("AWS_SECRET_ACCESS_KEY", "secret"),
    ];
    let store = "s3://gonio/captures";
    let log = std::env::temp_dir().join(format!("gonio-s3-{}.log", std::process::id()));

    let expected = fitted(&Farm::embedded(1).unwrap(), &mut || ());
    // The second time everything is in the bucket already, for a coordinator that knows nothing of the first.
    for run in ["first", "second"] {
        let mut cluster = Cluster::start_in(store, 0, &environment);
        cluster.add_logged_worker(&["--store", store], &environment, &log);
        assert_eq!(fitted(&Farm::connect(&cluster.url).unwrap(), &mut || ()), expected, "{run}");
        let log = std::fs::read_to_string(&log).unwrap();
        assert!(log.contains("fetched from the store") && !log.contains("asking the coordinator"), "{log}");
    }
    assert!(server.ask("GET", "/gonio?list-type=2").contains("captures/blob/sha256/"));

    sweeps(&server, &environment);

    // A bucket that does not exist is found out at the start.
    let mut command = Command::new(PROGRAMS.join("gonio-coordinator"));
    command.args(["--listen", "127.0.0.1:0", "--store", "s3://nowhere"]).envs(environment);
    let output = command.output().unwrap();
    let text = String::from_utf8_lossy(&output.stderr);
    assert!(!output.status.success() && text.contains("--store s3://nowhere: cannot be used"), "{text}");
    assert!(text.contains("check that the bucket exists"), "{text}");
    std::fs::remove_file(log).unwrap();
}

/// A sweep into the bucket, part of it and then all: the tables of one into a folder, nothing rendered twice.
fn sweeps(server: &Server, environment: &[(&str, &str)]) {
    let top = std::env::temp_dir().join(format!("gonio-s3-sweep-{}", std::process::id()));
    std::fs::create_dir_all(&top).unwrap();
    let sweep = |values: &str, out: &str| {
        let text = format!(
            "format = 1\ncapture = {:?}\nsamples = 4\nresolution = 0.2\nphotos = [\"00\"]\noutputs = [\"exr\", \"png\"]\n\
             [[design]]\nkind = \"grid\"\naxes = [{{ name = \"material.shell.roughness\", values = {values} }}]\n",
            gonio_tests::captures().join("none-201")
        );
        std::fs::write(top.join("sweep.toml"), text).unwrap();
        let mut command = Command::new(PROGRAMS.join("gonio"));
        command.current_dir(&top).args(["sweep", "sweep.toml", "--json", "--out", out]);
        let output = command.envs(environment.iter().copied()).output().unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        serde_json::from_slice::<serde_json::Value>(&output.stdout).unwrap()
    };
    let out = "s3://gonio/sweeps/one";
    assert_eq!(sweep("[0.2, 0.3]", out)["rendered"], 2);
    let all = sweep("[0.1, 0.2, 0.3, 0.4]", out);
    assert_eq!((&all["finished_before"], &all["rendered"]), (&2.into(), &2.into()));
    sweep("[0.1, 0.2, 0.3, 0.4]", "folder");
    // What is private may be listed here, though not read, without a signature.
    let listed = server.ask("GET", "/gonio?list-type=2&prefix=sweeps/one/table");
    let size = std::fs::metadata(top.join("folder/table.parquet")).unwrap().len();
    assert!(listed.contains("sweeps/one/table.csv") && listed.contains(&format!("<Size>{size}</Size>")), "{listed}");
    assert_eq!(sweep("[0.1, 0.2, 0.3, 0.4]", out)["rendered"], 0);
    std::fs::remove_dir_all(top).unwrap();
}
