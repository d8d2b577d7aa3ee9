//! What happened in a run, to jump to.

use fingerpost_format::{CameraRecordState, FrameRecord, MountRecordState, TrackState};
use serde::Serialize;

/// What kind of thing happened.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum EventKind {
    /// A feature was found.
    Detection,
    /// A followed feature was lost.
    Loss,
    /// The vehicle came to a feature.
    Arrival,
    /// The search changed to another state.
    State,
    /// The camera showed nothing, nothing new or something again, was turned, or its picture could not be read.
    Camera,
    /// Much speaks against what is claimed, or the frame took long.
    Worst,
}

/// Something that happened in a frame.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Event {
    /// Which of the run's records it is in, from zero.
    pub index: usize,
    /// Number of the frame in the input.
    pub frame: u64,
    /// What kind it is.
    pub kind: EventKind,
    /// What happened, in words.
    pub text: String,
}

/// What of a frame must be known to see what the next one changes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Standing {
    state: TrackState,
    feature: Option<i64>,
    camera: CameraStanding,
    is_turned: bool,
}

/// Whether the camera showed anything.
#[derive(Debug, Clone, Copy, PartialEq)]
enum CameraStanding {
    Shows(CameraRecordState),
    Unreadable,
}

impl Standing {
    /// Before the first frame: whatever is wrong in that one is an event.
    const fn at_first(record: &FrameRecord) -> Self {
        Self {
            state: record.state,
            feature: None,
            camera: CameraStanding::Shows(CameraRecordState::Clear),
            is_turned: false,
        }
    }

    fn of(record: &FrameRecord) -> Self {
        let shows = record.camera.map_or(CameraRecordState::Clear, |camera| camera.state);
        Self {
            state: record.state,
            feature: record.feature.as_ref().map(|feature| feature.id),
            camera: if record.error.is_some() {
                CameraStanding::Unreadable
            } else {
                CameraStanding::Shows(shows)
            },
            is_turned: record.mount.as_ref().is_some_and(|mount| mount.state == MountRecordState::Moved),
        }
    }
}

/// What happens in a frame against the one before, and how it stands after it.
pub(crate) fn happened(
    before: Option<Standing>,
    index: usize,
    record: &FrameRecord,
) -> (Vec<Event>, Standing) {
    let before = before.unwrap_or(Standing::at_first(record));
    let after = Standing::of(record);
    let mut events = Vec::new();
    let mut add = |kind, text: String| events.push(Event { index, frame: record.frame, kind, text });
    if after.camera != before.camera {
        add(EventKind::Camera, camera_text(record, after.camera));
    }
    if after.is_turned && !before.is_turned {
        let fault = record.mount.as_ref().and_then(|mount| mount.fault.as_ref());
        add(EventKind::Camera, fault.map_or("the camera was turned".to_owned(), ToString::to_string));
    }
    let is_another = after.feature.is_some() && after.feature != before.feature;
    let has_changed = after.state != before.state;
    match after.state {
        TrackState::Tracking if has_changed || is_another => {
            add(EventKind::Detection, format!("found: {}", followed_text(record)));
        }
        TrackState::Arrived if has_changed || is_another => {
            add(EventKind::Arrival, format!("arrived: {}", followed_text(record)));
        }
        TrackState::Lost if has_changed => {
            let lost = before.feature.map_or_else(String::new, |id| format!(": {id}"));
            add(EventKind::Loss, format!("lost{lost}"));
        }
        state if has_changed => add(EventKind::State, state_text(state).to_owned()),
        _ => {}
    }
    (events, after)
}

fn camera_text(record: &FrameRecord, camera: CameraStanding) -> String {
    match camera {
        CameraStanding::Shows(CameraRecordState::Clear) => "the camera is clear again".to_owned(),
        CameraStanding::Shows(state) => format!("the camera {state}"),
        CameraStanding::Unreadable => {
            format!("broken frame: {}", record.error.as_deref().unwrap_or_default())
        }
    }
}

fn followed_text(record: &FrameRecord) -> String {
    record.feature.as_ref().map_or_else(
        || "a feature".to_owned(),
        |feature| {
            format!("{} {}, {:.1} m ahead", feature.kind.replace('_', " "), feature.id, feature.forward_m)
        },
    )
}

pub(crate) const fn state_text(state: TrackState) -> &'static str {
    match state {
        TrackState::NoRoute => "no route",
        TrackState::Searching => "searching",
        TrackState::Tracking => "tracking",
        TrackState::Arrived => "arrived",
        TrackState::Lost => "lost",
        TrackState::RouteDone => "the route is done",
    }
}
