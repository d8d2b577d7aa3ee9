//! The region of interest: from the picture's base up to the distance that a driver needs to react.
//!
//! Paper 3, tables I and II: reaction time and speed give a distance, the distance a row. The rows are this camera's own,
//! through its height, pitch and lens.

use fingerpost_geometry::{Camera, Pixel};

use super::LanesConfig;
use super::road_view::RoadView;

/// Rows of the picture in which lanes are looked for, and its sections.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct LaneRegion {
    /// The uppermost row.
    pub top_row: usize,
    /// The row below the lowest one: the picture's height.
    pub base_row: usize,
    /// Distance that the vehicle drives while its driver reacts, metres ahead of its front.
    pub needed_m: f64,
    /// Distance that the region shows at least, metres ahead of the rear axle; less only where that is too near the horizon.
    pub range_m: f64,
    /// Rows of the sections, `[upper, lower)`, the lowest section first; they shrink with distance.
    pub sections: Vec<[usize; 2]>,
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
    /// Sets the region for a speed, m/s; none is a standing vehicle or one whose speed is not known. The region of the frame
    /// before is kept where it is hardly larger than needed.
    pub(super) fn lay(
        &mut self,
        config: &LanesConfig,
        camera: &Camera,
        pitch_rad: f64,
        speed_mps: Option<f64>,
    ) {
        self.needed_m = config.reaction_time_s * speed_mps.unwrap_or(0.0).max(0.0);
        let front_m = config.departure.front_axle_m + FRONT_OVERHANG_M;
        self.range_m = (front_m + self.needed_m).clamp(config.least_range_m, config.most_range_m);
        let (width, height) = (camera.width(), camera.height());
        let view = RoadView::new(camera, pitch_rad);
        let middle = (width - 1) as f64 / 2.0;
        let seen = |row: usize| {
            view.ground_of_pixel(Pixel::new(middle, row as f64)).is_some_and(|p| p.x <= self.range_m)
        };
        // Rows come nearer from the horizon down, so that the first near enough can be halved for.
        let (mut above, mut below) = (0, height);
        while below - above > 1 {
            let row = usize::midpoint(above, below);
            if seen(row) { below = row } else { above = row }
        }
        let margin = (LEAST_BELOW_HORIZON * height as f64) as usize;
        let lowest = height.saturating_sub(16.max(height / 24));
        let wanted = below.max(margin).min(lowest);
        // It grows at once, because what is needed must be seen, and shrinks late.
        let may_stay =
            self.base_row == height && self.top_row <= wanted && wanted < self.top_row + SLACK_ROWS;
        if !may_stay {
            self.top_row = wanted / STEP_ROWS * STEP_ROWS;
        }
        self.base_row = height;
        self.divide(config);
    }

    fn divide(&mut self, config: &LanesConfig) {
        let rows = (self.base_row - self.top_row) as f64;
        let total: f64 = (0..config.sections).map(|i| config.section_ratio.powi(i as i32)).sum();
        self.sections.clear();
        let (mut lower, mut part) = (self.base_row as f64, 1.0);
        for _ in 0..config.sections {
            let upper = lower - rows * part / total;
            self.sections.push([upper.round() as usize, lower.round() as usize]);
            lower = upper;
            part *= config.section_ratio;
        }
        self.sections.retain(|[upper, lower]| lower > upper);
    }
}

#[cfg(test)]
mod tests {
    use fingerpost_geometry::{Distortion, Intrinsics, Mount};

    use super::super::departure::DepartureConfig;
    use super::*;

    fn camera(height_m: f64) -> Camera {
        let intrinsics = Intrinsics { fx: 600.0, fy: 600.0, cx: 319.5, cy: 239.5 };
        Camera::calibrated(640, 480, intrinsics, Distortion::None, Mount::level(height_m)).unwrap()
    }

    #[test]
    fn the_top_row_shows_the_distance_that_is_needed() {
        let mut region = LaneRegion::default();
        let config = LanesConfig { reaction_time_s: 1.0, ..LanesConfig::default() };
        // 40 m/s for a second, 1.2 m high: 600 * 1.2 / 43.6 = 16.5 rows below the horizon at 239.5.
        region.lay(&config, &camera(1.2), 0.0, Some(40.0));
        assert!((region.needed_m - 40.0).abs() < 1e-12);
        assert_eq!(region.top_row, 257 / 8 * 8);
        // Slower, and the least range decides.
        region.lay(&config, &camera(1.2), 0.0, Some(5.0));
        assert!((region.range_m - 35.0).abs() < 1e-12 && (region.needed_m - 5.0).abs() < 1e-12);
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
        let config = LanesConfig { reaction_time_s: 1.0, ..LanesConfig::default() };
        let camera = camera(1.2);
        let top_row = |region: &mut LaneRegion, mps: f64, pitch_rad: f64| {
            region.lay(&config, &camera, pitch_rad, Some(mps));
            region.top_row
        };
        let mut boundaries = 0;
        for mean_mps in [31.6, 34.0, 36.0, 38.0, 40.0, 42.0] {
            let hovering = (0..60).map(|i| (mean_mps + 0.8 * f64::from(i).sin(), 0.004 * f64::from(i).cos()));
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
        region.lay(&LanesConfig::default(), &camera(1.3), 0.0, None);
        assert_eq!(region.sections.len(), 4);
        assert_eq!(region.sections[0][1], 480);
        assert_eq!(region.sections[3][0], region.top_row);
        for pair in region.sections.windows(2) {
            assert_eq!(pair[0][0], pair[1][1]);
            assert!(pair[1][1] - pair[1][0] < pair[0][1] - pair[0][0]);
        }
    }
}
