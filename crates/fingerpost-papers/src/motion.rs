//! Ego-motion as in the papers (paper 1, section VI): dense flow on the ground view, and the motion behind it.

mod coarse;
mod farneback;
mod rigid_fit;
mod sway;

pub use farneback::FarnebackMotion;
