//! One viewer's connection.

use std::collections::BTreeMap;
use std::io::ErrorKind;
use std::net::TcpStream;
use std::time::Duration;

use tungstenite::protocol::frame::coding::CloseCode;
use tungstenite::protocol::{CloseFrame, WebSocketConfig};
use tungstenite::{Error, Message, WebSocket};

use super::live_view::Shared;
use super::protocol::{self, Request};
use super::viewer::Viewer;
use crate::recording::{Channel, FrameMessages};

/// How long a connection may take to take what it is sent.
const PATIENCE: Duration = Duration::from_secs(5);
/// How long is listened for a viewer's wishes before frames are looked for: what that adds to a frame's way.
const LISTEN: Duration = Duration::from_millis(5);
/// Bytes of the largest request; a subscription to every channel has two thousand.
const MOST_REQUEST_BYTES: usize = 1 << 20;

/// Bounds of what a viewer sends.
pub(crate) fn config() -> WebSocketConfig {
    WebSocketConfig::default()
        .max_message_size(Some(MOST_REQUEST_BYTES))
        .max_frame_size(Some(MOST_REQUEST_BYTES))
}

/// Tells a viewer that there is no place for it, as far as the system takes it at once.
pub(crate) fn turn_away(mut socket: WebSocket<TcpStream>) {
    let frame = CloseFrame { code: CloseCode::Again, reason: "all places of viewers are taken".into() };
    // Whoever does not hear it finds the connection closed.
    let _ = socket.close(Some(frame));
}

/// Says which channels there are.
pub(crate) fn greet(socket: &mut WebSocket<TcpStream>, shared: &Shared) -> Result<(), Box<Error>> {
    let stream = socket.get_ref();
    stream
        .set_nonblocking(false)
        .and_then(|()| stream.set_read_timeout(Some(LISTEN)))
        .and_then(|()| stream.set_write_timeout(Some(PATIENCE)))
        .map_err(|cause| Box::new(Error::Io(cause)))?;
    socket.send(Message::text(protocol::server_info(&shared.name))).map_err(Box::new)?;
    socket.send(Message::text(protocol::advertisement())).map_err(Box::new)
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

/// The channels that a viewer wants, by what it calls them; each of them once.
type Wishes = BTreeMap<u32, Channel>;

/// Takes in the next thing that a viewer says, if it says anything: frames are looked for behind each, however much it has to say. No
/// more channels are new than there are.
fn listen(socket: &mut WebSocket<TcpStream>, wishes: &mut Wishes) -> Result<Vec<NewWish>, Box<Error>> {
    let mut new = Vec::new();
    let text = match socket.read() {
        Ok(Message::Text(text)) => text,
        Ok(_) => return Ok(new),
        Err(Error::Io(cause)) if matches!(cause.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut) => {
            return Ok(new);
        }
        Err(cause) => return Err(Box::new(cause)),
    };
    match serde_json::from_str(text.as_str()) {
        Ok(Request::Subscribe { subscriptions }) => {
            for wish in subscriptions {
                let Some(channel) = protocol::channel(wish.channel_id) else { continue };
                // As Foxglove's own server does; else a viewer could have the same frames a million times over.
                if wishes.contains_key(&wish.id) || wishes.values().any(|wanted| *wanted == channel) {
                    continue;
                }
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
    Ok(new)
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

#[cfg(test)]
mod tests {
    use std::net::{Ipv4Addr, TcpListener};

    use tungstenite::protocol::Role;

    use super::*;

    /// A viewer, and the server's end of its connection.
    fn connected() -> [WebSocket<TcpStream>; 2] {
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, 0)).unwrap();
        let viewer = TcpStream::connect(listener.local_addr().unwrap()).unwrap();
        let server = listener.accept().unwrap().0;
        server.set_read_timeout(Some(PATIENCE)).unwrap();
        [
            WebSocket::from_raw_socket(viewer, Role::Client, None),
            WebSocket::from_raw_socket(server, Role::Server, Some(config())),
        ]
    }

    #[test]
    fn a_viewer_that_never_pauses_is_heard_one_request_at_a_time() {
        let [mut viewer, mut server] = connected();
        let wish = r#"{"op":"subscribe","subscriptions":[{"id":7,"channelId":1}]}"#;
        let no_wish = r#"{"op":"unsubscribe","subscriptionIds":[7]}"#;
        for _ in 0..100 {
            viewer.send(Message::text(wish)).unwrap();
            viewer.send(Message::text(no_wish)).unwrap();
        }
        let mut wishes = Wishes::default();
        for _ in 0..100 {
            assert_eq!(listen(&mut server, &mut wishes).unwrap().len(), 1);
            assert_eq!(wishes.len(), 1);
            assert_eq!(listen(&mut server, &mut wishes).unwrap().len(), 0);
            assert_eq!(wishes.len(), 0);
        }
    }

    #[test]
    fn one_request_makes_no_more_channels_new_than_there_are() {
        let [mut viewer, mut server] = connected();
        let wishes: Vec<String> =
            (0..2000).map(|number| format!(r#"{{"id":7,"channelId":{}}}"#, 1 + number % 2)).collect();
        let request = format!(r#"{{"op":"subscribe","subscriptions":[{}]}}"#, wishes.join(","));
        viewer.send(Message::text(request)).unwrap();
        assert_eq!(listen(&mut server, &mut Wishes::default()).unwrap().len(), 1);
    }
}
