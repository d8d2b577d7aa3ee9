//! Road by colour and by height together: the odds multiply.

use fingerpost_vision::error::PictureError;
use fingerpost_vision::fusion::fuse;

use super::GroundHeight;
use super::height_map::UNIT;
use crate::road_surface::RoadSurface;

/// No colour is believed more than this against a height: one in twenty of what looks like road is none, as pavements do.
const DOUBT: u8 = 13;
/// A prior that says nothing, 256 standing for 1.
const EVEN: u8 = 128;

/// Joins height to the road surface, with its memory.
#[derive(Debug, Default)]
pub(crate) struct Joining {
    prior: Vec<u8>,
    fused: Vec<u8>,
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
        let RoadSurface { probability, sums } = surface;
        let (width, rows) = probability.size();
        let side = height.side_px.max(1);
        self.fused.resize(width, 0);
        for row in 0..rows.min(side * height.raised.height()) {
            if row % side == 0 {
                self.prior.clear();
                let squares = height.raised.row(row / side).iter();
                self.prior
                    .extend(squares.flat_map(|&raised| std::iter::repeat_n(prior(raised), side)).take(width));
                self.prior.resize(width, EVEN);
            }
            if self.prior.iter().all(|&prior| prior == EVEN) {
                continue;
            }
            let values = probability.row_mut(row);
            fuse(values, &self.prior, DOUBT, &mut self.fused)?;
            for run in sums.validity().runs(row) {
                let pixels = run.start..run.end;
                let told = self.prior[pixels.clone()].iter().zip(&self.fused[pixels.clone()]);
                for (value, (&prior, &fused)) in values[pixels].iter_mut().zip(told) {
                    if prior != EVEN {
                        *value = fused;
                    }
                }
            }
        }
        sums.resum(probability.view())
    }
}

/// Share of the ground beside roads that lies on their plane: verges, forecourts and dropped kerbs.
const LEVEL_BESIDE: f64 = 0.7;

/// Probability of road by the log-odds of raised ground, 256 standing for 1. Road is level; other ground is level or raised, so
/// that what is raised is no road, and what is level may be either.
fn prior(raised: i16) -> u8 {
    let beside = LEVEL_BESIDE + (1.0 - LEVEL_BESIDE) * (f64::from(raised) / UNIT).exp();
    (256.0 / (1.0 + beside)).round() as u8
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn raised_is_no_road_level_is_a_little_more_so_and_nothing_says_nothing() {
        let units = |log_odds: f64| (log_odds * UNIT) as i16;
        assert_eq!(prior(0), EVEN);
        assert!(prior(units(6.0)) < 3);
        assert!((150..=151).contains(&prior(units(-8.0))), "{}", prior(units(-8.0)));
    }
}
