//! What a page shows of a run over time, gathered frame by frame.

mod advice;

use std::collections::BTreeSet;
use std::ops::RangeInclusive;

use fingerpost_format::{DepartureRecord, FeatureRecord, FrameRecord, Side, TrackState, TruthRecord};
use fingerpost_locate::Status;
use fingerpost_map::{LatLon, TangentPlane};

use self::advice::AdviceTimeline;
use crate::fix_track::{FixTrack, TrackedFix};
use crate::palette;
use crate::series::{Places, Series, Stretches};

/// Losses, warnings and broken frames that are listed; the rest is counted.
const MAX_LISTED: usize = 40;

/// A run over time: curves, states and events, thinned as it goes on, so that a run of any length takes the same memory
/// and makes a page of the same size.
#[derive(Debug, Clone, Default)]
pub struct Timeline {
    pub(crate) seconds: Option<RangeInclusive<f64>>,
    pub(crate) states: Stretches<TrackState>,
    /// In the order in which they came.
    pub(crate) states_seen: Vec<TrackState>,
    /// The sub-mask with the least P(F_sub).
    pub(crate) weakest: Stretches<Option<String>>,
    pub(crate) weakest_seen: BTreeSet<String>,
    pub(crate) match_p: Series,
    pub(crate) present: Series,
    pub(crate) distance_m: Compared,
    pub(crate) error_m: Series,
    pub(crate) speed_mps: Compared,
    pub(crate) lane: LaneTimeline,
    pub(crate) advice: AdviceTimeline,
    /// Where the vehicle was believed to be, along the route.
    pub(crate) route_m: Places,
    pub(crate) route_states: Stretches<TrackState>,
    /// Fixes on the map, in a plane about the first of them.
    pub(crate) fixes: Option<(TangentPlane, FixTrack)>,
    /// Distance driven by the motion of the frames, metres.
    driven_m: f64,
    pub(crate) losses: Listed,
    pub(crate) broken: Listed,
    before: Before,
}

/// A value of the run and its truth.
#[derive(Debug, Clone, Default)]
pub(crate) struct Compared {
    pub(crate) reported: Series,
    pub(crate) truth: Series,
}

/// The lane over time.
#[derive(Debug, Clone, Default)]
pub(crate) struct LaneTimeline {
    pub(crate) left_m: Series,
    pub(crate) right_m: Series,
    pub(crate) width_m: Series,
    pub(crate) lateral_speed_mps: Series,
    pub(crate) warnings: Stretches<Option<Side>>,
    /// Why a warning is passed over.
    pub(crate) silences: Stretches<Option<String>>,
    pub(crate) warnings_begun: Listed,
}

/// Frames with a sentence each: the first few, and how many there are.
#[derive(Debug, Clone, Default)]
pub(crate) struct Listed {
    pub(crate) first: Vec<ListedFrame>,
    pub(crate) count: usize,
}

/// A frame with a sentence.
#[derive(Debug, Clone)]
pub(crate) struct ListedFrame {
    pub(crate) frame: u64,
    pub(crate) t_s: f64,
    pub(crate) text: String,
}

impl Listed {
    fn add(&mut self, record: &FrameRecord, text: &str) {
        self.count += 1;
        if self.first.len() < MAX_LISTED {
            self.first.push(ListedFrame { frame: record.frame, t_s: record.t_s, text: text.to_owned() });
        }
    }
}

/// What the frame before was.
#[derive(Debug, Clone, Default)]
struct Before {
    t_s: Option<f64>,
    feature_id: Option<i64>,
    lost: bool,
    warned: Option<Side>,
}

impl Timeline {
    /// A run from its records, with the truth of the same frames where there is one; both in ascending order.
    pub fn of<'a>(records: impl IntoIterator<Item = &'a FrameRecord>, truth: Option<&[TruthRecord]>) -> Self {
        let truth = truth.unwrap_or_default();
        let truth_of = |frame: u64| {
            truth.binary_search_by_key(&frame, |truth| truth.frame).ok().and_then(|i| truth.get(i))
        };
        let mut timeline = Self::default();
        records.into_iter().for_each(|record| timeline.add(record, truth_of(record.frame)));
        timeline
    }

    /// Goes on with the next frame and its truth, where there is one.
    pub fn add(&mut self, record: &FrameRecord, truth: Option<&TruthRecord>) {
        let from_s = self.seconds.take().map_or(record.t_s, |seconds| *seconds.start());
        self.seconds = Some(from_s..=record.t_s);
        self.add_state(record);
        self.add_feature(record, truth);
        self.add_speed(record, truth);
        self.add_fix(record, truth);
        self.lane.add(record, self.before.warned);
        self.advice.add(record);
        let feature_id = record.feature.as_ref().map(|feature| feature.id);
        let lost = record.state == TrackState::Lost;
        self.before = Before { t_s: Some(record.t_s), feature_id, lost, warned: warned(record) };
    }

    fn add_state(&mut self, record: &FrameRecord) {
        self.states.push(record.t_s, record.state);
        if !self.states_seen.contains(&record.state) {
            self.states_seen.push(record.state);
        }
        if let Some(route_m) = record.route_m {
            self.route_m.push(route_m);
            self.route_states.push(route_m, record.state);
        }
        if record.state == TrackState::Lost && !self.before.lost {
            self.losses.add(record, &record.why);
        }
        if let Some(error) = &record.error {
            self.broken.add(record, error);
        }
    }

    fn add_feature(&mut self, record: &FrameRecord, truth: Option<&TruthRecord>) {
        let feature = record.feature.as_ref();
        let sought = record.sought.as_ref().map(|sought| sought.p);
        self.match_p.push(record.t_s, feature.map(|feature| feature.p).or(sought).flatten());
        let present = record.sought.as_ref().map(|sought| sought.present);
        self.present.push(record.t_s, feature.map(|feature| feature.present).or(present).flatten());
        let weakest = feature.and_then(weakest);
        if let Some(label) = weakest.filter(|label| !self.weakest_seen.contains(*label)) {
            self.weakest_seen.insert(label.to_owned());
        }
        self.weakest.push(record.t_s, weakest.map(str::to_owned));
        let truth = truth.filter(|truth| feature.is_some_and(|feature| truth.feature_id == Some(feature.id)));
        let true_m = truth.and_then(|truth| truth.feature_forward_m.zip(truth.feature_left_m));
        let error_m = feature.zip(true_m).map(|(feature, (forward_m, left_m))| {
            libm::hypot(feature.forward_m - forward_m, feature.left_m - left_m)
        });
        let values = [
            (&mut self.distance_m.reported, feature.map(|feature| feature.forward_m)),
            (&mut self.distance_m.truth, truth.and_then(|truth| truth.feature_forward_m)),
            (&mut self.error_m, error_m),
        ];
        let another = feature.map(|feature| feature.id) != self.before.feature_id;
        for (series, value) in values {
            if another {
                // The curves of two features do not join.
                series.push(record.t_s, None);
            }
            series.push(record.t_s, value);
        }
    }

    fn add_fix(&mut self, record: &FrameRecord, truth: Option<&TruthRecord>) {
        self.driven_m += record.motion.map_or(0.0, |motion| motion.forward_m.abs());
        let Some(fix) = &record.fix else { return };
        let at = LatLon { lat_deg: fix.lat, lon_deg: fix.lon };
        let (plane, fixes) = self.fixes.get_or_insert_with(|| (TangentPlane::new(at), FixTrack::default()));
        let tracked = TrackedFix {
            t_s: record.t_s,
            driven_m: self.driven_m,
            place_m: plane.map_from_wgs84(at),
            level_m: fix.bound_m,
            status: fix.status.map_or(Status::Ambiguous, palette::status),
        };
        let true_at = truth.map(|truth| LatLon { lat_deg: truth.lat, lon_deg: truth.lon });
        fixes.add(tracked, true_at.map(|at| plane.map_from_wgs84(at)));
    }

    /// Speed by the motion of the frame; what a frame hides without a motion that is believed is left out.
    fn add_speed(&mut self, record: &FrameRecord, truth: Option<&TruthRecord>) {
        let since_s = self.before.t_s.map(|before| record.t_s - before).filter(|since| *since > 0.0);
        let moved_m = record.motion.filter(|motion| motion.doubt.is_none()).map(|motion| motion.forward_m);
        let speed = moved_m.zip(since_s).map(|(moved_m, since_s)| moved_m / since_s);
        self.speed_mps.reported.push(record.t_s, speed);
        self.speed_mps.truth.push(record.t_s, truth.map(|truth| truth.speed_mps));
    }
}

impl LaneTimeline {
    fn add(&mut self, record: &FrameRecord, warned_before: Option<Side>) {
        let lanes = record.lanes.as_ref();
        let departure = departure(record);
        let values = [
            (&mut self.left_m, lanes.and_then(|lanes| Some(lanes.left?.offset_m))),
            (&mut self.right_m, lanes.and_then(|lanes| Some(lanes.right?.offset_m))),
            (&mut self.width_m, lanes.and_then(|lanes| lanes.width_m)),
            (&mut self.lateral_speed_mps, departure.and_then(|departure| departure.lateral_speed_mps)),
        ];
        for (series, value) in values {
            series.push(record.t_s, value);
        }
        let warned = warned(record);
        self.warnings.push(record.t_s, warned);
        self.silences.push(record.t_s, departure.and_then(|departure| departure.silent_because.clone()));
        if warned.is_some() && warned != warned_before {
            self.warnings_begun.add(record, &record.why);
        }
    }
}

fn departure(record: &FrameRecord) -> Option<&DepartureRecord> {
    record.lanes.as_ref()?.departure.as_ref()
}

fn warned(record: &FrameRecord) -> Option<Side> {
    departure(record)?.warning
}

/// The sub-mask with the least P(F_sub).
fn weakest(feature: &FeatureRecord) -> Option<&str> {
    feature.sub.iter().min_by(|a, b| a.1.total_cmp(b.1)).map(|(label, _)| label.as_str())
}
