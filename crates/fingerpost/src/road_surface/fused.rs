//! The classifier that is trained as the drive goes, with the papers' back-projection for what it leaves open.
//!
//! The classifier knows where the road leads, but works on a reduced picture, so that kerbs seen from above are soft. Colours
//! are told apart pixel by pixel, but shadows and grey pavements deceive them. So in the ground view both are fused, colours
//! counting for so little that they decide only where the classifier is undecided. In a camera picture, where nothing is
//! enlarged, the classifier stands alone.

use fingerpost_vision::fusion::fuse;
use fingerpost_vision::picture::Plane;

use super::{Backprojection, Online, Perspective, RoadDetector, RoadError, RoadEvidence, RoadInput};

/// Range of what colours may say, of 256: a quarter to three quarters, odds of 3 to 1.
const COLOURS_SAY: [u8; 2] = [64, 192];
/// Doubt about the classifier, of 255: one in twenty of its sure pixels may be wrong, so that it is worth twice the colours.
const DOUBT: u8 = 13;

/// Classifier and colours.
pub(super) struct Fused {
    classifier: Online,
    colours: Backprojection,
    /// What each of them says.
    by_way: Plane<u8>,
    by_colour: Plane<u8>,
}

impl Fused {
    pub(super) fn new(classifier: Online, colours: Backprojection) -> Self {
        Self { classifier, colours, by_way: Plane::default(), by_colour: Plane::default() }
    }
}

impl RoadDetector for Fused {
    fn estimate(
        &mut self,
        input: RoadInput<'_>,
        probability: &mut Plane<u8>,
    ) -> Result<RoadEvidence, RoadError> {
        let Perspective::Ground { .. } = input.perspective else {
            return self.classifier.estimate(input, probability);
        };
        let of_colours = self.colours.estimate(input, &mut self.by_colour)?;
        let evidence = self.classifier.estimate(input, &mut self.by_way)?;
        let (width, height) = self.by_way.size();
        if probability.size() != (width, height) {
            probability.reset(width, height, 0);
        }
        let [least, most] = COLOURS_SAY;
        self.by_colour.as_mut_slice().iter_mut().for_each(|p| *p = (*p).clamp(least, most));
        for row in 0..height {
            let (way, colour, fused) =
                (self.by_way.row(row), self.by_colour.row(row), probability.row_mut(row));
            fused.fill(0);
            for run in input.validity.runs(row) {
                let pixels = run.start..run.end;
                fuse(&way[pixels.clone()], &colour[pixels.clone()], DOUBT, &mut fused[pixels])?;
            }
        }
        Ok(RoadEvidence { histograms: of_colours.histograms, ..evidence })
    }

    fn reset(&mut self) {
        self.classifier.reset();
        self.colours.reset();
    }
}
