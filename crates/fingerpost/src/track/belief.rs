//! The tracker that is one belief: the states are read off how probable it is that the next feature is there, and where.
//!
//! What is seen of the ground is kept on the ground (`ground_memory.rs`), and from it follows afresh, as often as it has more to
//! say, how probable every place of the next feature is, and that it is not there (`feature_belief.rs`):
//!
//! p(place, unknowns | ground) ~ p(place | progress) p(unknowns) prod (h + (1 - h) prod [q(d) e^l + 1 - q(d)] / [b e^l + 1 - b])
//!
//! over the stretches of the arms, of which a share h is hidden, and the cells of the ground beside each, with l a cell's log-odds of
//! road, d its signed distance from the edge of the road at that place, q the share of such ground that looks like road and b that of ground of which nothing is known. Against it stands the
//! same of a plain road without the feature. Searching while neither is sure, tracking once the feature is there and its place
//! is known well enough to steer by, arrived when the start of their curve reaches the bottom of the view, lost when the
//! probability goes elsewhere. A feature that was arrived at is measured on until it lies behind, while the next is searched for.
//! Where the vehicle is along the route is part of it (`route_belief.rs`). Without a start every feature may be the first one to come:
//! each of these hypotheses has a progress of its own and all of them share the ground (`hypothesis.rs`). Nothing is given out while
//! none of them is sure.

mod along_route;
mod feature_belief;
mod fit;
mod ground_memory;
mod hypothesis;
pub(super) mod junction_shape;
mod likelihood;
mod route_belief;

use fingerpost_geometry::{GeometryError, GroundGrid, Polyline};
use fingerpost_map::{FeatureKind, Route};
use fingerpost_vision::span::SpanError;
use nalgebra::Point2;

use self::feature_belief::{Moments, Workspace};
use self::ground_memory::{GroundMemory, Looks};
use self::hypothesis::{Hypothesis, Reading};
use self::likelihood::{Ground, RowAngles};
use self::route_belief::{FeatureInView, Stage, View};
use super::route_stop::{RouteStop, TrackerSetting, route_stops};
use super::shown::ShownRoad;
use super::{
    CandidatePlace, Decision, Followed, Lack, Moved, ShownSurface, Sought, State, TrackConfig, TrackEvidence,
    TrackOutput,
};
use crate::feature_masks::{PlacedMasks, node_pixel};
use crate::feature_model::ArmModel;
use crate::ground_view::{CameraTurn, Viewpoint};
use crate::matching::{LaidSurface, Match};
use crate::motion::CameraAttitude;
use crate::progress::{Progress, Travel};

/// Follows the features of a route, one after the other.
#[derive(Debug)]
pub struct BeliefTracker {
    config: TrackConfig,
    stops: Vec<RouteStop>,
    route_in_map: Option<Polyline>,
    /// Where the drive began, the likeliest first; one where that is known.
    hypotheses: Vec<Hypothesis>,
    /// The first feature by the hypothesis that is followed.
    believed: Option<usize>,
    memory: GroundMemory,
    ground: Ground,
    work: Workspace,
    /// Metres driven since the beliefs were computed; none before the first time.
    since_update_m: Option<f64>,
    /// Memory of matches that were handed out with the frame before.
    spare: Vec<Match>,
    view_m: [f64; 2],
    viewpoint: Viewpoint,
    /// Angle that a row of the picture spans, radians.
    row_rad: f64,
    /// As of the last frame's [`RoadSurface`](crate::road_surface::RoadSurface).
    reduced_rows: f64,
    /// Where the last frame shows the road.
    shown: ShownRoad,
    /// Standard deviations of the camera's pitch and roll, radians.
    attitude_sigma_rad: [f64; 2],
}

/// Distance driven after which the ground has more to say, metres: a cell of its map.
const NEWS_M: f64 = 0.25;
/// Probability from which a hypothesis is followed, and below which it is no more while it leads through a feature.
const SURE: f64 = 0.9;
const STILL_SURE: f64 = 0.5;
/// A hypothesis less probable than this is given up: two features where it expects them would hardly bring it back.
const GIVEN_UP: f64 = 1e-4;
/// Share of the drives without a start that begin with their route, as likely as not, and how far along it they do, metres: guesses.
const BEGINS_WITH_ROUTE: f64 = 0.5;
const BEGINNING_M: f64 = 5.0;

impl BeliefTracker {
    /// A tracker at the start of `route`, or without one.
    ///
    /// # Errors
    /// [`GeometryError`] when a feature's arms have no extent.
    pub fn new(
        setting: TrackerSetting<'_>,
        route: Option<&Route>,
        start_m: Option<f64>,
    ) -> Result<Self, GeometryError> {
        let (stops, route_in_map) = route_stops(setting, route)?;
        let route_length_m = route_in_map.as_ref().map_or(0.0, Polyline::length_m);
        Ok(Self {
            config: setting.track.clone(),
            hypotheses: hypotheses(setting, &stops, start_m, route_length_m),
            believed: None,
            stops,
            route_in_map,
            memory: GroundMemory::new(setting.viewpoint.foot),
            ground: Ground::default(),
            work: Workspace::default(),
            since_update_m: None,
            spare: Vec::new(),
            view_m: [setting.nearest_seen_m, setting.grid.far_m()],
            viewpoint: setting.viewpoint,
            row_rad: setting.row_rad,
            reduced_rows: 0.0,
            shown: ShownRoad::new(&CameraTurn::default(), setting.viewpoint),
            attitude_sigma_rad: CameraAttitude::default().sigma_rad,
        })
    }

    /// Moves everything on with the vehicle.
    fn carry(&mut self, moved: &Moved<'_>) {
        if let Some(CameraAttitude { turn, sigma_rad }) = moved.camera {
            self.shown = ShownRoad::new(&turn, self.viewpoint);
            self.attitude_sigma_rad = sigma_rad;
        }
        let Some((motion, travel)) = moved.motion.zip(moved.travel()) else { return };
        for hypothesis in &mut self.hypotheses {
            hypothesis.route.advance(travel, moved.time_s());
        }
        if let Travel::Measured { .. } = travel {
            let step = &motion.previous_from_current;
            self.memory.carry(step);
            self.hypotheses.iter_mut().for_each(|hypothesis| hypothesis.route.carry(step));
            self.since_update_m = self.since_update_m.map(|since_m| since_m + step.translation.vector.norm());
        } else {
            self.memory.clear();
            self.hypotheses.iter_mut().for_each(Hypothesis::leave_ground);
            self.since_update_m = None;
        }
    }

    /// Computes the beliefs afresh where the ground has more to say.
    fn compute(&mut self, evidence: &mut TrackEvidence) {
        if self.since_update_m.is_some_and(|since_m| since_m < NEWS_M) {
            return;
        }
        for hypothesis in &mut self.hypotheses {
            hypothesis.choose(&mut self.stops, self.view_m);
        }
        if self.hypotheses.iter().all(|hypothesis| hypothesis.route.features().is_empty()) {
            self.since_update_m = None;
            return;
        }
        self.since_update_m = Some(0.0);
        let rows = RowAngles { picture_rad: self.row_rad, reduced_rad: self.reduced_rows * self.row_rad };
        self.ground.take(self.memory.squares(), self.viewpoint, rows);
        let Self { config, stops, ground, view_m, attitude_sigma_rad, work, .. } = self;
        let (view_m, attitude_sigma_rad) = (*view_m, *attitude_sigma_rad);
        for hypothesis in &mut self.hypotheses {
            evidence.tried +=
                hypothesis.route.weigh(View { config, stops, ground, view_m, attitude_sigma_rad }, work);
        }
    }

    /// Weighs the hypotheses against each other, and gives up what is too improbable.
    fn weigh(&mut self) {
        let most = self.hypotheses.iter().map(Hypothesis::log_weight).fold(f64::NEG_INFINITY, f64::max);
        let share = |hypothesis: &Hypothesis| libm::exp(hypothesis.log_weight() - most);
        let total: f64 = self.hypotheses.iter().map(share).sum();
        for hypothesis in &mut self.hypotheses {
            hypothesis.weight = share(hypothesis) / total;
        }
        self.hypotheses.retain(|hypothesis| hypothesis.weight >= GIVEN_UP);
        self.hypotheses.sort_unstable_by(|a, b| b.weight.total_cmp(&a.weight).then(a.first.cmp(&b.first)));
        let mut index = 0;
        while let Some((one, others)) = self.hypotheses.get(index..).and_then(<[Hypothesis]>::split_first) {
            match others.iter().position(|other| one.agrees_with(other)) {
                Some(offset) => {
                    let other = self.hypotheses.remove(index + 1 + offset);
                    if let Some(one) = self.hypotheses.get_mut(index) {
                        one.take(&other);
                    }
                }
                None => index += 1,
            }
        }
    }

    /// Whether the likeliest hypothesis is sure enough to follow; says what it is not sure against.
    fn believe(&mut self) -> Option<Decision> {
        let first = self.hypotheses.first()?;
        let is_under_way = first.route.features().iter().any(|feature| feature.stage != Stage::Sought);
        let needed = if is_under_way && self.believed == Some(first.first) { STILL_SURE } else { SURE };
        let rival = self.hypotheses.get(1).filter(|_| first.weight < needed);
        self.believed = rival.is_none().then_some(first.first);
        rival.map(|rival| Decision::NextUnknown {
            likeliest: (first.first, first.weight),
            rival: (rival.first, rival.weight),
        })
    }

    /// The output of this frame, and what it rests on.
    fn give(
        &mut self,
        unknown: Option<Decision>,
        laid: &LaidSurface<'_>,
        output: &mut TrackOutput,
        evidence: &mut TrackEvidence,
    ) -> Result<(), SpanError> {
        let Some(hypothesis) = self.hypotheses.first().filter(|_| !self.stops.is_empty()) else {
            output.state = State::NoRoute;
            return Ok(());
        };
        output.state = hypothesis.state;
        evidence.decision = hypothesis.decision.clone();
        output.skipped = evidence.decision.skipped();
        if let Some(unknown) = unknown {
            (output.state, output.skipped, evidence.decision) = (State::Searching, None, unknown);
            return Ok(());
        }
        let at = |stage: Stage| hypothesis.route.features().iter().find(|feature| feature.stage == stage);
        let followed = match hypothesis.state {
            State::Tracking => at(Stage::Tracked),
            State::Arrived => at(Stage::Arrived),
            _ => None,
        };
        let Some(feature) = followed.or_else(|| at(Stage::Sought)) else { return Ok(()) };
        let FeatureInView { index, belief, .. } = feature;
        let (Some(moments), Some(stop)) = (belief.moments(), self.stops.get_mut(*index)) else {
            return Ok(());
        };
        evidence.places.extend(belief.places());
        belief.edges(stop, &mut evidence.edges);
        let (index, is_followed) = (*index, followed.is_some());
        let Moments { vehicle_from_feature, covariance, present } = moments;
        output.candidate = matches!(evidence.decision, Decision::NotSure { lack: Lack::Place { .. }, .. })
            .then_some(CandidatePlace { index, vehicle_from_feature, covariance, present });
        let mut matched = self.spare.pop().unwrap_or_default();
        laid.explain(&mut stop.masks, &self.shown.shown_from_road(&vehicle_from_feature), &mut matched)?;
        if is_followed {
            let present_by_sight = belief.present_by_sight();
            output.followed = Some(Followed {
                index,
                vehicle_from_feature,
                covariance,
                present,
                present_by_sight,
                matched,
            });
        } else {
            evidence.sought = Some(Sought { index, vehicle_from_feature, matched });
        }
        Ok(())
    }

    /// The features of the route with their driving lines.
    pub fn stops(&self) -> &[RouteStop] {
        &self.stops
    }

    /// Takes one frame in: how the vehicle moved, what it shows, and a GPS position in the map frame. Output and evidence take
    /// the place of the last frame's, whose memory is reused.
    ///
    /// # Errors
    /// [`SpanError`] when an arm cannot be drawn.
    pub fn step(
        &mut self,
        moved: Moved<'_>,
        shown: ShownSurface<'_>,
        gps_in_map: Option<Point2<f64>>,
        output: &mut TrackOutput,
        evidence: &mut TrackEvidence,
    ) -> Result<(), SpanError> {
        self.spare.extend(output.followed.take().map(|followed| followed.matched));
        self.spare.extend(evidence.sought.take().map(|sought| sought.matched));
        evidence.clear();
        output.begin_frame();
        if !self.stops.is_empty() {
            self.carry(&moved);
            let looks = Looks {
                probability: &shown.surface.probability,
                uninformed_log_odds: shown.surface.uninformed_log_odds,
                seen: shown.seen,
            };
            self.reduced_rows = shown.surface.reduced_rows;
            self.memory.see(shown.laid.grid(), looks, self.shown.map());
            if let (Some(route), Some(p_in_map)) = (&self.route_in_map, gps_in_map) {
                for hypothesis in self.hypotheses.iter_mut().rev() {
                    evidence.gps = Some(hypothesis.route.observe_gps(route, p_in_map));
                }
            }
            for hypothesis in &mut self.hypotheses {
                hypothesis.decision = Decision::default();
            }
            self.compute(evidence);
            let Self { config, stops, view_m: [nearest_seen_m, _], .. } = self;
            for hypothesis in &mut self.hypotheses {
                let (grid, nearest_seen_m) = (shown.laid.grid(), *nearest_seen_m);
                hypothesis.decide(Reading { config, stops, grid, nearest_seen_m })?;
            }
            self.weigh();
        }
        let unknown = self.believe();
        let is_unknown = unknown.is_some();
        self.give(unknown, &shown.laid, output, evidence)?;
        let beside = output.followed.as_ref().and_then(|followed| followed.route_m(&self.stops));
        let likeliest = || {
            let likeliest = self.hypotheses.first()?.route.progress().components().next()?;
            (!is_unknown).then_some((likeliest.mean_m, likeliest.sigma_m))
        };
        (output.route_m, output.route_sigma_m) = beside.or_else(likeliest).unzip();
        Ok(())
    }

    /// Whether the vehicle is on its way through a junction at which the route turns: lanes end there, and lines cross its way.
    pub fn turns_through(&self, output: &TrackOutput) -> bool {
        let followed = output.followed.as_ref().filter(|_| output.state == State::Arrived);
        let model = followed.and_then(|followed| self.stops.get(followed.index)).map(|stop| &stop.model);
        model.is_some_and(|model| {
            model.kind == FeatureKind::Junction && model.exit().is_some_and(ArmModel::leaves_the_line)
        })
    }

    /// The masks of the followed feature, or else of the one searched for, where they matched.
    pub fn placed_masks(
        &self,
        output: &TrackOutput,
        evidence: &TrackEvidence,
        grid: &GroundGrid,
    ) -> Option<PlacedMasks<'_>> {
        let followed = output.followed.as_ref().map(|followed| (followed.index, &followed.matched));
        let sought = evidence.sought.as_ref().map(|sought| (sought.index, &sought.matched));
        let (index, matched) = followed.or(sought)?;
        let pose = &matched.vehicle_from_feature;
        let masks = self.stops.get(index)?.masks.drawn(pose.rotation.angle())?;
        let (column, row) = node_pixel(grid, pose);
        Some(PlacedMasks { masks, column, row })
    }
}

/// The answers to where a drive begins: at its start, with its route, or anywhere before one of the route's features.
fn hypotheses(
    setting: TrackerSetting<'_>,
    stops: &[RouteStop],
    start_m: Option<f64>,
    route_length_m: f64,
) -> Vec<Hypothesis> {
    let at = |start_m: f64| Progress::new(setting.progress, Some(start_m), route_length_m);
    let last_m = match (start_m, stops.last()) {
        (None, Some(last)) if stops.len() > 1 => last.model.route_m.max(1.0),
        // Of a single feature there is no doubt which is first.
        (None, Some(only)) => {
            let before = [0.0, only.model.route_m.max(1.0)];
            let progress = Progress::between(setting.progress, before, route_length_m);
            return vec![Hypothesis::new(0, progress, 1.0)];
        }
        (start_m, _) => return vec![Hypothesis::new(0, at(start_m.unwrap_or_default()), 1.0)],
    };
    let with_route = Hypothesis::new(0, at(BEGINNING_M), BEGINS_WITH_ROUTE);
    let mut from_m = 0.0;
    let within = stops.iter().enumerate().map(|(first, stop)| {
        let to_m = stop.model.route_m.max(from_m + 1.0);
        let prior = (1.0 - BEGINS_WITH_ROUTE) * (to_m - from_m) / last_m;
        let progress = Progress::between(setting.progress, [from_m, to_m], route_length_m);
        from_m = to_m;
        Hypothesis::new(first, progress, prior)
    });
    std::iter::once(with_route).chain(within).collect()
}
