//! Which way the road goes on: along its curve, or round a corner to the left or to the right.
//!
//! Every way is a band as wide as the road: on along the curve of its edges, or straight to a corner at some distance, round
//! it and on. How probable a way is follows from how much road lies under its band and from how rare corners are; the
//! direction to steer in is that of the most probable kind of way, and its standard deviation counts all of them, so that it
//! is wide where the road forks.
//!
//! Limits: one corner, told from a single frame's surface; where two ways lie on road alike, nothing here knows better.

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
    /// How probable each kind of way is, 0 to 1, in the order of [`WayKind::ALL`].
    pub probability: [f64; 3],
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
    /// The kinds of way that cannot be left out: those that are not less probable than 1 in 20, the usual level of significance.
    pub fn open(&self) -> impl Iterator<Item = WayKind> + '_ {
        let of = WayKind::ALL.into_iter().zip(self.probability);
        of.filter(|(_, probability)| *probability >= 0.05).map(|(kind, _)| kind)
    }
}

/// How probable ways are before this frame's surface is asked, as logarithms.
#[derive(Debug, Clone, Copy)]
struct Expected {
    /// Distance along the road and turn of the corner that is remembered, and how probable that is.
    remembered: Option<(f64, f64, f64)>,
}

impl Expected {
    fn new(start: &RoadLine, remembered: Option<&Corner>) -> Self {
        let along_m = |corner: &Corner| (corner.approach.place - start.place).dot(&start.direction());
        let remembered = remembered.map(|corner| {
            let turn_rad = fingerpost_geometry::wrap_angle(corner.exit_rad - start.heading_rad);
            (along_m(corner), turn_rad, corner.probability.min(MOST_REMEMBERED))
        });
        Self { remembered }
    }

    fn on(&self) -> f64 {
        self.remembered.map_or(0.0, |(_, _, probability)| (0.5 * (1.0 - probability)).ln())
    }

    /// Of a corner that far along, by that turn.
    fn corner(&self, corner_m: f64, turn_rad: f64) -> f64 {
        let Some((at_m, by_rad, probability)) = self.remembered else {
            return (CORNERS_PER_M * EVERY_M / (2 * TURNS) as f64).ln();
        };
        let (off, turned) = ((corner_m - at_m) / EVERY_M, (turn_rad - by_rad) / TURN_STEP_RAD);
        // A step is a standard deviation: the density over the steps sums to 1.
        let density = (-0.5 * (off * off + turned * turned)).exp() / std::f64::consts::TAU;
        (probability * density + 0.5 * (1.0 - probability) / (WAYS - 1) as f64).ln()
    }
}

/// Tries all ways; its memory is reused from frame to frame.
#[derive(Debug)]
pub(super) struct WayFinder {
    tried: Vec<(Way, f64)>,
    /// Those that are followed to the look-ahead: their kind, weight and where they lead.
    followed: Vec<(WayKind, f64, f64)>,
    stations: Vec<Station>,
    log_odds: LogOdds,
}

impl Default for WayFinder {
    fn default() -> Self {
        Self {
            tried: Vec::with_capacity(WAYS),
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
        let on = Way::on(&start, road.curvature_per_m);
        let expected = Expected::new(&start, remembered);
        let band = Band { shown, width_m: road.width_m, log_odds: &self.log_odds };
        let approach = Approach::new(&start, &band);
        self.tried.push((on, on.evidence(&band, &approach) + expected.on()));
        for place in 0..PLACES {
            let corner_m = FROM_M + place as f64 * EVERY_M;
            for turn in 0..2 * TURNS {
                let size_rad = LEAST_TURN_RAD + (turn / 2) as f64 * TURN_STEP_RAD;
                let turn_rad = if turn % 2 == 0 { size_rad } else { -size_rad };
                let way = Way::round(&start, corner_m, turn_rad, radius_m);
                let evidence = way.evidence(&band, &approach) + expected.corner(corner_m, turn_rad);
                self.tried.push((way, evidence));
            }
        }
        let mut ways = self.summed(road, keeping);
        if let (Some(corner), Some(remembered)) = (&mut ways.corner, remembered) {
            corner.probability = remembered.probability;
        }
        ways
    }

    fn summed(&mut self, road: &Centreline, keeping: &Keeping) -> Ways {
        let most = self.tried.iter().map(|(_, evidence)| *evidence).fold(f64::NEG_INFINITY, f64::max);
        self.tried.iter_mut().for_each(|(_, evidence)| *evidence = (*evidence - most).exp());
        let all: f64 = self.tried.iter().map(|(_, weight)| weight).sum();
        let of = |kind: WayKind| self.tried.iter().filter(move |(way, _)| way.kind() == kind);
        let probability = WayKind::ALL.map(|kind| of(kind).map(|(_, weight)| weight).sum::<f64>() / all);
        let kind = WayKind::ALL
            .into_iter()
            .zip(probability)
            .max_by(|a, b| a.1.total_cmp(&b.1))
            .map_or(WayKind::On, |(kind, _)| kind);
        self.followed.clear();
        let (mut corner_m, mut turn_rad) = (0.0, 0.0);
        for (way, weight) in self.tried.iter().filter(|(_, weight)| *weight > LEAST_WEIGHT) {
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
        });
        let beside_rad = road.sigma_m / keeping.look_ahead_m;
        let sigma_rad = (variance + beside_rad * beside_rad).sqrt();
        Ways { probability, kind, corner, bearing_rad, sigma_rad }
    }
}
