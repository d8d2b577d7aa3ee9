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
    columns: Vec<Option<Between>>,
    rows: Vec<Option<Between>>,
    /// Probability by the step of a logit.
    probability: [f64; 256],
}

/// Where a pixel's centre lies among the network's places along one axis.
struct Between {
    before: usize,
    after: usize,
    /// How much the second counts.
    share: f64,
}

impl Between {
    /// That of `at` among so many places, whose border goes on to half a place beyond the last; none beyond that.
    fn of(at: f64, count: usize) -> Option<Self> {
        let last = count.checked_sub(1)?;
        if !(-0.5..=count as f64 - 0.5).contains(&at) {
            return None;
        }
        let within = at.clamp(0.0, last as f64);
        let before = within as usize;
        Some(Self { before, after: (before + 1).min(last), share: within - before as f64 })
    }

    fn mix(&self, before: f64, after: f64) -> f64 {
        before + self.share * (after - before)
    }
}

impl<'a> Classes<'a> {
    /// Those of a frame; none where no network was asked.
    pub(crate) fn of(scene: &Scene<'a>) -> Option<Self> {
        let network = scene.evidence.network?;
        let (width, height) = scene.picture.size();
        let (columns, rows) = network.logit_size();
        let place = |u: usize, v: usize| network.logit_place([u as f64, v as f64]);
        let probability = std::array::from_fn(|step| {
            let log_odds = (step as f64 - 128.0) / f64::from(LOGIT_STEPS);
            1.0 / (1.0 + libm::exp(-log_odds))
        });
        Some(Self {
            network,
            picture: scene.picture,
            columns: (0..width).map(|u| Between::of(place(u, 0)[0], columns)).collect(),
            rows: (0..height).map(|v| Between::of(place(0, v)[1], rows)).collect(),
            probability,
        })
    }

    /// Steps of an output's logit at a pixel of the camera's picture, bilinear between the network's places; none beyond the part that it
    /// looked at.
    fn logit(&self, output: NetworkOutput, u: usize, v: usize) -> Option<f64> {
        let logits = self.network.logits(output.index())?;
        bilinear(logits, self.columns.get(u)?.as_ref()?, self.rows.get(v)?.as_ref()?)
    }

    /// A pixel of the camera's picture with the classes over it.
    fn tinted(&self, u: usize, v: usize) -> Rgb {
        let shown = self.picture.get(u, v).unwrap_or_default();
        palette::NETWORK_CLASSES.iter().fold(shown, |under, class| {
            let step = self.logit(class.output, u, v).map(|logit| (logit + 128.5) as usize);
            let p = step.and_then(|step| self.probability.get(step)).copied().unwrap_or(0.0);
            mixed(under, class.colour, STRENGTH * p)
        })
    }

    /// The same with nothing but the road's edge over it, where it is in doubt.
    pub(crate) fn with_doubt(&self, u: usize, v: usize) -> Rgb {
        let shown = self.picture.get(u, v).unwrap_or_default();
        let doubt = self
            .logit(NetworkOutput::Road, u, v)
            .is_some_and(|logit| logit.abs() < DOUBT * f64::from(LOGIT_STEPS));
        if doubt { mixed(shown, palette::CENTRELINE, STRENGTH) } else { shown }
    }

    /// Draws the classes over the picture into `area`, which has its proportions.
    pub(crate) fn draw(&self, canvas: &mut Canvas, area: Rect) {
        canvas.picture(area, self.picture.size(), |u, v| self.tinted(u, v));
    }
}

fn bilinear(plane: &Plane<i8>, column: &Between, row: &Between) -> Option<f64> {
    let across = |row: &[i8]| {
        Some(column.mix(f64::from(*row.get(column.before)?), f64::from(*row.get(column.after)?)))
    };
    Some(row.mix(across(plane.row(row.before))?, across(plane.row(row.after))?))
}

fn mixed(under: Rgb, over: Rgb, share: f64) -> Rgb {
    std::array::from_fn(|channel| {
        let [under, over] = [under, over].map(|colour| f64::from(colour[channel]));
        (under + share * (over - under) + 0.5) as u8
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
            let [column, row] = [x, y].map(|at| Between::of(at, 2).unwrap());
            assert!((bilinear(&plane, &column, &row).unwrap() - expected).abs() < 1e-12, "{x} {y}");
        }
        assert!(Between::of(-0.6, 2).is_none() && Between::of(1.6, 2).is_none());
    }

    #[test]
    fn a_colour_is_laid_over_as_much_as_it_is_probable() {
        assert_eq!(mixed([0, 100, 200], [200, 100, 0], 0.0), [0, 100, 200]);
        assert_eq!(mixed([0, 100, 200], [200, 100, 0], 0.5), [100, 100, 100]);
    }
}
