//! Route progress: how far along the route the vehicle is believed to be.
//!
//! The search for the next feature starts from here (paper 1, section VII): from the start given and the motion since,
//! corrected by every feature that is followed and by GPS where there is any; or from nothing, in which case the
//! features serve as directions in their order (`track/directions.rs` asks which is the first) and one that is found says where the
//! vehicle is.

use fingerpost_geometry::Polyline;
use nalgebra::Point2;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::progress::GpsUse;

/// Settings of the progress along the route.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct RouteProgressConfig {
    /// Standard deviation of a start given by hand, metres.
    #[schemars(range(min = 0.1, max = 10000.0))]
    pub start_sigma_m: f64,
    /// Standard deviation of dead reckoning, share of the distance driven.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub drift_share: f64,
    /// Standard deviation of a GPS position along the road, metres.
    #[schemars(range(min = 0.1, max = 10000.0))]
    pub gps_sigma_m: f64,
    /// A GPS position farther than this from the route is not believed, metres.
    #[schemars(range(min = 1.0, max = 10000.0))]
    pub gps_gate_m: f64,
}

impl Default for RouteProgressConfig {
    fn default() -> Self {
        Self { start_sigma_m: 3.0, drift_share: 0.03, gps_sigma_m: 6.0, gps_gate_m: 40.0 }
    }
}

/// Standard deviation of the progress beside a feature that is followed, at least, metres.
const LEAST_SIGMA_M: f64 = 0.3;
/// A feature that is found farther from where it was expected leaves a doubt.
const AGREEING_SIGMAS: f64 = 1.5;

/// Progress along the route as a Gaussian, or unknown.
#[derive(Debug, Clone)]
pub struct RouteProgress {
    config: RouteProgressConfig,
    known: Option<Known>,
    /// What was known before a feature was found where it was not expected; kept until the next one tells which is right.
    doubted: Option<Known>,
    /// Distance along the route of the feature that was found last, metres.
    found_m: Option<f64>,
    /// Metres driven since the first frame: the vehicle started on the route, so it is at least this far along.
    driven_m: f64,
}

#[derive(Debug, Clone, Copy)]
struct Known {
    mean_m: f64,
    variance: f64,
}

impl RouteProgress {
    /// Progress at the first frame: `start_m` along the route, or unknown.
    pub fn new(config: &RouteProgressConfig, start_m: Option<f64>) -> Self {
        let known = start_m.map(|mean_m| Known { mean_m, variance: config.start_sigma_m.powi(2) });
        Self { config: config.clone(), known, doubted: None, found_m: None, driven_m: 0.0 }
    }

    /// Mean and standard deviation, metres; none while unknown.
    pub fn belief_m(&self) -> Option<(f64, f64)> {
        self.known.map(|known| (known.mean_m, known.variance.sqrt()))
    }

    /// Mean and standard deviation of every belief that is still possible, the likeliest first, metres; none while unknown.
    pub fn beliefs_m(&self) -> impl Iterator<Item = (f64, f64)> {
        self.known.into_iter().chain(self.doubted).map(|known| (known.mean_m, known.variance.sqrt()))
    }

    /// The least progress that is believed possible, metres.
    pub fn at_least_m(&self) -> f64 {
        self.beliefs_m()
            .map(|(mean_m, sigma_m)| mean_m - 3.0 * sigma_m)
            .min_by(f64::total_cmp)
            .unwrap_or((1.0 - 3.0 * self.config.drift_share) * self.driven_m)
    }

    /// The vehicle moved on by `forward_m`, known to the standard deviation `sigma_m`, metres.
    pub fn advance(&mut self, forward_m: f64, sigma_m: f64) {
        self.driven_m += forward_m;
        for known in self.known.iter_mut().chain(&mut self.doubted) {
            known.mean_m += forward_m;
            // Drift is one slow error, not noise anew in each frame: its standard deviation grows with the distance.
            let drift_m = (self.config.drift_share * forward_m.abs()).max(sigma_m);
            let sigma = known.variance.sqrt() + drift_m;
            known.variance = sigma * sigma;
        }
    }

    /// The feature that lies `feature_m` along the route was found and says where on it the vehicle is. What was believed
    /// before is kept beside it when the two disagree, because places look alike; what neither agrees with is forgotten.
    pub fn observe_found(&mut self, feature_m: f64, route_m: f64, sigma_m: f64) {
        // The same feature found again tells nothing new.
        let is_same =
            self.found_m.replace(feature_m).is_some_and(|found_m| (found_m - feature_m).abs() < 0.01);
        let agrees = |known: &Known| {
            let variance = known.variance + sigma_m.max(LEAST_SIGMA_M).powi(2);
            (route_m - known.mean_m).powi(2) <= AGREEING_SIGMAS.powi(2) * variance
        };
        let surprised = self.known.as_ref().is_some_and(|known| !agrees(known));
        self.doubted = match self.doubted {
            Some(doubted) if agrees(&doubted) => None,
            Some(doubted) if is_same => Some(doubted),
            _ if surprised => self.known,
            _ => None,
        };
        self.observe(route_m, sigma_m);
    }

    /// A followed feature says where on the route the vehicle is.
    pub fn observe(&mut self, route_m: f64, sigma_m: f64) {
        // The feature's place is measured against the map in each frame: it replaces dead reckoning.
        let sigma_m = sigma_m.max(LEAST_SIGMA_M);
        self.known = Some(Known { mean_m: route_m, variance: sigma_m * sigma_m });
    }

    /// A GPS position, in the map frame.
    pub fn observe_gps(&mut self, route: &Polyline, p_in_map: Point2<f64>) -> GpsUse {
        let foot = match self.known {
            // Where the route passes the same place twice, the pass that is believed counts.
            Some(known) => {
                let reach = 3.0 * known.variance.sqrt() + self.config.gps_gate_m;
                route
                    .nearest_on_part(p_in_map, known.mean_m - reach, known.mean_m + reach)
                    .unwrap_or_else(|| route.nearest(p_in_map))
            }
            None => route.nearest(p_in_map),
        };
        if foot.left_m.abs() > self.config.gps_gate_m {
            return GpsUse::OffRoute { distance_m: foot.left_m.abs() };
        }
        let measured = self.config.gps_sigma_m.powi(2);
        let contradicted =
            |known: &Known| (foot.along_m - known.mean_m).powi(2) > 9.0 * (known.variance + measured);
        self.doubted = self.doubted.filter(|doubted| !contradicted(doubted));
        let known = self.known.unwrap_or(Known { mean_m: foot.along_m, variance: 1e6 });
        let gain = known.variance / (known.variance + measured);
        let innovation_m = foot.along_m - known.mean_m;
        self.known = Some(Known {
            mean_m: known.mean_m + gain * innovation_m,
            variance: (1.0 - gain) * known.variance,
        });
        GpsUse::Accepted { innovation_m }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn route() -> Polyline {
        Polyline::new([Point2::new(0.0, 0.0), Point2::new(100.0, 0.0), Point2::new(100.0, 100.0)]).unwrap()
    }

    #[test]
    fn dead_reckoning_grows_unsure_and_a_feature_ends_it() {
        let mut progress = RouteProgress::new(&RouteProgressConfig::default(), Some(10.0));
        for _ in 0..100 {
            progress.advance(1.0, 0.0);
        }
        let (mean, sigma) = progress.belief_m().unwrap();
        assert!((mean - 110.0).abs() < 1e-9 && (sigma - 6.0).abs() < 1e-6, "{mean} {sigma}");
        progress.observe(105.0, 0.4);
        assert!((progress.belief_m().unwrap().0 - 105.0).abs() < 1e-9);
    }

    #[test]
    fn a_feature_that_is_not_where_it_was_expected_leaves_a_doubt_that_the_next_one_ends() {
        let start = || RouteProgress::new(&RouteProgressConfig::default(), Some(10.0));
        let sigma_m = 0.4;
        let means = |progress: &RouteProgress| progress.beliefs_m().map(|(mean, _)| mean).collect::<Vec<_>>();
        let mut progress = start();
        progress.observe_found(30.0, 13.0, sigma_m);
        assert_eq!(means(&progress), [13.0], "within what was expected");

        let surprised = || {
            let mut progress = start();
            progress.observe_found(30.0, 18.0, sigma_m);
            progress.observe(18.1, sigma_m);
            progress.advance(20.0, 0.0);
            progress
        };
        assert_eq!(means(&surprised()), [38.1, 30.0]);
        assert!(surprised().at_least_m() < 30.0 - 9.0, "neither is given up");
        for (next_m, believed) in [(38.3, vec![38.3]), (30.5, vec![30.5]), (50.0, vec![50.0, 38.1])] {
            let mut progress = surprised();
            progress.observe_found(60.0, next_m, sigma_m);
            assert_eq!(means(&progress), believed);
        }
        let mut lost_and_found = surprised();
        lost_and_found.observe_found(30.0, 38.2, sigma_m);
        assert_eq!(means(&lost_and_found), [38.2, 30.0], "the same feature again proves nothing");
        let mut with_gps = surprised();
        with_gps.observe_gps(&route(), Point2::new(80.0, 0.0));
        assert_eq!(means(&with_gps).len(), 1, "a position that contradicts the doubt ends it");
    }

    #[test]
    fn gps_places_a_vehicle_that_knew_nothing() {
        let mut progress = RouteProgress::new(&RouteProgressConfig::default(), None);
        assert!(progress.belief_m().is_none());
        let used = progress.observe_gps(&route(), Point2::new(60.0, 3.0));
        assert!(matches!(used, GpsUse::Accepted { .. }));
        assert!((progress.belief_m().unwrap().0 - 60.0).abs() < 0.1);
        let far = progress.observe_gps(&route(), Point2::new(60.0, -80.0));
        assert_eq!(far, GpsUse::OffRoute { distance_m: 80.0 });
    }

    #[test]
    fn without_a_start_the_distance_driven_is_the_least() {
        let mut progress = RouteProgress::new(&RouteProgressConfig::default(), None);
        progress.advance(40.0, 0.0);
        assert!((progress.at_least_m() - 36.4).abs() < 1e-9);
    }
}
