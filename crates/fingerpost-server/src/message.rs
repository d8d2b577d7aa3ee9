//! Requests and answers without a network.

use serde::Serialize;
use serde_json::json;

/// A request that came whole and from where it may come.
#[derive(Debug, Clone, Copy)]
pub struct Request<'a> {
    /// `GET`, `POST` or another method.
    pub method: &'a str,
    /// Path, with its leading slash and without a query.
    pub path: &'a str,
    /// What it carries.
    pub body: &'a [u8],
}

/// What is answered.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Answer {
    /// HTTP status, 200 to 599.
    pub status: u16,
    /// Type of the body.
    pub content_type: &'static str,
    /// The body.
    pub body: Vec<u8>,
}

/// Answers requests, in any thread and several at once.
pub trait Handler: Send + Sync + 'static {
    /// Answers a request.
    fn answer(&self, request: Request<'_>) -> Answer;
}

impl Answer {
    /// An error that a page shows: a JSON object with the text `error`.
    pub fn refused(status: u16, cause: &str) -> Self {
        Self::json(status, &json!({ "error": cause }))
    }

    /// A text of that type.
    pub fn text(content_type: &'static str, text: &str) -> Self {
        Self { status: 200, content_type, body: text.as_bytes().to_vec() }
    }

    /// Data as JSON.
    pub fn json<T: Serialize>(status: u16, data: &T) -> Self {
        match serde_json::to_vec(data) {
            Ok(body) => Self { status, content_type: "application/json", body },
            Err(cause) => {
                let body = json!({ "error": format!("the answer has no JSON form ({cause})") });
                Self { status: 500, content_type: "application/json", body: body.to_string().into_bytes() }
            }
        }
    }
}
