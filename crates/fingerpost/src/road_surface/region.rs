//! A rectangle of a picture and the histogram of what is seen there.

use fingerpost_vision::colour::HueSaturationBins;
use fingerpost_vision::histogram::{BinCounter, Histogram, Smoothing};
use fingerpost_vision::picture::{PlaneView, Rect, ValidityMask};
use fingerpost_vision::span::SpanMask;

use super::RoadError;

/// A rectangle of a picture and the histogram of what is seen there.
#[derive(Debug)]
pub(super) struct Region {
    rect: Rect,
    /// Rows from one that is counted to the next.
    row_step: usize,
    spans: SpanMask,
    /// Smoothed, mass 1; empty where nothing is seen.
    pub(super) histogram: Histogram,
}

impl Region {
    /// One of whose rows every `row_step`-th is counted.
    pub(super) fn new(bins: HueSaturationBins, row_step: usize) -> Result<Self, RoadError> {
        let rect = Rect { x: 0, y: 0, width: 0, height: 0 };
        let spans = SpanMask::from_rect(rect);
        Ok(Self { rect, row_step: row_step.max(1), spans, histogram: Histogram::new(bins)? })
    }

    /// Counts what is seen in those rows of `rect` of a picture of bins.
    pub(super) fn measure(
        &mut self,
        rect: Rect,
        bin: PlaneView<'_, u16>,
        validity: &ValidityMask,
        counter: &mut BinCounter,
        smoothing: &mut Smoothing,
    ) -> Result<(), RoadError> {
        if self.rect != rect {
            let whole = SpanMask::from_rect(rect);
            let rows = whole.spans().iter().step_by(self.row_step).copied().collect();
            (self.rect, self.spans) = (rect, SpanMask::from_spans(rows));
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
