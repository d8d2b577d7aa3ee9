//! A tracker among others, each of which takes another feature to be the first to come (`track/directions.rs`).

use fingerpost_geometry::Polyline;

use super::{RouteStop, Tracker, TrackerSetting};
use crate::route_progress::RouteProgress;

impl Tracker {
    /// A tracker whose vehicle may be anywhere on the route and comes to the feature `first` next. Its stops are lent to it for each
    /// step.
    pub(in crate::track) fn at_directions(
        setting: TrackerSetting<'_>,
        first: usize,
        route_in_map: Option<Polyline>,
    ) -> Self {
        Self::without_stops(setting, RouteProgress::new(setting.progress, None), first, route_in_map)
    }

    /// Lends it its stops, or takes them back.
    pub(in crate::track) fn exchange_stops(&mut self, stops: &mut Vec<RouteStop>) {
        std::mem::swap(&mut self.stops, stops);
    }

    /// Index of the feature that is followed or sought.
    pub(in crate::track) const fn next(&self) -> usize {
        self.next
    }

    /// Whether it seeks the same feature as another one, and has the vehicle within some metres of where that has it.
    pub(in crate::track) fn agrees_with(&self, other: &Self, within_m: f64) -> bool {
        let places = self.progress.belief_m().zip(other.progress.belief_m());
        self.next == other.next
            && places.is_some_and(|((one, _), (another, _))| (one - another).abs() < within_m)
    }

    /// Of a feature that was found in this frame: how far from where it was expected, and the standard deviation of that, metres;
    /// none where it was not expected anywhere.
    pub(in crate::track) const fn found_off(&self) -> Option<(f64, f64)> {
        self.found_off
    }
}
