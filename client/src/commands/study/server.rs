//! The server: three fixed files, images by their place in an observer's order, and two questions.

use super::answers::Answers;
use super::images::Images;
use axum::Router;
use axum::body::{Body, Bytes};
use axum::extract::{DefaultBodyLimit, Path, Request, State};
use axum::http::{HeaderMap, StatusCode, header};
use axum::middleware::{self, Next};
use axum::response::{IntoResponse, Response};
use axum::routing::{get, post};
use gonio_page::{Hosts, protected};
use gonio_study::{LEVELS, Rating, order, page};
use serde::Deserialize;
use std::sync::{Arc, Mutex, PoisonError};
use tokio::net::TcpListener;

/// Characters of an observer's name.
const LONGEST_NAME: usize = 80;

/// What is served.
pub(super) struct Study {
    images: Images,
    answers: Mutex<Answers>,
    seed: u64,
}

/// Where an observer begins or goes on.
#[derive(Deserialize)]
struct Begin {
    observer: String,
}

/// An answer to the image at `position` of the observer's order.
#[derive(Deserialize)]
struct Answer {
    observer: String,
    position: usize,
    rating: u8,
}

type Refusal = (StatusCode, String);

impl Study {
    pub(super) fn new(images: Images, answers: Answers, seed: u64) -> Arc<Self> {
        Arc::new(Self { images, answers: Mutex::new(answers), seed })
    }

    fn order(&self, observer: &str) -> Vec<usize> {
        order(self.seed, observer, self.images.0.len())
    }

    /// Where `observer` is: the first image of the order without an answer.
    fn state(&self, observer: &str, answers: &Answers) -> String {
        let order = self.order(observer);
        let position =
            order.iter().position(|&image| !answers.has(observer, &self.images.0[image].name)).unwrap_or(order.len());
        let name = observer.bytes().map(|byte| format!("{byte:02x}")).collect::<String>();
        // An image's address tells nothing of its name: that may say what it is.
        serde_json::json!({
            "observer": observer, "position": position, "count": order.len(), "image": format!("image/{name}/{position}"),
        })
        .to_string()
    }

    fn begin(&self, body: &[u8]) -> Result<String, Refusal> {
        let Begin { observer } = parse(body)?;
        let observer = named(&observer)?;
        Ok(self.state(observer, &self.answers.lock().unwrap_or_else(PoisonError::into_inner)))
    }

    fn answer(&self, body: &[u8]) -> Result<String, Refusal> {
        let Answer { observer, position, rating } = parse(body)?;
        let observer = named(&observer)?;
        if !(1..=LEVELS as u8).contains(&rating) {
            return Err((StatusCode::BAD_REQUEST, format!("a rating is 1 to {LEVELS}")));
        }
        let order = self.order(observer);
        let image = order.get(position).and_then(|&image| self.images.0.get(image));
        let image = image.ok_or_else(|| (StatusCode::BAD_REQUEST, "there is no such image".to_owned()))?;
        let mut answers = self.answers.lock().unwrap_or_else(PoisonError::into_inner);
        // One that was kept, but whose confirmation was lost: the first answer counts.
        if !answers.has(observer, &image.name) {
            let (name, truth) = (image.name.clone(), image.truth);
            answers.add(Rating { observer: observer.to_owned(), image: name, truth, rating }).map_err(|error| {
                (StatusCode::INTERNAL_SERVER_ERROR, format!("The answer could not be kept: {error}. Try again."))
            })?;
        }
        Ok(self.state(observer, &answers))
    }
}

fn parse<'a, T: Deserialize<'a>>(body: &'a [u8]) -> Result<T, Refusal> {
    serde_json::from_slice(body).map_err(|error| (StatusCode::BAD_REQUEST, format!("no question: {error}")))
}

fn named(observer: &str) -> Result<&str, Refusal> {
    let name = observer.trim();
    if name.is_empty() || name.chars().count() > LONGEST_NAME || name.contains(char::is_control) {
        return Err((StatusCode::BAD_REQUEST, format!("Write a name of 1 to {LONGEST_NAME} characters.")));
    }
    Ok(name)
}

fn file(kind: &'static str, body: impl Into<Body>) -> Response {
    ([(header::CONTENT_TYPE, kind)], body.into()).into_response()
}

fn json(answer: Result<String, Refusal>) -> Response {
    answer.map_or_else(IntoResponse::into_response, |text| file("application/json", text))
}

/// Another site's page may send a form to this machine, but not as JSON.
fn is_json(headers: &HeaderMap) -> bool {
    headers.get(header::CONTENT_TYPE).is_some_and(|kind| kind == "application/json")
}

async fn only_json(request: Request, next: Next) -> Response {
    if request.method() == axum::http::Method::POST && !is_json(request.headers()) {
        return StatusCode::FORBIDDEN.into_response();
    }
    next.run(request).await
}

async fn image(State(study): State<Arc<Study>>, Path((observer, position)): Path<(String, usize)>) -> Response {
    let bytes =
        (0..observer.len()).step_by(2).map(|i| observer.get(i..i + 2).and_then(|hex| u8::from_str_radix(hex, 16).ok()));
    let name = bytes.collect::<Option<Vec<u8>>>().and_then(|bytes| String::from_utf8(bytes).ok());
    let place = name.and_then(|name| study.order(&name).get(position).copied());
    match place.and_then(|place| study.images.0.get(place)) {
        Some(image) => file(image.kind, image.bytes.clone()),
        None => StatusCode::NOT_FOUND.into_response(),
    }
}

/// Serves until a signal comes. Answers are on disk already: there is nothing to end.
///
/// # Errors
/// The listener failed.
pub(super) async fn serve(listener: TcpListener, study: Arc<Study>) -> std::io::Result<()> {
    let app = Router::new()
        .route("/", get(async || file("text/html; charset=utf-8", page::HTML)))
        .route("/style.css", get(async || file("text/css", page::STYLE)))
        .route("/script.js", get(async || file("text/javascript", page::SCRIPT)))
        .route("/image/{observer}/{position}", get(image))
        .route("/begin", post(async |State(study): State<Arc<Study>>, body: Bytes| json(study.begin(&body))))
        .route("/answer", post(async |State(study): State<Arc<Study>>, body: Bytes| json(study.answer(&body))))
        .layer(DefaultBodyLimit::max(4096))
        .layer(middleware::from_fn(only_json))
        .with_state(study);
    // By whatever name: an answer is no secret, and anybody may give one.
    axum::serve(listener, protected(app, Hosts::Any)).await
}
