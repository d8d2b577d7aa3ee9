//! Where the vehicle is on the map, from its motion: no start, no camera, GPS only where there is any.
//!
//! The vehicle may be on any road, either way. Every possibility is a course through the road graph with a Gaussian of place,
//! heading, errors of speed and yaw rate, and offset from the road's line; it is moved by the measured motion, weighed by how well
//! it keeps to the road, and branches at junctions. One possibility is that the vehicle is on no road of the map. Takes values and
//! gives values: reads no file and no clock, and the same input gives the same result.

mod belief;
mod fix;
mod gps;
mod hypothesis;
mod landmark;
mod level;
mod locator;
mod merging;
mod odometry;
mod path;
mod random;
mod roads;
mod seeding;
mod speedometer;
mod start;
mod state;
mod unmapped;
mod unseen;

pub use fix::{ALERT_LIMIT_M, Fix, RISK, Rival, Status};
pub use gps::GpsEvidence;
pub use landmark::{PoseInnovation, Sighting, SightingEvidence, Verdict};
pub use locator::{LONGEST_GAP_S, Locator, MotionError};
pub use odometry::{Motion, MotionInterval, MotionSample, YAW_RATE_NOISE};
pub use roads::Traffic;
pub use start::Start;
