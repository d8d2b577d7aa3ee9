//! A way of the road as a band: how much road lies under it, and where it leads.

use std::ops::Range;

use fingerpost_geometry::GroundGrid;
use fingerpost_vision::picture::PlaneView;
use nalgebra::{Point2, Vector2};

use super::turn::RoadLine;
use super::way::WayKind;

/// Stations of a band: distance between them and their number, metres; as long as the default ground view.
const STATION_M: f64 = 1.0;
const STATIONS: usize = 20;
/// Distance between the places at which a way is followed to the look-ahead, metres: 2 degrees there.
const STEP_M: f64 = 0.25;
/// Places across a band, shares of the road's width from its middle: on it, and beside it, where there ought to be none. An edge
/// blurs over some decimetres, a twentieth of a road.
const ACROSS: [f64; 5] = [-0.45, -0.25, 0.0, 0.25, 0.45];
const BESIDE: [f64; 4] = [-0.7, -0.55, 0.55, 0.7];
/// How much road beside a road speaks against it, as log-odds: other roads, yards and parking places lie there too, 1 in 4.
const MOST_BESIDE: f64 = 1.0;
/// Area of road that errs together, square metres: shadows, patches and what stands beside a road are some 3 m long.
const ERRS_TOGETHER_M2: f64 = 10.0;
/// How far the probability of road is believed, as log-odds: nobody is surer than 1 in 20 of a patch.
const MOST_LOG_ODDS: f64 = 3.0;
/// Behind the rear axle a way is followed so far to find the vehicle beside it, metres.
const BEHIND_M: f64 = 8.0;
/// A way is followed so far, as a share of the look-ahead: round the sharpest corner a chord is half as long.
const FARTHEST_SHARE: f64 = 2.0;

/// How the vehicle keeps to a way.
#[derive(Debug, Clone, Copy)]
pub(super) struct Keeping {
    /// How far ahead the direction aims, metres.
    pub(super) look_ahead_m: f64,
    /// How far left of the road's middle the vehicle's lane is, metres.
    pub(super) lane_left_m: f64,
    /// Share of the distance to the lane's middle that is made good up to the look-ahead.
    pub(super) share: f64,
}

/// The probability of road in the ground view.
#[derive(Debug, Clone, Copy)]
pub(super) struct Shown<'a> {
    pub(super) probability: PlaneView<'a, u8>,
    pub(super) known: PlaneView<'a, u8>,
    pub(super) grid: &'a GroundGrid,
}

/// A place on a way and the unit vector along it.
pub(super) type Station = (Point2<f64>, Vector2<f64>);

/// A way: a curve, or two lines joined by an arc.
#[derive(Debug, Clone, Copy)]
pub(super) struct Way {
    /// Its tangent beside the rear axle.
    start: Station,
    curvature_per_m: f64,
    turn: Option<Turn>,
}

/// A corner of a way.
#[derive(Debug, Clone, Copy)]
pub(super) struct Turn {
    /// Distance along the first line, metres.
    pub(super) corner_m: f64,
    /// By how much the way turns, radians, positive to the left.
    pub(super) turn_rad: f64,
    radius_m: f64,
    /// Where the arc begins and ends along the way, metres.
    arc_m: [f64; 2],
    /// The place where it ends.
    exit: Station,
}

/// How much more probable a way is than no road at all, as logarithms.
#[derive(Debug, Clone, Copy)]
pub(super) struct WayEvidence {
    /// All of it.
    pub(super) all: f64,
    /// Of it the road behind its corner; 0 of a curve.
    pub(super) arm: f64,
}

/// Of a place on a line, the one that is so far along it and to its left.
fn ahead((place, direction): Station, x: f64, y: f64) -> Point2<f64> {
    place + direction * x + left(direction) * y
}

fn left(direction: Vector2<f64>) -> Vector2<f64> {
    Vector2::new(-direction.y, direction.x)
}

/// A direction turned to the left.
fn turned(direction: Vector2<f64>, by_rad: f64) -> Vector2<f64> {
    let (sin, cos) = libm::sincos(by_rad);
    direction * cos + left(direction) * sin
}

impl Way {
    /// On along a curve.
    pub(super) fn on(start: &RoadLine, curvature_per_m: f64) -> Self {
        Self { start: (start.place, start.direction()), curvature_per_m, turn: None }
    }

    /// Straight to a corner, round it and straight on.
    pub(super) fn round(start: &RoadLine, corner_m: f64, turn_rad: f64, radius_m: f64) -> Self {
        let (size_rad, sign) = (turn_rad.abs(), turn_rad.signum());
        let begin_m = corner_m - radius_m * libm::tan(0.5 * size_rad);
        let start = (start.place, start.direction());
        let place = ahead(
            start,
            begin_m + radius_m * libm::sin(size_rad),
            sign * radius_m * (1.0 - libm::cos(size_rad)),
        );
        let turn = Turn {
            corner_m,
            turn_rad,
            radius_m,
            arc_m: [begin_m, begin_m + radius_m * size_rad],
            exit: (place, turned(start.1, turn_rad)),
        };
        Self { start, curvature_per_m: 0.0, turn: Some(turn) }
    }

    /// Its corner; none of a curve.
    pub(super) fn turn(&self) -> Option<&Turn> {
        self.turn.as_ref()
    }

    /// On, or round a corner.
    pub(super) fn kind(&self) -> WayKind {
        match &self.turn {
            None => WayKind::On,
            Some(turn) if turn.turn_rad > 0.0 => WayKind::Left,
            Some(_) => WayKind::Right,
        }
    }

    /// The station at a distance along it from beside the rear axle, metres.
    fn at(&self, along_m: f64) -> Station {
        let (_, direction) = self.start;
        let Some(turn) = &self.turn else {
            let turned_rad = self.curvature_per_m * along_m;
            return (ahead(self.start, along_m, 0.5 * turned_rad * along_m), turned(direction, turned_rad));
        };
        let [begin_m, end_m] = turn.arc_m;
        if along_m <= begin_m {
            (ahead(self.start, along_m, 0.0), direction)
        } else if along_m >= end_m {
            (ahead(turn.exit, along_m - end_m, 0.0), turn.exit.1)
        } else {
            let (arc_rad, sign) = ((along_m - begin_m) / turn.radius_m, turn.turn_rad.signum());
            let (sin, cos) = libm::sincos(arc_rad);
            let place = ahead(self.start, begin_m + turn.radius_m * sin, sign * turn.radius_m * (1.0 - cos));
            (place, direction * cos + left(direction) * (sign * sin))
        }
    }

    /// How much more probable it is than no road at all, as a logarithm; `approach` is what the line that it begins with is worth.
    pub(super) fn evidence(&self, shown: &Band<'_>, approach: &Approach) -> WayEvidence {
        // Up to its corner a way is its first line, which all corners share.
        let [shared_m, arm_m] = self.turn.as_ref().map_or([-STATION_M, f64::INFINITY], |turn| turn.arc_m);
        let [shared, arm] = [shared_m / STATION_M + 1.0, (arm_m / STATION_M).ceil()]
            .map(|station| station.clamp(0.0, STATIONS as f64) as usize);
        let sum = |stations: Range<usize>| {
            stations.map(|i| shown.station(self.at(i as f64 * STATION_M))).sum::<f64>()
        };
        let arm = arm.max(shared);
        let behind = sum(arm..STATIONS);
        let all = approach.0[shared] + sum(shared..arm) + behind;
        WayEvidence { all: shown.evidence(all), arm: shown.evidence(behind) }
    }

    /// Direction from the rear axle to the place on it at the look-ahead, where the vehicle comes nearer to its lane; `stations` is
    /// memory.
    pub(super) fn bearing_rad(&self, keeping: &Keeping, stations: &mut Vec<Station>) -> f64 {
        let steps = ((BEHIND_M + FARTHEST_SHARE * keeping.look_ahead_m) / STEP_M) as usize;
        stations.clear();
        stations.extend((0..=steps).map(|i| self.at(i as f64 * STEP_M - BEHIND_M)));
        let beside = stations
            .iter()
            .enumerate()
            .min_by(|a, b| a.1.0.coords.norm_squared().total_cmp(&b.1.0.coords.norm_squared()));
        let Some((first, (nearest, direction))) = beside else { return 0.0 };
        // The vehicle's place left of the way, and where it ought to be.
        let left_m = -nearest.coords.dot(&left(*direction));
        let aim_m = left_m + keeping.share * (keeping.lane_left_m - left_m);
        let mut aims = stations[first..].iter().map(|(place, direction)| place + left(*direction) * aim_m);
        let reached = |place: &Point2<f64>| place.coords.norm() >= keeping.look_ahead_m;
        aims.clone()
            .find(reached)
            .or_else(|| aims.next_back())
            .map_or(0.0, |place| libm::atan2(place.y, place.x))
    }
}

/// What the stations of the line that ways begin with are worth: the sum of the first of them, for each number of them.
#[derive(Debug, Clone, Copy)]
pub(super) struct Approach([f64; STATIONS + 1]);

impl Approach {
    /// Of the ways that begin with this line.
    pub(super) fn new(start: &RoadLine, shown: &Band<'_>) -> Self {
        let line = Way::on(start, 0.0);
        let mut sums = [0.0; STATIONS + 1];
        for i in 0..STATIONS {
            sums[i + 1] = sums[i] + shown.station(line.at(i as f64 * STATION_M));
        }
        Self(sums)
    }

    /// How much more probable the line alone is than no road at all, as a logarithm.
    pub(super) fn evidence(&self, shown: &Band<'_>) -> f64 {
        shown.evidence(self.0[STATIONS])
    }
}

/// The surface under bands of one width, metres.
#[derive(Debug, Clone, Copy)]
pub(super) struct Band<'a> {
    pub(super) shown: &'a Shown<'a>,
    pub(super) width_m: f64,
    pub(super) log_odds: &'a LogOdds,
}

impl Band<'_> {
    /// What all stations together say, of which neighbours err alike.
    fn evidence(&self, stations: f64) -> f64 {
        let cell_m2 = STATION_M * self.width_m / ACROSS.len() as f64;
        stations * cell_m2 / ERRS_TOGETHER_M2
    }

    /// Log-odds of road across a band at a station, a place with a direction, less those of what is beside it.
    fn station(&self, (place, direction): Station) -> f64 {
        let grid = self.shown.grid;
        let per_m = 1.0 / grid.metres_per_pixel();
        // Pixels from the view's upper left corner, and how many of them the road's width is to the left.
        let corner = [(grid.half_width_m() - place.y) * per_m, (grid.far_m() - place.x) * per_m];
        let width_px = self.width_m * per_m;
        let left = [-direction.x * width_px, direction.y * width_px];
        let at = |across: &f64| {
            let [column, row] = [0, 1].map(|axis: usize| corner[axis] + across * left[axis]);
            self.shown.log_odds(column, row, self.log_odds)
        };
        let beside = |across: &f64| at(across).clamp(-MOST_BESIDE, MOST_BESIDE);
        ACROSS.iter().map(at).sum::<f64>() - BESIDE.iter().map(beside).sum::<f64>()
    }
}

impl Shown<'_> {
    /// Log-odds of road at a place, columns and rows from the view's upper left corner; none where it is not known.
    fn log_odds(&self, column: f64, row: f64, log_odds: &LogOdds) -> f64 {
        if !(column >= 0.0 && row >= 0.0) {
            return 0.0;
        }
        // What is behind the point is left away: pixels have whole corners.
        let (column, row) = (column as u32 as usize, row as u32 as usize);
        let (columns, rows) = self.known.size();
        if column >= columns || row >= rows || self.known.row(row)[column] == 0 {
            return 0.0;
        }
        log_odds.0[usize::from(self.probability.row(row)[column])]
    }
}

/// Log-odds of road of a pixel's level.
#[derive(Debug, Clone)]
pub(super) struct LogOdds([f64; 256]);

impl Default for LogOdds {
    fn default() -> Self {
        let of_level = |level: usize| {
            let p = (level as f64 + 0.5) / 256.0;
            libm::log(p / (1.0 - p)).clamp(-MOST_LOG_ODDS, MOST_LOG_ODDS)
        };
        Self(std::array::from_fn(of_level))
    }
}
