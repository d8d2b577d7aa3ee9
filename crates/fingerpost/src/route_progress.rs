//! Route progress: how far along the route the vehicle is believed to be.
//!
//! The search for the next feature starts from here (paper 1, section VII): from the start given and the motion since,
//! corrected by every feature that is followed and by GPS where there is any; or from nothing, in which case the
//! features serve as directions in their order (`track/directions.rs` asks which is the first) and one that is found says where the
//! vehicle is.
//!
//! A receiver's error keeps for minutes and is a part of what is believed (`progress/component.rs`), so that a feature says how far
//! GPS is off, and many fixes are not many witnesses. An error that fits no such model, a drift or a receiver that stands, is
//! found as integrity monitors of aircraft do it: what start, motion and features say alone is kept beside what GPS has corrected, and
//! where the two are farther apart than their covariances allow (solution separation: J. Blanch et al., "Baseline advanced RAIM user
//! algorithm and possible improvements", IEEE Transactions on Aerospace and Electronic Systems 51, 2015), both are looked for.

use fingerpost_geometry::Polyline;
use nalgebra::Point2;

use crate::progress::component::{Component, GPS, PROGRESS};
use crate::progress::noise::Noise;
use crate::progress::travel::Travelled;
use crate::progress::{GpsUse, RouteProgressConfig, Travel};

#[cfg(test)]
mod tests;

/// Standard deviation of the progress beside a feature that is followed, at least, metres.
const LEAST_SIGMA_M: f64 = 0.3;
/// A feature that is found farther from where it was expected leaves a doubt, and so does GPS that moves the progress farther.
const AGREEING_SIGMAS: f64 = 1.5;
/// Standard deviation of a progress of which nothing is known but GPS, metres.
const UNKNOWN_M: f64 = 1e3;

/// Progress along the route as Gaussians that are possible, or unknown.
#[derive(Debug, Clone)]
pub struct RouteProgress {
    config: RouteProgressConfig,
    noise: Noise,
    /// By all that was measured.
    known: Option<Component>,
    /// What was known before a feature was found, or a GPS position was, where it was not expected; kept until the next feature tells
    /// which is right.
    doubted: Option<Component>,
    /// Without GPS.
    unaided: Option<Component>,
    /// Distance along the route of the feature that was found last, metres.
    found_m: Option<f64>,
    /// Metres that were seen to be driven since the first frame: the vehicle started on the route, so it is at least this far along.
    driven_m: f64,
    /// What the vehicle can do where its motion is not known.
    travelled: Travelled,
}

impl RouteProgress {
    /// Progress at the first frame: `start_m` along the route, or unknown.
    pub fn new(config: &RouteProgressConfig, start_m: Option<f64>) -> Self {
        let noise = Noise::of_any_receiver(config);
        let known = start_m.map(|mean_m| Component::at(1.0, mean_m, config.start_sigma_m, &noise));
        Self {
            config: config.clone(),
            noise,
            known,
            doubted: None,
            unaided: known,
            found_m: None,
            driven_m: 0.0,
            travelled: Travelled::new(),
        }
    }

    /// Mean and standard deviation, metres; none while unknown.
    pub fn belief_m(&self) -> Option<(f64, f64)> {
        self.known.as_ref().map(moments_m)
    }

    /// Mean and standard deviation of every belief that is still possible, the likeliest first, metres; none while unknown.
    pub fn beliefs_m(&self) -> impl Iterator<Item = (f64, f64)> {
        self.known.iter().chain(&self.doubted).chain(self.separate()).map(moments_m)
    }

    /// What is believed without GPS, where that is farther from what is believed with it than the measurements between them explain.
    fn separate(&self) -> Option<&Component> {
        let (known, unaided) = (self.known.as_ref()?, self.unaided.as_ref()?);
        // The variance of the difference between an estimate and that of a part of its measurements is that of the variances.
        let explained = (unaided.sigma_m().powi(2) - known.sigma_m().powi(2)).max(0.0);
        let apart_m = known.mean_m() - unaided.mean_m();
        (apart_m * apart_m > AGREEING_SIGMAS * AGREEING_SIGMAS * explained).then_some(unaided)
    }

    /// The least progress that is believed possible, metres.
    pub fn at_least_m(&self) -> f64 {
        self.beliefs_m()
            .map(|(mean_m, sigma_m)| mean_m - 3.0 * sigma_m)
            .min_by(f64::total_cmp)
            .unwrap_or((1.0 - 3.0 * self.config.drift_share) * self.driven_m)
    }

    /// So many seconds went by, over which the receiver's slow error changes.
    pub fn elapse(&mut self, dt_s: f64) {
        for component in self.known.iter_mut().chain(&mut self.doubted) {
            component.forget_gps_error(dt_s, &self.noise);
        }
    }

    /// The vehicle moved on for `dt_s` seconds.
    pub fn advance(&mut self, travel: Travel, dt_s: f64) {
        let step = self.travelled.step(travel, dt_s, self.config.drift_share);
        // Drift is one slow error, not noise anew in each frame: its standard deviation grows with the distance.
        let (forward_m, drift_m) = match (travel, step) {
            (Travel::Measured { forward_m, sigma_m }, _) => {
                self.driven_m += forward_m;
                (forward_m, (self.config.drift_share * forward_m.abs()).max(sigma_m))
            }
            (_, Some(step)) => (step.unscaled_m, step.run_added_m),
            (_, None) => return,
        };
        for component in self.known.iter_mut().chain(&mut self.doubted).chain(&mut self.unaided) {
            component.move_by(forward_m, drift_m);
        }
    }

    /// The feature that lies `feature_m` along the route was found and says where on it the vehicle is. What was believed
    /// before is kept beside it when the two disagree, because places look alike; what neither agrees with is forgotten.
    pub fn observe_found(&mut self, feature_m: f64, route_m: f64, sigma_m: f64) {
        // The same feature found again tells nothing new.
        let is_same =
            self.found_m.replace(feature_m).is_some_and(|found_m| (found_m - feature_m).abs() < 0.01);
        let agrees = |component: &Component| {
            let (mean_m, of_m) = moments_m(component);
            let variance = of_m.powi(2) + sigma_m.max(LEAST_SIGMA_M).powi(2);
            (route_m - mean_m).powi(2) <= AGREEING_SIGMAS.powi(2) * variance
        };
        let surprised = self.known.is_some() && !self.known.iter().chain(self.separate()).any(agrees);
        self.doubted = match self.doubted {
            Some(doubted) if agrees(&doubted) => None,
            Some(doubted) if is_same => Some(doubted),
            _ if surprised => self.known,
            _ => None,
        };
        self.observe(route_m, sigma_m);
    }

    /// A followed feature says where on the route the vehicle is, and with it how far GPS is off.
    pub fn observe(&mut self, route_m: f64, sigma_m: f64) {
        // The feature's place is measured against the map in each frame: it replaces dead reckoning.
        let sigma_m = sigma_m.max(LEAST_SIGMA_M);
        let unknown = Component::at(1.0, route_m, sigma_m, &self.noise);
        for place in [&mut self.known, &mut self.unaided] {
            *place = Some(place.unwrap_or(unknown).given(&PROGRESS, route_m, sigma_m * sigma_m));
        }
    }

    /// A GPS position, in the map frame.
    pub fn observe_gps(&mut self, route: &Polyline, p_in_map: Point2<f64>) -> GpsUse {
        if !(p_in_map.x.is_finite() && p_in_map.y.is_finite()) {
            return GpsUse::NothingNew;
        }
        let foot = match &self.known {
            // Where the route passes the same place twice, the pass that is believed counts.
            Some(known) => {
                let reach = 3.0 * known.sigma_m() + self.config.gps_gate_m;
                route
                    .nearest_on_part(p_in_map, known.mean_m() - reach, known.mean_m() + reach)
                    .unwrap_or_else(|| route.nearest(p_in_map))
            }
            None => route.nearest(p_in_map),
        };
        if foot.left_m.abs() > self.config.gps_gate_m {
            return GpsUse::OffRoute { distance_m: foot.left_m.abs() };
        }
        let fix_m = foot.along_m;
        let here = Component::at(1.0, fix_m, UNKNOWN_M, &self.noise).with_fix(fix_m, &self.noise);
        let Some(known) = &mut self.known else {
            self.known = Some(here);
            return GpsUse::Accepted { innovation_m: 0.0 };
        };
        let innovation_m = fix_m - known.predicted(&GPS).0;
        if known.expects_fix(fix_m, &self.noise) {
            *known = known.with_fix(fix_m, &self.noise);
            // What the receiver contradicts and the rest does not is no more in doubt.
            self.doubted = self.doubted.filter(|doubted| doubted.expects_fix(fix_m, &self.noise));
            self.doubted = self.doubted.map(|doubted| doubted.with_fix(fix_m, &self.noise));
            return GpsUse::Accepted { innovation_m };
        }
        // The receiver has jumped, or it is right and the vehicle is not where it was believed.
        *known = known.after_jump(fix_m, &self.noise);
        self.doubted = Some(match self.doubted {
            Some(doubted) if doubted.expects_fix(fix_m, &self.noise) => doubted.with_fix(fix_m, &self.noise),
            _ => here,
        });
        GpsUse::Jumped { innovation_m }
    }
}

/// Mean and standard deviation, metres.
fn moments_m(component: &Component) -> (f64, f64) {
    (component.mean_m(), component.sigma_m())
}
