//! The routes: documents and files, the stream, pictures, actions.

use crate::files::{self, Page};
use crate::guard::{Hosts, protected};
use crate::show::{Refusal, Show, View};
use crate::stream::follow;
use crate::viewers::Viewers;
use axum::Router;
use axum::body::Bytes;
use axum::extract::{DefaultBodyLimit, Path, RawQuery, State};
use axum::http::{HeaderMap, StatusCode, header};
use axum::response::{IntoResponse, Response};
use axum::routing::{get, post};
use axum::serve::Listener;
use std::sync::Arc;

/// The header that an action must have: a form cannot send it, and another site's script only where the server agrees,
/// which this one never does.
pub const HEADER: &str = "x-gonio-page";

#[derive(Clone)]
struct Site {
    show: Arc<dyn Show>,
    page: Page,
    viewers: Viewers,
}

/// The routes of a page that shows `show`; `viewers` count who follows.
pub fn router(page: Page, show: Arc<dyn Show>, hosts: Hosts, viewers: Viewers) -> Router {
    let router = Router::new()
        .route("/", get(async |State(site): State<Site>| site.page.answer()))
        .route("/{file}", get(file))
        .route("/events", get(events))
        .route("/picture/{name}", get(picture))
        .route("/act/{action}", post(act))
        .layer(DefaultBodyLimit::max(4096))
        .with_state(Site { show, page, viewers });
    protected(router, hosts)
}

/// Serves the routes to whoever a listener lets in, until dropped.
///
/// # Errors
/// None that a connection could cause.
pub async fn serve<L>(listener: L, router: Router) -> std::io::Result<()>
where
    L: Listener,
    L::Addr: std::fmt::Debug,
{
    axum::serve(listener, router).await
}

fn authorization(headers: &HeaderMap) -> Option<&str> {
    headers.get(header::AUTHORIZATION).and_then(|value| value.to_str().ok())
}

async fn file(Path(name): Path<String>) -> Response {
    files::find(&name).unwrap_or_else(|| StatusCode::NOT_FOUND.into_response())
}

async fn events(State(site): State<Site>, headers: HeaderMap, RawQuery(query): RawQuery) -> Result<Response, Refusal> {
    let visitor = site.show.admit(authorization(&headers))?;
    let full = || Refusal::Full("too many pages follow already; close one".to_owned());
    let seat = site.viewers.enter().ok_or_else(full)?;
    Ok(follow(site.show, View::of(&query.unwrap_or_default()), visitor, seat))
}

async fn picture(State(site): State<Site>, headers: HeaderMap, Path(name): Path<String>) -> Result<Response, Refusal> {
    site.show.admit(authorization(&headers))?;
    let png = site.show.picture(&name).ok_or_else(|| Refusal::Absent("there is no such picture".to_owned()))?;
    Ok(([(header::CONTENT_TYPE, "image/png")], png).into_response())
}

async fn act(
    State(site): State<Site>,
    headers: HeaderMap,
    Path(action): Path<String>,
    body: Bytes,
) -> Result<String, Refusal> {
    if !headers.contains_key(HEADER) {
        return Err(Refusal::Forbidden(format!("an action needs the header {HEADER}")));
    }
    if !site.show.admit(authorization(&headers))?.may_act {
        return Err(Refusal::Forbidden("this token may look, and change nothing".to_owned()));
    }
    let of = if body.is_empty() { Ok(serde_json::Value::Null) } else { serde_json::from_slice(&body) };
    site.show.act(&action, &of.map_err(|error| Refusal::Bad(format!("no question: {error}")))?)
}
