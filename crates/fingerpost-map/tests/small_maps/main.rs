//! Graphs, routes and features on small maps laid out in metres, where every answer is known.

// Functions shared by tests fail their test by unwrapping.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod barriers;
mod doubled_nodes;
mod features;
mod matching;
mod notices;
mod places;
mod planning;
mod roads;
mod shortest;
mod town;
