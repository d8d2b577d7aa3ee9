//! A list of Gaussians of bounded length, which stays short by joining those that say the same.

use nalgebra::Matrix3;

use super::component::Component;

/// Two Gaussians are one when joining them loses no more than it would with two of the same shape half a standard deviation
/// apart: half the logarithm of 1 + (1/2)^2 / 4. The loss is Runnalls' bound on the divergence (2007) at equal weights, so that a
/// likely place does not swallow an unlikely one that lies elsewhere.
const SAME_LOSS: f64 = 0.030_312;
/// The like for the difference of the progress alone, squared standard deviations of the wider one: told without determinants.
const SAME_SQUARED_SIGMAS: f64 = 0.25;
/// A Gaussian of less weight is not worth keeping: it is as likely as four wrong maps in a row, one in fifty each.
const LEAST_WEIGHT: f64 = 1e-7;

/// Up to `N` weighted Gaussians.
#[derive(Debug, Clone)]
pub(super) struct Mixture<const N: usize> {
    items: [Component; N],
    len: usize,
}

impl<const N: usize> Mixture<N> {
    pub(super) const fn new() -> Self {
        Self { items: [Component::NONE; N], len: 0 }
    }

    pub(super) fn as_slice(&self) -> &[Component] {
        self.items.get(..self.len).unwrap_or_default()
    }

    pub(super) fn as_mut_slice(&mut self) -> &mut [Component] {
        self.items.get_mut(..self.len).unwrap_or_default()
    }

    pub(super) fn weight(&self) -> f64 {
        self.as_slice().iter().map(|component| component.weight).sum()
    }

    /// Adds one of positive, finite weight. Where there is no room, the least likely gives way.
    pub(super) fn push(&mut self, component: Component) {
        if !(component.weight > 0.0 && component.weight.is_finite()) {
            return;
        }
        if self.len == N {
            self.join();
        }
        if self.len == N {
            // They stand in the order of their weights.
            self.len -= 1;
        }
        if let Some(place) = self.items.get_mut(self.len) {
            *place = component;
            self.len += 1;
        }
    }

    /// Joins those that say the same; the likeliest stands first.
    pub(super) fn join(&mut self) {
        self.order();
        let items = self.items.get_mut(..self.len).unwrap_or_default();
        for i in 0..items.len() {
            let (first, rest) = items.split_at_mut(i + 1);
            let Some(kept) = first.last_mut().filter(|kept| kept.weight > 0.0) else { continue };
            for other in rest.iter_mut().filter(|other| other.weight > 0.0) {
                if are_same(kept, other) {
                    *kept = joined(kept, other);
                    other.weight = 0.0;
                }
            }
        }
        self.order();
        self.len = self.as_slice().partition_point(|component| component.weight > 0.0);
    }

    /// The likeliest of `self`, of which the whole weight is `total`, in a list of another length.
    pub(super) fn likeliest<const M: usize>(&self, total: f64) -> Mixture<M> {
        let mut kept = Mixture::new();
        for component in self.as_slice().iter().take(M).filter(|c| c.weight > LEAST_WEIGHT * total) {
            kept.push(*component);
        }
        kept
    }

    fn order(&mut self) {
        self.as_mut_slice()
            .sort_unstable_by(|a, b| b.weight.total_cmp(&a.weight).then(a.mean_m().total_cmp(&b.mean_m())));
    }
}

fn are_same(a: &Component, b: &Component) -> bool {
    let apart = a.mean - b.mean;
    if apart.x * apart.x > SAME_SQUARED_SIGMAS * a.covariance.m11.max(b.covariance.m11) {
        return false;
    }
    let both = (a.covariance + b.covariance) * 0.5 + apart * apart.transpose() * 0.25;
    let size = |covariance: &Matrix3<f64>| libm::log(covariance.determinant().max(f64::MIN_POSITIVE));
    0.5 * size(&both) - 0.25 * (size(&a.covariance) + size(&b.covariance)) < SAME_LOSS
}

/// The one Gaussian with the moments of both.
fn joined(a: &Component, b: &Component) -> Component {
    let weight = a.weight + b.weight;
    let share = b.weight / weight;
    let apart = b.mean - a.mean;
    Component {
        weight,
        mean: a.mean + apart * share,
        covariance: a.covariance * (1.0 - share)
            + b.covariance * share
            + apart * apart.transpose() * (share * (1.0 - share)),
        gps_level_m: a.gps_level_m + (b.gps_level_m - a.gps_level_m) * share,
    }
}
