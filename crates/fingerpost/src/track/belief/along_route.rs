//! A feature along the route: where it is expected, and what the ground alone says of its place.

use super::feature_belief::Seen;
use super::fit::Fit;
use super::likelihood::{log_sum, pose_of};
use crate::feature_model::FeatureModel;
use crate::progress::FeaturePlace;

/// How many places along a metre of road look like a feature and are none of the route's, as clutter is counted where targets
/// are tracked (Bar-Shalom, Daum, Huang: The probabilistic data association filter, 2009), and the log-likelihood over which they become
/// fewer by a factor of e: on 2,851 m of drawn worlds, away from every node, 14 had more than 10 and 10 more than 20. Drawn worlds have
/// about twice as many of them as other roads: a guess.
const CLUTTER_PER_M: f64 = 0.003;
const CLUTTER_LOG_LIKELIHOOD: f64 = 30.0;
/// Standard deviation within which a place is looked for where nothing says where the vehicle is, metres: the view.
const ANYWHERE_SIGMA_M: f64 = 15.0;
/// Least standard deviation of the progress, metres.
const LEAST_SIGMA_M: f64 = 0.1;
/// Standard deviation of a node's place along the route, metres: a guess between the quarter of a metre to which nodes
/// are drawn and the 2 m by which aerial pictures are off.
const NODE_SIGMA_M: f64 = 0.7;
/// Logarithm of the square root of 2 pi.
const LN_SQRT_TAU: f64 = 0.918_938_533_204_672_7;
/// No ground says more, logarithm: the progress multiplies features.
const MOST_LOG_LIKELIHOOD: f64 = 100.0;

/// Where the vehicle may be along its route, by all that is known without the feature.
#[derive(Debug, Clone, Copy)]
pub(super) struct Expected {
    /// Distance of the node ahead along the route, metres.
    pub(super) ahead_m: f64,
    pub(super) sigma_m: f64,
    /// Logarithm of its probability.
    pub(super) log_weight: f64,
}

impl Expected {
    /// Where the components of the progress put a feature of the route.
    pub(super) fn by_progress(seen: Seen<'_>) -> impl Iterator<Item = Self> {
        let Seen { stop, progress, .. } = seen;
        progress.components().map(|component| Self {
            ahead_m: stop.model.route_m - component.mean_m,
            sigma_m: component.sigma_m.max(LEAST_SIGMA_M),
            log_weight: libm::log(component.weight),
        })
    }

    /// Logarithm of its share of the probability per metre of a node this far ahead.
    pub(super) fn log_per_m(&self, ahead_m: f64) -> f64 {
        let off = (ahead_m - self.ahead_m) / self.sigma_m;
        self.log_weight - libm::log(self.sigma_m) - LN_SQRT_TAU - 0.5 * off * off
    }
}

/// The likeliest reason why the node may be `ahead_m` ahead.
pub(super) fn expected_at(
    Seen { stop, progress, .. }: Seen<'_>,
    expected: &[Expected],
    ahead_m: f64,
) -> Expected {
    let elsewhere_per_m = progress.elsewhere_per_m(stop.model.route_m - ahead_m).max(f64::MIN_POSITIVE);
    let log_weight = libm::log(elsewhere_per_m) + libm::log(ANYWHERE_SIGMA_M) + LN_SQRT_TAU;
    let anywhere = Expected { ahead_m, sigma_m: ANYWHERE_SIGMA_M, log_weight };
    expected.iter().copied().fold(anywhere, |best, next| {
        if next.log_per_m(ahead_m) > best.log_per_m(ahead_m) { next } else { best }
    })
}

/// Whether the ground says anything of where along the route a feature is.
pub(super) fn is_placed(model: &FeatureModel, fit: &Fit, prior: &Expected) -> bool {
    ground_precision(along(model, fit).1, prior) > ANYWHERE_SIGMA_M.powi(-2)
}

/// Precision of what the ground says by a fit with this variance, per square metre.
fn ground_precision(variance: f64, prior: &Expected) -> f64 {
    1.0 / variance - 1.0 / (prior.sigma_m * prior.sigma_m)
}

/// What the ground says of a place along the route, without what was expected of it.
pub(super) struct SeenAlong {
    ahead_m: f64,
    sigma_m: f64,
    /// Logarithm of the likelihood there against that of a plain road.
    log_likelihood: f64,
}

impl SeenAlong {
    /// By a fit with this evidence against a plain road, for which the place was expected so.
    pub(super) fn of(model: &FeatureModel, fit: &Fit, prior: &Expected, log_ratio: f64) -> Self {
        let (ahead_m, variance) = along(model, fit);
        let before = prior.sigma_m * prior.sigma_m;
        // Where the ground adds nothing its own variance has no bound.
        let precision = ground_precision(variance, prior).max(ANYWHERE_SIGMA_M.powi(-2));
        let seen_m = ahead_m + (ahead_m - prior.ahead_m) / (before * precision);
        let joint = 1.0 / precision + before;
        let off_m = seen_m - prior.ahead_m;
        // The evidence is the integral of the likelihood with the prior, which is a Gaussian of the two variances.
        let log_likelihood = log_ratio + 0.5 * off_m * off_m / joint + 0.5 * libm::log(joint * precision);
        Self { ahead_m: seen_m, sigma_m: (1.0 / precision).sqrt(), log_likelihood }
    }

    /// By a fit for which nothing was expected along the route.
    pub(super) fn unexpected(model: &FeatureModel, fit: &Fit, log_ratio: f64) -> Self {
        let (ahead_m, variance) = along(model, fit);
        Self { ahead_m, sigma_m: variance.sqrt(), log_likelihood: log_ratio }
    }

    /// Probability of a feature there by the ground alone, for which it was as likely as none.
    pub(super) fn probability(&self) -> f64 {
        1.0 / (1.0 + libm::exp(-self.log_likelihood))
    }

    /// Logarithm of how much likelier the ground is if what is seen there may also be none of the route's features.
    pub(super) fn log_clutter(&self) -> f64 {
        let alike_per_m = CLUTTER_PER_M * libm::exp(-self.log_likelihood.max(0.0) / CLUTTER_LOG_LIKELIHOOD);
        let log_share = libm::log(alike_per_m * self.sigma_m) + self.log_likelihood + LN_SQRT_TAU;
        log_sum(0.0, log_share)
    }

    /// Logarithm of the likelihood with so much of it for what looks alike.
    pub(super) fn log_likelihood(&self, log_clutter: f64) -> f64 {
        (self.log_likelihood - log_clutter).min(MOST_LOG_LIKELIHOOD)
    }

    /// As the progress takes it, whose map has errors of its own.
    pub(super) fn on_map(&self, log_clutter: f64) -> FeaturePlace {
        let sigma_m = libm::hypot(self.sigma_m, NODE_SIGMA_M);
        FeaturePlace {
            likelihood: libm::exp(self.log_likelihood(log_clutter)) * self.sigma_m / sigma_m,
            ahead_m: self.ahead_m,
            sigma_m,
        }
    }
}

/// How far ahead along the route the node is by a fit, and the variance, metres.
fn along(model: &FeatureModel, fit: &Fit) -> (f64, f64) {
    let pose = pose_of(&fit.unknowns);
    let before_m = model.before_m(&pose);
    let at = |before_m: f64| model.vehicle_from_feature(before_m, 0.0, 0.0).translation.vector;
    let step = at(before_m + 0.5) - at(before_m - 0.5);
    let along = step / step.norm().max(1e-6);
    let variance = (along.transpose() * fit.covariance.fixed_view::<2, 2>(0, 0) * along).x;
    let ahead_m = model.route_m_of_vehicle(&pose).map_or(before_m, |route_m| model.route_m - route_m);
    (ahead_m, variance)
}
