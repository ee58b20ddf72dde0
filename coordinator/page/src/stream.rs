//! What one page is sent: the state once, then what changes.

use crate::patch::{difference, prune};
use crate::show::{Show, View, Visitor};
use crate::viewers::Seat;
use axum::response::sse::{Event, KeepAlive, Sse};
use axum::response::{IntoResponse, Response};
use futures::stream;
use serde_json::{Map, Value};
use std::convert::Infallible;
use std::sync::Arc;
use std::time::Duration;
use tokio::time::{Interval, MissedTickBehavior};

/// Least time between two events of a page: nobody reads faster, and what happens meanwhile is sent at once.
pub const INTERVAL: Duration = Duration::from_millis(500);

/// How often a page hears something, whether there is news or not, so that it can tell silence from a server that is gone.
const ALIVE: Duration = Duration::from_secs(5);

struct Follow {
    show: Arc<dyn Show>,
    view: View,
    visitor: Visitor,
    ticks: Interval,
    /// What the page knows.
    known: Option<Map<String, Value>>,
    _seat: Seat,
}

/// The stream of one page.
pub(crate) fn follow(show: Arc<dyn Show>, view: View, visitor: Visitor, seat: Seat) -> Response {
    let mut ticks = tokio::time::interval(INTERVAL);
    // A page that reads slowly is sent less often, not more at once.
    ticks.set_missed_tick_behavior(MissedTickBehavior::Delay);
    let follow = Follow { show, view, visitor, ticks, known: None, _seat: seat };
    let events = stream::unfold(follow, |mut follow| async move {
        let event = follow.next().await;
        Some((Ok::<_, Infallible>(event), follow))
    });
    Sse::new(events).keep_alive(KeepAlive::new().interval(ALIVE)).into_response()
}

impl Follow {
    async fn next(&mut self) -> Event {
        loop {
            self.ticks.tick().await;
            // Asked before the state is, so that the state of what is over is its last.
            let over = self.show.is_over();
            let mut state = self.show.state(&self.view);
            state.insert("may_act".to_owned(), self.visitor.may_act.into());
            prune(&mut state);
            let Some(known) = self.known.replace(state) else {
                return self.event("snapshot", self.known.as_ref());
            };
            let patch = self.known.as_ref().map(|state| difference(&known, state)).unwrap_or_default();
            if !patch.is_empty() {
                return self.event("patch", Some(&patch));
            }
            if over {
                // The page closes the stream, once it has fetched the pictures, too.
                self.ticks = tokio::time::interval_at(tokio::time::Instant::now() + FOREVER, FOREVER);
                return Event::default().event("end").data("{}");
            }
        }
    }

    fn event(&self, name: &str, data: Option<&Map<String, Value>>) -> Event {
        let text = data.map(serde_json::to_string).and_then(Result::ok).unwrap_or_default();
        Event::default().event(name).data(text)
    }
}

/// Longer than any page is open.
const FOREVER: Duration = Duration::from_secs(1 << 30);
