//! What a page shows, as whoever has it to show implements it.

use axum::body::Bytes;
use axum::http::StatusCode;
use axum::response::{IntoResponse, Response};
use serde_json::{Map, Value};

/// Something to show.
pub trait Show: Send + Sync + 'static {
    /// Who is let in, by the request's `Authorization`.
    ///
    /// # Errors
    /// Nobody who may look.
    fn admit(&self, authorization: Option<&str>) -> Result<Visitor, Refusal>;

    /// All of it, now. It is asked about twice a second for every page that is open, and should take milliseconds at most.
    fn state(&self, view: &View) -> Map<String, Value>;

    /// Whether nothing will change any more.
    fn is_over(&self) -> bool {
        false
    }

    /// The PNG of a name that the state told.
    fn picture(&self, _name: &str) -> Option<Bytes> {
        None
    }

    /// Does what a visitor who may act asks for; the text says what was done.
    ///
    /// # Errors
    /// No such action, or none now.
    fn act(&self, action: &str, of: &Value) -> Result<String, Refusal>;
}

/// Who looks.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Visitor {
    /// Whether [`Show::act`] is for them, too.
    pub may_act: bool,
}

/// Why a request is refused, for people.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Refusal {
    /// No token, or an unknown one.
    Unknown(String),
    /// The token does not allow this.
    Forbidden(String),
    /// There is no such thing, or not any more.
    Absent(String),
    /// The question makes no sense.
    Bad(String),
    /// Too many are here.
    Full(String),
}

impl IntoResponse for Refusal {
    fn into_response(self) -> Response {
        let (status, text) = match self {
            Self::Unknown(text) => (StatusCode::UNAUTHORIZED, text),
            Self::Forbidden(text) => (StatusCode::FORBIDDEN, text),
            Self::Absent(text) => (StatusCode::NOT_FOUND, text),
            Self::Bad(text) => (StatusCode::BAD_REQUEST, text),
            Self::Full(text) => (StatusCode::SERVICE_UNAVAILABLE, text),
        };
        (status, text).into_response()
    }
}

/// Which part of a long state a page shows: the query of its stream's address.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct View(Vec<(String, String)>);

/// Some rows of a long table.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Window {
    /// The first row's place.
    pub from: usize,
    /// Rows.
    pub count: usize,
}

impl View {
    /// Most rows of a window.
    pub const MOST_ROWS: usize = 200;

    /// The view of a query such as `jobs=100,50&find=fit`.
    #[must_use]
    pub fn of(query: &str) -> Self {
        Self(form_urlencoded::parse(query.as_bytes()).into_owned().collect())
    }

    /// The text of a key; empty where there is none.
    #[must_use]
    pub fn text(&self, key: &str) -> &str {
        self.0.iter().find(|(known, _)| known == key).map_or("", |(_, value)| value)
    }

    /// The window `FROM,COUNT` of a key; the first 50 rows where there is none.
    #[must_use]
    pub fn window(&self, key: &str) -> Window {
        let numbers = self.text(key).split_once(',').and_then(|(a, b)| Some((a.parse().ok()?, b.parse().ok()?)));
        let (from, count): (usize, usize) = numbers.unwrap_or((0, 50));
        Window { from, count: count.min(Self::MOST_ROWS) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_view_is_what_the_query_says_within_bounds() {
        let view = View::of("jobs=100,25&find=a%20b%26c&workers=5,99999999&odd=7,x");
        assert_eq!(view.window("jobs"), Window { from: 100, count: 25 });
        assert_eq!(view.window("workers"), Window { from: 5, count: View::MOST_ROWS });
        assert_eq!(view.text("find"), "a b&c");
        for absent in ["odd", "none"] {
            assert_eq!(view.window(absent), Window { from: 0, count: 50 });
        }
    }
}
