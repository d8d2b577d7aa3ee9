//! From a frame with its evidence to messages.

use fingerpost::ground_view::GroundPicture;
use fingerpost_report::Scene;
use fingerpost_vision::jpeg::{ChromaSampling, JpegPlanes};
use foxglove::Encode;
use foxglove::messages::Timestamp;

use super::channel::Channel;
use super::entities::feature_entities;
use super::odometry::Odometry;
use super::transforms::{CAMERA, GROUND};
use super::{annotations, entities, ground, place, transforms};

/// A frame's messages, with its pictures still to be compressed.
#[derive(Debug)]
pub struct RecordedFrame {
    /// Seconds since the first frame.
    pub(crate) t_s: f64,
    pub(crate) messages: Vec<(Channel, Vec<u8>)>,
    pub(crate) pictures: Vec<(Channel, &'static str, JpegPlanes)>,
}

/// Turns frames into messages; keeps the odometry from frame to frame.
#[derive(Debug, Default)]
pub struct FrameRecorder {
    odometry: Odometry,
    last_t_s: Option<f64>,
}

impl FrameRecorder {
    /// The messages of a frame.
    pub fn record(&mut self, scene: &Scene<'_>) -> RecordedFrame {
        let (output, evidence, setting) = (scene.output, scene.evidence, scene.setting);
        let time = timestamp(scene.t_s);
        let dt_s = self.last_t_s.replace(scene.t_s).map(|last_s| scene.t_s - last_s);
        self.odometry.go_on(output.motion.as_ref(), dt_s);
        let mut messages = Vec::with_capacity(Channel::ALL.len());
        let followed = scene.followed();
        add(&mut messages, Channel::CameraAnnotations, &annotations::annotations(time, scene));
        let (grid, surface) = (&setting.grid, evidence.surface);
        let road = ground::road_surface(time, grid, surface, evidence.validity);
        add(&mut messages, Channel::RoadSurface, &road);
        if let Some(placed) = &evidence.masks {
            add(&mut messages, Channel::FeatureMasks, &ground::masks(time, grid, placed));
        }
        add(&mut messages, Channel::Feature, &feature_entities(time, followed));
        let line = entities::driving_line(time, &output.driving_line, setting.vehicle_width_m);
        add(&mut messages, Channel::DrivingLine, &line);
        let poses = entities::driving_line_poses(time, &output.driving_line);
        add(&mut messages, Channel::DrivingLinePoses, &poses);
        let centreline = entities::centreline(time, output.centreline.as_ref());
        add(&mut messages, Channel::Centreline, &centreline);
        add(&mut messages, Channel::Lanes, &entities::lanes(time, output.lane.as_ref()));
        add(&mut messages, Channel::Odometry, &self.odometry.message(time));
        let frames =
            transforms::transforms(time, &self.odometry.estimate().odom_from_vehicle, &setting.camera);
        add(&mut messages, Channel::Transforms, &frames);
        if let Some(calibration) = transforms::calibration(time, &setting.camera) {
            add(&mut messages, Channel::CameraCalibration, &calibration);
        }
        if let Some(fix) = &output.fix {
            add(&mut messages, Channel::Fix, &place::location_fix(time, fix));
        }
        let GroundPicture { colour, .. } = evidence.ground;
        let pictures = vec![
            (Channel::CameraImage, CAMERA, JpegPlanes::of(scene.picture, ChromaSampling::Halved)),
            (Channel::GroundView, GROUND, JpegPlanes::of(colour, ChromaSampling::Halved)),
        ];
        RecordedFrame { t_s: scene.t_s, messages, pictures }
    }
}

/// Adds a message; one that has no bytes is none.
fn add<M: Encode>(messages: &mut Vec<(Channel, Vec<u8>)>, channel: Channel, message: &M) {
    if let Ok(bytes) = encoded(message) {
        messages.push((channel, bytes));
    }
}

/// A message's bytes.
pub(crate) fn encoded<M: Encode>(message: &M) -> Result<Vec<u8>, M::Error> {
    let mut bytes = Vec::with_capacity(message.encoded_len().unwrap_or_default());
    message.encode(&mut bytes)?;
    Ok(bytes)
}

/// A time of the drive, in nanoseconds; times before its first frame are that frame's.
pub(crate) fn nanoseconds(t_s: f64) -> u64 {
    // The cast saturates, and takes what is no number for zero.
    (t_s * 1e9).round() as u64
}

/// The same as a timestamp; a drive of 136 years has no more of them.
pub(crate) fn timestamp(t_s: f64) -> Timestamp {
    const SECOND_NS: u64 = 1_000_000_000;
    let ns = nanoseconds(t_s);
    let seconds = u32::try_from(ns / SECOND_NS).unwrap_or(u32::MAX);
    Timestamp::new_checked(seconds, (ns % SECOND_NS) as u32).unwrap_or(Timestamp::MAX)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_those_of_the_drive_whatever_they_are() {
        assert_eq!(nanoseconds(12.5), 12_500_000_000);
        assert_eq!((nanoseconds(-1.0), nanoseconds(f64::NAN)), (0, 0));
        assert_eq!(timestamp(12.5), Timestamp::new_checked(12, 500_000_000).unwrap());
        assert_eq!(timestamp(f64::INFINITY).sec(), u32::MAX);
    }
}
