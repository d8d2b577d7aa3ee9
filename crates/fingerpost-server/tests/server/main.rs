//! The server on the loopback address, as browsers and others meet it.

// A helper that unwraps is part of the test that calls it.
#![allow(clippy::unwrap_used)]

mod patience;
mod served;
