//! How far ahead a camera's rows show the road, and how many of them a driver's reaction needs.
//!
//! Paper 3, tables II and I, for any camera. Rows are counted from the picture's base, distances ahead from the rear axle, both
//! down the picture's middle.

use fingerpost_geometry::{Camera, Pixel};
use serde::Serialize;

/// What drivers do and how long it takes them to begin to brake, seconds (paper 3, table I).
const REACTIONS_S: [(&str, f64); 5] = [
    ("driving", 0.392),
    ("radio", 0.408),
    ("talking to a passenger", 0.453),
    ("handheld telephone", 0.464),
    ("hands-free telephone", 0.465),
];
/// Speeds for which distances are given, km/h: town, country roads, motorways.
const SPEEDS_KMH: [f64; 5] = [30.0, 50.0, 80.0, 100.0, 120.0];
/// Lines of the table of rows in the picture's height.
const LINES: usize = 48;
/// Rows that show the road farther away are left out, metres: there a row is metres deep.
pub const FARTHEST_M: f64 = 100.0;

/// Both tables.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Reach {
    /// From the fewest rows on; none where the camera sees no road within [`FARTHEST_M`].
    pub rows: Vec<ReachOfRows>,
    /// What drivers do, the quickest reaction first.
    pub reactions: Vec<ReachOfReaction>,
}

/// How far the road is seen in so many rows.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct ReachOfRows {
    /// Rows, counted from the picture's base.
    pub rows: usize,
    /// How far ahead the uppermost of them shows the road, metres.
    pub range_m: f64,
    /// Range over rows.
    pub m_per_row: f64,
    /// How much farther away the next row shows the road, metres.
    pub row_depth_m: f64,
}

/// What a driver's reaction needs at several speeds.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ReachOfReaction {
    /// What the driver does besides.
    pub doing: &'static str,
    /// Time until the driver begins to brake, seconds.
    pub reaction_s: f64,
    /// One a speed, the slowest first.
    pub needs: Vec<RowsNeeded>,
}

/// What a reaction needs at one speed.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct RowsNeeded {
    /// Speed, km/h.
    pub speed_kmh: f64,
    /// Driven until the driver begins to brake, metres.
    pub distance_m: f64,
    /// Rows that show the road so far; none where none does.
    pub rows: Option<usize>,
}

/// How far ahead the uppermost of the picture's lowest `rows` shows the road, metres; none where it shows none.
fn range_m(camera: &Camera, rows: usize) -> Option<f64> {
    let row = camera.height().checked_sub(rows)?;
    let middle = Pixel::new((camera.width() - 1) as f64 / 2.0, row as f64);
    camera.ground_of_pixel(middle).map(|place| place.x).filter(|m| (0.0..=FARTHEST_M).contains(m))
}

impl Reach {
    /// The tables of a camera.
    pub fn of(camera: &Camera) -> Self {
        let step = (camera.height() / LINES).max(1);
        let line = |rows: usize| {
            let range_m = range_m(camera, rows)?;
            let next_m = self::range_m(camera, rows + 1)?;
            Some(ReachOfRows {
                rows,
                range_m,
                m_per_row: range_m / rows as f64,
                row_depth_m: next_m - range_m,
            })
        };
        let need = |reaction_s: f64, speed_kmh: f64| {
            let distance_m = reaction_s * speed_kmh / 3.6;
            let reaches = |rows: &usize| range_m(camera, *rows).is_some_and(|m| m >= distance_m);
            RowsNeeded { speed_kmh, distance_m, rows: (1..=camera.height()).find(reaches) }
        };
        let reaction = |(doing, reaction_s)| ReachOfReaction {
            doing,
            reaction_s,
            needs: SPEEDS_KMH.iter().map(|&speed_kmh| need(reaction_s, speed_kmh)).collect(),
        };
        Self {
            rows: (step..=camera.height()).step_by(step).filter_map(line).collect(),
            reactions: REACTIONS_S.into_iter().map(reaction).collect(),
        }
    }
}

#[cfg(test)]
mod tests {
    use fingerpost_geometry::{Distortion, Intrinsics, Mount};

    use super::*;

    #[test]
    fn rows_and_distances_are_those_of_the_ground_plane() {
        let intrinsics = Intrinsics { fx: 600.0, fy: 600.0, cx: 319.5, cy: 239.0 };
        let mount = Mount { x_m: 1.5, ..Mount::level(1.2) };
        let camera = Camera::calibrated(640, 480, intrinsics, Distortion::None, mount).unwrap();
        let reach = Reach::of(&camera);
        // Row 380 is the uppermost of a hundred: 600 * 1.2 / (380 - 239) before the camera.
        let hundred = reach.rows.iter().find(|line| line.rows == 100).unwrap();
        assert!((hundred.range_m - (1.5 + 720.0 / 141.0)).abs() < 1e-9);
        assert!((hundred.row_depth_m - (720.0 / 140.0 - 720.0 / 141.0)).abs() < 1e-9);
        assert!((hundred.m_per_row - hundred.range_m / 100.0).abs() < 1e-12);
        // The horizon is in row 239, and no row between it and a hundred metres is told.
        assert!(reach.rows.iter().all(|line| line.rows <= 480 - 247));
        // The paper's first line: 0.392 s at 120 km/h are 13 m; 720 / 11.57 = 62.2 rows below the horizon.
        let need = &reach.reactions[0].needs[4];
        assert!((need.distance_m - 13.07).abs() < 0.01);
        assert_eq!(need.rows, Some(480 - 239 - 62));
    }
}
