//! Made-up drives on the roads of a map, with sensors and maps that are wrong.

pub(crate) mod score;

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use fingerpost_geometry::Polyline;
use fingerpost_locate::{Fix, Locator, MotionSample, Traffic};
use fingerpost_map::{Direction, OsmData, RoadGraph, TangentPlane, Travel};
use nalgebra::{Point2, Vector2};

pub(crate) use self::score::{Score, score};

/// A true pose.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Pose {
    pub(crate) place_m: Point2<f64>,
    pub(crate) heading_rad: f64,
    pub(crate) driven_m: f64,
}

/// What is wrong with the sensors.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Faults {
    /// The measured speed is greater than the true one by this part.
    pub(crate) scale: f64,
    /// The measured yaw rate is greater than the true one by this, rad/s.
    pub(crate) bias_rps: f64,
}

/// Numbers of a seed (SplitMix64).
pub(crate) struct Numbers(pub(crate) u64);

impl Numbers {
    pub(crate) fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }

    pub(crate) fn normal(&mut self, sigma: f64) -> f64 {
        (-2.0 * libm::log(1.0 - self.unit())).sqrt() * libm::cos(TAU * self.unit()) * sigma
    }
}

/// Errors of speed and yaw rate as sensors of cars have them: 1 % and 0.05 degrees a second.
pub(crate) fn typical_faults(numbers: &mut Numbers) -> Faults {
    Faults { scale: numbers.normal(0.01), bias_rps: numbers.normal(0.05_f64.to_radians()) }
}

/// Time between rows, seconds.
const ROW_S: f64 = 0.1;
/// Fastest, m/s, and sideways acceleration in bends, m/s².
const FASTEST_MPS: f64 = 13.0;
const SIDEWAYS_MPS2: f64 = 2.0;
/// The driver's place in the lane: standard deviation, metres, and the distance over which it changes.
const WANDER_M: f64 = 1.5;
const WANDER_OVER_M: f64 = 60.0;
/// Radius of corners, metres.
const CORNER_M: f64 = 8.0;

/// The map as somebody drew it: every way traced with a shift of its own (imagery that lies wrong), every node a little beside that.
/// Both are standard deviations east and north, metres.
pub(crate) fn drawn(osm: &OsmData, shift_m: f64, beside_m: f64, numbers: &mut Numbers) -> OsmData {
    let mut drawn = osm.clone();
    let mut shifts: BTreeMap<i64, (Vector2<f64>, f64)> = BTreeMap::new();
    for way in &drawn.ways {
        let shift = Vector2::new(numbers.normal(shift_m), numbers.normal(shift_m));
        for node in &way.nodes {
            let (sum, count) = shifts.entry(*node).or_insert((Vector2::zeros(), 0.0));
            *sum += shift;
            *count += 1.0;
        }
    }
    for node in &mut drawn.nodes {
        // A junction's node lies between what its ways say.
        let shift = shifts.get(&node.id).map_or(Vector2::zeros(), |(sum, count)| sum / *count);
        let off = shift + Vector2::new(numbers.normal(beside_m), numbers.normal(beside_m));
        let metres_per_deg = 111_320.0;
        node.at.lat_deg += off.y / metres_per_deg;
        node.at.lon_deg += off.x / (metres_per_deg * libm::cos(node.at.lat_deg.to_radians()));
    }
    drawn
}

/// A line through roads, and from where on the vehicle's lane is how far left of it, metres.
#[derive(Debug, Clone)]
pub(crate) struct Road {
    pub(crate) line: Polyline,
    pub(crate) lanes: Vec<(f64, f64)>,
}

impl Road {
    fn lane_m(&self, along_m: f64) -> f64 {
        let index = self.lanes.partition_point(|(from_m, _)| *from_m <= along_m);
        index.checked_sub(1).map_or(0.0, |index| self.lanes[index].1)
    }
}

/// A drive at random for `length_m` on the true roads: no U-turns, no one-way street the wrong way, and no dead end where there is
/// another way. `None` where it ends early.
pub(crate) fn line(graph: &RoadGraph, length_m: f64, numbers: &mut Numbers) -> Option<Road> {
    let mut segment = (numbers.unit() * graph.segments().len() as f64) as usize;
    let mut direction = if numbers.unit() < 0.5 { Direction::Forward } else { Direction::Backward };
    if !graph.permits(segment, direction) {
        return None;
    }
    let other = if direction == Direction::Forward { Direction::Backward } else { Direction::Forward };
    let mut points = vec![graph.nodes()[graph.head(segment, other)].p_in_map];
    let mut total_m = 0.0;
    let mut lanes = Vec::new();
    while total_m < length_m {
        let head = graph.head(segment, direction);
        points.push(graph.nodes()[head].p_in_map);
        let attributes = graph.attributes_of(segment);
        // Two lanes are kept to; narrower roads are driven in the middle.
        let has_lanes = attributes.travel == Travel::Both && attributes.width_m >= 6.0;
        lanes.push((total_m, if has_lanes { -0.25 * attributes.width_m } else { 0.0 }));
        total_m += graph.segments()[segment].length_m;
        let onward: Vec<usize> = graph.nodes()[head]
            .segments
            .iter()
            .copied()
            .filter(|&next| next != segment && graph.permits(next, graph.away_from(next, head)))
            .filter(|&next| {
                let end = graph.head(next, graph.away_from(next, head));
                graph.nodes()[end].segments.len() > 1
            })
            .collect();
        let next = *onward.get((numbers.unit() * onward.len() as f64) as usize)?;
        (segment, direction) = (next, graph.away_from(next, head));
    }
    Some(Road { line: Polyline::new(points).ok()?, lanes })
}

/// Rows of a drive along a line, with the true pose of each.
pub(crate) fn drive(road: &Road, faults: Faults, numbers: &mut Numbers) -> Vec<(MotionSample, Pose)> {
    let line = &road.line;
    // The centre of a short window rounds corners, about as an arc of the radius does.
    let round = |along_m: f64| {
        let window = (-8..=8)
            .map(|i| line.at((along_m + CORNER_M * f64::from(i) / 8.0).clamp(0.0, line.length_m())).0.coords);
        window.sum::<Vector2<f64>>() / 17.0
    };
    let mut offset_m = road.lane_m(0.0) + numbers.normal(WANDER_M);
    let mut slope = 0.0;
    let mut rows = Vec::new();
    let (mut along_m, mut t_s) = (CORNER_M, 0.0);
    let mut speed_mps = 5.0;
    let mut before: Option<Pose> = None;
    while along_m < line.length_m() - CORNER_M - 20.0 {
        let ahead = (round(along_m + 0.5) - round(along_m - 0.5)).normalize();
        let place_m = Point2::from(round(along_m) + Vector2::new(-ahead.y, ahead.x) * offset_m);
        let look = |at_m: f64| {
            let chord = round(at_m + 3.0) - round(at_m - 3.0);
            libm::atan2(chord.y, chord.x)
        };
        let bend = (0..4)
            .map(|i| along_m + 5.0 * f64::from(i))
            .map(|at_m| wrap(look(at_m + 3.0) - look(at_m - 3.0)).abs() / 6.0);
        let bend = bend.fold(1e-3, f64::max);
        let wanted_mps = (SIDEWAYS_MPS2 / bend).sqrt().clamp(2.5, FASTEST_MPS);
        speed_mps += (wanted_mps - speed_mps).clamp(-3.0 * ROW_S, 1.5 * ROW_S);
        let heading_rad = libm::atan2(ahead.y, ahead.x) + slope;
        let (moved_m, turned_rad) = before.map_or((0.0, 0.0), |before: Pose| {
            ((place_m - before.place_m).norm(), wrap(heading_rad - before.heading_rad))
        });
        let pose =
            Pose { place_m, heading_rad, driven_m: before.map_or(0.0, |before| before.driven_m) + moved_m };
        if before.is_some() {
            let speed_mps = moved_m / ROW_S * (1.0 + faults.scale) + numbers.normal(0.1);
            let yaw_rate_rps = turned_rad / ROW_S + faults.bias_rps + numbers.normal(1.7e-3);
            rows.push((MotionSample { t_s, speed_mps, yaw_rate_rps }, pose));
        }
        before = Some(pose);
        // The driver's offset is smooth: its slope is drawn to bring it back and shaken.
        let step_m = speed_mps * ROW_S;
        let stiffness = 1.0 / WANDER_OVER_M;
        slope += step_m
            * (-2.0 * stiffness * slope - stiffness * stiffness * (offset_m - road.lane_m(along_m)))
            + numbers.normal(2.0 * WANDER_M * (stiffness.powi(3) * step_m).sqrt());
        offset_m += slope * step_m;
        along_m += step_m;
        t_s += ROW_S;
    }
    rows
}

/// An angle in (-π, π].
pub(crate) fn wrap(angle_rad: f64) -> f64 {
    fingerpost_geometry::wrap_angle(angle_rad)
}

/// A vehicle that is located on a map that was drawn with errors: ways shifted by 1.2 m, nodes by 0.5 m (standard deviations east
/// and north).
pub(crate) struct Drive {
    pub(crate) locator: Locator,
    roads: TangentPlane,
    map: TangentPlane,
}

impl Drive {
    pub(crate) fn of(osm: &OsmData, numbers: &mut Numbers) -> Self {
        Self::with_map(osm, osm, numbers)
    }

    /// The same where the map was drawn from something else than the true roads.
    pub(crate) fn with_map(roads: &OsmData, map: &OsmData, numbers: &mut Numbers) -> Self {
        let map = RoadGraph::from_osm(&drawn(map, 1.2, 0.5, numbers)).unwrap();
        let roads = *RoadGraph::from_osm(roads).unwrap().plane();
        Self { locator: Locator::new(&map, Traffic::Right, 1), roads, map: *map.plane() }
    }

    /// A fix a row, and beside each the true place, in the plane of the map's graph. (Hairpins of the map are driven faster round than
    /// any car turns: such rows are refused, and the fix before holds.)
    pub(crate) fn fixes(mut self, rows: &[(MotionSample, Pose)]) -> Vec<(Fix, Point2<f64>)> {
        let mut fixes: Vec<(Fix, Point2<f64>)> = Vec::with_capacity(rows.len());
        for (row, pose) in rows {
            let fix = match self.locator.step(*row) {
                Ok(fix) => fix.unwrap(),
                Err(_) => fixes.last().unwrap().0.clone(),
            };
            fixes.push((fix, self.in_map(pose)));
        }
        fixes
    }

    /// A true place in the plane of the map's graph, metres.
    pub(crate) fn in_map(&self, pose: &Pose) -> Point2<f64> {
        self.map.map_from_wgs84(self.roads.wgs84_from_map(pose.place_m))
    }
}

/// The fixes of a drive, and beside each the true place, in the plane of the map's graph.
pub(crate) fn fixes(
    osm: &OsmData,
    rows: &[(MotionSample, Pose)],
    numbers: &mut Numbers,
) -> Vec<(Fix, Point2<f64>)> {
    Drive::of(osm, numbers).fixes(rows)
}

/// How well a drive is located.
pub(crate) fn locate(osm: &OsmData, rows: &[(MotionSample, Pose)], numbers: &mut Numbers) -> Score {
    score(&fixes(osm, rows, numbers), rows)
}
