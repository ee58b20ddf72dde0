//! The study's server: answers survive a kill, and the observer goes on where they were.

use crate::fixture::command;
use gonio_scene::image::write_png8;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::path::Path;
use std::process::{Child, Stdio};

fn serve(at: &Path) -> (Child, String) {
    let arguments =
        ["study", "real/a.png", "synthetic/b.png", "--out", "answers.csv", "--listen", "127.0.0.1:0", "--json"];
    let mut child = command(at, &arguments).stdout(Stdio::piped()).spawn().unwrap();
    let mut line = String::new();
    BufReader::new(child.stdout.take().unwrap()).read_line(&mut line).unwrap();
    let told: serde_json::Value = serde_json::from_str(&line).unwrap();
    let host = told["url"].as_str().unwrap().trim_start_matches("http://").trim_end_matches('/').to_owned();
    (child, host)
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
    for (folder, file) in [("real", "a.png"), ("synthetic", "b.png")] {
        std::fs::create_dir(top.path().join(folder)).unwrap();
        write_png8(&top.path().join(folder).join(file), 2, 2, &[[9; 3]; 4]).unwrap();
    }
    let (mut server, host) = serve(top.path());
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
    std::fs::write(&table, format!("{before}Ann,b.p")).unwrap();
    let (mut server, host) = serve(top.path());
    let state = post(&host, "/begin", r#"{"observer":"Ann"}"#, &format!("http://{host}"));
    assert!(state.contains(r#""position":1"#), "{state}");
    assert_eq!(std::fs::read_to_string(&table).unwrap(), before);
    server.kill().unwrap();
    server.wait().unwrap();
}
