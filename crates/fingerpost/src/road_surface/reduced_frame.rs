//! What a network finds in a part of the camera's frame, at a size of its own, laid into the picture that is asked for.

use fingerpost_geometry::Pixel;
use fingerpost_vision::error::PictureError;
use fingerpost_vision::picture::{Plane, Rect};
use fingerpost_vision::warp::WarpTable;

use super::perspective::KnownPerspective;
use super::{RoadEvidence, RoadInput, SampleUse};

/// Lays what stands for a part of the frame into other pictures; its table is kept while the sizes and the perspective are.
#[derive(Default)]
pub(super) struct ReducedFrame {
    layout: Option<Layout>,
}

/// Where the reduced frame lies in the picture that is asked for.
struct Layout {
    perspective: KnownPerspective,
    frame: (usize, usize),
    part: Rect,
    table: WarpTable,
}

impl ReducedFrame {
    /// Fills `out`, which gets the size of the picture that is asked for, bilinearly, from what was found in `part` of the frame; 0 where
    /// the frame does not show it. Beyond the part its border goes on.
    pub(super) fn lay_into(
        &mut self,
        input: &RoadInput<'_>,
        (part, reduced): (Rect, &Plane<u8>),
        out: &mut Plane<u8>,
    ) -> Result<(), PictureError> {
        let layout = match self.layout.take() {
            Some(layout) if layout.serves(input, part, reduced) => layout,
            _ => Layout::new(input, part, reduced)?,
        };
        let layout = self.layout.insert(layout);
        if out.size() != input.validity.size() {
            let (width, height) = input.validity.size();
            out.reset(width, height, 0);
        }
        layout.table.warp_grey(reduced, out)
    }
}

impl Layout {
    fn new(input: &RoadInput<'_>, part: Rect, reduced: &Plane<u8>) -> Result<Self, PictureError> {
        let frame = input.camera_picture().size();
        let place = |at: f64, from: usize, length: usize, to: usize| {
            (at - from as f64 + 0.5) * to as f64 / length.max(1) as f64 - 0.5
        };
        let reduced_from_frame = |p: Pixel| {
            [
                place(p.u, part.x, part.width, reduced.width()),
                place(p.v, part.y, part.height, reduced.height()),
            ]
        };
        Ok(Self {
            perspective: KnownPerspective::of(input.perspective),
            frame,
            part,
            table: input.table_from_reduced(reduced.size(), reduced_from_frame)?,
        })
    }

    fn serves(&self, input: &RoadInput<'_>, part: Rect, reduced: &Plane<u8>) -> bool {
        self.perspective.is(input.perspective)
            && self.frame == input.camera_picture().size()
            && self.part == part
            && self.table.source_size() == reduced.size()
            && self.table.target_size() == input.validity.size()
    }
}

/// The evidence of a detector that learns nothing on the drive.
pub(super) fn evidence_of_a_network(
    detector: &'static str,
    input: &RoadInput<'_>,
    reduced_rows: f64,
    probability: &Plane<u8>,
) -> RoadEvidence {
    RoadEvidence {
        detector,
        sample: input.sample,
        sample_use: SampleUse::Unused,
        sample_probability: mean_inside(input.sample, probability),
        reduced_rows,
        ..RoadEvidence::default()
    }
}

/// Mean probability inside a rectangle, 0 to 1.
fn mean_inside(rect: Rect, probability: &Plane<u8>) -> f64 {
    let (width, height) = probability.size();
    let columns = rect.x.min(width)..(rect.x + rect.width).min(width);
    let rows = rect.y.min(height)..(rect.y + rect.height).min(height);
    let count = columns.len() * rows.len();
    let total: u64 = rows.flat_map(|y| &probability.row(y)[columns.clone()]).map(|&p| u64::from(p)).sum();
    total as f64 / (255 * count.max(1)) as f64
}
