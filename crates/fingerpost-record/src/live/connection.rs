//! One viewer's connection.

use std::collections::BTreeMap;
use std::io::ErrorKind;
use std::net::TcpStream;
use std::time::Duration;

use tungstenite::handshake::server::{ErrorResponse, Request as Handshake, Response};
use tungstenite::http::{HeaderValue, StatusCode, header};
use tungstenite::protocol::WebSocketConfig;
use tungstenite::{Error, Message, WebSocket, accept_hdr_with_config};

use super::live_view::Shared;
use super::protocol::{self, Request};
use super::viewer::Viewer;
use crate::recording::{Channel, FrameMessages};

/// How long a connection may take to say what it wants, and to take what it is sent.
const PATIENCE: Duration = Duration::from_secs(5);
/// How long is listened for a viewer's wishes before frames are looked for: what that adds to a frame's way.
const LISTEN: Duration = Duration::from_millis(5);
/// Bytes of the largest request; a subscription to every channel has two thousand.
const MOST_REQUEST_BYTES: usize = 1 << 20;

/// Agrees on the protocol; none with what is no viewer.
pub(crate) fn greet(stream: TcpStream, shared: &Shared) -> Option<WebSocket<TcpStream>> {
    // On some systems a connection takes this over from the listener.
    stream.set_nonblocking(false).ok()?;
    stream.set_nodelay(true).ok()?;
    stream.set_read_timeout(Some(PATIENCE)).ok()?;
    stream.set_write_timeout(Some(PATIENCE)).ok()?;
    let config = WebSocketConfig::default()
        .max_message_size(Some(MOST_REQUEST_BYTES))
        .max_frame_size(Some(MOST_REQUEST_BYTES));
    #[expect(clippy::result_large_err, reason = "the form that tungstenite asks for")]
    let agree = |asked: &Handshake, answer: Response| agree(asked, answer, shared.port);
    let mut socket = accept_hdr_with_config(stream, agree, Some(config)).ok()?;
    socket.get_ref().set_read_timeout(Some(LISTEN)).ok()?;
    socket.send(Message::text(protocol::server_info(&shared.name))).ok()?;
    socket.send(Message::text(protocol::advertisement())).ok()?;
    Some(socket)
}

/// Refuses those who come under another name than this machine's own, as pages whose name was made to lead here do, and those who
/// speak another protocol.
#[expect(clippy::result_large_err, reason = "the form that tungstenite asks for")]
fn agree(asked: &Handshake, mut answer: Response, port: u16) -> Result<Response, ErrorResponse> {
    let text = |name: header::HeaderName| asked.headers().get(name).and_then(|value| value.to_str().ok());
    let names = [format!("127.0.0.1:{port}"), format!("localhost:{port}")];
    if !text(header::HOST).is_some_and(|host| names.iter().any(|name| name == host)) {
        return Err(refusal(StatusCode::FORBIDDEN, "come to 127.0.0.1 or localhost"));
    }
    let offered = text(header::SEC_WEBSOCKET_PROTOCOL).unwrap_or_default();
    let chosen = protocol::SUBPROTOCOLS
        .into_iter()
        .find(|known| offered.split(',').any(|offer| offer.trim() == *known));
    let Some(chosen) = chosen else {
        return Err(refusal(
            StatusCode::BAD_REQUEST,
            "the subprotocol is foxglove.sdk.v1 or foxglove.websocket.v1",
        ));
    };
    answer.headers_mut().insert(header::SEC_WEBSOCKET_PROTOCOL, HeaderValue::from_static(chosen));
    Ok(answer)
}

fn refusal(status: StatusCode, why: &str) -> ErrorResponse {
    let mut response = ErrorResponse::new(Some(why.to_owned()));
    *response.status_mut() = status;
    response
}

/// Sends what is wanted until the viewer leaves, or everything that there will be has been sent.
pub(crate) fn serve(
    mut socket: WebSocket<TcpStream>,
    viewer: &Viewer,
    shared: &Shared,
) -> Result<(), Box<Error>> {
    let mut wishes = Wishes::default();
    loop {
        // Looked at first, so that a frame which came before the end is sent before it.
        let ended = shared.has_ended();
        for new in listen(&mut socket, &mut wishes)? {
            if let (Channel::Route, Some(route)) = (new.channel, &shared.route) {
                send(&mut socket, new.subscription, 0, route)?;
            }
        }
        while let Some(frame) = viewer.take() {
            send_frame(&mut socket, &wishes, &frame)?;
        }
        if ended {
            socket.close(None).map_err(Box::new)?;
            // The viewer's answer, which ends the connection, or its silence.
            while socket.read().is_ok() {}
            return Ok(());
        }
    }
}

/// A channel that a viewer has come to want.
struct NewWish {
    channel: Channel,
    subscription: u32,
}

/// The channels that a viewer wants, by what it calls them.
type Wishes = BTreeMap<u32, Channel>;

/// Takes in what a viewer says until it is silent.
fn listen(socket: &mut WebSocket<TcpStream>, wishes: &mut Wishes) -> Result<Vec<NewWish>, Box<Error>> {
    let mut new = Vec::new();
    loop {
        let text = match socket.read() {
            Ok(Message::Text(text)) => text,
            Ok(_) => continue,
            Err(Error::Io(cause)) if matches!(cause.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut) => {
                return Ok(new);
            }
            Err(cause) => return Err(Box::new(cause)),
        };
        match serde_json::from_str(text.as_str()) {
            Ok(Request::Subscribe { subscriptions }) => {
                for wish in subscriptions {
                    let Some(channel) = protocol::channel(wish.channel_id) else { continue };
                    wishes.insert(wish.id, channel);
                    new.push(NewWish { channel, subscription: wish.id });
                }
            }
            Ok(Request::Unsubscribe { subscription_ids }) => {
                wishes.retain(|id, _| !subscription_ids.contains(id));
            }
            // What is no request, or one that is not listened to.
            Ok(Request::Other) | Err(_) => {}
        }
    }
}

fn send_frame(
    socket: &mut WebSocket<TcpStream>,
    wishes: &Wishes,
    frame: &FrameMessages,
) -> Result<(), Box<Error>> {
    for (channel, data) in &frame.messages {
        for (subscription, _) in wishes.iter().filter(|(_, wanted)| *wanted == channel) {
            send(socket, *subscription, frame.time_ns(), data)?;
        }
    }
    Ok(())
}

fn send(
    socket: &mut WebSocket<TcpStream>,
    subscription: u32,
    time_ns: u64,
    data: &[u8],
) -> Result<(), Box<Error>> {
    let bytes = protocol::message_data(subscription, time_ns, data);
    socket.send(Message::binary(bytes)).map_err(Box::new)
}
