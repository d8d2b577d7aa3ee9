//! Made-up drives on the roads of the built-in town, whose map is drawn wrong, with sensors that err.

// Functions shared by tests fail their test by unwrapping; figures are shown with `--nocapture`.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::print_stdout)]

#[path = "../drives/mod.rs"]
mod drives;
mod faults;
mod gps;
mod simulated;
mod wrong_maps;
