//! The stages that do not depend on the feature that is followed: motion, road surface and lanes. They are found ahead of those that do, in a
//! thread of their own, and once for all settings that leave them as they are.

mod lanes;
mod motion;
mod notes;
mod road;

use std::collections::BTreeSet;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use anyhow::Result;
use fingerpost::lanes::{LaneDetector, LaneMethod};
use fingerpost::motion::MotionEstimator;
use fingerpost::pipeline::Parts;
use fingerpost::{Config, Sensors};
use fingerpost_format::TriedSettings;
use fingerpost_geometry::Camera;

use self::lanes::{LaneNote, LaneSource, NotedLanes, RepeatedLanes};
use self::motion::{MotionNote, NotedMotion, RepeatedMotion};
use self::notes::{Notes, Reader, Writer};
use self::road::{NotedRoad, RepeatedRoad, RoadNote};
use super::stretch::{Deadline, StretchFrame};
use crate::driver::{Driver, RunSetting, Sequence};
use crate::parts;
use crate::recorder::Wishes;

/// A stage that is found ahead.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum StageAhead {
    Motion,
    Road,
    Lanes,
}

impl StageAhead {
    const ALL: [Self; 3] = [Self::Motion, Self::Road, Self::Lanes];
}

/// Tables of the stages behind them in a frame, whose output nothing before reads in the next one.
const LATER_STAGES: [&str; 7] =
    ["feature_mask", "match", "track", "route_progress", "driving_line", "centreline", "advice"];

/// The stages that find something else where a setting of that key is changed.
fn changed_by(key: &str) -> &'static [StageAhead] {
    match key.split_once('.') {
        Some((table, _)) if LATER_STAGES.contains(&table) => &[],
        Some(("lanes", _)) => &[StageAhead::Lanes],
        // The ground view is made with the histograms' bins.
        Some(("road_surface", setting)) if !setting.starts_with("backprojection") => &[StageAhead::Road],
        _ => &StageAhead::ALL,
    }
}

/// What these stages find in a stretch.
#[derive(Debug, Clone, Default)]
pub(super) struct FoundAhead {
    motion: Arc<Notes<MotionNote>>,
    road: Arc<Notes<RoadNote>>,
    lanes: Arc<Notes<LaneNote>>,
}

/// What is to be found ahead in a stretch.
#[derive(Debug)]
pub(super) struct AheadTask {
    /// What is known, and where the rest is written down.
    pub(super) found: FoundAhead,
    anew: BTreeSet<StageAhead>,
}

impl AheadTask {
    /// All of them.
    pub(super) fn whole() -> Self {
        Self { found: FoundAhead::default(), anew: StageAhead::ALL.into() }
    }

    /// What these settings change of what is known.
    pub(super) fn with_changes(known: &FoundAhead, changed: &TriedSettings) -> Self {
        let anew: BTreeSet<StageAhead> = changed.keys().flat_map(|key| changed_by(key)).copied().collect();
        let mut found = known.clone();
        for stage in &anew {
            match stage {
                StageAhead::Motion => found.motion = Arc::default(),
                StageAhead::Road => found.road = Arc::default(),
                StageAhead::Lanes => found.lanes = Arc::default(),
            }
        }
        Self { found, anew }
    }

    /// Whether all is known.
    pub(super) fn is_done(&self) -> bool {
        self.anew.is_empty()
    }

    /// Finds it. Who reads is not left waiting where this fails.
    pub(super) fn run(
        &self,
        config: &Config,
        camera: &Camera,
        frames: &[StretchFrame<'_>],
        deadline: Deadline,
    ) -> Result<()> {
        let is_last = Arc::new(AtomicBool::new(false));
        let mut config = config.clone();
        let parts = self.noting_parts(&mut config, &is_last)?;
        let setting =
            RunSetting { config: &config, camera, route: None, start_m: None, sequence: Sequence::Drive };
        let mut driver =
            Driver::with_parts(setting, &Wishes::records_alone(), None, parts)?.without_key_frames();
        for (index, frame) in frames.iter().enumerate() {
            deadline.check(index, frames.len())?;
            is_last.store(index + 1 == frames.len(), Ordering::Relaxed);
            driver.step(frame.time, frame.picture, Sensors::default())?;
        }
        Ok(())
    }

    /// The stages of a drive without a route in which this is found.
    fn noting_parts(&self, config: &mut Config, is_last: &Arc<AtomicBool>) -> Result<Parts> {
        // The notes end with their writers, also where something fails before the first frame.
        let is_anew = |stage| self.anew.contains(&stage);
        let motion = is_anew(StageAhead::Motion).then(|| Writer::of(&self.found.motion, is_last));
        let road = is_anew(StageAhead::Road).then(|| Writer::of(&self.found.road, is_last));
        let lanes = is_anew(StageAhead::Lanes).then(|| Writer::of(&self.found.lanes, is_last));
        let mut parts = Parts {
            road_detector: Some(match road {
                Some(notes) => {
                    Box::new(NotedRoad { detector: parts::road_detector(&config.road_surface)?, notes })
                }
                None => Box::new(RepeatedRoad(Reader::of(&self.found.road))),
            }),
            ..fingerpost_papers::parts(config)?
        };
        parts.motion_estimator = Some(match motion {
            Some(notes) => {
                let estimator: Box<dyn MotionEstimator> = match parts.motion_estimator.take() {
                    Some(estimator) => estimator,
                    None => config.motion.estimator()?,
                };
                Box::new(NotedMotion { estimator, notes })
            }
            None => Box::new(RepeatedMotion(Reader::of(&self.found.motion))),
        });
        let finder = lane_finder(parts.lane_finder.take(), config)?;
        match (finder, lanes) {
            (Some(finder), Some(notes)) => parts.lane_finder = Some(Box::new(NotedLanes { finder, notes })),
            // They are known, or not to be looked for.
            _ => config.lanes.finder = LaneMethod::Off,
        }
        Ok(parts)
    }
}

impl FoundAhead {
    /// The stages of a drive that is given this.
    pub(super) fn repeating_parts(&self, config: &Config) -> Result<Parts> {
        let mut parts = fingerpost_papers::parts(config)?;
        let finder = lane_finder(parts.lane_finder.take(), config)?;
        Ok(Parts {
            road_detector: Some(Box::new(RepeatedRoad(Reader::of(&self.road)))),
            motion_estimator: Some(Box::new(RepeatedMotion(Reader::of(&self.motion)))),
            lane_finder: finder.map(|finder| -> Box<dyn LaneDetector> {
                let notes = Reader::of(&self.lanes);
                Box::new(RepeatedLanes { notes, finder, source: LaneSource::Notes })
            }),
            ..parts
        })
    }
}

/// The finder that was given, else the configuration's; none where lanes are not to be looked for.
fn lane_finder(
    given: Option<Box<dyn LaneDetector>>,
    config: &Config,
) -> Result<Option<Box<dyn LaneDetector>>> {
    Ok(match given {
        Some(finder) => Some(finder),
        None => config.lanes.finder()?,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_setting_changes_no_stage_before_its_own() {
        assert_eq!(changed_by("track.detect_present"), []);
        assert_eq!(changed_by("lanes.width_m"), [StageAhead::Lanes]);
        assert_eq!(changed_by("road_surface.sample_width_m"), [StageAhead::Road]);
        for key in
            ["road_surface.backprojection.hue_bins", "road_surface", "ground_view.far_m", "vehicle", "x.y"]
        {
            assert_eq!(changed_by(key), StageAhead::ALL, "{key}");
        }
    }
}
