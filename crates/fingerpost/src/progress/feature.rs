//! What a feature of the route that was looked for says of the progress: where it was seen, and where it was not.

use super::component::{Component, PROGRESS};
use super::mixture::Mixture;
use super::{Progress, WORKING};

/// A place at which a feature may have been seen.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FeaturePlace {
    /// Likelihood of what is seen if the feature is exactly here, against that on a plain road without it; 0 or more. Where an
    /// integral of this ratio over the places (metres) is at hand, it is that integral over sqrt(2 pi) `sigma_m`.
    pub likelihood: f64,
    /// How far the vehicle is before the feature's node, along the route, metres; negative beyond it.
    pub ahead_m: f64,
    /// Standard deviation, metres, above 0: of the measurement, and of the node on the map.
    pub sigma_m: f64,
}

/// What was seen of one feature of the route.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FeatureOutcome<'a> {
    /// Where it may have been seen; empty where there is nothing like it.
    pub places: &'a [FeaturePlace],
    /// It would have been seen, or its place is among `places`, if the vehicle is this far before its node (nearest, farthest),
    /// metres; none where it was not looked for. Beyond, the ground says as much of it as of a plain road.
    pub looked_for_m: Option<[f64; 2]>,
    /// Probability that the map is wrong and the feature does not exist, 0 to 1.
    pub map_wrong_share: f64,
    /// Logarithm of a factor of the likelihoods that says nothing of whether the belief is right; [`Progress::log_evidence`] leaves it out.
    pub log_excess: f64,
}

/// Share of a component that the looked-for stretch has to take for the component to be cut there.
const LEAST_CUT: f64 = 1e-6;
/// Nothing that is seen is more telling than this ratio of likelihoods: products of it stay finite.
const MOST_TELLING: f64 = 1e100;
/// A place is known no better than this, metres.
const LEAST_SIGMA_M: f64 = 0.01;

impl Progress {
    /// The belief once it is known what was seen of the feature that lies `feature_m` metres along the route.
    ///
    /// With p the probability of a progress s, the feature then being ahead = `feature_m` - s before the vehicle, m the share of wrong
    /// maps, and L the likelihoods of `outcome`:
    ///
    ///   p(s | seen) ~ p(s) [m + (1 - m) sum L_j exp(-(ahead - `ahead_m_j`)^2 / 2 sigma_j^2)]  if it was looked for at ahead,
    ///   p(s | seen) ~ p(s) [1 + (1 - m) the same sum]                                    elsewhere.
    ///
    /// The same evidence may be given for several features one after the other, where it may be any of them. It is to be given once
    /// for each: while a feature is in view, condition what was believed before it, moved on, afresh.
    #[must_use]
    pub fn conditioned(&self, feature_m: f64, outcome: &FeatureOutcome<'_>) -> Self {
        let mut after = self.clone();
        if !feature_m.is_finite() {
            return after;
        }
        let absent =
            if outcome.map_wrong_share.is_finite() { outcome.map_wrong_share.clamp(0.0, 1.0) } else { 0.0 };
        let mut weighed = Mixture::<WORKING>::new();
        let places = outcome.places.iter().filter_map(|place| place.on_route(feature_m, 1.0 - absent));
        for (route_m, sigma_m, likelihood) in places {
            let at_place = |component: &Component| component.found(route_m, sigma_m, likelihood);
            self.components.as_slice().iter().map(at_place).for_each(|found| weighed.push(found));
            let width_m = sigma_m * std::f64::consts::TAU.sqrt();
            let weight = likelihood * width_m * self.elsewhere.density(route_m, sigma_m);
            weighed.push(Component::at(weight, route_m, sigma_m, &self.noise));
        }
        let looked_m = outcome.looked_for_m.map(|[near_m, far_m]| [feature_m - far_m, feature_m - near_m]);
        let looked_m = looked_m.filter(|[from_m, to_m]| from_m < to_m);
        for component in self.components.as_slice() {
            match looked_m {
                Some(looked_m) => component.unseen(looked_m, absent, &mut weighed),
                None => weighed.push(*component),
            }
        }
        if let Some([from_m, to_m]) = looked_m {
            after.elsewhere.thin(from_m, to_m, absent);
        }
        after.settle(weighed);
        after.log_evidence -= outcome.log_excess;
        after
    }
}

impl FeaturePlace {
    /// The vehicle's place along the route and its standard deviation, metres, and the likelihood with the share of right maps; none
    /// where they are no such numbers.
    fn on_route(&self, feature_m: f64, map_right: f64) -> Option<(f64, f64, f64)> {
        let likelihood = self.likelihood.min(MOST_TELLING) * map_right;
        let is_sound = likelihood > 0.0 && self.ahead_m.is_finite() && self.sigma_m.is_finite();
        is_sound.then(|| (feature_m - self.ahead_m, self.sigma_m.abs().max(LEAST_SIGMA_M), likelihood))
    }
}

impl Component {
    /// The part that explains a feature which places the vehicle at `route_m`.
    fn found(&self, route_m: f64, sigma_m: f64, likelihood: f64) -> Self {
        let variance = sigma_m * sigma_m;
        let (expected_m, before) = self.predicted(&PROGRESS);
        let innovation_m = route_m - expected_m;
        let fit = (variance / (before + variance)).sqrt()
            * libm::exp(-0.5 * innovation_m * innovation_m / (before + variance));
        Self { weight: self.weight * likelihood * fit, ..self.measured(&PROGRESS, route_m, variance) }
    }

    /// The parts that explain that nothing was seen: where it was looked for, the map is wrong; or it was not looked for there.
    fn unseen(&self, [from_m, to_m]: [f64; 2], absent: f64, weighed: &mut Mixture<WORKING>) {
        let Some(looked_for) = self.between(from_m, to_m, LEAST_CUT) else {
            weighed.push(*self);
            return;
        };
        weighed.push(Self { weight: looked_for.weight * absent, ..looked_for });
        for (from_m, to_m) in [(f64::NEG_INFINITY, from_m), (to_m, f64::INFINITY)] {
            self.between(from_m, to_m, 0.0).into_iter().for_each(|part| weighed.push(part));
        }
    }
}
