//! How a test asks a program's operations port.

use std::collections::{BTreeMap, BTreeSet};
use std::io::{Read, Write};
use std::net::{TcpListener, TcpStream};
use std::time::{Duration, Instant};

/// An answer: status and body.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Answer {
    pub status: u16,
    pub body: String,
}

/// A free port of this machine, as an address; somebody else might take it, which a test would notice.
pub fn free_address() -> String {
    TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().to_string()
}

/// Asks; `None` where nobody answers within `patience`.
pub fn ask(address: &str, path: &str, patience: Duration) -> Option<Answer> {
    let mut stream = TcpStream::connect(address.trim_start_matches("http://")).ok()?;
    stream.set_read_timeout(Some(patience)).unwrap();
    write!(stream, "GET {path} HTTP/1.1\r\nHost: test\r\n\r\n").ok()?;
    let mut text = String::new();
    stream.read_to_string(&mut text).ok()?;
    let (head, body) = text.split_once("\r\n\r\n")?;
    let status = head.split(' ').nth(1)?.parse().ok()?;
    let chunked = head.to_ascii_lowercase().contains("transfer-encoding");
    assert!(!chunked, "this reader knows no chunks");
    Some(Answer { status, body: body.to_owned() })
}

/// Asks a probe: its status and reason.
pub fn probe(address: &str, name: &str) -> Option<Answer> {
    ask(address, &format!("/healthz/{name}"), Duration::from_secs(5))
}

/// Waits until a probe has this status; its reason.
pub fn wait_for(address: &str, name: &str, status: u16, patience: Duration) -> String {
    let begin = Instant::now();
    loop {
        let answer = probe(address, name);
        if let Some(answer) = answer.clone().filter(|answer| answer.status == status) {
            return answer.body;
        }
        assert!(begin.elapsed() < patience, "{address} {name} is not {status} within {patience:?}: {answer:?}");
        std::thread::sleep(Duration::from_millis(20));
    }
}

/// What a program serves as metrics.
#[derive(Debug)]
pub struct Metrics {
    pub text: String,
    /// By name and labels as they are written.
    values: BTreeMap<String, f64>,
}

impl Metrics {
    /// Scrapes.
    pub fn of(address: &str) -> Self {
        let answer = ask(address, "/metrics", Duration::from_secs(10)).unwrap();
        assert_eq!(answer.status, 200);
        let samples = answer.body.lines().filter(|line| !line.starts_with('#'));
        let values = samples.map(|line| line.rsplit_once(' ').unwrap());
        let values = values.map(|(name, value)| (name.to_owned(), value.parse().unwrap())).collect();
        Self { text: answer.body, values }
    }

    /// The value of a series.
    pub fn value(&self, series: &str) -> f64 {
        *self.values.get(series).unwrap_or_else(|| panic!("no {series} in {}", self.text))
    }

    /// The sum of all series of a name.
    pub fn sum(&self, name: &str) -> f64 {
        let of_name = |series: &str| series.split('{').next() == Some(name);
        self.values.iter().filter(|(series, _)| of_name(series)).map(|(_, value)| value).sum()
    }

    /// The names that a query may use: of samples, `_bucket`, `_sum` and `_count` of histograms among them.
    pub fn names(&self) -> BTreeSet<&str> {
        self.values.keys().filter_map(|series| series.split('{').next()).collect()
    }
}
