//! The width of the lane between its markings, for a height that is only known roughly.
//!
//! Markings are narrow and brighter than the road on both sides. Along the vehicle's direction they add up to peaks across
//! the ground view, the nearest one to either side of the vehicle being its lane's. The width between them is proportional to
//! the camera's height, so that a known width gives the height.
//!
//! Limits: lanes marked on both sides, driven along and not across.

use fingerpost::ground_view::{GroundPicture, GroundView, GroundViewConfig, GroundViewError};
use fingerpost_geometry::{Camera, GroundPixel};
use fingerpost_vision::colour::HueSaturationBins;
use fingerpost_vision::picture::RgbImage;

use crate::mount::Estimated;

/// Measures the lane's width in a drive.
#[derive(Debug)]
pub struct LaneWidth {
    view: GroundView,
    picture: GroundPicture,
    /// Summed profile of the frames of a block, and how many they are.
    profile: Vec<f64>,
    frames: usize,
    widths_m: Vec<f64>,
}

/// The part of the road that is looked at: near enough for a lane to be straight and its markings sharp.
const VIEW: GroundViewConfig =
    GroundViewConfig { near_m: 5.0, far_m: 14.0, half_width_m: 5.0, metres_per_pixel: 0.05 };
/// Distance from a marking's middle at which there is road again, pixels of the view: a quarter of a metre.
const BESIDE_PX: usize = 5;
/// Brightness over the road beyond which more does not count: a reflection.
const MOST_BRIGHTER: f64 = 60.0;
/// Frames that are summed: dashes and their gaps pass by.
const BLOCK: usize = 8;
/// Distances of a marking from the vehicle's middle, metres.
const NEAREST_M: f64 = 0.7;
const FARTHEST_M: f64 = 4.0;
/// Least mean brightness over the road of a marking, and how much it must stand out of the other columns.
const LEAST_BRIGHTER: f64 = 2.0;
const STANDS_OUT: f64 = 3.0;
/// Blocks that must show both markings.
const LEAST_BLOCKS: usize = 3;
/// Standard deviation that no number of blocks takes away: a marking is 10 to 15 cm wide, and widths are told from middle to
/// middle or from edge to edge.
const FLOOR_M: f64 = 0.05;

impl LaneWidth {
    /// A measurement through a camera whose mount is known but for its height.
    ///
    /// # Errors
    /// [`GroundViewError`] when the camera does not see the road just ahead.
    pub fn new(camera: &Camera) -> Result<Self, GroundViewError> {
        // Colours play no part, and one bin is the least there can be of each.
        let view = GroundView::new(&VIEW, HueSaturationBins { hue: 1, saturation: 1 }, camera)?;
        let profile = vec![0.0; view.grid().columns()];
        Ok(Self { picture: view.black_picture(), view, profile, frames: 0, widths_m: Vec::new() })
    }

    /// Takes in a frame.
    ///
    /// # Errors
    /// [`GroundViewError::Frame`] when it has not the camera's size.
    pub fn add(&mut self, frame: &RgbImage) -> Result<(), GroundViewError> {
        self.view.render(frame, &mut self.picture)?;
        let grey = &self.picture.grey;
        let rows = grey.height() as f64;
        for row in 0..grey.height() {
            let seen = self.view.validity().plane().row(row);
            for (index, (windows, sum)) in
                grey.row(row).windows(2 * BESIDE_PX + 1).zip(&mut self.profile[BESIDE_PX..]).enumerate()
            {
                if seen[index] != 0 && seen[index + 2 * BESIDE_PX] != 0 {
                    let beside = windows[0].max(windows[2 * BESIDE_PX]);
                    let brighter = f64::from(windows[BESIDE_PX]) - f64::from(beside);
                    *sum += brighter.clamp(0.0, MOST_BRIGHTER) / rows;
                }
            }
        }
        self.frames += 1;
        if self.frames == BLOCK {
            self.widths_m.extend(self.width_of_block());
            self.profile.fill(0.0);
            self.frames = 0;
        }
        Ok(())
    }

    fn width_of_block(&self) -> Option<f64> {
        let profile: Vec<f64> = self.profile.iter().map(|sum| sum / BLOCK as f64).collect();
        let mut sorted = profile.clone();
        sorted.sort_unstable_by(f64::total_cmp);
        let least = (STANDS_OUT * sorted[sorted.len() / 2]).max(LEAST_BRIGHTER);
        let grid = self.view.grid();
        let left_m = |column: f64| grid.vehicle_from_ground(GroundPixel { column, row: 0.0 }).y;
        let marking = |side: f64| {
            let near = |column: &usize| {
                let aside = side * left_m(*column as f64);
                (NEAREST_M..=FARTHEST_M).contains(&aside)
            };
            let best = (1..profile.len() - 1)
                .filter(near)
                .max_by(|a, b| profile[*a].total_cmp(&profile[*b]))
                .filter(|best| profile[*best] >= least)?;
            // The middle of the peak, by its neighbours.
            let about = best.saturating_sub(2)..(best + 3).min(profile.len());
            let total: f64 = profile[about.clone()].iter().sum();
            let middle: f64 = about.map(|column| column as f64 * profile[column]).sum();
            Some(left_m(middle / total))
        };
        Some(marking(1.0)? - marking(-1.0)?)
    }

    /// The width from marking to marking, metres, with the height that the camera was said to have; none where too few frames
    /// show both markings.
    #[must_use]
    pub fn width(&self) -> Option<Estimated> {
        if self.widths_m.len() < LEAST_BLOCKS {
            return None;
        }
        let mut sorted = self.widths_m.clone();
        sorted.sort_unstable_by(f64::total_cmp);
        let median = sorted[sorted.len() / 2];
        let quarter = sorted.len() / 4;
        // Half the distance between the quartiles is 0.67 standard deviations.
        let scatter = (sorted[sorted.len() - 1 - quarter] - sorted[quarter]) / 1.35;
        Some(Estimated { value: median, sigma: libm::hypot(scatter / (sorted.len() as f64).sqrt(), FLOOR_M) })
    }
}
