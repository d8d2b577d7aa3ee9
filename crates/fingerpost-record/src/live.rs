//! Viewers that are connected while a drive is run: the messages of a recording over Foxglove's WebSocket protocol, on the
//! loopback address alone.
//!
//! Each viewer gets the channels that it subscribes to, from the frame at hand on, and the route at once. One that is too slow
//! loses its oldest frames and holds nobody up.
//!
//! Protocol: Foxglove's `ws-protocol`, the part by which a server advertises channels and sends messages; subprotocols
//! `foxglove.sdk.v1` and the older `foxglove.websocket.v1`. Foxglove's own crate has a server too, which needs five times as many
//! crates, and one of them in a version that the reader of GPS sentences excludes.
//!
//! Limits: what a viewer publishes, asks to be set or calls is not listened to. Programs of this machine may connect, and of the
//! pages in its browsers Foxglove's, those of this machine and those that are named, under this machine's own name alone.

mod agreement;
mod connection;
mod handshakes;
mod live_view;
mod origin;
mod protocol;
mod viewer;

pub use live_view::{LiveError, LiveView};
pub use origin::{NoOrigin, Origin};
