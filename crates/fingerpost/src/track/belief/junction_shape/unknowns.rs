//! What is not known of a feature: its pose, widths, offsets and corners, and how the camera is turned.

use nalgebra::SVector;

use super::MOST_ARMS;

/// Places of the unknowns in a vector: pose, then width, offset and corner of every arm, then the camera's.
pub(in crate::track) const FORWARD: usize = 0;
pub(in crate::track) const LEFT: usize = 1;
pub(in crate::track) const HEADING: usize = 2;
pub(in crate::track) const WIDTHS: usize = 3;
pub(in crate::track) const OFFSETS: usize = WIDTHS + MOST_ARMS;
pub(in crate::track) const CORNERS: usize = OFFSETS + MOST_ARMS;
pub(in crate::track) const PITCH: usize = CORNERS + MOST_ARMS;
pub(in crate::track) const ROLL: usize = PITCH + 1;
pub(in crate::track) const SCALE: usize = PITCH + 2;
/// How many unknowns there are.
pub(in crate::track) const UNKNOWNS: usize = PITCH + 3;

/// Values of the unknowns, or derivatives by them.
pub(in crate::track) type Unknowns = SVector<f64, UNKNOWNS>;
