//! Road by colour and by height together: the odds multiply.
//!
//! Road is level. Other ground is level or raised, as the drive shows it: of what is not road by its colours, in a street of kerbs and
//! walls hardly anything is level, in the country nearly all. So ground whose log-odds of being raised are r is exp(r) (1 - s) + s times
//! as likely beside the road as on it, s being the share of level ground beside it.

use fingerpost_vision::error::PictureError;
use fingerpost_vision::fusion::fuse;
use fingerpost_vision::picture::{Plane, ValidityMask};

use super::RoadSurface;
use crate::height::{GroundHeight, MOST_LOG_ODDS, UNIT};

/// A prior that says nothing, 256 standing for 1.
const EVEN: u8 = 128;
/// Squares whose worth of either kind is thought to have been seen before the first: two square metres.
const BEFORE: f64 = 50.0;
/// What is kept of the counts from frame to frame: five seconds of a camera at ten frames a second.
const KEPT: f64 = 0.98;
/// Units of log-odds that share an entry of the table of priors.
const UNITS_AN_ENTRY: i32 = 16;
const ENTRIES: usize = 2 * (MOST_LOG_ODDS as usize * UNIT as usize) / UNITS_AN_ENTRY as usize + 1;

/// Joins height to the road surface, with its memory.
#[derive(Debug)]
pub(crate) struct Joining {
    /// Squares beside the road by their colours that are level, and raised.
    beside: [f64; 2],
    /// Probability of road by log-odds of raised ground.
    priors: [u8; ENTRIES],
    prior: Vec<u8>,
    fused: Vec<u8>,
}

impl Default for Joining {
    fn default() -> Self {
        Self { beside: [0.0; 2], priors: [EVEN; ENTRIES], prior: Vec::new(), fused: Vec::new() }
    }
}

impl Joining {
    /// Changes the surface where the height is known, and leaves it as it is elsewhere.
    ///
    /// # Errors
    /// [`PictureError`] when surface and sums do not fit together.
    pub(crate) fn join(
        &mut self,
        height: &GroundHeight,
        surface: &mut RoadSurface,
    ) -> Result<(), PictureError> {
        let RoadSurface { probability, sums, .. } = surface;
        self.join_seen(height, sums.validity(), probability)?;
        sums.resum(probability.view())
    }

    /// The same for probabilities of road where `validity` shows any.
    ///
    /// # Errors
    /// [`PictureError`] when they do not fit together.
    pub(super) fn join_seen(
        &mut self,
        height: &GroundHeight,
        validity: &ValidityMask,
        probability: &mut Plane<u8>,
    ) -> Result<(), PictureError> {
        self.learn(height, validity, probability);
        let level_beside = self.level_beside();
        for (entry, prior) in self.priors.iter_mut().enumerate() {
            let units = entry as f64 * f64::from(UNITS_AN_ENTRY) - f64::from(MOST_LOG_ODDS) * UNIT;
            *prior = road_by_height(units / UNIT, level_beside);
        }
        let (width, rows) = probability.size();
        let side = height.side_px.max(1);
        self.fused.resize(width, 0);
        for row in 0..rows.min(side * height.raised.height()) {
            if row % side == 0 {
                let Self { prior, priors, .. } = self;
                prior.clear();
                let squares = height.raised.row(row / side).iter().map(|&raised| prior_of(priors, raised));
                prior.extend(squares.flat_map(|prior| std::iter::repeat_n(prior, side)).take(width));
                prior.resize(width, EVEN);
            }
            if self.prior.iter().all(|&prior| prior == EVEN) {
                continue;
            }
            let values = probability.row_mut(row);
            fuse(values, &self.prior, 0, &mut self.fused)?;
            for run in validity.runs(row) {
                let pixels = run.start..run.end;
                let told = self.prior[pixels.clone()].iter().zip(&self.fused[pixels.clone()]);
                for (value, (&prior, &fused)) in values[pixels].iter_mut().zip(told) {
                    if prior != EVEN {
                        *value = fused;
                    }
                }
            }
        }
        Ok(())
    }

    /// Learns how much of the ground beside the road is level from what is none by its colours.
    fn learn(&mut self, height: &GroundHeight, validity: &ValidityMask, by_colour: &Plane<u8>) {
        self.beside = self.beside.map(|squares| KEPT * squares);
        let (side, seen) = (height.side_px.max(1), validity.plane());
        let middle = side / 2;
        for row in 0..height.raised.height() {
            for (column, &raised) in height.raised.row(row).iter().enumerate() {
                let pixel = (column * side + middle, row * side + middle);
                let (Some(road), Some(1..)) = (by_colour.get(pixel.0, pixel.1), seen.get(pixel.0, pixel.1))
                else {
                    continue;
                };
                // Half sure of either says nothing of it.
                if road < EVEN / 2 && f64::from(raised.unsigned_abs()) > UNIT {
                    self.beside[usize::from(raised > 0)] += 1.0;
                }
            }
        }
    }

    fn level_beside(&self) -> f64 {
        let [level, raised] = self.beside;
        (level + BEFORE) / (level + raised + 2.0 * BEFORE)
    }
}

fn prior_of(priors: &[u8; ENTRIES], raised: i16) -> u8 {
    let entry = (i32::from(raised) + (MOST_LOG_ODDS * UNIT as f32) as i32) / UNITS_AN_ENTRY;
    priors.get(entry.max(0) as usize).copied().unwrap_or(EVEN)
}

/// Probability of road, 256 standing for 1, of ground with such log-odds of being raised.
fn road_by_height(raised: f64, level_beside: f64) -> u8 {
    let beside = level_beside + (1.0 - level_beside) * libm::exp(raised);
    (256.0 / (1.0 + beside)).round() as u8
}

#[cfg(test)]
mod tests {
    use fingerpost_vision::picture::ValidityMask;

    use super::*;

    #[test]
    fn raised_is_no_road_and_level_is_as_far_as_what_lies_beside_is_not() {
        for level_beside in [0.0, 0.5, 1.0] {
            assert_eq!(road_by_height(0.0, level_beside), EVEN, "nothing says nothing");
        }
        assert!(road_by_height(6.0, 0.5) < 3 && road_by_height(6.0, 0.0) < 3);
        assert!(road_by_height(-8.0, 0.0) > 254);
        assert!((170..=172).contains(&road_by_height(-8.0, 0.5)));
        assert_eq!(road_by_height(-8.0, 1.0), EVEN);
    }

    /// A view of 40 squares by 40 of two pixels, its left half road by its colours.
    fn joined(raised_beside: i16, frames: usize) -> (Joining, Plane<u8>) {
        let mut height = GroundHeight { side_px: 2, raised: Plane::new(40, 40, -1000) };
        for row in 0..40 {
            height.raised.row_mut(row)[20..].fill(raised_beside);
        }
        let validity = ValidityMask::from_plane(Plane::new(80, 80, 1));
        let mut joining = Joining::default();
        let mut probability = Plane::default();
        for _ in 0..frames {
            probability = Plane::new(80, 80, 20);
            (0..80).for_each(|row| probability.row_mut(row)[..40].fill(200));
            joining.join_seen(&height, &validity, &mut probability).unwrap();
        }
        (joining, probability)
    }

    #[test]
    fn a_country_road_s_verge_stays_one_and_a_street_s_level_ground_is_road() {
        let (country, fields) = joined(-1000, 60);
        assert!(country.level_beside() > 0.95, "{}", country.level_beside());
        assert!(fields.get(60, 40).unwrap() < 26);
        let (street, pavement) = joined(1000, 60);
        assert!(street.level_beside() < 0.05, "{}", street.level_beside());
        assert!(pavement.get(60, 40).unwrap() < 2 && pavement.get(10, 40).unwrap() > 245);
    }
}
