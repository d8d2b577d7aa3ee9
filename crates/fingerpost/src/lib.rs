//! Fingerpost's method: from a camera picture, a map and a route to tracked junctions and driving lines.
//!
//! Start with [`pipeline`]: it is one page and calls the stages in the order of the data. Each stage is a function of
//! `(config, state, input)` that gives `(output, evidence)`; evidence is what a person is shown. The method reads no
//! file, clock or environment, and never sees truth.
//!
//! A camera, a route and frames in; the feature ahead out:
//!
//! ```
//! use fingerpost::geometry::{Camera, Distortion, Intrinsics, Mount};
//! use fingerpost::{Config, Pipeline, Sensors, map};
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! # let route_text = fingerpost_sim::TOWN_ROUTE;
//! # let frames = [fingerpost::vision::picture::RgbImage::new(640, 480)];
//! let lens = Intrinsics { fx: 560.0, fy: 560.0, cx: 319.5, cy: 239.5 };
//! let camera = Camera::calibrated(640, 480, lens, Distortion::None, Mount::level(1.4))?;
//! let route = map::read_route(route_text)?;
//! let mut pipeline = Pipeline::new(&Config::default(), &camera, Some(&route), Some(0.0))?;
//! for frame in &frames {
//!     let (output, _evidence) = pipeline.step(frame, Sensors::default(), &mut |_stage| ())?;
//!     let feature = output.track.followed.as_ref();
//!     let ahead_m = feature.map(|feature| feature.vehicle_from_feature.translation.x);
//!     let (steer_rad, why) = (output.advice.steer_rad, &output.why);
//!     # assert!(ahead_m.is_none() && steer_rad.is_finite() && !why.is_empty());
//! }
//! # Ok(())
//! # }
//! ```
//!
//! Whole programs are in `examples/`: a simulated drive, pictures of a folder, and a road detector of one's own.
//!
//! Sources: paper 1, M. McDonnell, "An interpretable system for single camera autonomous vehicle navigation
//! localisation"; paper 2, the same author's "Implementation discussion" of it.

pub mod advice;
pub mod attitude;
pub mod calibration_check;
pub mod camera_state;
pub mod centreline;
pub mod config;
mod conic;
mod declared;
pub mod driving_line;
pub mod feature_masks;
pub mod feature_model;
pub mod fix;
pub mod ground_view;
mod kerbs;
pub mod matching;
pub mod motion;
pub mod mount;
pub mod pipeline;
pub mod progress;
pub mod road_surface;
pub mod track;
pub mod vehicle_signals;
mod why;

// What callers of the method meet in its arguments and results.
pub use fingerpost_control::vehicle;
pub use fingerpost_geometry as geometry;
pub use fingerpost_lanes as lanes;
pub use fingerpost_map as map;
pub use fingerpost_vision as vision;
pub use nalgebra;

pub use config::{Config, ConfigTextError, vehicle_to_toml};
pub use declared::ConfigError;
pub use pipeline::{FrameEvidence, FrameOutput, Pipeline, PipelineError, Sensors, Stage};
