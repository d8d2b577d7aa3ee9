//! What must be absent: invariants of the whole workspace that no compiler checks, as ARCHITECTURE.md states them.

// A helper that unwraps or panics is part of the test that calls it.
#![allow(clippy::unwrap_used, clippy::panic)]

mod crates;
mod evidence;
mod modules;
mod page;
mod paths;
mod purity;
mod sources;
