//! What a network finds all over the camera's frame, at a size of its own, laid into the picture that is asked for.

use fingerpost_geometry::Pixel;
use fingerpost_vision::error::PictureError;
use fingerpost_vision::picture::{Plane, Rect};
use fingerpost_vision::warp::WarpTable;

use super::perspective::KnownPerspective;
use super::{RoadEvidence, RoadInput, SampleUse};

/// Lays what stands for the whole frame into other pictures; its table is kept while the sizes and the perspective are.
#[derive(Default)]
pub(super) struct ReducedFrame {
    layout: Option<Layout>,
}

/// Where the reduced frame lies in the picture that is asked for.
struct Layout {
    perspective: KnownPerspective,
    frame: (usize, usize),
    table: WarpTable,
}

impl ReducedFrame {
    /// Fills `out`, which gets the size of the picture that is asked for, bilinearly; 0 where the frame does not show it.
    pub(super) fn lay_into(
        &mut self,
        input: &RoadInput<'_>,
        reduced: &Plane<u8>,
        out: &mut Plane<u8>,
    ) -> Result<(), PictureError> {
        let layout = match self.layout.take() {
            Some(layout) if layout.serves(input, reduced) => layout,
            _ => Layout::new(input, reduced)?,
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
    fn new(input: &RoadInput<'_>, reduced: &Plane<u8>) -> Result<Self, PictureError> {
        let frame = input.camera_picture().size();
        let place = |place: f64, from: usize, to: usize| (place + 0.5) * to as f64 / from.max(1) as f64 - 0.5;
        let reduced_from_frame =
            |p: Pixel| [place(p.u, frame.0, reduced.width()), place(p.v, frame.1, reduced.height())];
        Ok(Self {
            perspective: KnownPerspective::of(input.perspective),
            frame,
            table: input.table_from_reduced(reduced.size(), reduced_from_frame)?,
        })
    }

    fn serves(&self, input: &RoadInput<'_>, reduced: &Plane<u8>) -> bool {
        self.perspective.is(input.perspective)
            && self.frame == input.camera_picture().size()
            && self.table.source_size() == reduced.size()
            && self.table.target_size() == input.validity.size()
    }
}

/// The evidence of a detector that learns nothing on the drive.
pub(super) fn evidence_of_a_network(
    detector: &'static str,
    input: &RoadInput<'_>,
    probability: &Plane<u8>,
) -> RoadEvidence {
    RoadEvidence {
        detector,
        sample: input.sample,
        sample_use: SampleUse::Unused,
        sample_probability: mean_inside(input.sample, probability),
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
