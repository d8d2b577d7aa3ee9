//! Ground views of the last metres, each with where the vehicle was and how its camera was turned.

use fingerpost_vision::picture::Plane;
use nalgebra::Isometry2;

use crate::ground_view::CameraTurn;

/// Travel between two views that are kept, metres: half of what a pair needs to be told from its neighbours.
pub(super) const SPACING_M: f64 = 0.4;
/// Views that are kept: those of a pair's travel, and two more.
const KEPT: usize = 9;
/// A view is taken for one of another travel up to this share of it: frames of a fast drive lie farther apart than views that are
/// kept.
const OFF_SHARE: f64 = 0.25;

/// A view that was kept.
#[derive(Debug, Default)]
pub(super) struct PastView {
    /// Grey of the ground, in steps of [`fingerpost_vision::parallax`].
    pub(super) grey: Plane<i16>,
    pub(super) odometry_from_vehicle: Isometry2<f64>,
    pub(super) turn: CameraTurn,
    /// Metres driven until then.
    pub(super) driven_m: f64,
}

/// The views, in a ring.
#[derive(Debug, Default)]
pub(super) struct PastViews {
    views: Vec<PastView>,
    /// Where the next one goes.
    next: usize,
    filled: usize,
}

impl PastViews {
    pub(super) fn clear(&mut self) {
        (self.next, self.filled) = (0, 0);
    }

    /// Keeps `view`; the memory of one that is forgotten comes back in its place.
    pub(super) fn keep(&mut self, view: &mut PastView) {
        if self.views.len() < KEPT {
            self.views.resize_with(KEPT, PastView::default);
        }
        if let Some(place) = self.views.get_mut(self.next) {
            std::mem::swap(place, view);
        }
        self.next = (self.next + 1) % KEPT;
        self.filled = (self.filled + 1).min(KEPT);
    }

    /// The view from where the vehicle was about `travel_m` before it had driven `driven_m`; none where there is none.
    pub(super) fn at(&self, driven_m: f64, travel_m: f64) -> Option<&PastView> {
        let off_m = |view: &&PastView| (driven_m - view.driven_m - travel_m).abs();
        let kept = (0..self.filled).filter_map(|back| self.views.get((self.next + KEPT - 1 - back) % KEPT));
        kept.min_by(|a, b| off_m(a).total_cmp(&off_m(b))).filter(|view| off_m(view) <= OFF_SHARE * travel_m)
    }
}
