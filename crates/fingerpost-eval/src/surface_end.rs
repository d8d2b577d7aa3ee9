//! Where the road surface ends across the road.

/// Spacing of the places that are looked at across the road, metres: that of the ground view's pixels, where nothing else is set.
pub(crate) const STEP_M: f64 = 0.05;
/// Narrower gaps are none, metres: a joint or a line.
pub(crate) const GAP_M: f64 = 0.2;
/// From this probability on ground is called road.
const ROAD_FROM: f64 = 0.5;

/// The places across the road that are looked at, from the vehicle's axis outwards, metres aside.
pub(crate) fn places_aside() -> impl Iterator<Item = f64> {
    (0..).map(|i| STEP_M * (f64::from(i) + 0.5))
}

/// Whether ground of this probability is called road.
pub(crate) fn is_called_road(probability: f64) -> bool {
    probability >= ROAD_FROM
}

/// A walk from the vehicle's axis outwards: the surface ends where nothing within [`GAP_M`] is road any more.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct SurfaceEnd {
    /// How far aside the surface goes, metres; 0 where there is none beside the axis.
    pub(crate) end_m: f64,
    /// The last place that was seen, metres aside.
    pub(crate) last_m: f64,
    /// Whether it ends before that.
    pub(crate) ended: bool,
}

impl SurfaceEnd {
    /// Takes the next place in.
    pub(crate) fn take(&mut self, aside_m: f64, is_road: bool) {
        self.ended |= aside_m - self.end_m > GAP_M;
        if is_road && !self.ended {
            self.end_m = aside_m + 0.5 * STEP_M;
        }
        self.last_m = aside_m;
    }
}
