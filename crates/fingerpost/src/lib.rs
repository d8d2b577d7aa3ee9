//! Fingerpost's method: from a camera picture, a map and a route to tracked junctions and driving lines.
//!
//! Start with [`pipeline`]: it is one page and calls the stages in the order of the data. Each stage is a function of
//! `(config, state, input)` that gives `(output, evidence)`; evidence is what a person is shown. The method reads no
//! file, clock or environment, and never sees truth.
//!
//! Sources: paper 1, M. McDonnell, "An interpretable system for single camera autonomous vehicle navigation
//! localisation"; paper 2, the same author's "Implementation discussion" of it.

pub mod advice;
pub mod calibration_check;
pub mod camera_state;
pub mod centreline;
pub mod config;
pub mod driving_line;
pub mod feature_masks;
pub mod feature_model;
pub mod fix;
pub mod ground_view;
pub mod height;
mod kerbs;
pub mod lanes;
pub mod matching;
pub mod motion;
pub mod mount;
pub mod pipeline;
pub mod progress;
pub mod road_surface;
pub mod route_progress;
mod still_cells;
pub mod track;
pub mod vehicle;
pub mod vehicle_signals;
mod why;

pub use config::{Config, ConfigError};
pub use pipeline::{FrameEvidence, FrameOutput, Pipeline, PipelineError, Sensors, Stage};
