//! What has been seen of the ground about the vehicle: a map of log-odds of road, fixed in the odometry frame.
//!
//! A feature stands still on the ground while the vehicle moves towards it, so the evidence for it is kept there and not in
//! the belief: each cell holds the mean of what was seen of it, the nearest looks counting most, and a hundred looks from the
//! same place say no more than one. A standing vehicle thus never grows surer (Thrun, Burgard, Fox: Probabilistic Robotics,
//! 2005, section 9, on what happens otherwise).
//!
//! Limits: the map drifts with ego-motion, by centimetres over the metres that a feature is in view.

use fingerpost_geometry::{GroundGrid, GroundPixel};
use fingerpost_vision::picture::{Plane, ValidityMask};
use nalgebra::{Isometry2, Matrix3, Point2};

/// Side of a cell, metres: the time of a fit grows with its inverse square, and an edge is soft over about as much.
pub(super) const CELL_M: f64 = 0.25;
/// Cells of a square of two by two that are seen, and their share of it: the others lie between four of them, and err with them.
const SEEN_OF_SQUARE: [[i64; 2]; 2] = [[0, 0], [1, 1]];
/// Ground that a cell speaks for, square metres.
pub(super) const SPEAKS_FOR_M2: f64 = 2.0 * CELL_M * CELL_M;
/// Cells along a side of the map: 32 m.
const SIDE: i64 = 128;
/// The middle of the map lies so far ahead of the vehicle, metres: what is behind was seen and is kept for a while.
const MIDDLE_AHEAD_M: f64 = 6.0;
/// Distance from the camera at which a look counts half as much as a near one, metres.
const HALF_TRUST_M: f64 = 12.0;
/// Distance driven over which earlier looks at a place come to count a third of what they did, metres.
const KEPT_LOOKS_M: f64 = 3.0;
/// Distance driven over which what is not seen any more comes to count a third, metres: ego-motion's drift.
const FADING_M: f64 = 30.0;
/// Trust below which a place says nothing.
const LEAST_TRUST: f64 = 0.02;
/// Greatest log-odds that a place can have, either way: no look is surer than 20 to 1, though the same measurement reached -5
/// where the detector is sure of no road.
const MOST_LOG_ODDS: f64 = 3.0;

/// What a frame shows of the road surface, where `seen` says that it shows any.
#[derive(Debug, Clone, Copy)]
pub(super) struct Looks<'a> {
    pub(super) probability: &'a Plane<u8>,
    /// As of [`RoadSurface::uninformed_log_odds`](crate::road_surface::RoadSurface).
    pub(super) uninformed_log_odds: f64,
    pub(super) seen: &'a ValidityMask,
}

/// What is known of a cell.
#[derive(Debug, Clone, Copy, Default)]
struct Cell {
    log_odds: f32,
    /// Trust of all looks that count.
    looks: f32,
    /// Trust of the best of them.
    trust: f32,
}

/// A place of the ground with what was seen of it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct GroundCell {
    /// Vehicle frame, metres.
    pub(super) place: Point2<f64>,
    /// Log-odds of road.
    pub(super) log_odds: f64,
    /// How well it was seen, 0 to 1.
    pub(super) trust: f64,
    /// Distance ahead of the camera from which it was seen best, metres.
    pub(super) seen_ahead_m: f64,
}

/// The map about the vehicle.
#[derive(Debug)]
pub(super) struct GroundMemory {
    cells: Vec<Cell>,
    map_from_vehicle: Isometry2<f64>,
    /// First column and row of the map that are in reach.
    corner: [i64; 2],
    camera_foot: Point2<f64>,
    listed: Vec<GroundCell>,
    /// Where in `listed` each square of two by two cells begins, those of which nothing is known left out.
    squares: Vec<usize>,
}

impl GroundMemory {
    /// An empty map for a camera above this place.
    pub(super) fn new(camera_foot: Point2<f64>) -> Self {
        let mut memory = Self {
            cells: vec![Cell::default(); (SIDE * SIDE) as usize],
            map_from_vehicle: Isometry2::identity(),
            corner: [0, 0],
            camera_foot,
            listed: Vec::new(),
            squares: Vec::new(),
        };
        memory.corner = memory.corner_now();
        memory
    }

    /// Forgets everything.
    pub(super) fn clear(&mut self) {
        self.cells.fill(Cell::default());
        self.listed.clear();
        self.squares.clear();
    }

    /// What is known, as the last frame left it: the known cells of every square of two by two.
    pub(super) fn squares(&self) -> impl Iterator<Item = &[GroundCell]> {
        let ends = self.squares.iter().skip(1).copied().chain([self.listed.len()]);
        self.squares.iter().zip(ends).filter_map(|(&start, end)| self.listed.get(start..end))
    }

    /// Moves the vehicle on.
    pub(super) fn carry(&mut self, previous_from_current: &Isometry2<f64>) {
        self.map_from_vehicle *= previous_from_current;
        self.map_from_vehicle.rotation.renormalize();
        let moved_m = previous_from_current.translation.vector.norm();
        let [looks, trust] = [KEPT_LOOKS_M, FADING_M].map(|over_m| libm::exp(-moved_m / over_m) as f32);
        for cell in &mut self.cells {
            cell.looks *= looks;
            cell.trust *= trust;
        }
        let before = self.corner;
        self.corner = self.corner_now();
        for axis in [0, 1] {
            let (was, is) = (before[axis], self.corner[axis]);
            let entered = if is >= was { was + SIDE..is + SIDE } else { is..was };
            for line in entered.take(SIDE as usize) {
                for across in 0..SIDE {
                    let place = if axis == 0 { [line, across] } else { [across, line] };
                    self.cells[index(place)] = Cell::default();
                }
            }
        }
    }

    fn corner_now(&self) -> [i64; 2] {
        let middle = self.map_from_vehicle * Point2::new(MIDDLE_AHEAD_M, 0.0);
        [middle.x, middle.y].map(|m| (m / CELL_M).round() as i64 - SIDE / 2)
    }

    /// Takes in what a frame shows of the road surface and lists what is known from then on. The view shows a place of the road where `shown_from_road` says.
    pub(super) fn see(
        &mut self,
        grid: &GroundGrid,
        Looks { probability, uninformed_log_odds, seen }: Looks<'_>,
        shown_from_road: &Matrix3<f64>,
    ) {
        let vehicle_from_map = self.map_from_vehicle.inverse();
        self.listed.clear();
        self.squares.clear();
        let first = self.corner.map(|line| line + (line & 1));
        for (row, column) in
            (0..SIDE / 2 - 1).flat_map(|row| (0..SIDE / 2 - 1).map(move |column| (row, column)))
        {
            let start = self.listed.len();
            for [right, down] in SEEN_OF_SQUARE {
                let at = [first[0] + 2 * column + right, first[1] + 2 * row + down];
                let place = vehicle_from_map * Point2::from(at.map(|line| line as f64 * CELL_M));
                let Some(cell) = self.cells.get_mut(index(at)) else { continue };
                if place.x > grid.near_m() - 1.0 && place.x < grid.far_m() + 1.0 {
                    let shown = shown_from_road * place.to_homogeneous();
                    let shown = Point2::new(shown.x / shown.z, shown.y / shown.z);
                    if let Some(p) = mean_about(probability, seen, grid.ground_from_vehicle(shown)) {
                        let ahead_m2 = (place - self.camera_foot).norm_squared();
                        cell.look(p, uninformed_log_odds, 1.0 / (1.0 + ahead_m2 / HALF_TRUST_M.powi(2)));
                    }
                }
                let trust = f64::from(cell.trust);
                if trust > LEAST_TRUST {
                    let seen_ahead_m = place.x.max(grid.near_m()) - self.camera_foot.x;
                    self.listed.push(GroundCell {
                        place,
                        log_odds: f64::from(cell.log_odds),
                        trust,
                        seen_ahead_m,
                    });
                }
            }
            if self.listed.len() > start {
                self.squares.push(start);
            }
        }
    }
}

impl Cell {
    /// Takes a look in at which the cell was road with probability `p`, by a detector whose log-odds are those where it knows nothing.
    fn look(&mut self, p: f64, uninformed_log_odds: f64, trust: f64) {
        // Half a level of 255, where the detector's own odds would be endless.
        let p = p.clamp(0.002, 0.998);
        let log_odds = (libm::log(p / (1.0 - p)) - uninformed_log_odds).clamp(-MOST_LOG_ODDS, MOST_LOG_ODDS);
        let (before, looks) = (f64::from(self.looks), f64::from(self.looks) + trust);
        self.log_odds = ((f64::from(self.log_odds) * before + log_odds * trust) / looks) as f32;
        self.looks = looks as f32;
        self.trust = self.trust.max(trust as f32);
    }
}

/// The cell of a place in the map, which is a torus.
const fn index([column, row]: [i64; 2]) -> usize {
    ((row & (SIDE - 1)) * SIDE + (column & (SIDE - 1))) as usize
}

/// Mean probability about a pixel; none where that is not all seen.
fn mean_about(probability: &Plane<u8>, seen: &ValidityMask, pixel: GroundPixel) -> Option<f64> {
    let (width, height) = probability.size();
    let mut sum = 0.0;
    for [right, down] in [[-1.0, -1.0], [1.0, -1.0], [-1.0, 1.0], [1.0, 1.0]] {
        let (column, row) = ((pixel.column + right).round(), (pixel.row + down).round());
        if !(column >= 0.0 && row >= 0.0 && column < width as f64 && row < height as f64) {
            return None;
        }
        let (column, row) = (column as usize, row as usize);
        if seen.plane().row(row)[column] == 0 {
            return None;
        }
        sum += f64::from(probability.row(row)[column]);
    }
    Some(sum / (4.0 * 255.0))
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector2;

    use super::*;

    fn surface(grid: &GroundGrid, of: impl Fn(Point2<f64>) -> u8) -> Plane<u8> {
        let mut plane = Plane::new(grid.columns(), grid.rows(), 0);
        for row in 0..grid.rows() {
            for (column, value) in plane.row_mut(row).iter_mut().enumerate() {
                *value = of(grid.vehicle_from_ground(GroundPixel { column: column as f64, row: row as f64 }));
            }
        }
        plane
    }

    fn looks<'a>(probability: &'a Plane<u8>, seen: &'a ValidityMask) -> Looks<'a> {
        Looks { probability, uninformed_log_odds: 0.0, seen }
    }

    fn at(memory: &GroundMemory, place: Point2<f64>) -> Option<GroundCell> {
        memory.squares().flatten().find(|cell| (cell.place - place).amax() < 0.5 * CELL_M).copied()
    }

    #[test]
    fn what_was_seen_ahead_is_known_behind_and_a_standing_vehicle_learns_nothing() {
        let grid = GroundGrid::new(4.0, 20.0, 10.0, 0.05).unwrap();
        let seen = ValidityMask::all_seen(grid.columns(), grid.rows());
        let road = surface(&grid, |p| if p.y.abs() < 3.0 { 250 } else { 5 });
        let mut memory = GroundMemory::new(Point2::new(1.5, 0.0));
        memory.see(&grid, looks(&road, &seen), &Matrix3::identity());
        let before: Vec<GroundCell> = memory.squares().flatten().copied().collect();
        for _ in 0..100 {
            memory.carry(&Isometry2::identity());
            memory.see(&grid, looks(&road, &seen), &Matrix3::identity());
        }
        assert_eq!(before.len(), memory.squares().flatten().count());
        for (before, now) in before.iter().zip(memory.squares().flatten()) {
            assert!((before.log_odds - now.log_odds).abs() < 1e-3 && (before.trust - now.trust).abs() < 1e-9);
        }
        assert!(at(&memory, Point2::new(6.0, 2.0)).unwrap().log_odds > 2.0);
        assert!(at(&memory, Point2::new(6.0, 4.0)).unwrap().log_odds < -2.0);
        // Driven on and turned left by a right angle: what lay ahead on the left lies ahead now.
        memory.carry(&Isometry2::new(Vector2::new(6.0, 0.0), std::f64::consts::FRAC_PI_2));
        let nothing = ValidityMask::from_plane(Plane::new(grid.columns(), grid.rows(), 0));
        memory.see(&grid, looks(&road, &nothing), &Matrix3::identity());
        assert!(at(&memory, Point2::new(2.0, 0.0)).unwrap().log_odds > 2.0);
        assert!(at(&memory, Point2::new(4.0, 0.0)).unwrap().log_odds < -2.0);
    }
}
