//! What the network sees in the camera's picture: its classes, and where it doubts that there is road.

use fingerpost::road_surface::NetworkOutput;
use fingerpost_vision::picture::{Plane, Rect, RgbImage};
use fingerpost_vision::road_network::{LOGIT_STEPS, RoadNetwork};

use crate::draw::Canvas;
use crate::palette::{self, Rgb};
use crate::scene::Scene;

pub(crate) const LEGEND: &str = "What the network sees, each colour as strong as it is probable: green road, white paint on it, magenta \
    raised ground as pavements, red what hides the ground. Orange: between one to three and three to one for road.";

/// Strength of the colour of what is certain; the picture shows through.
const STRENGTH: f64 = 0.55;
/// Log-odds of road within which the edge is in doubt: three to one.
const DOUBT: f64 = 1.1;

/// The network's outputs over a picture of any size.
pub(crate) struct Classes<'a> {
    network: &'a RoadNetwork,
    picture: &'a RgbImage,
}

impl<'a> Classes<'a> {
    /// Those of a frame; none where no network was asked.
    pub(crate) fn of(scene: &Scene<'a>) -> Option<Self> {
        Some(Self { network: scene.evidence.network?, picture: scene.picture })
    }

    /// Log-odds at a pixel of the camera's picture, bilinear between the network's places; none beyond the part that it looked at.
    fn log_odds(&self, output: NetworkOutput, u: usize, v: usize) -> Option<f64> {
        let logits = self.network.logits(output.index())?;
        let [x, y] = self.network.logit_place([u as f64, v as f64]);
        let last = [logits.width(), logits.height()].map(|places| places as f64 - 0.5);
        let is_seen = x >= -0.5 && y >= -0.5 && x <= last[0] && y <= last[1];
        is_seen.then(|| bilinear(logits, x, y) / f64::from(LOGIT_STEPS))
    }

    /// A pixel of the camera's picture with the classes over it.
    fn tinted(&self, u: usize, v: usize) -> Rgb {
        let shown = self.picture.get(u, v).unwrap_or_default();
        palette::NETWORK_CLASSES.iter().fold(shown, |under, &(output, colour)| {
            let p = self.log_odds(output, u, v).map_or(0.0, |log_odds| 1.0 / (1.0 + libm::exp(-log_odds)));
            mixed(under, colour, STRENGTH * p)
        })
    }

    /// The same with nothing but the road's edge over it, where it is in doubt.
    pub(crate) fn with_doubt(&self, u: usize, v: usize) -> Rgb {
        let shown = self.picture.get(u, v).unwrap_or_default();
        let doubt = self.log_odds(NetworkOutput::Road, u, v).is_some_and(|log_odds| log_odds.abs() < DOUBT);
        if doubt { mixed(shown, palette::CENTRELINE, STRENGTH) } else { shown }
    }

    /// Draws the classes over the picture into `area`, which has its proportions.
    pub(crate) fn draw(&self, canvas: &mut Canvas, area: Rect) {
        canvas.picture(area, self.picture.size(), |u, v| self.tinted(u, v));
    }
}

fn bilinear(plane: &Plane<i8>, x: f64, y: f64) -> f64 {
    let (left, top) = (x.floor(), y.floor());
    let at = |column: f64, row: f64| {
        let within = |place: f64, count: usize| place.clamp(0.0, count.saturating_sub(1) as f64);
        let (column, row) = (within(column, plane.width()), within(row, plane.height()));
        plane.get(column as usize, row as usize).map_or(0.0, f64::from)
    };
    let mix = |from: f64, to: f64, share: f64| from + share * (to - from);
    let above = mix(at(left, top), at(left + 1.0, top), x - left);
    let below = mix(at(left, top + 1.0), at(left + 1.0, top + 1.0), x - left);
    mix(above, below, y - top)
}

fn mixed(under: Rgb, over: Rgb, share: f64) -> Rgb {
    std::array::from_fn(|channel| {
        let [under, over] = [under, over].map(|colour| f64::from(colour[channel]));
        (under + share * (over - under)).round() as u8
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_between_places_lie_between_theirs_and_the_border_goes_on() {
        let plane = Plane::from_vec(2, 2, vec![0_i8, 16, 32, 48]).unwrap();
        for ([x, y], expected) in
            [([0.5, 0.5], 24.0), ([1.0, 0.25], 24.0), ([1.0, 1.0], 48.0), ([-0.5, 0.0], 0.0)]
        {
            assert!((bilinear(&plane, x, y) - expected).abs() < 1e-12, "{x} {y}");
        }
    }

    #[test]
    fn a_colour_is_laid_over_as_much_as_it_is_probable() {
        assert_eq!(mixed([0, 100, 200], [200, 100, 0], 0.0), [0, 100, 200]);
        assert_eq!(mixed([0, 100, 200], [200, 100, 0], 0.5), [100, 100, 100]);
    }
}
