//! Progress along the route: a belief that knows what it does not know.
//!
//! A mixture of Gaussians over where on the route the vehicle is (metres from the route's start), by how much the measured
//! distance is too short (a share; scale error of the camera's height and pitch), and how far GPS is off along the route
//! (metres; the slow part of its error). Beside it stands what is left for every other place of the route (`progress/elsewhere.rs`):
//! an unknown start, a start that is wrong, a vehicle that was moved.
//!
//! Motion moves and widens every Gaussian (`progress/travel.rs`); a feature of the route that was looked for multiplies the weight of
//! each by how well it explains what was seen, and what was not (`progress/feature.rs`); GPS likewise, with its slow error as a
//! part of the state, so that many fixes are not many witnesses (`progress/gps.rs`).
//!
//! Memory is bounded, no call allocates, and the same calls give the same numbers.

mod component;
mod config;
mod elsewhere;
mod feature;
mod gps;
mod mixture;
mod noise;
#[cfg(test)]
mod tests;
mod travel;

use self::component::Component;
pub use self::config::RouteProgressConfig;
use self::elsewhere::Elsewhere;
pub use self::feature::{FeatureOutcome, FeaturePlace};
pub use self::gps::GpsUse;
use self::gps::Receiver;
use self::mixture::Mixture;
use self::noise::Noise;
pub use self::travel::Travel;
use self::travel::Travelled;

/// Most Gaussians of a belief: a few places that look alike, each passed or not, seen or not.
const CAPACITY: usize = 24;
/// Most Gaussians that are at hand while one observation is taken in.
const WORKING: usize = 128;
/// Probability that a start given by hand is wrong by more than its standard deviation says: one in fifty, as that of a wrong map.
const START_WRONG: f64 = 0.02;
/// Probability, for each metre driven, that the vehicle is somewhere else than motion says: once in 100 km.
const LOST_PER_M: f64 = 1e-5;

/// Where along the route the vehicle is believed to be.
#[derive(Debug, Clone)]
pub struct Progress {
    noise: Noise,
    components: Mixture<CAPACITY>,
    elsewhere: Elsewhere,
    travelled: Travelled,
    receiver: Receiver,
    /// Logarithm of how probable it made what was observed.
    log_evidence: f64,
}

/// One of the places at which the vehicle may be.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ProgressComponent {
    /// Probability, 0 to 1.
    pub weight: f64,
    /// Distance along the route, metres.
    pub mean_m: f64,
    /// Standard deviation, metres.
    pub sigma_m: f64,
}

impl Progress {
    /// Progress at the first frame of a route of `route_length_m` metres: at `start_m` along it, or anywhere on it.
    pub fn new(config: &RouteProgressConfig, start_m: Option<f64>, route_length_m: f64) -> Self {
        let noise = Noise::new(config);
        let route_length_m = if route_length_m.is_finite() { route_length_m.max(1.0) } else { 1.0 };
        let mut components = Mixture::new();
        let mut elsewhere = Elsewhere::new(route_length_m);
        if let Some(start_m) = start_m.filter(|start_m| start_m.is_finite()) {
            components.push(Component::at(1.0 - START_WRONG, start_m, noise.start_m, &noise));
            elsewhere.add_evenly(START_WRONG);
        } else {
            elsewhere.add_evenly(1.0);
        }
        Self::of(noise, components, elsewhere)
    }

    /// Progress at the first frame of a route of `route_length_m` metres: anywhere between two places along it.
    pub fn between(config: &RouteProgressConfig, [from_m, to_m]: [f64; 2], route_length_m: f64) -> Self {
        let route_length_m = if route_length_m.is_finite() { route_length_m.max(1.0) } else { 1.0 };
        let mut elsewhere = Elsewhere::new(route_length_m);
        elsewhere.add_between(1.0, from_m, to_m.max(from_m + 1.0));
        Self::of(Noise::new(config), Mixture::new(), elsewhere)
    }

    fn of(noise: Noise, components: Mixture<CAPACITY>, elsewhere: Elsewhere) -> Self {
        let (travelled, receiver) = (Travelled::new(), Receiver::new());
        Self { noise, components, elsewhere, travelled, receiver, log_evidence: 0.0 }
    }

    /// Logarithm of how probable what was observed of the route was by this belief, against a road without its features.
    pub fn log_evidence(&self) -> f64 {
        self.log_evidence
    }

    /// The vehicle moved on for `dt_s` seconds. A step without time is ignored; a distance or speed that no road vehicle has
    /// counts as unknown.
    pub fn advance(&mut self, travel: Travel, dt_s: f64) {
        let Some(step) = self.travelled.step(travel, dt_s, self.noise.scale_sigma) else { return };
        let forward_m = step.measured_m + step.unscaled_m;
        let lost_share = 1.0 - libm::exp(-LOST_PER_M * forward_m.abs());
        let lost = lost_share * self.components.weight();
        for component in self.components.as_mut_slice() {
            component.advance(&step, &self.noise);
            component.weight *= 1.0 - lost_share;
        }
        let sigma_m = self.noise.scale_sigma * step.measured_m.abs() + step.run_added_m;
        self.elsewhere.advance(forward_m, sigma_m);
        self.receiver.moved(forward_m, lost, self.elsewhere.mass());
        self.elsewhere.add_evenly(lost);
        self.normalise();
    }

    /// The places at which the vehicle may be, the likeliest first. What is missing of a total weight of 1 is
    /// [`elsewhere`](Self::elsewhere).
    pub fn components(&self) -> impl Iterator<Item = ProgressComponent> + '_ {
        self.components.as_slice().iter().map(|component| ProgressComponent {
            weight: component.weight,
            mean_m: component.mean_m(),
            sigma_m: component.sigma_m(),
        })
    }

    /// Probability that the vehicle is at none of the [`components`](Self::components), but anywhere on the route.
    pub fn elsewhere(&self) -> f64 {
        self.elsewhere.mass()
    }

    /// Probability per metre, at `route_m` metres along the route, that the vehicle is there and at none of the
    /// [`components`](Self::components).
    pub fn elsewhere_per_m(&self, route_m: f64) -> f64 {
        self.elsewhere.density(route_m, 0.0)
    }

    /// Mean and standard deviation of the components together, metres along the route: where the vehicle is if it is not
    /// elsewhere. Those of the whole route that is left while there are no components.
    pub fn moments_m(&self) -> (f64, f64) {
        match self.moments(|component| (component.mean.x, component.covariance.m11)) {
            Some(moments) => moments,
            None => {
                let (mean_m, variance_m2) = self.elsewhere.moments_m().unwrap_or_default();
                (mean_m, variance_m2.sqrt())
            }
        }
    }

    /// Mean and standard deviation of the share by which the measured distance is too short; the prior's while there are no
    /// components.
    pub fn scale_error(&self) -> (f64, f64) {
        self.moments(|component| (component.mean.y, component.covariance.m22))
            .unwrap_or((0.0, self.noise.scale_sigma))
    }

    /// Probability that the vehicle is between `from_m` and `to_m` along the route, metres.
    pub fn probability_between(&self, from_m: f64, to_m: f64) -> f64 {
        let share_of = |component: &Component| component.weight * component.share_between(from_m, to_m);
        let here: f64 = self.components.as_slice().iter().map(share_of).sum();
        here + self.elsewhere.mass_between(from_m, to_m)
    }

    /// Probability that the vehicle has passed the place `feature_m` metres along the route.
    pub fn mass_behind(&self, feature_m: f64) -> f64 {
        self.probability_between(feature_m, f64::INFINITY)
    }

    /// Number of GPS fixes that contradicted most of what was believed: jumps of the receiver, or of the vehicle.
    pub fn gps_jumps(&self) -> u32 {
        self.receiver.jumps()
    }

    /// Mean and standard deviation over the components of what has the mean and variance that `of` gives; none without components.
    fn moments(&self, of: impl Fn(&Component) -> (f64, f64)) -> Option<(f64, f64)> {
        let weight = self.components.weight();
        let average = |value: &dyn Fn(&Component) -> f64| {
            self.components.as_slice().iter().map(|c| c.weight * value(c)).sum::<f64>() / weight
        };
        (weight > 0.0).then(|| {
            let mean = average(&|component| of(component).0);
            let variance = average(&|component| of(component).1 + (of(component).0 - mean).powi(2));
            (mean, variance.max(0.0).sqrt())
        })
    }

    /// Takes over what an observation left of the components.
    fn settle(&mut self, mut weighed: Mixture<WORKING>) {
        weighed.join();
        let total = weighed.weight();
        self.components = weighed.likeliest(total + self.elsewhere.mass());
        // What there is no room for is not known to be wrong.
        self.elsewhere.add_evenly(total - self.components.weight());
        self.normalise();
    }

    /// Makes the weights add up to 1; where nothing is left that is possible, the vehicle may be anywhere.
    fn normalise(&mut self) {
        let total = self.components.weight() + self.elsewhere.mass();
        if total > 0.0 && total.is_finite() {
            for component in self.components.as_mut_slice() {
                component.weight /= total;
            }
            self.elsewhere.scale(1.0 / total);
            self.log_evidence += libm::log(total);
        } else {
            self.components = Mixture::new();
            self.elsewhere.scale(0.0);
            self.elsewhere.add_evenly(1.0);
        }
    }
}
