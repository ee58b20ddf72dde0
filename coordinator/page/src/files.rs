//! The pages' files.

use axum::body::Body;
use axum::http::header;
use axum::response::{IntoResponse, Response};

/// The Content-Security-Policy of every answer: own scripts, styles and pictures, and nothing else at all. `data:` is for
/// pictures alone.
pub const POLICY: &str = "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data:; \
                          connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

const HTML: &str = "text/html; charset=utf-8";
const SCRIPT: &str = "text/javascript; charset=utf-8";

/// What is served at `/`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Page {
    /// One fit, diagnosis or sweep.
    Run,
    /// A farm's jobs and workers.
    Farm,
}

/// Name, kind and text of every file but the documents.
const FILES: [(&str, &str, &str); 11] = [
    ("style.css", "text/css; charset=utf-8", include_str!("../page/style.css")),
    ("icon.svg", "image/svg+xml", include_str!("../page/icon.svg")),
    ("stream.js", SCRIPT, include_str!("../page/stream.js")),
    ("table.js", SCRIPT, include_str!("../page/table.js")),
    ("text.js", SCRIPT, include_str!("../page/text.js")),
    ("chart.js", SCRIPT, include_str!("../page/chart.js")),
    ("pictures.js", SCRIPT, include_str!("../page/pictures.js")),
    ("parameters.js", SCRIPT, include_str!("../page/parameters.js")),
    ("causes.js", SCRIPT, include_str!("../page/causes.js")),
    ("run.js", SCRIPT, include_str!("../page/run.js")),
    ("farm.js", SCRIPT, include_str!("../page/farm.js")),
];

impl Page {
    /// The document.
    #[must_use]
    pub fn html(self) -> &'static str {
        match self {
            Self::Run => include_str!("../page/run.html"),
            Self::Farm => include_str!("../page/farm.html"),
        }
    }

    /// The answer at `/`.
    pub(crate) fn answer(self) -> Response {
        file(HTML, self.html())
    }
}

/// The file of a name.
pub(crate) fn find(name: &str) -> Option<Response> {
    FILES.iter().find(|(known, ..)| *known == name).map(|(_, kind, text)| file(kind, *text))
}

fn file(kind: &'static str, body: impl Into<Body>) -> Response {
    ([(header::CONTENT_TYPE, kind)], body.into()).into_response()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_files_name_no_other_host_and_hold_nothing_inline() {
        let pages = [Page::Run, Page::Farm].map(Page::html);
        for text in FILES.iter().map(|(.., text)| *text).chain(pages) {
            // The name of SVG's elements is no address that anybody fetches.
            let text = text.replace("http://www.w3.org/2000/svg", "");
            for bad in ["http:", "https:", "//cdn", "@import", "url(", "innerHTML", "outerHTML", "eval(", ".style."] {
                assert!(!text.contains(bad), "{bad}");
            }
        }
        for page in pages {
            for bad in ["style=", "<style", " on", "<script>", "javascript:"] {
                let found = if bad == " on" {
                    page.contains(" onclick=") || page.contains(" onload=")
                } else {
                    page.contains(bad)
                };
                assert!(!found, "{bad}");
            }
        }
    }

    #[test]
    fn every_file_that_is_named_is_served_and_every_one_served_is_named() {
        let pages = [Page::Run, Page::Farm].map(Page::html).concat();
        let all = FILES.iter().map(|(.., text)| *text).collect::<String>() + &pages;
        for (name, ..) in FILES {
            assert!(all.contains(&format!("\"{name}\"")) || all.contains(&format!("\"./{name}\"")), "{name}");
        }
        let named = all.split('"').filter_map(|word| word.strip_prefix("./"));
        for name in named.filter(|name| name.ends_with(".js")) {
            assert!(FILES.iter().any(|(known, ..)| *known == name), "{name}");
        }
    }
}
