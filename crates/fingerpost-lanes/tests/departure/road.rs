//! A vehicle between the edges of lanes, and a camera that sees them badly.

use std::f64::consts::TAU;

use fingerpost_lanes::geometry::{EdgeOnRoad, LaneOnRoad};

/// Front axle ahead of the rear one, and the body's width, metres.
pub(crate) const FRONT_AXLE_M: f64 = 2.7;
pub(crate) const WIDTH_M: f64 = 1.8;

/// Random numbers that are the same every time.
pub(crate) struct Random(u64);

impl Random {
    pub(crate) fn new(seed: u64) -> Self {
        Self(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ 0x5851_f42d_4c95_7f2d)
    }

    /// Evenly spread between two numbers.
    pub(crate) fn between(&mut self, low: f64, high: f64) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut bits = self.0;
        bits = (bits ^ (bits >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        bits = (bits ^ (bits >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        low + (high - low) * ((bits ^ (bits >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Normally spread with standard deviation 1.
    pub(crate) fn normal(&mut self) -> f64 {
        let (radius, angle) = (self.between(1e-12, 1.0), self.between(0.0, TAU));
        (-2.0 * libm::log(radius)).sqrt() * libm::cos(angle)
    }

    pub(crate) fn happens(&mut self, probability: f64) -> bool {
        self.between(0.0, 1.0) < probability
    }

    pub(crate) fn sign(&mut self) -> f64 {
        if self.happens(0.5) { 1.0 } else { -1.0 }
    }
}

/// An error that stays alike for a while.
struct Correlated {
    value: f64,
    sigma: f64,
    time_s: f64,
}

impl Correlated {
    fn new(random: &mut Random, sigma: f64, time_s: f64) -> Self {
        Self { value: sigma * random.normal(), sigma, time_s }
    }

    fn step(&mut self, random: &mut Random, dt_s: f64) -> f64 {
        let kept = libm::exp(-dt_s / self.time_s);
        self.value = kept * self.value + (1.0 - kept * kept).sqrt() * self.sigma * random.normal();
        self.value
    }
}

/// A road of equal lanes.
#[derive(Clone, Copy)]
pub(crate) struct Road {
    pub(crate) lane_width_m: f64,
    pub(crate) curvature_per_m: f64,
}

/// The vehicle on it: its rear axle left of the middle of lane 0, and its speed across.
#[derive(Clone, Copy, Default)]
pub(crate) struct Place {
    pub(crate) left_m: f64,
    pub(crate) lateral_mps: f64,
}

impl Place {
    pub(crate) fn heading_rad(&self, speed_mps: f64) -> f64 {
        libm::asin((self.lateral_mps / speed_mps).clamp(-0.5, 0.5))
    }

    /// How far the outer sides of the front wheels are from the left and the right edge of lane 0.
    pub(crate) fn clearance_m(&self, road: &Road, speed_mps: f64) -> [f64; 2] {
        let across_m = self.left_m + libm::tan(self.heading_rad(speed_mps)) * FRONT_AXLE_M
            - 0.5 * road.curvature_per_m * FRONT_AXLE_M * FRONT_AXLE_M;
        [1.0, -1.0].map(|sign| 0.5 * (road.lane_width_m - WIDTH_M) - sign * across_m)
    }
}

/// How an edge is seen.
struct SeenEdge {
    place: Correlated,
    heading: Correlated,
    /// Metres until the dash ends, and where the edge is taken to be until then.
    dash_m: f64,
    jump_m: f64,
    /// Seconds until it is seen again.
    hidden_s: f64,
    last: Option<EdgeOnRoad>,
}

/// A camera that looks a little aside, with edges that jump and vanish.
pub(crate) struct Camera {
    edges: [SeenEdge; 2],
    common: Correlated,
    aside_rad: f64,
    lane: f64,
}

impl Camera {
    pub(crate) fn new(random: &mut Random) -> Self {
        let third_of_a_degree = 0.3_f64.to_radians();
        let share = third_of_a_degree / 2_f64.sqrt();
        let edges = [(); 2].map(|()| {
            let sigma_m = random.between(0.03, 0.05);
            SeenEdge {
                place: Correlated::new(random, sigma_m, 0.2),
                heading: Correlated::new(random, share, 0.1),
                dash_m: 0.0,
                jump_m: 0.0,
                hidden_s: 0.0,
                last: None,
            }
        });
        let common = Correlated::new(random, share, 0.1);
        Self { edges, common, aside_rad: random.normal() * 0.2_f64.to_radians(), lane: 0.0 }
    }

    /// The lane in which the camera takes the vehicle to be, as it sees it.
    pub(crate) fn see(
        &mut self,
        random: &mut Random,
        road: &Road,
        place: &Place,
        speed_mps: f64,
        dt_s: f64,
    ) -> LaneOnRoad {
        let in_lane_m = place.left_m - self.lane * road.lane_width_m;
        if in_lane_m.abs() > 0.5 * road.lane_width_m + 0.1 {
            self.lane += in_lane_m.signum();
            self.edges.iter_mut().for_each(|edge| edge.last = None);
        }
        let in_lane_m = place.left_m - self.lane * road.lane_width_m;
        let common_rad = self.common.step(random, dt_s) + self.aside_rad;
        let mut seen = [None; 2];
        for ((edge, seen), sign) in self.edges.iter_mut().zip(&mut seen).zip([1.0, -1.0]) {
            let (place_m, heading_rad) = (edge.place.step(random, dt_s), edge.heading.step(random, dt_s));
            edge.dash_m -= speed_mps * dt_s;
            if edge.dash_m <= 0.0 {
                edge.dash_m = 12.0;
                edge.jump_m =
                    if random.happens(0.05) { random.sign() * random.between(0.10, 0.15) } else { 0.0 };
            }
            edge.hidden_s -= dt_s;
            if edge.hidden_s <= 0.0 && random.happens(0.1 * dt_s) {
                edge.hidden_s = random.between(0.2, 0.8);
            }
            let new = EdgeOnRoad {
                offset_m: sign * 0.5 * road.lane_width_m - in_lane_m + place_m + edge.jump_m,
                heading_rad: common_rad + heading_rad - place.heading_rad(speed_mps),
                curvature_per_m: road.curvature_per_m + 3e-4 * random.normal(),
                kept_frames: 0,
            };
            edge.last = if edge.hidden_s > 0.0 {
                edge.last.map(|last| EdgeOnRoad { kept_frames: last.kept_frames + 1, ..last })
            } else {
                Some(new)
            };
            // An edge that is kept too long is given up.
            *seen = edge.last.filter(|edge| edge.kept_frames <= 15);
        }
        LaneOnRoad { left: seen[0], right: seen[1] }
    }
}

/// A driver who keeps near the middle, wandering.
pub(crate) struct Driver {
    waves: [(f64, f64, f64); 3],
    lag_s: f64,
}

impl Driver {
    /// `wander_m` is the root mean square of the wander.
    pub(crate) fn new(random: &mut Random, wander_m: f64) -> Self {
        let waves = [1.0, 0.75, 0.6]
            .map(|share| (wander_m * share, TAU / random.between(6.0, 20.0), random.between(0.0, TAU)));
        Self { waves, lag_s: random.between(0.3, 0.8) }
    }

    /// Speed across that keeps the vehicle where the driver's wander has it, beside `middle_m`.
    pub(crate) fn keeping_mps(&self, t_s: f64, place: &Place, middle_m: f64) -> f64 {
        let wave = |&(high_m, rate, phase): &(f64, f64, f64)| {
            let angle = rate * t_s + phase;
            (high_m * libm::sin(angle), high_m * rate * libm::cos(angle))
        };
        let (wish_m, wish_mps) =
            self.waves.iter().map(wave).fold((middle_m, 0.0), |(m, mps), (dm, dmps)| (m + dm, mps + dmps));
        wish_mps + (0.7 * (wish_m - place.left_m)).clamp(-0.6, 0.6)
    }

    /// Moves the vehicle on towards a speed across.
    pub(crate) fn steer(&self, place: &mut Place, wish_mps: f64, dt_s: f64) {
        place.lateral_mps += (wish_mps - place.lateral_mps) * (1.0 - libm::exp(-dt_s / self.lag_s));
        place.left_m += place.lateral_mps * dt_s;
    }
}
