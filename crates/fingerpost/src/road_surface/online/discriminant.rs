//! What tells the road from what is not, learned as the drive goes: Fisher's linear discriminant between the sample of the
//! road and the rows above the horizon, retrained every frame on running statistics of both.

use fingerpost_vision::moments::Moments;
use fingerpost_vision::passage::FEATURES;
use nalgebra::{SMatrix, SVector};

type Vector = SVector<f64, FEATURES>;
type Matrix = SMatrix<f64, FEATURES, FEATURES>;

/// Variance added to every feature: differences of a tenth are noise.
const FLOOR: f64 = 0.01;
/// Share of a new frame in the running statistics: they reach back over about ten frames.
const NEW_SHARE: f64 = 0.1;
/// Squared distance of the two means, in standard deviations, below which nothing tells them apart.
const MIN_SEPARATION: f64 = 1e-3;

/// Mean and covariance of one kind of place.
#[derive(Debug, Clone, Copy)]
pub(super) struct Kind {
    mean: Vector,
    covariance: Matrix,
}

impl From<Moments<FEATURES>> for Kind {
    fn from(moments: Moments<FEATURES>) -> Self {
        Self { mean: moments.mean.into(), covariance: moments.covariance.into() }
    }
}

impl Kind {
    fn blend(self, new: Self) -> Self {
        let mix = |old: f64, new: f64| (1.0 - NEW_SHARE) * old + NEW_SHARE * new;
        Self {
            mean: self.mean.zip_map(&new.mean, mix),
            covariance: self.covariance.zip_map(&new.covariance, mix),
        }
    }
}

/// Running statistics of the road and of what is not.
#[derive(Debug, Default)]
pub(super) struct Discriminant {
    road: Option<Kind>,
    other: Option<Kind>,
}

/// A discriminant ready for use.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct Weights {
    /// Of the features, and what is added: 0 on the road's mean, 1 on the other's.
    pub(super) linear: ([f32; FEATURES], f32),
    /// Distance of the two means in standard deviations.
    pub(super) separation: f64,
}

impl Discriminant {
    pub(super) fn forget(&mut self) {
        *self = Self::default();
    }

    pub(super) fn learn(&mut self, road: Option<Kind>, other: Option<Kind>) {
        let blend = |old: Option<Kind>, new: Option<Kind>| match (old, new) {
            (Some(old), Some(new)) => Some(old.blend(new)),
            (old, new) => new.or(old),
        };
        self.road = blend(self.road, road);
        self.other = blend(self.other, other);
    }

    /// The weights; all zero as long as one of the kinds has not been seen or nothing tells them apart.
    pub(super) fn weights(&self) -> Weights {
        self.solve().unwrap_or_default()
    }

    fn solve(&self) -> Option<Weights> {
        let (road, other) = (self.road?, self.other?);
        let spread = road.covariance + other.covariance + FLOOR * Matrix::identity();
        let between = other.mean - road.mean;
        let direction = spread.cholesky()?.solve(&between);
        let squared = between.dot(&direction);
        if squared < MIN_SEPARATION {
            return None;
        }
        let direction = direction / squared;
        let linear = (direction.map(|w| w as f32).into(), -direction.dot(&road.mean) as f32);
        Some(Weights { linear, separation: squared.sqrt() })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn kind(brightness: f32, texture: f32) -> Option<Kind> {
        let near: Vec<[f32; FEATURES]> = (0..50)
            .map(|i| {
                let wobble = 0.1 * (i % 7) as f32;
                [wobble, brightness + wobble, 0.05 * (i % 3) as f32, 0.05 * (i % 5) as f32, texture - wobble]
            })
            .collect();
        let features: [Vec<f32>; FEATURES] = std::array::from_fn(|i| near.iter().map(|f| f[i]).collect());
        Moments::of(features.each_ref().map(Vec::as_slice)).map(Kind::from)
    }

    fn value(weights: &Weights, features: [f32; FEATURES]) -> f32 {
        let (w, offset) = weights.linear;
        offset + w.iter().zip(features).map(|(w, f)| w * f).sum::<f32>()
    }

    #[test]
    fn means_lie_at_zero_and_one() {
        let (road, other) = (kind(3.0, -4.0), kind(4.0, -2.0));
        let mut discriminant = Discriminant::default();
        discriminant.learn(road, other);
        let weights = discriminant.weights();
        let at = |kind: Option<Kind>| value(&weights, kind.unwrap().mean.map(|v| v as f32).into());
        assert!(at(road).abs() < 1e-3 && (at(other) - 1.0).abs() < 1e-3);
        assert!(weights.separation > 3.0);
    }

    #[test]
    fn nothing_is_told_apart_without_the_other_kind() {
        let mut discriminant = Discriminant::default();
        discriminant.learn(kind(3.0, -4.0), None);
        assert_eq!(discriminant.weights(), Weights::default());
        discriminant.learn(kind(3.0, -4.0), kind(3.0, -4.0));
        assert_eq!(discriminant.weights(), Weights::default());
    }
}
