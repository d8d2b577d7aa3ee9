//! Which line leads: the driving line through the feature at hand, the road's middle, or the lane.

use fingerpost_control::{ControllerName, PathPoint, arc, at, foot, lay};
use nalgebra::{Isometry2, Point2};

use super::alignment::{FeaturePlace, GATE_SIGMAS};
use super::{AdviceInput, AdviceSetting};
use crate::centreline::{Centreline, SteerBy, WayKind};
use crate::feature_model::ArmModel;
use crate::lanes::{Lane, Side};
use crate::track::{CandidatePlace, Followed, RouteStop};
use crate::vehicle::VehicleConfig;

/// What is steered along.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum LineKind {
    /// The driving line through the feature that is followed.
    DrivingLine,
    /// The vehicle's part of the road, by the road's middle.
    Centreline,
    /// The middle of the lane.
    Lane,
}

impl LineKind {
    /// Its name, as it stands in files.
    pub const fn name(self) -> &'static str {
        match self {
            Self::DrivingLine => "driving_line",
            Self::Centreline => "centreline",
            Self::Lane => "lane",
        }
    }
}

/// Why a line leads no farther.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum RoadEnd {
    /// The road ends at another, and nothing says which of its arms is taken.
    Ambiguous,
    /// The vehicle cannot turn as tightly as the feature asks for.
    TooTight {
        /// Radius of the driving line, metres.
        tightest_radius_m: f64,
        /// Radius of the vehicle's turning circle, metres.
        turning_radius_m: f64,
    },
}

/// The line that leads, whose points are the stage's path.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Led {
    pub(super) kind: LineKind,
    /// The feature through which it leads, and its node, vehicle frame, metres; none of other lines.
    feature: Option<(usize, Point2<f64>)>,
    /// Standard deviation of its place across itself, metres.
    pub(super) sigma_m: f64,
    /// How far the vehicle may be beside it, metres.
    pub(super) room_m: f64,
    /// Probability that it is there, 0 to 1.
    pub(super) present: f64,
    /// How far ahead it is seen, metres.
    pub(super) seen_m: f64,
    /// Why it leads no farther than that; none where only sight ends.
    pub(super) end: Option<RoadEnd>,
    /// Metres driven since it was seen.
    pub(super) kept_m: f64,
}

impl Led {
    /// After a motion of the vehicle along it unseen, each metre of which makes it less sure by `sigma`, metres.
    pub(super) fn drive_on(&mut self, previous_from_current: &Isometry2<f64>, sigma: f64) {
        let way_m = previous_from_current.translation.x.abs();
        self.feature = self.feature.map(|(index, node)| (index, previous_from_current.inverse() * node));
        self.kept_m += way_m;
        self.seen_m -= way_m;
        self.sigma_m += sigma * way_m;
    }

    /// Whether the feature through which it leads lies behind the vehicle.
    fn is_behind(&self) -> bool {
        self.feature.is_some_and(|(_, node)| node.x < 0.0)
    }

    /// Whether this frame shows it.
    pub(super) fn is_seen(&self) -> bool {
        self.kept_m <= 0.0
    }
}

/// Distance between the points of a line that is an arc, metres.
const STEP_M: f64 = 0.5;
/// How far beside the vehicle a driving line may pass to be followed, metres: within half a wide road.
const MOST_BESIDE_M: f64 = 5.0;
/// Room beside a line that there is at the least, metres: what is narrower than the vehicle is measured wrong.
const LEAST_ROOM_M: f64 = 0.2;

/// Chooses among the lines of a frame.
#[derive(Debug)]
pub(super) struct LineFinder {
    vehicle: VehicleConfig,
    controller: ControllerName,
    /// How far ahead the ground view shows the road, metres.
    far_m: f64,
    /// How far ahead the centreline aims, metres.
    aim_m: f64,
    /// Width of the lane when both its edges were known, metres.
    lane_width_m: Option<f64>,
    width: KnownWidth,
    /// Points of the driving line where the road's middle has them, vehicle frame, metres.
    points: Vec<Point2<f64>>,
    /// The same as a path.
    laid: Vec<PathPoint>,
}

impl LineFinder {
    pub(super) fn new(setting: &AdviceSetting<'_>) -> Self {
        Self {
            vehicle: setting.vehicle.clone(),
            controller: setting.advice.controller,
            far_m: setting.far_m,
            aim_m: setting.aim_m,
            lane_width_m: None,
            width: KnownWidth::default(),
            points: Vec::new(),
            laid: Vec::new(),
        }
    }

    pub(super) const fn controller(&self) -> ControllerName {
        self.controller
    }

    /// The line that leads in a frame, with its points in `path`; none where there is none or the one that is kept in `path` leads
    /// on, and `path` is left as it is.
    pub(super) fn find(
        &mut self,
        input: &AdviceInput<'_>,
        kept: Option<&Led>,
        path: &mut Vec<PathPoint>,
    ) -> Option<Led> {
        let followed = input.track.followed.as_ref();
        let stop = followed.and_then(|followed| input.stops.get(followed.index));
        self.width.learn(stop.zip(followed), input.centreline);
        let through = Through::at_hand(input);
        let leads_on = foot(path, Point2::origin())
            .zip(path.last())
            .is_some_and(|(beside, last)| last.along_m - beside.on_path.along_m > self.aim_m);
        if let Some(led) = through.and_then(|through| self.driving_line(&through, input)) {
            // Where the feature is no longer seen well its place may jump: the line that lies where it was seen better is surer.
            let index = |led: &Led| led.feature.map(|(index, _)| index);
            let same = kept.filter(|kept| leads_on && index(kept) == index(&led));
            if same.is_some_and(|kept| kept.sigma_m < led.sigma_m || self.jumps(kept, path, &led)) {
                return None;
            }
            std::mem::swap(path, &mut self.laid);
            return Some(led);
        }
        // Just behind a corner the road's middle is told by few edges: the line through the corner was surer.
        let through_corner = kept.is_some_and(|led| led.kind == LineKind::DrivingLine && led.end.is_none());
        if leads_on && through_corner {
            return None;
        }
        // The road's surface shows bends and ends that a lane's kept edges do not, and which side of the road the vehicle is on.
        if let Some(road) = input.centreline.filter(|road| self.width.fits(road)) {
            return Some(self.centreline(road, path));
        }
        // A lane that is in sight is surer than one that was.
        let keeps = kept.is_some_and(|led| led.kind != LineKind::Lane || input.lane.is_none());
        if leads_on && keeps {
            return None;
        }
        input.lane.and_then(|lane| self.lane(lane, path))
    }

    /// Whether a feature's line of this frame is beside the one that is kept by more than both may be off, though the feature lies behind
    /// the vehicle by what is kept: its arms are out of view then but for the exit, and what is taken for them is something else.
    fn jumps(&self, kept: &Led, path: &[PathPoint], led: &Led) -> bool {
        let most_m = GATE_SIGMAS * libm::hypot(kept.sigma_m, led.sigma_m);
        let apart_m = |place: Point2<f64>| {
            let feet = foot(path, place).zip(foot(&self.laid, place));
            feet.is_some_and(|(kept, fresh)| (kept.left_m - fresh.left_m).abs() > most_m)
        };
        kept.is_behind()
            && (apart_m(Point2::origin()) || apart_m(at(path, self.aim_m).unwrap_or_default().place()))
    }

    fn room_m(&self, half_width_m: f64) -> f64 {
        (half_width_m - 0.5 * self.vehicle.width_m).max(LEAST_ROOM_M)
    }

    fn led(&self, kind: LineKind, sigma_m: f64, half_width_m: f64) -> Led {
        let (room_m, seen_m) = (self.room_m(half_width_m), self.far_m);
        Led { kind, feature: None, sigma_m, room_m, present: 1.0, seen_m, end: None, kept_m: 0.0 }
    }

    /// The driving line through a feature where the road's middle beside the vehicle has it, in `laid`; none where it does not lead past the
    /// vehicle.
    fn driving_line(&mut self, through: &Through<'_>, input: &AdviceInput<'_>) -> Option<Led> {
        let Through { index, stop, tracked, present } = *through;
        let line = stop.line.as_ref()?;
        let place = match input.centreline {
            Some(road) => tracked.with_road(&stop.model, road),
            None => tracked,
        };
        let in_vehicle = line.points.iter().map(|p_in_feature| place.vehicle_from_feature * p_in_feature);
        self.points.clear();
        self.points.extend(in_vehicle.skip_while(|p_in_vehicle| p_in_vehicle.x < 0.0));
        let passes = |place: &Point2<f64>| place.coords.norm() < MOST_BESIDE_M;
        if self.points.len() < 2 || !self.points.iter().any(passes) {
            return None;
        }
        lay(&self.points, &line.curvature_per_m[line.points.len() - self.points.len()..], &mut self.laid);
        let path = &self.laid;
        let aim = at(path, self.aim_m).unwrap_or_default();
        let sigma_m = place.sigma_across_m(aim.place(), aim.direction());
        let width_m = stop.model.approach().map_or(0.0, |arm| arm.width_m);
        let to_edge_m = 0.5 * width_m - self.vehicle.traffic.lane_left_m(width_m).abs();
        let mut led = self.led(LineKind::DrivingLine, sigma_m, to_edge_m);
        let node = place.vehicle_from_feature * Point2::origin();
        (led.feature, led.present) = (Some((index, node)), present);
        if !line.within_turning_circle() {
            let begins = foot(path, place.vehicle_from_feature * line.start());
            led.seen_m = led.seen_m.min(begins.map_or(0.0, |begins| begins.on_path.along_m));
            led.end = Some(RoadEnd::TooTight {
                tightest_radius_m: line.tightest_radius_m,
                turning_radius_m: line.turning_radius_m,
            });
        }
        Some(led)
    }

    /// The middle of the lane, by both edges or by one and the width that it had.
    fn lane(&mut self, lane: &Lane, path: &mut Vec<PathPoint>) -> Option<Led> {
        self.lane_width_m = lane.width_m().or(self.lane_width_m);
        let half_m = 0.5 * self.lane_width_m?;
        let edges = [Side::Left, Side::Right].map(|side| lane.edge(side));
        let inwards = [-half_m, half_m];
        let shown = || edges.iter().zip(inwards).filter_map(|(edge, inwards)| Some(((*edge)?, inwards)));
        let count = shown().count() as f64;
        if count < 1.0 {
            return None;
        }
        let [mut left_m, mut heading_rad, mut curvature_per_m, mut variance_m2] = [0.0; 4];
        for (edge, inwards_m) in shown() {
            left_m += (edge.offset_m + inwards_m) / count;
            heading_rad += edge.heading_rad / count;
            curvature_per_m += edge.curvature_per_m / count;
            variance_m2 += (edge.offset_sigma_m / count).powi(2);
        }
        arc(left_m, heading_rad, curvature_per_m, [self.far_m, STEP_M], path);
        Some(self.led(LineKind::Lane, variance_m2.sqrt(), half_m))
    }

    /// The vehicle's part of the road.
    fn centreline(&self, road: &Centreline, path: &mut Vec<PathPoint>) -> Led {
        let lane_left_m = self.vehicle.traffic.lane_left_m(road.width_m);
        let mut led = self.led(LineKind::Centreline, road.sigma_m, 0.5 * road.width_m - lane_left_m.abs());
        let turns = road.way_on.is_some_and(|way| way != WayKind::On);
        match road.steer {
            Some(steer) if turns && steer.by == SteerBy::Road => {
                // Round a corner that is no feature the road's surface alone leads, by one direction.
                let curvature_per_m = 2.0 * libm::sin(steer.direction_rad) / self.aim_m;
                arc(0.0, 0.0, curvature_per_m, [self.aim_m, STEP_M], path);
                led.seen_m = self.aim_m;
            }
            steer => {
                let across = lane_left_m / libm::cos(road.heading_rad);
                // A line beside a curve has another curvature.
                let curvature_per_m =
                    road.curvature_per_m / (1.0 - lane_left_m * road.curvature_per_m).max(0.1);
                arc(road.offset_m + across, road.heading_rad, curvature_per_m, [self.far_m, STEP_M], path);
                if steer.is_none() {
                    let begins_m = road.corner_begins_m.unwrap_or(self.aim_m);
                    led.seen_m = led.seen_m.min(begins_m.max(0.0));
                    led.end = Some(RoadEnd::Ambiguous);
                }
            }
        }
        led
    }
}

/// A feature that the vehicle may steer through.
struct Through<'a> {
    /// Its index in the route.
    index: usize,
    stop: &'a RouteStop,
    tracked: FeaturePlace,
    /// Probability that the driving line is there, 0 to 1.
    present: f64,
}

impl<'a> Through<'a> {
    /// The feature that is followed, or else one at which the route turns and whose place alone is not sure: driving on straight where
    /// the route turns is surely wrong.
    fn at_hand(input: &AdviceInput<'a>) -> Option<Self> {
        if let Some(followed) = &input.track.followed {
            let stop = input.stops.get(followed.index)?;
            let Followed { vehicle_from_feature, covariance, present, .. } = *followed;
            let tracked = FeaturePlace { vehicle_from_feature, covariance };
            // Where the route keeps to its road, that goes on whether the feature is there or not.
            let present = if turns(stop) { present } else { 1.0 };
            return Some(Self { index: followed.index, stop, tracked, present });
        }
        let CandidatePlace { index, vehicle_from_feature, covariance, present } = input.track.candidate?;
        let stop = input.stops.get(index).filter(|stop| turns(stop))?;
        Some(Self { index, stop, tracked: FeaturePlace { vehicle_from_feature, covariance }, present })
    }
}

/// How wide the road should be: as the map has it, by what has been measured of roads that it has.
#[derive(Debug, Clone, Copy, Default)]
struct KnownWidth {
    /// The map's width of the road under way, metres; none before the first feature.
    on_map_m: Option<f64>,
    /// Logarithm of measured widths by the map's.
    log_ratio: f64,
}

/// A road's middle that is sure to this, metres, tells the road's width: on clear drives widths are within a tenth then.
const SURE_SIGMA_M: f64 = 0.15;
/// A road that is wider than this by what is known of it has an edge that is none. On eight clear drives the middle of roads of
/// 5.5 and 6.5 m is off by 0.1 m (median) where they are measured up to 6.5 m wide, and by 0.8 m and more from 7.5 m on.
const MOST_WIDER: f64 = 1.25;
/// Share of a new width in what is known: some five seconds at ten frames a second.
const LEARNING: f64 = 0.02;

impl KnownWidth {
    /// Takes the map's width from the feature that is followed, and what is measured where that is sure.
    fn learn(&mut self, followed: Option<(&RouteStop, &Followed)>, road: Option<&Centreline>) {
        if let Some((stop, followed)) = followed {
            let ahead = followed.vehicle_from_feature.translation.x > 0.0;
            let arm = if ahead { stop.model.approach() } else { stop.model.exit() };
            self.on_map_m = arm.map(|arm| arm.width_m).or(self.on_map_m);
        }
        if let Some((road, on_map_m)) = road.filter(|road| road.sigma_m < SURE_SIGMA_M).zip(self.on_map_m) {
            self.log_ratio += LEARNING * (libm::log(road.width_m / on_map_m) - self.log_ratio);
        }
    }

    /// Whether a road's width is one that it may have.
    fn fits(&self, road: &Centreline) -> bool {
        self.on_map_m.is_none_or(|on_map_m| road.width_m < MOST_WIDER * on_map_m * libm::exp(self.log_ratio))
    }
}

/// Whether the route turns at a feature.
pub(super) fn turns(stop: &RouteStop) -> bool {
    stop.model.exit().is_some_and(ArmModel::leaves_the_line)
}
