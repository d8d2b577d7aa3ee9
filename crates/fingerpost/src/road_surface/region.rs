//! A rectangle of a picture and the histogram of what is seen there.

use fingerpost_vision::colour::HueSaturationBins;
use fingerpost_vision::histogram::{BinCounter, Histogram, Smoothing};
use fingerpost_vision::picture::{PlaneView, Rect, ValidityMask};
use fingerpost_vision::span::SpanMask;

use super::RoadError;

/// A rectangle of a picture and the histogram of what is seen there.
#[derive(Debug)]
pub struct Region {
    rect: Rect,
    spans: SpanMask,
    /// Smoothed, mass 1; empty where nothing is seen.
    pub histogram: Histogram,
}

impl Region {
    /// Of nothing yet; `bins` are those of the pictures.
    ///
    /// # Errors
    /// [`RoadError::Histogram`] when the bins cannot be used.
    pub fn new(bins: HueSaturationBins) -> Result<Self, RoadError> {
        let rect = Rect { x: 0, y: 0, width: 0, height: 0 };
        Ok(Self { rect, spans: SpanMask::from_rect(rect), histogram: Histogram::new(bins)? })
    }

    /// Counts what is seen in `rect` of a picture of bins.
    pub(super) fn measure(
        &mut self,
        rect: Rect,
        bin: PlaneView<'_, u16>,
        validity: &ValidityMask,
        counter: &mut BinCounter,
        smoothing: &mut Smoothing,
    ) -> Result<(), RoadError> {
        if self.rect != rect {
            (self.rect, self.spans) = (rect, SpanMask::from_rect(rect));
        }
        self.histogram.clear();
        counter.count(bin, validity, &self.spans, &mut self.histogram)?;
        smoothing.apply(&mut self.histogram)?;
        self.histogram.normalise();
        Ok(())
    }

    pub(super) fn is_seen(&self) -> bool {
        self.histogram.total() > 0.0
    }
}
