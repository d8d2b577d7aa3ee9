//! Where in a row an edge of the lane may lie, and to where it may lead.
//!
//! The lane bends with the vehicle's way, which its yaw rate tells (paper 3, III-B): limits are laid about that way.

use fingerpost_geometry::Pixel;
use nalgebra::Point2;

use crate::LanesConfig;
use crate::region::LaneRegion;
use crate::road_view::RoadView;

/// How far an edge's own direction may be off, radians: a 3 x 3 gradient between pixels.
const DIRECTION_RAD: f32 = 0.14;
/// How far from straight ahead a lane may lead at the most, radians: the way by a yaw rate at walking pace would go about in
/// circles, and beside and behind the camera there is no horizon.
const MOST_AWAY_RAD: f64 = 1.3;
/// A place so far ahead is at the horizon, metres.
const HORIZON_M: f64 = 2000.0;
/// Rows between those for which limits are computed; in between they are interpolated.
const LIMIT_ROWS: usize = 8;

/// Which of a marking's two edges are kept.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MarkingEdges {
    /// The one on the vehicle's side.
    Inner,
    /// Both, as in the paper, which tells them apart by their inner angles.
    Both,
}

/// Columns between which an edge of a row may lie and to which it may lead.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct RowLimits {
    pub(super) row: f32,
    /// Leftmost and rightmost column.
    pub(super) from: f32,
    pub(super) to: f32,
    /// The column straight ahead: left of it edges belong to the left side.
    pub(super) ahead: f32,
    /// The stretch of the horizon to which a lane can lead.
    pub(super) horizon_from: f32,
    pub(super) horizon_to: f32,
    pub(super) horizon_row: f32,
}

/// Lays the limits of a region's rows, every few rows from its top on. `curvature_per_m` is that of the vehicle's way, positive
/// left.
pub(super) fn lay_limits(
    limits: &mut Vec<RowLimits>,
    config: &LanesConfig,
    region: &LaneRegion,
    view: &RoadView<'_>,
    curvature_per_m: f64,
    width: usize,
) {
    limits.clear();
    let most_rad = config.max_heading_deg.to_radians();
    // Never negative nor not a number, whatever heading is asked for: it bounds a clamp.
    let most_bent_rad = (MOST_AWAY_RAD - most_rad).max(0.0);
    let middle = (width - 1) as f64 / 2.0;
    let mut row = region.top_row;
    loop {
        if let Some(place) = view.ground_of_pixel(Pixel::new(middle, row as f64)) {
            // The way bends with the yaw rate, and the lane's direction at a distance with it.
            let bent = (curvature_per_m * place.x).clamp(-most_bent_rad, most_bent_rad);
            let beside = |left_m: f64| view.pixel_of_ground(Point2::new(place.x, left_m));
            let at_horizon = |heading: f64| {
                view.pixel_of_ground(Point2::new(
                    HORIZON_M * libm::cos(heading),
                    HORIZON_M * libm::sin(heading),
                ))
            };
            let bends_to_m = place.x.min(most_bent_rad / curvature_per_m.abs());
            let way_m = bent * (place.x - 0.5 * bends_to_m);
            // A lane may be entered at the far end of the largest heading.
            let reach_m = config.max_offset_m + 0.1 * place.x;
            let columns = [beside(way_m + reach_m), beside(way_m - reach_m), beside(way_m)];
            let horizon = [at_horizon(bent + most_rad), at_horizon(bent - most_rad), at_horizon(bent)];
            if let ([Some(from), Some(to), Some(ahead)], [Some(left), Some(right), Some(far)]) =
                (columns, horizon)
            {
                limits.push(RowLimits {
                    row: (row - region.top_row) as f32,
                    from: from.u as f32,
                    to: to.u as f32,
                    ahead: ahead.u as f32,
                    horizon_from: left.u as f32,
                    horizon_to: right.u as f32,
                    horizon_row: far.v as f32 - region.top_row as f32,
                });
            }
        }
        if row + 1 >= region.base_row {
            break;
        }
        row = (row + LIMIT_ROWS).min(region.base_row - 1);
    }
}

impl RowLimits {
    /// The limits of a row between this and a later one.
    pub(super) fn towards(&self, later: &Self, row: f32) -> Self {
        let span = later.row - self.row;
        let t = if span > 0.0 { ((row - self.row) / span).min(1.0) } else { 0.0 };
        let mix = |a: f32, b: f32| a + t * (b - a);
        Self {
            row,
            from: mix(self.from, later.from),
            to: mix(self.to, later.to),
            ahead: mix(self.ahead, later.ahead),
            horizon_from: mix(self.horizon_from, later.horizon_from),
            horizon_to: mix(self.horizon_to, later.horizon_to),
            horizon_row: mix(self.horizon_row, later.horizon_row),
        }
    }

    /// Whether an edge with this gradient leads to the horizon's stretch, and is brighter on the outside where it must be an
    /// inner one.
    pub(super) fn accepts(
        &self,
        kept: MarkingEdges,
        x: f32,
        y: f32,
        [gx, gy]: [f32; 2],
        slack_rows: f32,
    ) -> bool {
        // Brighter to the left on the left of the vehicle, to the right on its right.
        let outward = if x < self.ahead { -gx } else { gx };
        match kept {
            MarkingEdges::Inner => outward > 0.0 && self.leads_to_horizon(x, y, gy / gx, slack_rows),
            MarkingEdges::Both => outward != 0.0 && self.has_direction(x, y, gy / gx),
        }
    }

    /// Whether an edge that moves so many columns to the right for each row up comes to the horizon's stretch.
    fn leads_to_horizon(&self, x: f32, y: f32, slope: f32, slack_rows: f32) -> bool {
        let up = y - self.horizon_row;
        let at_horizon = x + slope * up;
        let slack = slope.abs() * slack_rows + up * (1.0 + slope * slope) * DIRECTION_RAD;
        at_horizon > self.horizon_from - slack && at_horizon < self.horizon_to + slack
    }

    /// Whether such an edge has a direction in the picture between those to the ends of the horizon's stretch (paper 3: a range of
    /// angles with a safety range). Unlike where it comes to the horizon this tells what is nearly level.
    fn has_direction(&self, x: f32, y: f32, slope: f32) -> bool {
        let up = y - self.horizon_row;
        let [right_rad, left_rad] =
            [self.horizon_to, self.horizon_from].map(|column| libm::atan2f(up, column - x));
        let along_rad = libm::atan2f(1.0_f32, slope);
        along_rad > right_rad - DIRECTION_RAD && along_rad < left_rad + DIRECTION_RAD
    }
}
