//! The way that the vehicle comes in a frame, by the dashes of its lane: their ends come nearer as fast as it drives.
//!
//! Smooth asphalt shows the camera's motion too little: what stands still with the camera, the bonnet or its mirror image,
//! then makes a vehicle at speed a standing one. A broken line shows the way best of all. How bright both lines are along
//! the road is superimposed on how bright they were in the frame before; a motion that lasts in contradicting that is wrong.

use fingerpost_geometry::{Camera, Pixel};
use fingerpost_vision::picture::RgbImage;
use nalgebra::Point2;

use super::Side;
use super::lane_filter::LaneFilter;
use super::road_view::RoadView;

/// Stretch of road that is compared, metres ahead of the rear axle, and the length of its cells.
const FROM_M: f64 = 5.0;
const TO_M: f64 = 26.0;
const CELL_M: f64 = 0.15;
const CELLS: usize = ((TO_M - FROM_M) / CELL_M) as usize;
/// Where a line is read, outside its inner edge, and the road for comparison, metres.
const PAINT_M: f64 = 0.06;
const ROAD_M: f64 = -0.30;
/// Fastest vehicle, m/s, and the longest way in a frame: half of the shortest period of dashes.
const FASTEST_MPS: f64 = 60.0;
const MOST_WAY_M: f64 = 4.5;
/// Cells that must lie over each other.
const LEAST_CELLS: usize = 40;
/// Mean squared difference, levels squared, that wrong places must leave: that of a dash's end or two among worn paint.
const LEAST_DIFFERENCE: f64 = 22.0;
/// The squared difference left at the best place against that at the others: at the most.
const BEST_SHARE: f64 = 0.8;
/// So far from the best place no other may be as good, cells.
const APART_CELLS: usize = 5;
/// Ways that differ by more contradict each other: metres, and share of the dashes' way.
const TOLERANCE_M: f64 = 0.45;
const TOLERANCE: f64 = 0.3;
/// Frames that must contradict a motion, more than do not, before it is wrong, and the most that are remembered.
const CONTRADICTIONS: u32 = 3;
const MOST_CONTRADICTIONS: u32 = 10;

/// How bright both lines are along the road; not a number where nothing is seen.
#[derive(Debug, Clone)]
struct Profiles([[f32; CELLS]; 2]);

impl Default for Profiles {
    fn default() -> Self {
        Self([[f32::NAN; CELLS]; 2])
    }
}

/// Watches the dashes.
#[derive(Debug, Default)]
pub(super) struct DashMotion {
    before: Profiles,
    now: Profiles,
    /// Frames that contradicted the motion, less those since that showed no dash.
    contradictions: u32,
}

impl DashMotion {
    /// Whether the dashes have contradicted the motion for long enough.
    pub(super) const fn contradict_motion(&self) -> bool {
        self.contradictions >= CONTRADICTIONS
    }

    /// Takes a frame in, whose lane is known; `sides` says which edges are followed.
    pub(super) fn look_at(
        &mut self,
        camera: &Camera,
        filter: &LaneFilter,
        frame: &RgbImage,
        sides: [bool; 2],
    ) {
        std::mem::swap(&mut self.before, &mut self.now);
        let view = RoadView::new(camera, filter.pitch_rad());
        for side in Side::BOTH {
            let profile = &mut self.now.0[side.index()];
            profile.fill(f32::NAN);
            if !sides[side.index()] {
                continue;
            }
            for (cell, level) in profile.iter_mut().enumerate() {
                let ahead_m = FROM_M + (cell as f64 + 0.5) * CELL_M;
                let left_m = filter.left_at(side, ahead_m);
                let at = |outside_m: f64| {
                    let place = Point2::new(ahead_m, left_m - side.outward() * outside_m);
                    level_at(frame, view.pixel_of_ground(place)?)
                };
                if let Some((paint, road)) = at(PAINT_M).zip(at(ROAD_M)) {
                    *level = paint - road;
                }
            }
        }
    }

    /// Holds the way that a motion says the vehicle came in the last frame, of `dt_s`, against the dashes.
    pub(super) fn judge_motion(&mut self, forward_m: f64, dt_s: f64) {
        let way_m = self.way_m((FASTEST_MPS * dt_s).min(MOST_WAY_M));
        let agrees = |way_m: f64| (way_m - forward_m).abs() <= TOLERANCE_M.max(TOLERANCE * way_m);
        self.contradictions = match way_m {
            Some(way_m) if agrees(way_m) => 0,
            Some(_) => (self.contradictions + 1).min(MOST_CONTRADICTIONS),
            None => self.contradictions.saturating_sub(1),
        };
    }

    /// How far the vehicle came since the frame before, where the dashes show it.
    fn way_m(&self, most_m: f64) -> Option<f64> {
        let most = (most_m / CELL_M) as usize;
        let mut left = [f64::NAN; (MOST_WAY_M / CELL_M) as usize + 2];
        let (mut sum, mut count, mut best) = (0.0, 0.0, 0);
        for shift in 0..=most {
            left[shift] = self.difference(shift)?;
            sum += left[shift];
            count += 1.0;
            if left[shift] < left[best] {
                best = shift;
            }
        }
        let mean = sum / count;
        let apart = left[..=most].iter().enumerate().filter(|(shift, _)| shift.abs_diff(best) >= APART_CELLS);
        let second = apart.map(|(_, difference)| *difference).fold(f64::INFINITY, f64::min);
        // A shift at the end of the range may be a part of a longer one. Hardly any says nothing: what stays with the camera,
        // and rows that fall on the same pixels again, do not move either.
        if best == most
            || best < APART_CELLS
            || left[best] > BEST_SHARE * mean.min(second)
            || mean < LEAST_DIFFERENCE
        {
            return None;
        }
        Some(best as f64 * CELL_M)
    }

    /// Mean squared difference of the lines when the vehicle came `shift` cells, levels squared.
    fn difference(&self, shift: usize) -> Option<f64> {
        let (mut sum, mut count) = (0.0_f32, 0);
        for (before, now) in self.before.0.iter().zip(&self.now.0) {
            for (before, now) in before[shift..].iter().zip(now) {
                let difference = before - now;
                if !difference.is_nan() {
                    sum += difference * difference;
                    count += 1;
                }
            }
        }
        (count >= LEAST_CELLS).then(|| f64::from(sum) / count as f64)
    }
}

/// Red and a third more than blue, as paint is looked for in, at a pixel; none outside of the picture.
fn level_at(frame: &RgbImage, pixel: Pixel) -> Option<f32> {
    let (u, v) = (pixel.u.round(), pixel.v.round());
    let inside = u >= 1.0 && v >= 0.0 && u + 1.0 < frame.width() as f64 && v < frame.height() as f64;
    if !inside {
        return None;
    }
    let (u, v) = (u as usize, v as usize);
    let sum: i32 = (u - 1..=u + 1)
        .filter_map(|u| frame.get(u, v))
        .map(|[red, _, blue]| 4 * i32::from(red) - i32::from(blue))
        .sum();
    Some(sum as f32 / 9.0)
}

#[cfg(test)]
mod tests {
    use fingerpost_geometry::{Distortion, Intrinsics, Mount};

    use super::*;

    const DT_S: f64 = 0.05;

    /// A whole line on the left and dashes of 3 m with gaps of `gap_m` on the right, after `way_m` of driving.
    fn picture(camera: &Camera, gap_m: f64, way_m: f64) -> RgbImage {
        let mut data = Vec::new();
        for v in 0..camera.height() {
            for u in 0..camera.width() {
                let place = camera.ground_of_pixel(Pixel::new(u as f64, v as f64));
                let is_paint = place.is_some_and(|p| {
                    let is_dash = (p.x + way_m).rem_euclid(3.0 + gap_m) < 3.0;
                    (1.8..1.95).contains(&p.y) || is_dash && (-1.95..-1.8).contains(&p.y)
                });
                data.extend([if is_paint { 200 } else { 80 }; 3]);
            }
        }
        RgbImage::from_vec(camera.width(), camera.height(), data).unwrap()
    }

    /// The dashes after frames with so much way between two of them, held against a motion of `motion_m` a frame.
    fn driven(gap_m: f64, way_m: f64, motion_m: f64) -> DashMotion {
        let intrinsics = Intrinsics { fx: 600.0, fy: 600.0, cx: 319.5, cy: 239.5 };
        let mount = Mount { pitch_rad: 0.05, x_m: 1.5, ..Mount::level(1.3) };
        let camera = Camera::calibrated(640, 480, intrinsics, Distortion::None, mount).unwrap();
        let mut filter = LaneFilter::new();
        filter.place_edge(Side::Left, 1.8, 0.05);
        filter.place_edge(Side::Right, -1.8, 0.05);
        let mut dashes = DashMotion::default();
        for frame in 0..5 {
            let frame = picture(&camera, gap_m, f64::from(frame) * way_m);
            dashes.look_at(&camera, &filter, &frame, [true; 2]);
            dashes.judge_motion(motion_m, DT_S);
        }
        dashes
    }

    #[test]
    fn dashes_show_the_way() {
        for way_m in [0.9, 1.2, 2.0] {
            let seen_m = driven(9.0, way_m, way_m).way_m(2.5).unwrap();
            assert!((seen_m - way_m).abs() <= CELL_M, "{seen_m} of {way_m} m");
        }
    }

    #[test]
    fn a_standing_vehicle_whose_dashes_move_does_not_stand() {
        assert!(driven(9.0, 1.2, 0.0).contradict_motion());
        assert!(!driven(9.0, 1.2, 1.3).contradict_motion());
        assert!(!driven(9.0, 0.0, 0.0).contradict_motion());
    }

    #[test]
    fn dashes_that_stand_still_say_nothing() {
        let dashes = driven(9.0, 0.0, 1.2);
        assert_eq!(dashes.way_m(2.5), None);
        assert!(!dashes.contradict_motion());
    }

    #[test]
    fn whole_lines_contradict_no_motion() {
        let dashes = driven(0.0, 1.2, 0.0);
        assert_eq!(dashes.way_m(2.5), None);
        assert!(!dashes.contradict_motion());
    }
}
