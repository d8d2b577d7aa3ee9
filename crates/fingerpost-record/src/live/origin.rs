//! Whose pages may connect.
//!
//! A page of any site that is open in a browser of this machine may open a WebSocket to it: the rules that keep pages from reading
//! each other's sites do not hold for WebSockets, and the server must look at the header `Origin` (RFC 6455, 10.2), which browsers
//! alone send, and no page can change.

use std::str::FromStr;

use thiserror::Error;
use tungstenite::http::Uri;

/// Where Foxglove in a browser comes from.
const FOXGLOVE: &str = "https://app.foxglove.dev";
/// What pages of this machine's files come from, as Foxglove's program for the desktop does.
const FILES: &str = "file://";
/// This machine's names, whose pages its own programs serve.
const LOOPBACK: [&str; 3] = ["localhost", "127.0.0.1", "[::1]"];

/// A site whose pages may connect: scheme, host and port, as browsers name it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Origin(String);

/// A text that is no site.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error(
    "{text:?} is no origin; give scheme and host, and the port where it is not the usual one: https://viewer.example:8443"
)]
pub struct NoOrigin {
    text: String,
}

impl FromStr for Origin {
    type Err = NoOrigin;

    fn from_str(text: &str) -> Result<Self, NoOrigin> {
        let no_origin = || NoOrigin { text: text.to_owned() };
        let (scheme, host) = text.split_once("://").ok_or_else(no_origin)?;
        let uri: Uri = text.parse().map_err(|_| no_origin())?;
        // A path, a query or a user would be no part of what browsers send, and the origin would never match.
        let is_bare =
            uri.authority().is_some_and(|authority| authority.as_str() == host) && !host.contains('@');
        if !is_bare || !["http", "https"].contains(&scheme) {
            return Err(no_origin());
        }
        Ok(Self(text.to_ascii_lowercase()))
    }
}

/// Whether pages of the site that a browser names may connect: Foxglove's, this machine's own, and those of `more`.
pub(crate) fn may_connect(origin: &str, more: &[Origin]) -> bool {
    if origin == FOXGLOVE || origin == FILES || more.iter().any(|Origin(other)| origin == other) {
        return true;
    }
    let host = ["http://", "https://"].iter().find_map(|scheme| origin.strip_prefix(scheme));
    host.is_some_and(|host| {
        LOOPBACK.iter().any(|name| {
            let port = host.strip_prefix(name);
            port.is_some_and(|port| port.is_empty() || port.strip_prefix(':').is_some_and(is_port))
        })
    })
}

fn is_port(text: &str) -> bool {
    text.parse::<u16>().is_ok() && text.bytes().all(|byte| byte.is_ascii_digit())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_foxgloves_and_this_machines_pages_may_connect() {
        for origin in [
            "https://app.foxglove.dev",
            "file://",
            "http://localhost:8080",
            "http://localhost",
            "https://127.0.0.1:8443",
            "http://[::1]:3000",
        ] {
            assert!(may_connect(origin, &[]), "{origin}");
        }
        for origin in [
            "null",
            "",
            "http://evil.example",
            "https://evil.example",
            "http://app.foxglove.dev",
            "https://app.foxglove.dev.evil.example",
            "https://app.foxglove.dev:444",
            "http://localhost.evil.example",
            "http://localhost:8080.evil.example",
            "http://localhost:+80",
            "http://localhost@evil.example",
            "http://127.0.0.1.evil.example:80",
            "file://evil.example",
            "ws://localhost:8765",
        ] {
            assert!(!may_connect(origin, &[]), "{origin}");
        }
    }

    #[test]
    fn a_user_may_name_more_and_what_is_no_origin_is_said() {
        let own: Origin = "https://Viewer.example:8443".parse().unwrap();
        assert!(may_connect("https://viewer.example:8443", std::slice::from_ref(&own)));
        for other in ["https://viewer.example", "http://viewer.example:8443", "https://viewer.example:84430"]
        {
            assert!(!may_connect(other, std::slice::from_ref(&own)), "{other}");
        }
        for text in [
            "viewer.example",
            "*",
            "null",
            "https://",
            "https://a/b",
            "https://a/",
            "https://u@a",
            "ws://a",
            "https://a b",
        ] {
            let said = text.parse::<Origin>().unwrap_err().to_string();
            assert!(said.contains("https://viewer.example:8443"), "{text}: {said}");
        }
    }
}
