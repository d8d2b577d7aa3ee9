//! What a drive was, from the run's records alone: how far, how long, of how much of it anything is known, and why nothing was found where
//! nothing was.

use std::collections::BTreeMap;

use fingerpost_format::{
    CameraRecordState, DriveSummary, FeatureSummary, FrameRecord, MotionDoubtRecord, TrackState,
};

use crate::remarks::Remark;

/// The numbers of a drive, frame by frame: [`DriveTotals::into_summary`] of a run that goes on.
#[derive(Debug, Clone)]
pub struct DriveTotals {
    /// Quality from which a motion was measured, 0 to 1.
    measured_quality: f64,
    frames: u64,
    /// Frames that were used, and those of them whose picture showed something.
    used: u64,
    shown: u64,
    /// First and last time, seconds.
    times_s: Option<[f64; 2]>,
    /// Frames behind another one, and those of them whose motion was measured.
    steps: u64,
    measured: u64,
    /// Metres of the measured motions, and seconds that they took.
    distance_m: f64,
    measured_s: f64,
    /// Time of the last frame whose picture showed something, seconds: a motion is the one since then.
    shown_at_s: Option<f64>,
    doubts: BTreeMap<MotionDoubtRecord, u64>,
    /// What is seen where a motion is doubted, as a clause of a sentence.
    seen_of_doubt: fn(MotionDoubtRecord) -> String,
    /// Frames with a doubted motion in which the bus did not say how fast the vehicle drives.
    doubted_without_speed: u64,
    has_route: bool,
    /// The last place along the route that is known.
    route_m: Option<f64>,
    with_feature: u64,
    /// Frames in which a lane was looked for, and in which an edge of one is known.
    looked_for_lane: u64,
    with_lane: u64,
}

impl DriveTotals {
    /// Nothing seen yet; a motion of at least this quality, 0 to 1, was measured. `seen_of_doubt` says what was seen where one is not
    /// believed, as a clause of a sentence.
    pub fn new(measured_quality: f64, seen_of_doubt: fn(MotionDoubtRecord) -> String) -> Self {
        Self {
            measured_quality,
            frames: 0,
            used: 0,
            shown: 0,
            times_s: None,
            steps: 0,
            measured: 0,
            distance_m: 0.0,
            measured_s: 0.0,
            shown_at_s: None,
            doubts: BTreeMap::new(),
            seen_of_doubt,
            doubted_without_speed: 0,
            has_route: false,
            route_m: None,
            with_feature: 0,
            looked_for_lane: 0,
            with_lane: 0,
        }
    }

    /// Goes on with the next frame.
    pub fn add(&mut self, record: &FrameRecord) {
        let is_behind_another = self.times_s.is_some();
        self.times_s = Some([self.times_s.map_or(record.t_s, |[first_s, _]| first_s), record.t_s]);
        self.frames += 1;
        self.used += u64::from(record.error.is_none());
        self.shown += u64::from(record.camera.is_some_and(|camera| camera.state == CameraRecordState::Clear));
        self.has_route |= record.state != TrackState::NoRoute;
        self.route_m = record.route_m.or(self.route_m);
        self.with_feature += u64::from(record.feature.is_some());
        self.looked_for_lane += u64::from(record.lanes.is_some());
        let has_edge = |record: &FrameRecord| {
            record.lanes.as_ref().is_some_and(|lanes| lanes.left.is_some() || lanes.right.is_some())
        };
        self.with_lane += u64::from(has_edge(record));
        self.steps += u64::from(is_behind_another);
        self.add_motion(record);
    }

    /// Counts the way and the time of a motion that was measured. It began with the last picture that showed something: the frames between
    /// that were passed over are a part of it.
    fn add_motion(&mut self, record: &FrameRecord) {
        let shows = record.error.is_none()
            && record.camera.is_none_or(|camera| camera.state == CameraRecordState::Clear);
        if !shows {
            return;
        }
        let Some(since_s) = self.shown_at_s.replace(record.t_s).map(|shown_at_s| record.t_s - shown_at_s)
        else {
            return;
        };
        let Some(motion) = &record.motion else { return };
        if let Some(doubt) = motion.doubt {
            *self.doubts.entry(doubt).or_default() += 1;
            let has_speed = record.signals.as_ref().is_some_and(|signals| signals.speed_mps.is_some());
            self.doubted_without_speed += u64::from(!has_speed);
        } else if motion.quality >= self.measured_quality {
            self.measured += 1;
            self.distance_m += libm::hypot(motion.forward_m, motion.left_m);
            self.measured_s += since_s.max(0.0);
        }
    }

    /// The numbers, with what is `said` already of what contradicts what; `features` are what became of the route's.
    pub fn into_summary(self, features: &[FeatureSummary], said: Vec<String>) -> DriveSummary {
        let share = |part: u64, whole: u64| if whole > 0 { part as f64 / whole as f64 } else { 0.0 };
        let duration_s = self.times_s.map_or(0.0, |[first_s, last_s]| last_s - first_s);
        let unmeasured_s = (duration_s - self.measured_s).max(0.0);
        // What is known of the smaller part of a drive says nothing of the whole.
        let is_mostly_measured = self.measured > 0 && self.measured_s >= unmeasured_s;
        let distance_m = is_mostly_measured.then_some(self.distance_m);
        let found = self.remarks(features).into_iter().map(|remark| remark.to_string());
        DriveSummary {
            distance_m: distance_m.map(hundredths),
            duration_s: hundredths(duration_s),
            mean_speed_mps: distance_m
                .filter(|_| self.measured_s > 0.0)
                .map(|distance_m| hundredths(distance_m / self.measured_s)),
            unmeasured_s: hundredths(unmeasured_s),
            motion_share: hundredths(share(self.measured, self.steps)),
            lane_share: (self.looked_for_lane > 0).then(|| hundredths(share(self.with_lane, self.frames))),
            feature_share: self.has_route.then(|| hundredths(share(self.with_feature, self.frames))),
            remarks: said.into_iter().chain(found).collect(),
            motion_doubts: self.doubts,
        }
    }

    /// Why nothing was found where nothing was.
    fn remarks(&self, features: &[FeatureSummary]) -> Vec<Remark> {
        if self.used == 0 {
            return vec![Remark::NothingUsed];
        }
        if self.shown == 0 {
            return vec![Remark::NothingShown { frames: self.used }];
        }
        let of = self.steps;
        let frames = self.doubts.values().sum();
        let most = self.doubts.iter().max_by_key(|(_, frames)| **frames);
        let doubted = most.map(|(&doubt, _)| Remark::MotionNotBelieved {
            seen: (self.seen_of_doubt)(doubt),
            frames,
            of,
            without_speed: self.doubted_without_speed,
        });
        let no_motion = (of > 0 && self.measured == 0 && self.doubts.is_empty()).then_some(Remark::NoMotion);
        let nothing_detected = features.iter().all(|feature| feature.detected_frame.is_none());
        let no_feature = (self.has_route && nothing_detected)
            .then(|| Remark::no_feature(self.route_m, features))
            .flatten();
        let no_lane = (self.looked_for_lane > 0 && self.with_lane == 0).then_some(Remark::NoLane);
        doubted.into_iter().chain(no_motion).chain(no_feature).chain(no_lane).collect()
    }
}

/// A number to two digits behind the point: metres, seconds and shares are known no better.
fn hundredths(value: f64) -> f64 {
    (100.0 * value).round() / 100.0
}
