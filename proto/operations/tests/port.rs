//! The port over real connections: what it answers, and that it answers while the program hangs.

#![allow(missing_docs, clippy::unwrap_used)]

use gonio_operations::{Families, Probe, Pulse, Verdict, serve};
use std::io::{Read, Write};
use std::net::{SocketAddr, TcpStream};
use std::sync::{Arc, Mutex};
use std::time::Duration;

/// Ready when `ready` says so; alive while `pulse` beats; counts under `lock`.
struct Program {
    ready: Mutex<Verdict>,
    pulse: Pulse,
    lock: Mutex<u64>,
}

impl Probe for Program {
    fn startup(&self) -> Verdict {
        Ok(())
    }

    fn ready(&self) -> Verdict {
        self.ready.lock().unwrap().clone()
    }

    fn live(&self) -> Verdict {
        self.pulse.within(Duration::from_millis(500), "the loop")
    }

    fn metrics(&self) -> Families {
        let mut families = Families::new();
        families.counter("gonio_test_tasks_total", "Tasks.", *self.lock.lock().unwrap());
        families
    }
}

fn started() -> (Arc<Program>, SocketAddr) {
    let program = Program { ready: Mutex::new(Ok(())), pulse: Pulse::default(), lock: Mutex::new(7) };
    let program = Arc::new(program);
    let address = serve("127.0.0.1:0".parse().unwrap(), Arc::clone(&program) as Arc<dyn Probe>).unwrap();
    (program, address)
}

fn get(address: SocketAddr, path: &str) -> String {
    let mut stream = TcpStream::connect(address).unwrap();
    stream.set_read_timeout(Some(Duration::from_secs(20))).unwrap();
    write!(stream, "GET {path} HTTP/1.1\r\nHost: x\r\n\r\n").unwrap();
    let mut answer = String::new();
    stream.read_to_string(&mut answer).unwrap();
    answer
}

#[test]
fn verdicts_are_status_and_reason() {
    let (program, address) = started();
    assert!(get(address, "/healthz/ready").starts_with("HTTP/1.1 200"));
    *program.ready.lock().unwrap() = Err("it drains".to_owned());
    let refused = get(address, "/healthz/ready");
    assert!(refused.starts_with("HTTP/1.1 503") && refused.ends_with("it drains\n"), "{refused}");
    assert!(get(address, "/healthz").starts_with("HTTP/1.1 404"));
    let metrics = get(address, "/metrics");
    assert!(metrics.contains("content-type: text/plain; version=0.0.4"), "{metrics}");
    assert!(metrics.contains("gonio_test_tasks_total 7\n") && metrics.contains("gonio_build_info{"), "{metrics}");
}

/// A lock that never comes free takes the metrics along, and neither the probes nor the news that the loop stands still.
#[test]
fn a_hang_is_told() {
    let (program, address) = started();
    program.pulse.beat();
    assert!(get(address, "/healthz/live").starts_with("HTTP/1.1 200"));
    let held = program.lock.lock().unwrap();
    let scrapes: Vec<_> = (0..4).map(|_| std::thread::spawn(move || get(address, "/metrics"))).collect();
    std::thread::sleep(Duration::from_millis(700));
    let live = get(address, "/healthz/live");
    assert!(live.starts_with("HTTP/1.1 503") && live.contains("the loop has not come round"), "{live}");
    assert!(scrapes.iter().all(|scrape| !scrape.is_finished()));
    drop(held);
    assert!(scrapes.into_iter().all(|scrape| scrape.join().unwrap().starts_with("HTTP/1.1 200")));
}

/// Who connects and says nothing is let go, and does not keep others out.
#[test]
fn silent_connections_do_not_keep_others_out() {
    let (_program, address) = started();
    let silent: Vec<TcpStream> = (0..64).map(|_| TcpStream::connect(address).unwrap()).collect();
    let begin = std::time::Instant::now();
    assert!(get(address, "/healthz/live").starts_with("HTTP/1.1 "));
    assert!(begin.elapsed() < Duration::from_secs(15));
    drop(silent);
}
