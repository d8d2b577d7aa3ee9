//! Pages of the program, served on the loopback address to this machine alone.
//!
//! What is served is a [`Handler`]: a request in, an answer out, no network in it. [`LocalServer`] does the rest with hyper:
//! connections, limits and who may ask. Whatever a connection sends or leaves undone costs at most what [`Limits`] says.
//! [`Pictures`] is where the pictures that a page shows come from.

mod connections;
mod guard;
mod limits;
mod local_server;
mod message;
mod pictures;

pub use limits::Limits;
pub use local_server::{LocalServer, ServerError};
pub use message::{Answer, Handler, Request};
pub use pictures::{Cause, Picture, Pictures};
