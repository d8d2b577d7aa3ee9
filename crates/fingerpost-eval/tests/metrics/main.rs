//! Metrics of hand-made runs against numbers computed by hand.

// A helper that unwraps is part of the test that calls it.
#![allow(clippy::unwrap_used)]

mod drive;
mod first_detections;
mod junctions;
mod lanes;
mod made_by_hand;
mod motion;
mod road;
