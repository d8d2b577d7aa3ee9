//! The classifier that is trained as the drive goes, with the colours of what it finds.
//!
//! The classifier knows where the road leads, but works on a reduced picture and lets go of the road slowly, so that edges
//! seen from above are soft. The colours of what it found to be road, and of what it did not, draw them to the pixel where
//! road and verge differ ([`RoadColours`]); where they do not, colours say nothing and the classifier stands. In a camera
//! picture, where nothing is enlarged, it stands alone.

use fingerpost_vision::colour::HueSaturationBins;
use fingerpost_vision::fusion::fuse;
use fingerpost_vision::picture::Plane;

use super::colours::RoadColours;
use super::{Online, Perspective, RoadDetector, RoadError, RoadEvidence, RoadInput};

/// Doubt about the classifier, of 255: a quarter of what it is sure of may be wrong, so that clear colours outvote it.
const DOUBT: u8 = 64;

/// Classifier and colours.
pub(super) struct Fused {
    classifier: Online,
    colours: RoadColours,
    by_way: Plane<u8>,
    by_colour: Vec<u8>,
}

impl Fused {
    pub(super) fn new(classifier: Online, bins: HueSaturationBins) -> Self {
        Self { classifier, colours: RoadColours::new(bins), by_way: Plane::default(), by_colour: Vec::new() }
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
        let evidence = self.classifier.estimate(input, &mut self.by_way)?;
        self.colours.learn(input.picture, input.validity, &self.by_way);
        let (width, height) = self.by_way.size();
        if probability.size() != (width, height) {
            probability.reset(width, height, 0);
        }
        self.by_colour.resize(width, 0);
        for row in 0..height {
            self.colours.read(input.picture, row, &mut self.by_colour);
            let (way, fused) = (self.by_way.row(row), probability.row_mut(row));
            fused.fill(0);
            for run in input.validity.runs(row) {
                let pixels = run.start..run.end;
                fuse(&way[pixels.clone()], &self.by_colour[pixels.clone()], DOUBT, &mut fused[pixels])?;
            }
        }
        Ok(evidence)
    }

    fn reset(&mut self) {
        self.classifier.reset();
        self.colours.forget();
    }
}
