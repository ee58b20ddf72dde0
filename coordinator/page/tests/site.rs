//! A page's server, asked as browsers and others ask.

#![allow(clippy::unwrap_used)] // A test fails by panicking.

use axum::body::{Body, Bytes};
use axum::http::{Method, Request, Response, StatusCode};
use futures::StreamExt;
use gonio_page::{HEADER, Hosts, MOST, POLICY, Page, Refusal, Show, View, Viewers, Visitor, router};
use serde_json::{Map, Value, json};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex};
use std::time::Duration;
use tower::ServiceExt;

/// Shows a number; lets in who says "watch" or "act".
#[derive(Default)]
struct Shown {
    number: AtomicU64,
    over: AtomicBool,
    acts: Mutex<Vec<String>>,
}

impl Show for Shown {
    fn admit(&self, authorization: Option<&str>) -> Result<Visitor, Refusal> {
        match authorization {
            Some("Bearer watch") => Ok(Visitor { may_act: false }),
            Some("Bearer act") => Ok(Visitor { may_act: true }),
            _ => Err(Refusal::Unknown("who are you?".to_owned())),
        }
    }

    fn state(&self, view: &View) -> Map<String, Value> {
        let state =
            json!({ "number": self.number.load(Ordering::SeqCst), "find": view.text("find"), "same": { "a": [1] } });
        state.as_object().unwrap().clone()
    }

    fn is_over(&self) -> bool {
        self.over.load(Ordering::SeqCst)
    }

    fn picture(&self, name: &str) -> Option<Bytes> {
        (name == "one").then(|| Bytes::from_static(b"png"))
    }

    fn act(&self, action: &str, of: &Value) -> Result<String, Refusal> {
        self.acts.lock().unwrap().push(format!("{action} {of}"));
        Ok("done".to_owned())
    }
}

struct Site {
    shown: Arc<Shown>,
    router: axum::Router,
}

impl Site {
    fn new() -> Self {
        let shown = Arc::new(Shown::default());
        let show: Arc<dyn Show> = shown.clone();
        Self { shown, router: router(Page::Farm, show, Hosts::Addresses, Viewers::default()) }
    }

    async fn ask(&self, method: Method, path: &str, headers: &[(&str, &str)], body: &'static str) -> Response<Body> {
        let mut request = Request::builder().method(method).uri(path);
        let own = [("host", "127.0.0.1:7301")];
        let named = headers.iter().any(|(name, _)| *name == "host");
        for (name, value) in own.iter().filter(|_| !named).chain(headers) {
            request = request.header(*name, *value);
        }
        self.router.clone().oneshot(request.body(Body::from(body)).unwrap()).await.unwrap()
    }

    async fn get(&self, path: &str, headers: &[(&str, &str)]) -> Response<Body> {
        self.ask(Method::GET, path, headers, "").await
    }
}

const WATCH: (&str, &str) = ("authorization", "Bearer watch");
const ACT: (&str, &str) = ("authorization", "Bearer act");

/// The next event of a stream: its name and its data.
async fn next(stream: &mut axum::body::BodyDataStream) -> (String, Value) {
    loop {
        let bytes = stream.next().await.unwrap().unwrap();
        let text = std::str::from_utf8(&bytes).unwrap();
        let line = |name: &str| text.lines().find_map(|line| line.strip_prefix(name)).map(str::trim);
        if let (Some(event), Some(data)) = (line("event:"), line("data:")) {
            return (event.to_owned(), serde_json::from_str(data).unwrap());
        }
    }
}

#[tokio::test]
async fn every_answer_has_the_strict_policy_and_none_lets_other_sites_read() {
    let site = Site::new();
    for (path, status) in [
        ("/", StatusCode::OK),
        ("/farm.js", StatusCode::OK),
        ("/style.css", StatusCode::OK),
        ("/nothing.js", StatusCode::NOT_FOUND),
        ("/picture/one", StatusCode::OK),
        ("/picture/two", StatusCode::NOT_FOUND),
        ("/act/stop", StatusCode::METHOD_NOT_ALLOWED),
    ] {
        let answer = site.get(path, &[WATCH, ("origin", "http://evil.example")]).await;
        assert_eq!(answer.status(), status, "{path}");
        assert_eq!(answer.headers()["content-security-policy"], POLICY, "{path}");
        assert_eq!(answer.headers()["x-content-type-options"], "nosniff");
        assert!(!answer.headers().contains_key("access-control-allow-origin"));
    }
    assert!(POLICY.starts_with(
        "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data:; connect-src 'self'"
    ));
    assert!(!POLICY.contains("unsafe"));
}

#[tokio::test]
async fn a_name_that_somebody_else_may_own_is_refused() {
    let site = Site::new();
    for (host, status) in [("evil.example:7301", 403), ("localhost:1", 200), ("[::1]", 200), ("10.1.2.3", 200)] {
        assert_eq!(site.get("/", &[("host", host)]).await.status(), status, "{host}");
    }
}

#[tokio::test]
async fn an_action_needs_a_right_its_header_and_our_own_page() {
    let site = Site::new();
    let post = async |headers: &[(&str, &str)]| {
        site.ask(Method::POST, "/act/cancel", headers, "{\"evaluation\":7}").await.status()
    };
    let own = (HEADER, "1");
    assert_eq!(post(&[ACT]).await, StatusCode::FORBIDDEN);
    assert_eq!(post(&[own]).await, StatusCode::UNAUTHORIZED);
    assert_eq!(post(&[WATCH, own]).await, StatusCode::FORBIDDEN);
    assert_eq!(post(&[ACT, own, ("origin", "http://evil.example")]).await, StatusCode::FORBIDDEN);
    assert!(site.shown.acts.lock().unwrap().is_empty());
    assert_eq!(post(&[ACT, own, ("origin", "http://127.0.0.1:7301")]).await, StatusCode::OK);
    assert_eq!(*site.shown.acts.lock().unwrap(), ["cancel {\"evaluation\":7}"]);
    let nonsense = site.ask(Method::POST, "/act/cancel", &[ACT, own], "{").await;
    assert_eq!(nonsense.status(), StatusCode::BAD_REQUEST);
    let preflight = site.ask(Method::OPTIONS, "/act/cancel", &[("origin", "http://evil.example")], "").await;
    assert_eq!(preflight.status(), StatusCode::FORBIDDEN);
}

#[tokio::test(start_paused = true)]
async fn a_stream_is_the_state_then_what_changes_then_the_end() {
    let site = Site::new();
    assert_eq!(site.get("/events", &[]).await.status(), StatusCode::UNAUTHORIZED);
    let answer = site.get("/events?find=x", &[WATCH]).await;
    assert_eq!(answer.headers()["content-type"], "text/event-stream");
    let mut stream = answer.into_body().into_data_stream();
    let (event, state) = next(&mut stream).await;
    assert_eq!(event, "snapshot");
    assert_eq!(state, json!({ "number": 0, "find": "x", "same": { "a": [1] }, "may_act": false }));
    // A thousand changes between two looks are one event, and no sooner than half a second after the last.
    let begin = tokio::time::Instant::now();
    for _ in 0..1000 {
        site.shown.number.fetch_add(1, Ordering::SeqCst);
    }
    assert_eq!(next(&mut stream).await, ("patch".to_owned(), json!({ "number": 1000 })));
    assert!(begin.elapsed() >= gonio_page::INTERVAL);
    site.shown.number.store(7, Ordering::SeqCst);
    site.shown.over.store(true, Ordering::SeqCst);
    assert_eq!(next(&mut stream).await, ("patch".to_owned(), json!({ "number": 7 })));
    assert_eq!(next(&mut stream).await.0, "end");
    // It stays open: the page closes it once it has what it wants.
    let more = tokio::time::timeout(Duration::from_secs(3600), next(&mut stream)).await;
    assert!(more.is_err());
}

#[tokio::test]
async fn streams_are_bounded_and_count_until_they_are_closed() {
    let site = Site::new();
    let mut open = Vec::new();
    for _ in 0..MOST {
        open.push(site.get("/events", &[ACT]).await);
    }
    assert!(open.iter().all(|answer| answer.status() == StatusCode::OK));
    assert_eq!(site.get("/events", &[ACT]).await.status(), StatusCode::SERVICE_UNAVAILABLE);
    open.pop();
    assert_eq!(site.get("/events", &[ACT]).await.status(), StatusCode::OK);
}
