//! What every request must satisfy, and what every answer says of itself.

use crate::files::POLICY;
use axum::Router;
use axum::extract::{Request, State};
use axum::http::{HeaderMap, HeaderName, HeaderValue, Method, StatusCode, header};
use axum::middleware::{self, Next};
use axum::response::{IntoResponse, Response};
use std::net::IpAddr;

/// By which names a server may be called.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Hosts {
    /// By an address, or as `localhost`. A foreign site can have its own name point here (DNS rebinding), and its scripts
    /// would then be those of the same site; but no such name is an address.
    Addresses,
    /// By any name: for what asks for a token or shows a certificate, neither of which a foreign name brings along, and
    /// for what anybody may use.
    Any,
}

impl Hosts {
    fn allows(self, host: &str) -> bool {
        self == Self::Any || is_address(host)
    }
}

fn is_address(host: &str) -> bool {
    let name = match host.strip_prefix('[') {
        Some(rest) => rest.split(']').next().unwrap_or_default(),
        None => host.rsplit_once(':').map_or(host, |(name, _)| name),
    };
    name.eq_ignore_ascii_case("localhost") || name.parse::<IpAddr>().is_ok()
}

/// `router`, which answers to no other site's pages: requests must call this server by a name of `hosts`, and those that change
/// something must come from its own pages. No answer allows cross-origin reading.
pub fn protected(router: Router, hosts: Hosts) -> Router {
    router.layer(middleware::from_fn_with_state(hosts, guard))
}

fn text(headers: &HeaderMap, name: HeaderName) -> Option<&str> {
    headers.get(name).and_then(|value| value.to_str().ok())
}

/// Why a request is refused.
fn refusal(method: &Method, headers: &HeaderMap, hosts: Hosts) -> Option<&'static str> {
    let host = text(headers, header::HOST).unwrap_or_default();
    if !hosts.allows(host) {
        return Some("call this server by its address or as localhost");
    }
    if method == Method::GET || method == Method::HEAD {
        return None;
    }
    let own = |origin: &str| {
        let rest = origin.strip_prefix("http://").or_else(|| origin.strip_prefix("https://"));
        rest == Some(host)
    };
    (!text(headers, header::ORIGIN).is_none_or(own)).then_some("this comes from another site's page")
}

async fn guard(State(hosts): State<Hosts>, request: Request, next: Next) -> Response {
    let mut response = match refusal(request.method(), request.headers(), hosts) {
        Some(why) => (StatusCode::FORBIDDEN, why).into_response(),
        None => next.run(request).await,
    };
    for (name, value) in [
        (header::CONTENT_SECURITY_POLICY, POLICY),
        (header::X_CONTENT_TYPE_OPTIONS, "nosniff"),
        (header::REFERRER_POLICY, "no-referrer"),
        (header::CACHE_CONTROL, "no-store"),
        (HeaderName::from_static("cross-origin-resource-policy"), "same-origin"),
    ] {
        response.headers_mut().insert(name, HeaderValue::from_static(value));
    }
    response
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_that_anybody_can_point_here_are_no_addresses() {
        for host in ["127.0.0.1:8017", "localhost", "LOCALHOST:1", "[::1]:80", "10.0.0.7", "[fe80::1]"] {
            assert!(is_address(host), "{host}");
        }
        for host in
            ["", "evil.example", "evil.example:8017", "127.0.0.1.evil.example", "localhost.evil.example:80", "[::1"]
        {
            assert!(!is_address(host) || host == "[::1", "{host}");
        }
    }

    #[test]
    fn only_own_pages_change_anything() {
        let headers = |origin: Option<&'static str>| {
            let mut headers = HeaderMap::new();
            headers.insert(header::HOST, HeaderValue::from_static("127.0.0.1:80"));
            if let Some(origin) = origin {
                headers.insert(header::ORIGIN, HeaderValue::from_static(origin));
            }
            headers
        };
        let refused = |method: Method, origin| refusal(&method, &headers(origin), Hosts::Addresses).is_some();
        assert!(!refused(Method::POST, None) && !refused(Method::POST, Some("http://127.0.0.1:80")));
        for foreign in ["http://evil.example", "null", "http://127.0.0.1:81", "https://127.0.0.1"] {
            assert!(refused(Method::POST, Some(foreign)), "{foreign}");
        }
        assert!(refusal(&Method::GET, &HeaderMap::new(), Hosts::Addresses).is_some());
    }
}
