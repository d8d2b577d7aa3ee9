//! What became of drives in which the advice moves the vehicle.

use fingerpost_format::{ClosedLoop, CrossTrackCounts, LoopDrive, LoopEnd, LoopFrame, LoopGroup};

/// A vehicle that is so far from its lane has left the route, metres: beyond the road's other edge even where it is wide.
const OFF_ROUTE_M: f64 = 10.0;
/// A vehicle that stands so long has stopped, seconds: longer than a stop at which it looks about.
const STOPPED_S: f64 = 5.0;
/// Slower than this a vehicle stands, m/s.
const STANDS_MPS: f64 = 0.1;
/// A vehicle that stands so near to the drive's end has arrived, metres: two lengths of a car.
const AT_END_M: f64 = 10.0;
/// A drive that is slower than this on average is out of time, m/s; so many seconds more are given for standing.
const LEAST_MEAN_MPS: f64 = 1.0;
const SPARE_S: f64 = 40.0;
/// Spacing of the places at which the distance from the lane is counted, metres.
const COUNTED_EVERY_M: f64 = 0.5;

/// Follows a drive and says when it is over.
#[derive(Debug, Clone)]
pub struct LoopWatch {
    /// Where along the route the drive ends, metres.
    end_m: f64,
    drive: LoopDrive,
    /// Where along its own way the vehicle was counted last, metres, and how far it has come.
    counted_m: f64,
    way_m: f64,
    last: Option<LoopFrame>,
    standing_s: f64,
}

impl LoopWatch {
    /// Before the first frame of a `drive` that ends at `end_m` of its route, metres. What names the drive is kept.
    pub fn new(drive: LoopDrive, end_m: f64) -> Self {
        Self { end_m, drive, counted_m: f64::NEG_INFINITY, way_m: 0.0, last: None, standing_s: 0.0 }
    }

    /// Takes a frame in; says how the drive ended where this was its last.
    pub fn take(&mut self, frame: &LoopFrame) -> Option<LoopEnd> {
        let before = self.last.replace(frame.clone());
        let (mut dt_s, mut moved_m) = (0.0, 0.0);
        if let Some(before) = &before {
            dt_s = frame.t_s - before.t_s;
            moved_m = libm::hypot(frame.x_m - before.x_m, frame.y_m - before.y_m);
        }
        self.way_m += moved_m;
        self.standing_s = if frame.speed_mps < STANDS_MPS { self.standing_s + dt_s } else { 0.0 };
        self.count(frame);
        let drive = &mut self.drive;
        drive.frames += 1;
        drive.duration_s = frame.t_s;
        drive.end_m = frame.route_m;
        drive.wheel_off_m = drive.wheel_off_m.max(frame.wheel_off_m);
        drive.wheel_off_frames += u64::from(frame.wheel_off_m > 0.0);
        if frame.axle_off {
            drive.axle_off_frames += 1;
            drive.claimed_off_frames += u64::from(frame.has_line && !frame.lost);
            drive.left_road_at_m = drive.left_road_at_m.or(Some(frame.route_m));
        }
        self.end(frame)
    }

    fn count(&mut self, frame: &LoopFrame) {
        if self.way_m - self.counted_m > COUNTED_EVERY_M - 1e-6 {
            self.counted_m = self.way_m;
            let counts = if frame.junction { &mut self.drive.junction } else { &mut self.drive.straight };
            counts.add(frame.left_m);
        }
    }

    fn end(&self, frame: &LoopFrame) -> Option<LoopEnd> {
        let stopped = self.standing_s >= STOPPED_S;
        let at_end = frame.route_m >= self.end_m || (stopped && frame.route_m >= self.end_m - AT_END_M);
        if at_end && frame.left_m.abs() < OFF_ROUTE_M {
            let kept = self.drive.left_road_at_m.is_none();
            return Some(if kept { LoopEnd::Arrived } else { LoopEnd::ArrivedOffRoad });
        }
        if stopped {
            return Some(match (frame.lost, frame.axle_off) {
                (true, _) => LoopEnd::StoppedLost,
                (false, true) => LoopEnd::LeftRoad,
                (false, false) => LoopEnd::StoppedUnsaid,
            });
        }
        if frame.left_m.abs() > OFF_ROUTE_M {
            return Some(if frame.axle_off { LoopEnd::LeftRoad } else { LoopEnd::WrongRoad });
        }
        (frame.t_s > self.end_m / LEAST_MEAN_MPS + SPARE_S).then_some(LoopEnd::TimedOut)
    }

    /// The drive in numbers.
    pub fn finish(self, end: LoopEnd) -> LoopDrive {
        let because = self.last.map(|frame| frame.because).unwrap_or_default();
        let Self { drive, .. } = self;
        LoopDrive {
            end,
            because,
            straight_m: drive.straight.quantiles(),
            junction_m: drive.junction.quantiles(),
            ..drive
        }
    }
}

/// All drives in a table: controllers in this order, and conditions in theirs. The same whatever order the drives came in.
pub fn closed_loop_table(
    drives: &[LoopDrive],
    controllers: &[String],
    conditions: &[String],
    wanted: u64,
) -> ClosedLoop {
    let named = |controller: &String, name: Option<&String>| {
        let wanted = |drive: &&LoopDrive| {
            drive.controller == *controller && name.is_none_or(|name| drive.conditions == *name)
        };
        group(controller, name, &drives.iter().filter(wanted).collect::<Vec<_>>())
    };
    let groups = controllers.iter().flat_map(|controller| {
        let all = [None].into_iter().chain(conditions.iter().map(Some));
        all.map(|name| named(controller, name)).collect::<Vec<_>>()
    });
    let mut not_arrived: Vec<LoopDrive> =
        drives.iter().filter(|drive| drive.end != LoopEnd::Arrived).cloned().collect();
    not_arrived.sort_by(|a, b| {
        let key = |drive: &LoopDrive| (drive.seed, drive.conditions.clone(), drive.controller.clone());
        key(a).cmp(&key(b))
    });
    let done = drives.len() as u64;
    ClosedLoop {
        drives_wanted: wanted,
        interrupted: done < wanted,
        groups: groups.filter(|group| group.drives > 0).collect(),
        not_arrived,
    }
}

fn group(controller: &str, conditions: Option<&String>, drives: &[&LoopDrive]) -> LoopGroup {
    let (mut straight, mut junction) = (CrossTrackCounts::default(), CrossTrackCounts::default());
    for drive in drives {
        straight.merge(&drive.straight);
        junction.merge(&drive.junction);
    }
    let count = |is: &dyn Fn(&LoopDrive) -> bool| drives.iter().filter(|drive| is(drive)).count() as u64;
    let ends = LoopEnd::ALL.map(|end| (end, count(&|drive| drive.end == end)));
    LoopGroup {
        controller: controller.to_owned(),
        conditions: conditions.cloned(),
        drives: drives.len() as u64,
        arrived: count(&|drive| drive.end == LoopEnd::Arrived),
        ends: ends.into_iter().filter(|(_, count)| *count > 0).collect(),
        features: drives.iter().map(|drive| drive.features).sum(),
        straight_m: straight.quantiles(),
        junction_m: junction.quantiles(),
        wheel_off_drives: count(&|drive| drive.wheel_off_frames > 0),
        claimed_off_drives: count(&|drive| drive.claimed_off_frames > 0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// At 5 m/s along a straight lane, `left_m` beside its middle.
    fn frame(i: u32, left_m: f64) -> LoopFrame {
        let t_s = 0.1 * f64::from(i);
        LoopFrame {
            t_s,
            x_m: 5.0 * t_s,
            speed_mps: 5.0,
            route_m: 5.0 * t_s,
            left_m,
            wheel_off_m: -1.0,
            has_line: true,
            ..LoopFrame::default()
        }
    }

    fn watched(frames: impl IntoIterator<Item = LoopFrame>) -> LoopDrive {
        let mut watch = LoopWatch::new(LoopDrive::default(), 100.0);
        let end = frames.into_iter().find_map(|frame| watch.take(&frame));
        watch.finish(end.unwrap_or(LoopEnd::Failed))
    }

    #[test]
    fn one_that_keeps_its_lane_arrives() {
        let drive = watched((0..300).map(|i| frame(i, 0.2)));
        assert_eq!((drive.end, drive.frames), (LoopEnd::Arrived, 201));
        let straight = drive.straight_m.unwrap();
        assert!((straight.p95 - 0.22).abs() < 0.021 && drive.junction_m.is_none());
        assert_eq!(drive.straight.total(), 201);
    }

    #[test]
    fn one_that_stops_says_so_or_not() {
        let stops = |lost| {
            (0..300).map(move |i| LoopFrame {
                speed_mps: if i > 50 { 0.0 } else { 5.0 },
                lost,
                ..frame(i.min(50), 0.0)
            })
        };
        let timed = |frames: Vec<LoopFrame>| {
            let times = frames.into_iter().enumerate();
            times.map(|(i, frame)| LoopFrame { t_s: 0.1 * i as f64, ..frame }).collect::<Vec<_>>()
        };
        assert_eq!(watched(timed(stops(true).collect())).end, LoopEnd::StoppedLost);
        assert_eq!(watched(timed(stops(false).collect())).end, LoopEnd::StoppedUnsaid);
    }

    #[test]
    fn off_the_road_is_told_from_off_the_route_and_claims_are_counted() {
        let drifts = |axle_off| {
            (0..300).map(move |i| LoopFrame {
                axle_off: axle_off && i > 60,
                wheel_off_m: if axle_off && i > 60 { 0.5 } else { -0.5 },
                lost: i > 70,
                ..frame(i, 0.1 * f64::from(i))
            })
        };
        let left = watched(drifts(true));
        assert_eq!((left.end, left.claimed_off_frames), (LoopEnd::LeftRoad, 10));
        assert!((left.left_road_at_m.unwrap() - 30.5).abs() < 1e-9);
        assert_eq!(watched(drifts(false)).end, LoopEnd::WrongRoad);
        let back = watched((0..300).map(|i| LoopFrame { axle_off: i == 60, ..frame(i, 0.0) }));
        assert_eq!(back.end, LoopEnd::ArrivedOffRoad);
    }

    #[test]
    fn the_table_adds_up() {
        let arrived = watched((0..300).map(|i| frame(i, 0.2)));
        let named = |seed, controller: &str, conditions: &str, end| LoopDrive {
            seed,
            controller: controller.to_owned(),
            conditions: conditions.to_owned(),
            end,
            features: 5,
            ..arrived.clone()
        };
        let mut drives = vec![
            named(1, "fuzzy", "clear", LoopEnd::Arrived),
            named(2, "fuzzy", "wet", LoopEnd::StoppedLost),
            named(1, "stanley", "clear", LoopEnd::Arrived),
        ];
        let names = |names: &[&str]| names.iter().map(|&name| name.to_owned()).collect::<Vec<_>>();
        let (controllers, conditions) = (names(&["fuzzy", "stanley"]), names(&["clear", "wet"]));
        let table = closed_loop_table(&drives, &controllers, &conditions, 4);
        assert!(table.interrupted && table.not_arrived.len() == 1);
        assert_eq!(table.groups.len(), 5, "of stanley there is no wet drive");
        assert_eq!((table.groups[0].drives, table.groups[0].arrived, table.groups[0].features), (2, 1, 10));
        assert_eq!(table.groups[0].ends, [(LoopEnd::Arrived, 1), (LoopEnd::StoppedLost, 1)]);
        drives.reverse();
        assert_eq!(table, closed_loop_table(&drives, &controllers, &conditions, 4));
    }
}
