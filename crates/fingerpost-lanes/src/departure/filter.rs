//! Where the vehicle is between its lane's edges and how fast it moves across, from noisy edges.
//!
//! A Kalman filter on five numbers: the offsets of both edges at the rear axle, the speed across the lane, a turn that all
//! edges seem to have against the road because the camera looks aside, and the yaw rate that keeps to the road, its bias
//! included. Both edges share the speed, which the directions of the edges measure too and the yaw rate beyond the road's
//! changes: so an edge that jumps when a dash ends, or is not seen for a moment, is carried by the other one and by what the
//! vehicle was doing. The width of a lane changes slowly, which averages the offsets over seconds without a lag in the drift.

use nalgebra::{Matrix5, RowVector5, Vector5};

use super::DepartureConfig;
use crate::Side;
use crate::geometry::{EdgeOnRoad, LaneOnRoad};

/// Places of the numbers in the state behind the two offsets.
const LATERAL: usize = 2;
const BIAS: usize = 3;
const BEND: usize = 4;

/// How fast an edge wanders beside the vehicle for other reasons than its drift, m per square root of a second: markings are
/// painted by hand, and lanes widen within minutes.
const WANDER_M: f64 = 0.005;
/// How fast drivers change the speed across the lane, m/s per square root of a second: 0.2 m/s² for a second.
const STEERING_MPS: f64 = 0.2;
/// The same where the yaw rate tells it: what is left is the yaw rate's noise.
const STEERED_MPS: f64 = 0.05;
/// How fast the camera's yaw wanders, radians per square root of a second: a mount moves over minutes.
const BIAS_RAD: f64 = 0.0005;
/// How fast the road's own yaw rate changes, radians a second per square root of a second: bends begin over seconds.
const BEND_RPS: f64 = 0.003;
/// How far a camera's yaw may be off at first, radians: what a calibration leaves, a third of a degree.
const FIRST_BIAS_RAD: f64 = 0.006;
/// Speed across the lane at first, m/s: an ordinary lane change.
const FIRST_LATERAL_MPS: f64 = 0.5;
/// Yaw rate of the road at first, radians a second: a motorway's bend and a gyroscope's bias.
const FIRST_BEND_RPS: f64 = 0.03;
/// How far off the curvature of an edge is seen, 1/m.
const CURVATURE_SIGMA_PER_M: f64 = 5e-4;
/// Bias of a yaw rate, radians a second: half a degree.
const YAW_RATE_SIGMA_RPS: f64 = 0.008;
/// For how long a curvature's error stays alike, seconds.
const CURVATURE_CORRELATION_S: f64 = 1.0;
/// How far the curvature's mean may be from the road's yaw rate until a bend has begun, radians a second: beyond what a yaw
/// rate's bias and the curvature's noise are off, and at 30 m/s a drift of a third of a metre a second within a second.
const BEND_OFF_RPS: f64 = 0.012;
/// Time within which a bend that has begun is taken in, seconds.
const BEND_BEGINS_S: f64 = 0.2;
/// For how long an edge's error in place stays alike, seconds; so long do frames say the same again.
const OFFSET_CORRELATION_S: f64 = 0.6;
/// The same for its direction.
const HEADING_CORRELATION_S: f64 = 0.6;
/// Innovations beyond so many standard deviations count less the farther off they are (Huber).
const HUBER_SIGMAS: f64 = 1.0;
/// From here an edge is another edge, metres: no edge of one lane moves so far between frames.
const OTHER_EDGE_M: f64 = 1.0;
/// From here it is that of another lane, metres: lanes are wider, and seams and patches that are taken for an edge mostly lie
/// nearer.
const OTHER_LANE_M: f64 = 2.0;
/// How long an edge may be off by more than the filter allows before it is taken as moved, seconds.
const MOVED_EDGE_S: f64 = 1.5;
/// Innovation from which an edge is off, standard deviations.
const OFF_SIGMAS: f64 = 3.0;
/// How long an edge that is not seen is still known, seconds.
const UNSEEN_S: f64 = 2.0;
/// Speed below which directions say nothing about the speed across, m/s.
const MIN_SPEED_MPS: f64 = 2.0;
/// Most acceleration across the lane by which a vehicle is turned against its road, m/s², and, where its yaw rate is not
/// known, by which the road turns it: an edge that asks for more is drawn wrongly.
const MAX_AGAINST_ROAD_MPS2: f64 = 4.0;
const MAX_WITH_ROAD_MPS2: f64 = 8.0;
/// Time constant of the curvature's mean, seconds, and the least share of a new one.
const CURVATURE_MEAN: (f64, f64) = (0.5, 0.02);
/// Frames that say the same again at the most, whatever the rate.
const MAX_ALIKE: f64 = 1e3;

/// What the vehicle says of its motion.
#[derive(Debug, Clone, Copy)]
pub(super) struct VehicleMotion {
    pub(super) speed_mps: Option<f64>,
    pub(super) yaw_rate_rps: Option<f64>,
    /// Since the frame before, seconds.
    pub(super) dt_s: f64,
}

/// What a frame brought.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Seen {
    /// How far each edge was from where it was expected, metres.
    pub(super) innovation_m: [Option<f64>; 2],
    /// Which edges are others than before: nothing is known of them from earlier frames.
    pub(super) other_edge: [bool; 2],
    /// The edges are those of another lane.
    pub(super) lane_changed: bool,
}

/// An edge at some distance ahead.
#[derive(Debug, Clone, Copy)]
pub(super) struct EdgeAhead {
    /// Metres to the left.
    pub(super) left_m: f64,
    /// Its standard deviation.
    pub(super) sigma_m: f64,
}

/// How long ago an edge was seen and for how long it has been off, seconds.
#[derive(Debug, Clone, Copy, Default)]
struct Watch {
    unseen_s: f64,
    off_s: f64,
}

/// The filter with its state.
#[derive(Debug, Clone, Default)]
pub(super) struct LateralFilter {
    state: Vector5<f64>,
    covariance: Matrix5<f64>,
    known: [Option<Watch>; 2],
    curvature_per_m: f64,
}

impl LateralFilter {
    /// Takes a frame in.
    pub(super) fn step(
        &mut self,
        config: &DepartureConfig,
        lane: &LaneOnRoad,
        vehicle: VehicleMotion,
    ) -> Seen {
        self.predict(vehicle);
        let dt_s = vehicle.dt_s;
        let mut seen = Seen::default();
        for (side, edge) in Side::BOTH.into_iter().zip([lane.left, lane.right]) {
            let Some(edge) = edge.filter(|edge| edge.kept_frames == 0 && is_finite(edge)) else { continue };
            let moved = self.take_offset(config, side, edge.offset_m, dt_s);
            seen.innovation_m[side.index()] = moved.innovation_m;
            seen.other_edge[side.index()] = moved.other_edge;
            seen.lane_changed |= moved.other_lane;
            if !can_be_followed(&edge, vehicle) {
                continue;
            }
            let (time_s, least) = CURVATURE_MEAN;
            let share = (dt_s / time_s).clamp(least, 1.0);
            self.curvature_per_m += share * (edge.curvature_per_m - self.curvature_per_m);
            if let Some(mps) = vehicle.speed_mps.filter(|mps| *mps >= MIN_SPEED_MPS) {
                self.take_direction(config, &edge, mps, dt_s);
            }
        }
        for known in &mut self.known {
            *known = known.filter(|watch| watch.unseen_s <= UNSEEN_S);
        }
        seen
    }

    /// Speed across the lane, m/s, positive to the left; none while no edge is known.
    pub(super) fn lateral_speed_mps(&self) -> Option<f64> {
        self.known.iter().any(Option::is_some).then_some(self.state[LATERAL])
    }

    pub(super) fn heading_bias_rad(&self) -> f64 {
        self.state[BIAS]
    }

    /// Where an edge is at some distance ahead; none while it is not known.
    pub(super) fn edge_at(&self, side: Side, ahead_m: f64, speed_mps: Option<f64>) -> Option<EdgeAhead> {
        self.known[side.index()]?;
        // The vehicle moves across because it points across: the edge leans the other way.
        let lean = speed_mps.map_or(0.0, |mps| -1.0 / mps.max(MIN_SPEED_MPS));
        let mut of_state = RowVector5::zeros();
        of_state[side.index()] = 1.0;
        of_state[LATERAL] = ahead_m * lean;
        let left_m = (of_state * self.state)[0] + 0.5 * self.curvature_per_m * ahead_m * ahead_m;
        let variance = (of_state * self.covariance * of_state.transpose())[0];
        Some(EdgeAhead { left_m, sigma_m: variance.max(f64::MIN_POSITIVE).sqrt() })
    }

    fn predict(&mut self, VehicleMotion { speed_mps, yaw_rate_rps, dt_s }: VehicleMotion) {
        if self.known.iter().all(Option::is_none) {
            let sigmas = [1.0, 1.0, FIRST_LATERAL_MPS, FIRST_BIAS_RAD, FIRST_BEND_RPS];
            *self = Self {
                covariance: Matrix5::from_diagonal(&Vector5::from(sigmas.map(|sigma| sigma * sigma))),
                ..Self::default()
            };
            return;
        }
        let mut motion = Matrix5::identity();
        for side in Side::BOTH {
            motion[(side.index(), LATERAL)] = -dt_s;
        }
        let mut steering_mps = STEERING_MPS;
        let mut turned_mps = 0.0;
        if let Some((mps, rps)) = speed_mps.zip(yaw_rate_rps) {
            // What the vehicle turns beyond the road turns its speed across the lane.
            motion[(LATERAL, BEND)] = -mps * dt_s;
            turned_mps = mps * rps * dt_s;
            steering_mps = STEERED_MPS;
        }
        let noise = Vector5::new(WANDER_M, WANDER_M, steering_mps, BIAS_RAD, BEND_RPS);
        let noise = noise.map(|sigma| sigma * sigma * dt_s);
        self.state = motion * self.state;
        self.state[LATERAL] += turned_mps;
        self.covariance = motion * self.covariance * motion.transpose() + Matrix5::from_diagonal(&noise);
        for watch in self.known.iter_mut().flatten() {
            watch.unseen_s += dt_s;
        }
    }

    fn take_offset(&mut self, config: &DepartureConfig, side: Side, offset_m: f64, dt_s: f64) -> Moved {
        let place = side.index();
        let variance = config.offset_sigma_m * config.offset_sigma_m;
        let Some(watch) = self.known[place] else {
            self.start_edge(place, offset_m, variance);
            return Moved { other_edge: true, ..Moved::default() };
        };
        let innovation_m = offset_m - self.state[place];
        // What one frame may be off; the filter itself counts frames that err alike as one.
        let spread_m = (self.covariance[(place, place)] + variance).sqrt();
        let off_s = if innovation_m.abs() > OFF_SIGMAS * spread_m { watch.off_s + dt_s } else { 0.0 };
        let other_edge = innovation_m.abs() > OTHER_EDGE_M || off_s > MOVED_EDGE_S;
        if other_edge {
            self.start_edge(place, offset_m, variance);
        } else {
            self.known[place] = Some(Watch { unseen_s: 0.0, off_s });
            let mut of_state = RowVector5::zeros();
            of_state[place] = 1.0;
            self.update(&of_state, innovation_m, variance, alike(OFFSET_CORRELATION_S, dt_s));
        }
        let other_lane = innovation_m.abs() > OTHER_LANE_M;
        Moved { innovation_m: Some(innovation_m), other_edge, other_lane }
    }

    /// Direction and curvature of an edge, at a speed that lets them say something.
    fn take_direction(&mut self, config: &DepartureConfig, edge: &EdgeOnRoad, mps: f64, dt_s: f64) {
        let of_heading = RowVector5::new(0.0, 0.0, -1.0 / mps, 1.0, 0.0);
        let innovation = libm::tan(edge.heading_rad) - (of_heading * self.state)[0];
        let sigma_rad = config.heading_sigma_deg.to_radians();
        self.update(&of_heading, innovation, sigma_rad * sigma_rad, alike(HEADING_CORRELATION_S, dt_s));

        let of_bend = RowVector5::new(0.0, 0.0, 0.0, 0.0, 1.0);
        let innovation = edge.curvature_per_m * mps - self.state[BEND];
        let sigma_rps = CURVATURE_SIGMA_PER_M * mps + YAW_RATE_SIGMA_RPS;
        // So far off for so long is no error: a bend has begun or ended.
        let off_rps = self.curvature_per_m * mps - self.state[BEND];
        if off_rps.abs() > BEND_OFF_RPS {
            let share = (dt_s / BEND_BEGINS_S).min(1.0);
            self.covariance[(BEND, BEND)] += share * off_rps * off_rps;
        }
        self.update(&of_bend, innovation, sigma_rps * sigma_rps, alike(CURVATURE_CORRELATION_S, dt_s));
    }

    /// An edge that is seen for the first time, or elsewhere: what it says is new, and nothing else follows from it.
    fn start_edge(&mut self, place: usize, offset_m: f64, variance: f64) {
        self.state[place] = offset_m;
        self.covariance.row_mut(place).fill(0.0);
        self.covariance.column_mut(place).fill(0.0);
        self.covariance[(place, place)] = variance;
        self.known[place] = Some(Watch::default());
    }

    /// The measurement of a number that is `of_state` times the state, `innovation` off, with the variance of one frame, of
    /// which so many are alike. One that is far off counts less.
    fn update(&mut self, of_state: &RowVector5<f64>, innovation: f64, variance: f64, alike: f64) {
        let shared = self.covariance * of_state.transpose();
        let expected = (of_state * shared)[0];
        let excess = (innovation.abs() / (HUBER_SIGMAS * (expected + variance).sqrt())).max(1.0);
        let variance = variance * alike * excess * excess;
        let gain = shared / (expected + variance);
        self.state += gain * innovation;
        // Joseph's form keeps the covariance symmetric and positive.
        let rest = Matrix5::identity() - gain * of_state;
        self.covariance = rest * self.covariance * rest.transpose() + gain * variance * gain.transpose();
    }
}

/// By how much the variance of one frame grows when the frames of a time say the same again.
fn alike(time_s: f64, dt_s: f64) -> f64 {
    (time_s / dt_s.max(f64::MIN_POSITIVE)).clamp(1.0, MAX_ALIKE)
}

/// What became of an offset.
#[derive(Debug, Clone, Copy, Default)]
struct Moved {
    innovation_m: Option<f64>,
    other_edge: bool,
    other_lane: bool,
}

/// Whether a vehicle with this motion can be beside an edge that bends so.
fn can_be_followed(edge: &EdgeOnRoad, vehicle: VehicleMotion) -> bool {
    let Some(mps) = vehicle.speed_mps else { return true };
    let of_road = edge.curvature_per_m * mps;
    match vehicle.yaw_rate_rps {
        Some(rps) => mps * (of_road - rps).abs() <= MAX_AGAINST_ROAD_MPS2,
        None => mps * of_road.abs() <= MAX_WITH_ROAD_MPS2,
    }
}

fn is_finite(edge: &EdgeOnRoad) -> bool {
    edge.offset_m.is_finite() && edge.heading_rad.is_finite() && edge.curvature_per_m.is_finite()
}
