//! Which way the road goes on: along its curve, or round a corner to the left or to the right.
//!
//! Every way is a band as wide as the road: on along the curve of its edges, or straight to a corner at some distance, round
//! it and on. How probable a way is follows from how much road lies under its band and from how rare corners are; the
//! direction to steer in is that of the most probable kind of way, and its standard deviation counts all of them, so that it
//! is wide where the road forks. Where the road ends at another, both of whose arms are there, only the vehicle's own turn says
//! which of them is taken; before it turns the road ahead is ambiguous, and there is no direction to steer in.
//!
//! Limits: one corner, seen in a single frame's surface.

use std::f64::consts::FRAC_PI_2;

use super::Centreline;
use super::band::{Approach, Band, Keeping, LogOdds, Shown, Station, Way};
use super::turn::{Corner, RoadLine, middle_radius_m};

/// Corners that are tried: distances along the road from the rear axle, metres, and turns, radians (20 to 110 degrees: less is
/// a curve, more doubles back).
const FROM_M: f64 = -2.0;
const EVERY_M: f64 = 1.0;
const PLACES: usize = 19;
const LEAST_TURN_RAD: f64 = FRAC_PI_2 * 2.0 / 9.0;
const TURN_STEP_RAD: f64 = FRAC_PI_2 / 9.0;
const TURNS: usize = 10;
/// All ways: on, and each corner to the left and to the right.
const WAYS: usize = 1 + 2 * PLACES * TURNS;
/// How probable a corner is at the most that is out of sight: 1 in 20 is another.
const MOST_REMEMBERED: f64 = 0.95;
/// Corners on a metre of road: one every 100 m, as in the towns and on the farms that are driven.
const CORNERS_PER_M: f64 = 0.01;
/// Of the corners that could be either, the share that are the end of the road at another: a road that nobody knows.
const TEE_SHARE: f64 = 0.5;
/// Turns whose opposite arm is tried too, and the sum of the numbers of both: they make a straight road, 70 to 110 degrees each.
const TEE_TURNS: std::ops::Range<usize> = 5..TURNS;
const TEE_TURNS_SUM: usize = 14;
/// How far vehicles turn in their lane before a corner, standard deviation, radians (7 degrees): drivers swing out.
const SWING_RAD: f64 = 0.12;
/// The road ahead is ambiguous where either arm is taken with this probability: both are likely there, and the vehicle has not yet
/// turned to one of them. Simulated road ends reach it in 144 of 170 frames before the vehicle turns, bends of 50 to 90 degrees
/// in 7 of 230.
const AMBIGUOUS: f64 = 0.2;
/// Ways of less weight than this, of the most probable one's, are not followed: together they weigh less than 4 %.
const LEAST_WEIGHT: f64 = 1e-4;

/// A kind of way.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum WayKind {
    /// Round a corner to the left.
    Left,
    /// On along the road.
    #[default]
    On,
    /// Round a corner to the right.
    Right,
}

impl WayKind {
    /// All of them, in the order of [`Ways::probability`].
    pub const ALL: [Self; 3] = [Self::Left, Self::On, Self::Right];
}

/// Which ways the road goes on.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Ways {
    /// How probable it is that the vehicle goes on by each kind of way, 0 to 1, in the order of [`WayKind::ALL`].
    pub probability: [f64; 3],
    /// How probable it is that the road ends at another that leads to both sides, 0 to 1.
    pub tee_probability: f64,
    /// The most probable kind.
    pub kind: WayKind,
    /// Its corner.
    pub(crate) corner: Option<Corner>,
    /// Where it leads at the look-ahead, radians, positive to the left.
    pub(crate) bearing_rad: f64,
    /// Standard deviation of that over all ways, radians.
    pub(crate) sigma_rad: f64,
}

impl Ways {
    /// Whether the road ends at another and nothing says which of its arms is taken.
    pub fn is_ambiguous(&self) -> bool {
        let [left, _, right] = self.probability;
        left.min(right) >= AMBIGUOUS
    }
}

/// How probable ways are before this frame's surface is asked, as logarithms.
#[derive(Debug, Clone, Copy)]
struct Expected {
    /// Distance along the road and turn of the corner that is remembered, and how probable that is.
    remembered: Option<(f64, f64, f64)>,
    /// Share of the corners that are the end of the road at another, where they can be.
    tee_share: f64,
}

impl Expected {
    fn new(start: &RoadLine, remembered: Option<&Corner>) -> Self {
        let along_m = |corner: &Corner| (corner.approach.place - start.place).dot(&start.direction());
        let remembered_tee = remembered.map(|corner| corner.tee_probability.min(MOST_REMEMBERED));
        let remembered = remembered.map(|corner| {
            let turn_rad = fingerpost_geometry::wrap_angle(corner.exit_rad - start.heading_rad);
            (along_m(corner), turn_rad, corner.probability.min(MOST_REMEMBERED))
        });
        let tee_share = remembered_tee.unwrap_or(TEE_SHARE);
        Self { remembered, tee_share }
    }

    fn on(&self) -> f64 {
        self.remembered.map_or(0.0, |(_, _, probability)| libm::log(0.5 * (1.0 - probability)))
    }

    /// Of a corner that far along, by that turn.
    fn corner(&self, corner_m: f64, turn_rad: f64) -> f64 {
        let Some((at_m, by_rad, probability)) = self.remembered else {
            return libm::log(CORNERS_PER_M * EVERY_M / (2 * TURNS) as f64);
        };
        let (off, turned) = ((corner_m - at_m) / EVERY_M, (turn_rad - by_rad) / TURN_STEP_RAD);
        // A step is a standard deviation: the density over the steps sums to 1.
        let density = libm::exp(-0.5 * (off * off + turned * turned)) / std::f64::consts::TAU;
        libm::log(probability * density + 0.5 * (1.0 - probability) / (WAYS - 1) as f64)
    }
}

/// Tries all ways; its memory is reused from frame to frame.
#[derive(Debug)]
pub(super) struct WayFinder {
    tried: Vec<(Way, f64)>,
    /// What the roads behind the corners are worth, of each way that was tried.
    arms: Vec<f64>,
    /// Those that are followed to the look-ahead: their kind, weight and where they lead.
    followed: Vec<(WayKind, f64, f64)>,
    stations: Vec<Station>,
    log_odds: LogOdds,
}

impl Default for WayFinder {
    fn default() -> Self {
        Self {
            tried: Vec::with_capacity(WAYS),
            arms: Vec::with_capacity(WAYS),
            followed: Vec::with_capacity(WAYS),
            stations: Vec::new(),
            log_odds: LogOdds::default(),
        }
    }
}

impl WayFinder {
    /// Log-odds of pixels' levels.
    pub(super) const fn log_odds(&self) -> &LogOdds {
        &self.log_odds
    }

    /// The ways on from a road's middle; a corner that is out of sight is `remembered`.
    pub(super) fn find(
        &mut self,
        shown: &Shown<'_>,
        road: &Centreline,
        remembered: Option<&Corner>,
        keeping: &Keeping,
    ) -> Ways {
        let start = road.line();
        let radius_m = middle_radius_m(road.width_m);
        self.tried.clear();
        self.arms.clear();
        let on = Way::on(&start, road.curvature_per_m);
        let expected = Expected::new(&start, remembered);
        let band = Band { shown, width_m: road.width_m, log_odds: &self.log_odds };
        let approach = Approach::new(&start, &band);
        self.tried.push((on, on.evidence(&band, &approach).all + expected.on()));
        self.arms.push(0.0);
        for place in 0..PLACES {
            let corner_m = FROM_M + place as f64 * EVERY_M;
            for turn in 0..2 * TURNS {
                let size_rad = LEAST_TURN_RAD + (turn / 2) as f64 * TURN_STEP_RAD;
                let turn_rad = if turn % 2 == 0 { size_rad } else { -size_rad };
                let way = Way::round(&start, corner_m, turn_rad, radius_m);
                let evidence = way.evidence(&band, &approach);
                self.tried.push((way, evidence.all + expected.corner(corner_m, turn_rad)));
                self.arms.push(evidence.arm);
            }
        }
        let tees = self.weigh(&start, expected.tee_share);
        let mut ways = self.summed(road, keeping, tees);
        if let (Some(corner), Some(remembered)) = (&mut ways.corner, remembered) {
            corner.probability = remembered.probability;
            corner.tee_probability = remembered.tee_probability;
        }
        ways
    }

    /// Makes weights of the evidence and of how far the vehicle has turned, those of each end of the road at another shared among
    /// its arms; the weight of all those ends.
    fn weigh(&mut self, start: &RoadLine, tee_share: f64) -> f64 {
        let most = self.tried.iter().map(|(_, evidence)| *evidence).fold(f64::NEG_INFINITY, f64::max);
        self.tried.iter_mut().for_each(|(_, evidence)| *evidence = libm::exp(*evidence - most));
        let mut tees = 0.0;
        let turned = -start.heading_rad / SWING_RAD;
        // Nobody turns far to one side on the way to the other.
        let against = libm::exp(-0.5 * turned * turned);
        let [to_left, to_right] = if turned > 0.0 { [1.0, against] } else { [against, 1.0] };
        for place in 0..PLACES {
            let of = |turn: usize, side: usize| 1 + (place * TURNS + turn) * 2 + side;
            for turn in TEE_TURNS {
                let pair = [of(turn, 0), of(TEE_TURNS_SUM - turn, 1)];
                let [left, right] = pair.map(|way| self.tried[way].1);
                let [left_arm, right_arm] = pair.map(|way| libm::exp(self.arms[way]));
                let tee = tee_share * (left * right_arm + right * left_arm);
                for way in pair {
                    self.tried[way].1 = (1.0 - tee_share) * self.tried[way].1 + 0.5 * tee;
                }
                tees += tee * 0.5 * (to_left + to_right);
            }
        }
        for (way, weight) in &mut self.tried {
            *weight *= match way.kind() {
                WayKind::Left => to_left,
                WayKind::On => 1.0,
                WayKind::Right => to_right,
            };
        }
        tees
    }

    fn summed(&mut self, road: &Centreline, keeping: &Keeping, tees: f64) -> Ways {
        let all: f64 = self.tried.iter().map(|(_, weight)| weight).sum();
        let of = |kind: WayKind| self.tried.iter().filter(move |(way, _)| way.kind() == kind);
        let probability = WayKind::ALL.map(|kind| of(kind).map(|(_, weight)| weight).sum::<f64>() / all);
        let tee_probability = tees / all;
        let kind = WayKind::ALL
            .into_iter()
            .zip(probability)
            .max_by(|a, b| a.1.total_cmp(&b.1))
            .map_or(WayKind::On, |(kind, _)| kind);
        let least = LEAST_WEIGHT * self.tried.iter().map(|(_, weight)| *weight).fold(0.0, f64::max);
        self.followed.clear();
        let (mut corner_m, mut turn_rad) = (0.0, 0.0);
        for (way, weight) in self.tried.iter().filter(|(_, weight)| *weight > least) {
            self.followed.push((way.kind(), *weight, way.bearing_rad(keeping, &mut self.stations)));
            if let Some(turn) = way.turn().filter(|_| way.kind() == kind) {
                (corner_m, turn_rad) = (corner_m + weight * turn.corner_m, turn_rad + weight * turn.turn_rad);
            }
        }
        let of_kind = || self.followed.iter().filter(|(of, ..)| *of == kind);
        let sum: f64 = of_kind().map(|(_, weight, _)| weight).sum();
        let bearing_rad = of_kind().map(|(_, weight, bearing_rad)| weight * bearing_rad).sum::<f64>() / sum;
        let off = |(_, weight, other_rad): &(WayKind, f64, f64)| weight * (other_rad - bearing_rad).powi(2);
        let variance = self.followed.iter().map(off).sum::<f64>() / all;
        let (corner_m, turn_rad) = (corner_m / sum, turn_rad / sum);
        let start = road.line();
        let corner = (kind != WayKind::On).then(|| Corner {
            approach: RoadLine { place: start.place + start.direction() * corner_m, ..start },
            exit_rad: road.heading_rad + turn_rad,
            sigma_m: EVERY_M,
            sigma_rad: TURN_STEP_RAD,
            probability: probability.into_iter().fold(0.0, f64::max),
            tee_probability,
        });
        let beside_rad = road.sigma_m / keeping.look_ahead_m;
        let sigma_rad = (variance + beside_rad * beside_rad).sqrt();
        Ways { probability, tee_probability, kind, corner, bearing_rad, sigma_rad }
    }
}
