//! The study's server: answers survive a kill, and the observer goes on where they were.

use crate::fixture::command;
use gonio_scene::image::write_png8;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::path::Path;
use std::process::{Child, Stdio};

/// Serves `images` at an address, and tells the host and port.
pub fn serve_at(at: &Path, images: &[String], listen: &str) -> (Child, String) {
    let images: Vec<&str> = images.iter().map(String::as_str).collect();
    let arguments = [&["study"], &images[..], &["--out", "answers.csv", "--listen", listen, "--json"]].concat();
    let mut child = command(at, &arguments).stdout(Stdio::piped()).spawn().unwrap();
    let mut line = String::new();
    BufReader::new(child.stdout.take().unwrap()).read_line(&mut line).unwrap();
    let told: serde_json::Value = serde_json::from_str(&line).unwrap();
    let host = told["url"].as_str().unwrap().trim_start_matches("http://").trim_end_matches('/').to_owned();
    (child, host)
}

/// So many images, alternately real and synthetic.
pub fn shown(at: &Path, count: usize) -> Vec<String> {
    for folder in ["real", "synthetic"] {
        std::fs::create_dir(at.join(folder)).unwrap();
    }
    let image = |k: usize| {
        let name = format!("{}/{k}.png", if k.is_multiple_of(2) { "real" } else { "synthetic" });
        write_png8(&at.join(&name), 320, 240, &vec![[40 * k as u8; 3]; 320 * 240]).unwrap();
        name
    };
    (0..count).map(image).collect()
}

fn post(host: &str, path: &str, body: &str, origin: &str) -> String {
    let mut stream = TcpStream::connect(host).unwrap();
    let length = body.len();
    let head = format!("POST {path} HTTP/1.1\r\nhost: {host}\r\norigin: {origin}\r\nconnection: close\r\n");
    write!(stream, "{head}content-type: application/json\r\ncontent-length: {length}\r\n\r\n{body}").unwrap();
    let mut answer = String::new();
    stream.read_to_string(&mut answer).unwrap();
    answer
}

#[test]
fn answers_survive_a_kill_of_the_server() {
    let top = tempfile::tempdir().unwrap();
    let images = shown(top.path(), 2);
    let (mut server, host) = serve_at(top.path(), &images, "127.0.0.1:0");
    let own = format!("http://{host}");
    assert!(post(&host, "/begin", r#"{"observer":"Ann"}"#, &own).contains(r#""position":0"#));
    let answer = r#"{"observer":"Ann","position":0,"rating":4}"#;
    assert!(post(&host, "/answer", answer, "http://elsewhere").starts_with("HTTP/1.1 403"));
    let kept = post(&host, "/answer", answer, &own);
    assert!(kept.contains(r#""position":1"#) && kept.contains("content-security-policy: default-src 'none'"), "{kept}");
    server.kill().unwrap();
    server.wait().unwrap();
    // Half a line, as a kill in the midst of writing leaves it.
    let table = top.path().join("answers.csv");
    let before = std::fs::read_to_string(&table).unwrap();
    assert!(before.lines().count() == 2 && before.contains("Ann,") && before.ends_with(",4\n"), "{before}");
    std::fs::write(&table, format!("{before}Ann,1.p")).unwrap();
    let (mut server, host) = serve_at(top.path(), &images, "127.0.0.1:0");
    let state = post(&host, "/begin", r#"{"observer":"Ann"}"#, &format!("http://{host}"));
    assert!(state.contains(r#""position":1"#), "{state}");
    assert_eq!(std::fs::read_to_string(&table).unwrap(), before);
    server.kill().unwrap();
    server.wait().unwrap();
}
