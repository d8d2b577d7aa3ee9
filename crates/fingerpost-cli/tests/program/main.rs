//! The program as its users call it: arguments, files, messages and exit codes.

// A helper that unwraps is part of the test that calls it.
#![allow(clippy::unwrap_used)]

mod about;
#[cfg(unix)]
mod advising;
#[cfg(unix)]
mod advisor;
mod bad_inputs;
mod broken_frames;
mod calibrating;
mod campaigning;
mod can;
mod centreline;
mod chessboard;
mod claims;
mod closed_loop;
mod converting;
mod drive;
mod evaluating;
mod evaluating_lanes;
mod evaluating_road;
mod fixes;
mod interrupts;
mod lanes;
mod live;
mod locating;
mod looking;
#[cfg(feature = "completions")]
mod manual;
mod maps;
mod marking;
#[cfg(feature = "onnx")]
mod networks;
mod outputs;
mod papers;
mod program;
mod recorded_measurements;
mod recording;
mod running;
mod sampling;
mod simulated_bus;
mod simulating;
mod stalls;
mod tuning;
mod verbosity;
mod video_stub;
#[cfg(unix)]
mod watchdog;
