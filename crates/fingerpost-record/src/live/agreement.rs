//! With whom the protocol is agreed on.

use std::sync::Arc;

use tungstenite::handshake::server::{Callback, ErrorResponse, Request, Response};
use tungstenite::http::{HeaderValue, StatusCode, header};

use super::live_view::Shared;
use super::{origin, protocol};

/// Answers a handshake.
#[derive(Debug)]
pub(crate) struct Agreement(Arc<Shared>);

impl Agreement {
    pub(crate) fn new(shared: &Arc<Shared>) -> Self {
        Self(Arc::clone(shared))
    }
}

impl Callback for Agreement {
    /// Refuses those who come under another name than this machine's own, as pages whose name was made to lead here do, pages of other
    /// sites, and those who speak another protocol.
    fn on_request(self, asked: &Request, mut answer: Response) -> Result<Response, ErrorResponse> {
        let Self(shared) = self;
        let (Some(host), Some(origin)) = (only(asked, header::HOST), only(asked, header::ORIGIN)) else {
            return Err(refusal(StatusCode::BAD_REQUEST, "a header is there twice or is no text"));
        };
        let names = [format!("127.0.0.1:{}", shared.port), format!("localhost:{}", shared.port)];
        if !host.is_some_and(|host| names.iter().any(|name| name == host)) {
            return Err(refusal(StatusCode::FORBIDDEN, "come to 127.0.0.1 or localhost"));
        }
        // A program that is no browser says none.
        if origin.is_some_and(|origin| !origin::may_connect(origin, &shared.origins)) {
            return Err(refusal(
                StatusCode::FORBIDDEN,
                "a page of this site may not connect; name the site with --serve-origin if it may",
            ));
        }
        let offered = asked.headers().get_all(header::SEC_WEBSOCKET_PROTOCOL).iter();
        let offered: Vec<&str> =
            offered.filter_map(|value| value.to_str().ok()).flat_map(|text| text.split(',')).collect();
        let chosen = protocol::SUBPROTOCOLS
            .into_iter()
            .find(|known| offered.iter().any(|offer| offer.trim() == *known));
        let Some(chosen) = chosen else {
            return Err(refusal(
                StatusCode::BAD_REQUEST,
                "the subprotocol is foxglove.sdk.v1 or foxglove.websocket.v1",
            ));
        };
        answer.headers_mut().insert(header::SEC_WEBSOCKET_PROTOCOL, HeaderValue::from_static(chosen));
        Ok(answer)
    }
}

/// The value of a header that may be there once; none where it is there twice or is no text.
fn only(asked: &Request, name: header::HeaderName) -> Option<Option<&str>> {
    let mut values = asked.headers().get_all(name).iter();
    match (values.next(), values.next()) {
        (None, _) => Some(None),
        (Some(value), None) => value.to_str().ok().map(Some),
        (Some(_), Some(_)) => None,
    }
}

fn refusal(status: StatusCode, why: &str) -> ErrorResponse {
    let mut response = ErrorResponse::new(Some(why.to_owned()));
    *response.status_mut() = status;
    response
}
