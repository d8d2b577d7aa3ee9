//! The region of interest: from the picture's base up to the distance that a driver needs to react.
//!
//! Paper 3, tables I and II: reaction time and speed give a distance, the distance a row. The rows are this camera's own,
//! through its height, pitch and lens. Beyond the paper: an edge that is followed is read farther, because it is known where.

use fingerpost_geometry::{Camera, Pixel};

use super::LanesConfig;
use super::road_view::RoadView;

/// Rows of the picture in which lines are searched for and edges read, and their sections.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct LaneRegion {
    /// The uppermost row in which lines are searched for.
    pub top_row: usize,
    /// The uppermost row in which an edge that is followed is read; not below the other one.
    pub read_top_row: usize,
    /// The row below the lowest one: the picture's height.
    pub base_row: usize,
    /// Distance that the vehicle drives while its driver reacts, metres ahead of its front; none where its speed is not known.
    pub needed_m: Option<f64>,
    /// Distance to which lines are searched for at least, metres ahead of the rear axle; less only where that is too near the
    /// horizon.
    pub range_m: f64,
    /// Rows of the sections in which lines are searched for, `[upper, lower)`, the lowest section first; they shrink with
    /// distance.
    pub sections: Vec<[usize; 2]>,
    /// The same of the rows in which edges are read.
    pub read_sections: Vec<[usize; 2]>,
}

/// Rows below the horizon that are too flat to be read: a row is metres deep there.
const LEAST_BELOW_HORIZON: f64 = 0.02;
/// How far a body reaches beyond its front axle, metres, a medium car's.
const FRONT_OVERHANG_M: f64 = 0.9;
/// The uppermost row is a multiple of this, so that small movements of the region leave the frame buffer where it is.
const STEP_ROWS: usize = 8;
/// Rows that the region must be too high by before it shrinks: more than a speed or a pitch that hovers moves it.
const SLACK_ROWS: usize = 2 * STEP_ROWS;

impl LaneRegion {
    /// Sets the region for a speed, m/s; none where it is not known, and then any distance may be needed. The camera is pitched by
    /// `pitch_rad` against its mount, positive nose down. The region of the frame before is kept where it is hardly larger than
    /// needed.
    pub fn lay(&mut self, config: &LanesConfig, camera: &Camera, pitch_rad: f64, speed_mps: Option<f64>) {
        self.needed_m = speed_mps.map(|speed_mps| config.reaction_time_s * speed_mps.max(0.0));
        let front_m = config.departure.front_axle_m + FRONT_OVERHANG_M;
        let most_m = config.most_range_m;
        self.range_m = self.needed_m.map_or(most_m, |m| (front_m + m).max(config.least_range_m).min(most_m));
        let is_new = self.base_row != camera.height();
        self.base_row = camera.height();
        let tops = [(&mut self.top_row, self.range_m), (&mut self.read_top_row, most_m)];
        for (top_row, range_m) in tops {
            let wanted = row_at(camera, pitch_rad, range_m);
            // It grows at once, because what is needed must be seen, and shrinks late.
            let may_stay = *top_row <= wanted && wanted < *top_row + SLACK_ROWS;
            if is_new || !may_stay {
                *top_row = wanted / STEP_ROWS * STEP_ROWS;
            }
        }
        self.read_top_row = self.read_top_row.min(self.top_row);
        let both = [(&mut self.sections, self.top_row), (&mut self.read_sections, self.read_top_row)];
        for (sections, top_row) in both {
            divide(sections, config, [top_row, self.base_row]);
        }
    }
}

/// The uppermost row that shows no place beyond a distance from the rear axle, metres, and is not too flat to be read.
fn row_at(camera: &Camera, pitch_rad: f64, range_m: f64) -> usize {
    let (width, height) = (camera.width(), camera.height());
    let view = RoadView::new(camera, pitch_rad);
    let middle = (width - 1) as f64 / 2.0;
    let seen =
        |row: usize| view.ground_of_pixel(Pixel::new(middle, row as f64)).is_some_and(|p| p.x <= range_m);
    // Rows come nearer from the horizon down, so that the first near enough can be halved for.
    let (mut above, mut below) = (0, height);
    while below - above > 1 {
        let row = usize::midpoint(above, below);
        if seen(row) { below = row } else { above = row }
    }
    let margin = (LEAST_BELOW_HORIZON * height as f64) as usize;
    let lowest = height.saturating_sub(16.max(height / 24));
    below.max(margin).min(lowest)
}

/// Divides the rows from the first to before the second into sections.
fn divide(sections: &mut Vec<[usize; 2]>, config: &LanesConfig, [top_row, base_row]: [usize; 2]) {
    let rows = (base_row - top_row) as f64;
    let total: f64 = (0..config.sections).map(|i| config.section_ratio.powi(i as i32)).sum();
    sections.clear();
    let (mut lower, mut part) = (base_row as f64, 1.0);
    for _ in 0..config.sections {
        let upper = lower - rows * part / total;
        sections.push([upper.round() as usize, lower.round() as usize]);
        lower = upper;
        part *= config.section_ratio;
    }
    sections.retain(|[upper, lower]| lower > upper);
}

#[cfg(test)]
mod tests {
    use fingerpost_geometry::{Distortion, Intrinsics, Mount};

    use super::*;
    use crate::departure::DepartureConfig;

    fn camera(height_m: f64) -> Camera {
        let intrinsics = Intrinsics { fx: 600.0, fy: 600.0, cx: 319.5, cy: 239.5 };
        Camera::calibrated(640, 480, intrinsics, Distortion::None, Mount::level(height_m)).unwrap()
    }

    #[test]
    fn the_top_row_shows_the_distance_that_is_needed() {
        let mut region = LaneRegion::default();
        let config = LanesConfig { reaction_time_s: 1.0, most_range_m: 60.0, ..LanesConfig::default() };
        // 40 m/s for a second, 1.2 m high: 600 * 1.2 / 43.6 = 16.5 rows below the horizon at 239.5.
        region.lay(&config, &camera(1.2), 0.0, Some(40.0));
        assert_eq!(region.needed_m, Some(40.0));
        assert_eq!(region.top_row, 257 / 8 * 8);
        // Slower, and the least range decides.
        region.lay(&config, &camera(1.2), 0.0, Some(5.0));
        assert_eq!((region.range_m, region.needed_m), (10.4, Some(5.0)));
        assert_eq!(region.top_row, 309 / 8 * 8);
        // Faster, and the largest does; so it does where the speed is not known. Edges are read so far in any case.
        for (speed_mps, needed_m) in [(Some(60.0), Some(60.0)), (None, None)] {
            region.lay(&config, &camera(1.2), 0.0, speed_mps);
            assert_eq!((region.range_m, region.needed_m), (60.0, needed_m));
            assert_eq!((region.top_row, region.read_top_row), (252 / 8 * 8, 252 / 8 * 8));
        }
        region.lay(&config, &camera(1.2), 0.0, Some(0.0));
        assert_eq!((region.top_row, region.read_top_row), (309 / 8 * 8, 252 / 8 * 8));
    }

    #[test]
    fn at_city_and_motorway_speeds_the_reaction_time_decides() {
        let range_m = |reaction_time_s: f64, speed_mps: f64| {
            let mut region = LaneRegion::default();
            let config = LanesConfig { reaction_time_s, ..LanesConfig::default() };
            region.lay(&config, &camera(1.2), 0.0, Some(speed_mps));
            (region.range_m, region.top_row)
        };
        // 54 and 108 km/h.
        for speed_mps in [15.0, 30.0] {
            let [quick, usual, slow] = [0.1, 0.465, 0.9].map(|time_s| range_m(time_s, speed_mps));
            assert!(quick.0 < usual.0 && usual.0 < slow.0, "{quick:?}, {usual:?}, {slow:?}");
            assert!(quick.1 >= usual.1 && usual.1 > slow.1, "{quick:?}, {usual:?}, {slow:?}");
        }
    }

    #[test]
    fn what_is_needed_is_counted_from_the_vehicles_front() {
        let config = LanesConfig { reaction_time_s: 1.0, least_range_m: 8.0, ..LanesConfig::default() };
        let camera = camera(1.2);
        for (speed_mps, front_axle_m) in [(20.0, 2.7), (20.0, 6.0), (12.0, 2.7)] {
            let departure = DepartureConfig { front_axle_m, ..DepartureConfig::default() };
            let mut region = LaneRegion::default();
            region.lay(&LanesConfig { departure, ..config.clone() }, &camera, 0.0, Some(speed_mps));
            let from_axle_m = speed_mps + front_axle_m + 0.9;
            assert!((region.range_m - from_axle_m).abs() < 1e-12);
            let row = (239.5 + 600.0 * 1.2 / from_axle_m).ceil() as usize;
            assert_eq!(region.top_row, row / 8 * 8, "{speed_mps} m/s, front axle {front_axle_m} m");
        }
    }

    #[test]
    fn what_hovers_leaves_the_region_where_it_is() {
        let config = LanesConfig { reaction_time_s: 1.0, most_range_m: 60.0, ..LanesConfig::default() };
        let camera = camera(1.2);
        let top_row = |region: &mut LaneRegion, mps: f64, pitch_rad: f64| {
            region.lay(&config, &camera, pitch_rad, Some(mps));
            region.top_row
        };
        let mut boundaries = 0;
        for mean_mps in [31.6, 34.0, 36.0, 38.0, 40.0, 42.0] {
            let hovering =
                (0..60).map(|i| (mean_mps + 0.8 * libm::sin(f64::from(i)), 0.004 * libm::cos(f64::from(i))));
            let mut region = LaneRegion::default();
            let rows: Vec<usize> =
                hovering.clone().map(|(mps, pitch)| top_row(&mut region, mps, pitch)).collect();
            assert!(rows[20..].iter().all(|row| *row == rows[20]), "{mean_mps} m/s: {rows:?}");
            let alone = hovering.map(|(mps, pitch)| top_row(&mut LaneRegion::default(), mps, pitch));
            let alone: Vec<usize> = alone.collect();
            boundaries += usize::from(alone.iter().any(|row| *row != alone[0]));
        }
        assert!(boundaries >= 3, "without memory {boundaries} of them would have moved");
        // What is needed is never left out, and what is not needed any more is given up.
        let mut region = LaneRegion::default();
        for mps in [10.0, 55.0, 12.0, 41.0, 38.0, 40.5, 30.0] {
            let (kept, alone) =
                (top_row(&mut region, mps, 0.0), top_row(&mut LaneRegion::default(), mps, 0.0));
            assert!(kept <= alone && kept + 16 > alone, "{mps} m/s: {kept}, alone {alone}");
        }
    }

    #[test]
    fn sections_shrink_with_distance_and_leave_no_row_out() {
        let mut region = LaneRegion::default();
        region.lay(&LanesConfig::default(), &camera(1.3), 0.0, Some(0.0));
        assert!(region.top_row > region.read_top_row);
        for (sections, top_row) in
            [(&region.sections, region.top_row), (&region.read_sections, region.read_top_row)]
        {
            assert_eq!((sections.len(), sections[0][1], sections[3][0]), (4, 480, top_row));
            for pair in sections.windows(2) {
                assert_eq!(pair[0][0], pair[1][1]);
                assert!(pair[1][1] - pair[1][0] < pair[0][1] - pair[0][0]);
            }
        }
    }
}
