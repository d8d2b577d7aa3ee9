//! Who may ask: pages of this server, opened on this machine.
//!
//! A page of another site can reach a loopback address through a name of its own (DNS rebinding) or by sending forms to it.
//! So a request must name this address in `Host`, and in `Origin` where it has one; and what it sends must be JSON, which a
//! page of another site may not send without being asked first.

use hyper::header::{CONTENT_TYPE, HOST, HeaderMap, HeaderName, ORIGIN};
use hyper::{Method, StatusCode};

/// Why a request is not answered: status and text.
pub(crate) type Refusal = (StatusCode, String);

/// Why a request is not answered, if it is not.
pub(crate) fn refusal(port: u16, method: &Method, headers: &HeaderMap) -> Option<Refusal> {
    let refused = |status, text: &str| Some((status, text.to_owned()));
    let (Some(host), Some(origin), Some(content_type)) =
        (only(headers, HOST), only(headers, ORIGIN), only(headers, CONTENT_TYPE))
    else {
        return refused(StatusCode::BAD_REQUEST, "a header is there twice or is no text");
    };
    let own = |name: &str| name == format!("127.0.0.1:{port}") || name == format!("localhost:{port}");
    if !host.is_some_and(own) {
        return refused(StatusCode::FORBIDDEN, &format!("open http://127.0.0.1:{port}/ on this machine"));
    }
    if origin.is_some_and(|origin| !origin.strip_prefix("http://").is_some_and(own)) {
        return refused(StatusCode::FORBIDDEN, "a page of another site may not ask this");
    }
    let is_json = content_type.is_some_and(|kind| kind.starts_with("application/json"));
    if method == Method::POST && !is_json {
        return refused(StatusCode::UNSUPPORTED_MEDIA_TYPE, "send JSON");
    }
    None
}

/// The value of a header that may be there once; none where it is there twice or is no text.
fn only(headers: &HeaderMap, name: HeaderName) -> Option<Option<&str>> {
    let mut values = headers.get_all(name).iter();
    match (values.next(), values.next()) {
        (None, _) => Some(None),
        (Some(value), None) => value.to_str().ok().map(Some),
        (Some(_), Some(_)) => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn status(method: Method, headers: &[(HeaderName, &str)]) -> Option<u16> {
        let headers: HeaderMap =
            headers.iter().map(|(name, value)| (name.clone(), value.parse().unwrap())).collect();
        refusal(8420, &method, &headers).map(|(status, _)| status.as_u16())
    }

    #[test]
    fn only_this_machines_own_page_is_answered() {
        const OWN: (HeaderName, &str) = (HOST, "127.0.0.1:8420");
        const JSON: (HeaderName, &str) = (CONTENT_TYPE, "application/json");
        assert_eq!(status(Method::GET, &[OWN]), None);
        assert_eq!(status(Method::GET, &[(HOST, "localhost:8420")]), None);
        assert_eq!(status(Method::POST, &[OWN, (ORIGIN, "http://127.0.0.1:8420"), JSON]), None);
        assert_eq!(status(Method::GET, &[]), Some(403));
        for host in ["evil.example", "127.0.0.1", "127.0.0.1:80", "127.0.0.1:8420.evil.example"] {
            assert_eq!(status(Method::GET, &[(HOST, host)]), Some(403), "{host}");
        }
        for origin in ["http://evil.example", "https://127.0.0.1:8420", "null"] {
            assert_eq!(status(Method::POST, &[OWN, (ORIGIN, origin), JSON]), Some(403), "{origin}");
        }
        assert_eq!(status(Method::POST, &[OWN, (CONTENT_TYPE, "text/plain")]), Some(415));
        assert_eq!(status(Method::POST, &[OWN]), Some(415));
    }

    #[test]
    fn a_header_that_is_there_twice_is_refused() {
        let mut headers = HeaderMap::new();
        for host in ["127.0.0.1:8420", "evil.example"] {
            headers.append(HOST, host.parse().unwrap());
        }
        assert_eq!(refusal(8420, &Method::GET, &headers).map(|(status, _)| status.as_u16()), Some(400));
    }
}
