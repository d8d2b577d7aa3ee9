//! The most probable values of everything that is not known of a feature, and how sure they are.

use fingerpost_geometry::wrap_angle;

use super::junction_shape::{
    CORNERS, FORWARD, HEADING, LEFT, MOST_ARMS, Surroundings, UNKNOWNS, Unknowns, WIDTHS,
};
use super::likelihood::{Ground, Information, NearGround};

/// What is known of the unknowns before anything of the feature is seen: means and standard deviations.
#[derive(Debug, Clone)]
pub(super) struct Prior {
    pub(super) mean: Unknowns,
    pub(super) sigma: Unknowns,
}

/// Where a fit starts.
#[derive(Debug, Clone, Copy)]
pub(super) struct Start {
    pub(super) unknowns: Unknowns,
    /// After so many rounds at the most it ends.
    pub(super) rounds: usize,
    /// How much shorter its first step is made: what the last fit of the same place came to.
    pub(super) damping: f64,
}

impl Start {
    /// A place that has not been fitted.
    pub(super) const fn new(unknowns: Unknowns) -> Self {
        Self { unknowns, rounds: ROUNDS, damping: FIRST_DAMPING }
    }
}

/// Rounds of a fit from a new start, and from what the last frame left.
const ROUNDS: usize = 12;
const WARM_ROUNDS: usize = 4;
const FIRST_DAMPING: f64 = 1e-2;

/// A place where the feature may be.
#[derive(Debug, Clone)]
pub(super) struct Fit {
    /// How much shorter the next step would be made.
    damping: f64,
    /// The most probable values of the unknowns.
    pub(super) unknowns: Unknowns,
    pub(super) covariance: Information,
    /// Logarithm of the evidence about this place: the likelihood against ground of which nothing is known, integrated over
    /// the unknowns with their prior (Laplace's method).
    pub(super) log_evidence: f64,
}

impl Fit {
    /// To be fitted on where the ground has more to say.
    pub(super) const fn start(&self) -> Start {
        Start { unknowns: self.unknowns, rounds: WARM_ROUNDS, damping: self.damping }
    }
}

/// Cells nearer to an edge than this are looked at in every round of a fit, metres: farther no place is moved.
const NEAR_M: f64 = 1.0;
/// Farthest that a round of a fit may move the place, metres, and turn it, radians: as far as an edge is felt.
const STEP: [f64; 2] = [0.7, 0.1];
/// A round that gains less, or promises less, ends the fit: a twentieth of a standard deviation.
const LEAST_GAIN: f64 = 1e-3;

/// Fits the unknowns to the ground; its memory is reused from fit to fit.
#[derive(Debug, Default)]
pub(super) struct Fitter {
    near: NearGround,
}

impl Fitter {
    /// The most probable values about `start` (Levenberg: A method for the solution of certain non-linear problems in least
    /// squares, 1944); none where the way there leads to what `is_known`.
    pub(super) fn fit(
        &mut self,
        ground: &Ground,
        around: &Surroundings<'_>,
        prior: &Prior,
        start: &Start,
        is_known: impl Fn(&Unknowns) -> bool,
    ) -> Option<Fit> {
        let Start { unknowns: start, rounds, mut damping } = *start;
        let near = &mut self.near;
        near.take(ground, around, &start, NEAR_M);
        let mut taken_at = start;
        let precision = prior.sigma.map(|sigma| 1.0 / (sigma * sigma));
        let log_prior = |unknowns: &Unknowns| {
            let off = prior.off(unknowns);
            -0.5 * off.component_mul(&precision).dot(&off)
        };
        let mut unknowns = start;
        // The first look says which stretches show.
        near.linearised(around, &unknowns);
        let (likelihood, mut gradient, mut information) = near.linearised(around, &unknowns);
        let mut posterior = likelihood + log_prior(&unknowns);
        for _ in 0..rounds {
            let slope = gradient - prior.off(&unknowns).component_mul(&precision);
            let mut curvature = information + Information::from_diagonal(&precision);
            for i in 0..UNKNOWNS {
                curvature[(i, i)] *= 1.0 + damping;
            }
            let Some(cholesky) = curvature.cholesky() else { break };
            let step = cholesky.solve(&slope);
            let far = (libm::hypot(step[FORWARD], step[LEFT]) / STEP[0])
                .max(step[HEADING].abs() / STEP[1])
                .max(1.0);
            // By the quadratic form that the step is the top of, before damping, it gains between half of this and all of it.
            if slope.dot(&step) < LEAST_GAIN {
                break;
            }
            let tried = unknowns + step / far;
            let (tried_likelihood, tried_gradient, tried_information) = near.linearised(around, &tried);
            let tried_posterior = tried_likelihood + log_prior(&tried);
            if tried_posterior <= posterior {
                damping *= 8.0;
                continue;
            }
            let gain = tried_posterior - posterior;
            (unknowns, gradient, information) = (tried, tried_gradient, tried_information);
            posterior = tried_posterior;
            damping *= 0.3;
            if is_known(&unknowns) {
                return None;
            }
            if edges_moved_m(&taken_at, &unknowns) > 0.5 * NEAR_M {
                near.take(ground, around, &unknowns, NEAR_M);
                taken_at = unknowns;
                let likelihood;
                (likelihood, gradient, information) = near.linearised(around, &unknowns);
                posterior = likelihood + log_prior(&unknowns);
            } else if gain < LEAST_GAIN {
                break;
            }
        }
        let curvature = information + Information::from_diagonal(&precision);
        let (covariance, log_determinant) = curvature.cholesky().map_or_else(
            || (Information::from_diagonal(&prior.sigma.map(|sigma| sigma * sigma)), 0.0),
            |cholesky| {
                let factor = cholesky.l();
                (cholesky.inverse(), (0..UNKNOWNS).map(|i| 2.0 * libm::log(factor[(i, i)])).sum())
            },
        );
        let prior_determinant: f64 = precision.iter().map(|precision| libm::log(*precision)).sum();
        let log_evidence = posterior - 0.5 * (log_determinant - prior_determinant);
        Some(Fit { damping, unknowns, covariance, log_evidence })
    }
}

/// About how far the edges lie apart with these unknowns, metres: at most half of the view from the node, on roads of 8 m.
fn edges_moved_m(a: &Unknowns, b: &Unknowns) -> f64 {
    let off = |i: usize| (a[i] - b[i]).abs();
    let place_m = off(FORWARD).max(off(LEFT)).max(8.0 * wrap_angle(off(HEADING)).abs());
    (0..MOST_ARMS).fold(place_m, |most_m, arm| {
        let corner_m = (libm::exp(a[CORNERS + arm]) - libm::exp(b[CORNERS + arm])).abs();
        most_m.max(4.0 * off(WIDTHS + arm)).max(0.5 * corner_m)
    })
}

impl Prior {
    fn off(&self, unknowns: &Unknowns) -> Unknowns {
        let mut off = unknowns - self.mean;
        off[HEADING] = wrap_angle(off[HEADING]);
        off
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::{Point2, Vector2};

    use super::super::ground_memory::{CELL_M, GroundCell};
    use super::super::junction_shape::tests::t_junction;
    use super::super::junction_shape::{JunctionShape, OFFSETS, PITCH, ROLL, SCALE};
    use super::super::likelihood::{INSET_ROWS, RowAngles, pose_of};
    use super::*;
    use crate::ground_view::Viewpoint;

    const VIEWPOINT: Viewpoint = Viewpoint { foot: Point2::new(1.5, 0.0), height_m: 1.4 };

    /// What is known before: the place to 3 m, the rest as usual; or all but the place exactly.
    fn prior(rest_sigma: f64) -> Prior {
        let (mut mean, mut sigma) = (Unknowns::zeros(), Unknowns::repeat(rest_sigma));
        mean[FORWARD] = 12.0;
        [sigma[FORWARD], sigma[LEFT], sigma[HEADING]] = [3.0, 2.0, 0.15];
        for arm in 0..MOST_ARMS {
            mean[CORNERS + arm] = libm::log(4.0_f64);
            (sigma[WIDTHS + arm], sigma[OFFSETS + arm]) = (0.16 * rest_sigma, 0.3 * rest_sigma);
        }
        (sigma[PITCH], sigma[ROLL], sigma[SCALE]) =
            (0.007 * rest_sigma, 0.007 * rest_sigma, 0.03 * rest_sigma);
        Prior { mean, sigma }
    }

    /// The ground about a junction with these unknowns, as a detector sees it that is sure.
    fn ground(truth: &Unknowns) -> Ground {
        ground_seen(truth, 0.0, 0.0)
    }

    /// The same by a detector whose reduced picture's rows span `row_rad`, which is believed to have rows of `believed_rad`.
    fn ground_seen(truth: &Unknowns, row_rad: f64, believed_rad: f64) -> Ground {
        let (shape, feature_from_vehicle) = (t_junction(), pose_of(truth).inverse());
        let outline = shape.outline(truth);
        let cells: Vec<GroundCell> = (0..64)
            .flat_map(|row| {
                // As the memory lists them: every second one each way in turns.
                (-40 + row % 2..40)
                    .step_by(2)
                    .map(move |column| Point2::new(4.0 + CELL_M * f64::from(row), CELL_M * f64::from(column)))
            })
            .map(|place| {
                let edge = outline.distance(feature_from_vehicle * place);
                let ahead_m = place.x - VIEWPOINT.foot.x;
                let inset_m =
                    INSET_ROWS * row_rad * (ahead_m * ahead_m / VIEWPOINT.height_m + VIEWPOINT.height_m);
                let is_road = edge.is_some_and(|edge| {
                    let across = (pose_of(truth).rotation * edge.by_place).x.abs();
                    edge.distance_m < -inset_m * across
                });
                let log_odds = if is_road { 2.0 } else { -2.5 };
                GroundCell { place, log_odds, trust: 0.6, seen_ahead_m: place.x - VIEWPOINT.foot.x }
            })
            .collect();
        let mut ground = Ground::default();
        ground.take(cells.chunks(2), VIEWPOINT, RowAngles { picture_rad: 0.0025, reduced_rad: believed_rad });
        ground
    }

    /// A feature far from all others.
    const fn alone(shape: &JunctionShape) -> Surroundings<'_> {
        Surroundings { shape, neighbours: [None; 2] }
    }

    /// What is most probable after thirty rounds from the prior's mean.
    fn fit(ground: &Ground, shape: &JunctionShape, prior: &Prior) -> Fit {
        let start = Start { rounds: 30, ..Start::new(prior.mean) };
        Fitter::default().fit(ground, &alone(shape), prior, &start, |_| false).unwrap()
    }

    fn truth(place: [f64; 3], radii_m: [f64; 3]) -> Unknowns {
        let mut truth = Unknowns::zeros();
        [truth[FORWARD], truth[LEFT], truth[HEADING]] = place;
        radii_m
            .into_iter()
            .enumerate()
            .for_each(|(arm, radius_m)| truth[CORNERS + arm] = libm::log(radius_m));
        truth
    }

    #[test]
    fn a_junction_is_found_whatever_its_corners_are() {
        let shape = t_junction();
        for (place, radii_m) in [
            ([13.2, 0.8, 0.05], [4.0, 4.0, 4.0]),
            ([11.0, -1.0, -0.06], [0.5, 8.0, 4.0]),
            ([12.5, 0.3, 0.0], [8.0, 1.0, 8.0]),
        ] {
            let truth = truth(place, radii_m);
            let prior = prior(1.0);
            let fit = fit(&ground(&truth), &shape, &prior);
            let off = fit.unknowns - truth;
            for (axis, most) in [(FORWARD, 0.5), (LEFT, 0.3), (HEADING, 0.03)] {
                let sigma = fit.covariance[(axis, axis)].sqrt();
                assert!(
                    off[axis].abs() < most && off[axis].abs() < 2.5 * sigma,
                    "{place:?} {axis}: {} of {sigma}",
                    off[axis]
                );
            }
        }
    }

    #[test]
    fn edges_that_are_seen_inside_the_road_make_it_no_narrower() {
        let (shape, truth) = (t_junction(), truth([12.0, 0.0, 0.0], [4.0; 3]));
        // Of the arms by their direction, the first and the last lie across the view.
        let widths = |believed_rad: f64| {
            let fit = fit(&ground_seen(&truth, 0.0075, believed_rad), &shape, &prior(1.0));
            [0, 1, 2].map(|arm| fit.unknowns[WIDTHS + arm])
        };
        let [side, approach, exit] = widths(0.0);
        assert!(side < -0.05 && exit < -0.05 && approach.abs() < 0.05, "{side} {approach} {exit}");
        let [side, approach, exit] = widths(0.0075);
        assert!([side, approach, exit].iter().all(|width| width.abs() < 0.05), "{side} {approach} {exit}");
    }

    #[test]
    fn with_all_else_given_the_place_is_surer() {
        let (shape, truth) = (t_junction(), truth([12.0, 0.0, 0.0], [4.0; 3]));
        let ground = ground(&truth);
        let sigma_m = |rest: f64| {
            let prior = prior(rest);
            fit(&ground, &shape, &prior).covariance[(FORWARD, FORWARD)].sqrt()
        };
        assert!(sigma_m(1e-3) < 0.5 * sigma_m(1.0), "{} {}", sigma_m(1e-3), sigma_m(1.0));
    }

    #[test]
    fn a_fit_that_runs_into_a_known_place_ends() {
        let (shape, truth) = (t_junction(), truth([13.0, 0.5, 0.0], [4.0; 3]));
        let (ground, prior) = (ground(&truth), prior(1.0));
        let is_known = |unknowns: &Unknowns| (unknowns[FORWARD] - truth[FORWARD]).abs() < 0.7;
        assert!(
            Fitter::default()
                .fit(&ground, &alone(&shape), &prior, &Start::new(prior.mean), is_known)
                .is_none()
        );
    }

    #[test]
    fn the_gradient_is_that_of_the_likelihood() {
        let (shape, truth) = (t_junction(), truth([12.0, 0.4, 0.02], [3.0, 5.0, 4.0]));
        let ground = ground(&truth);
        let mut at = truth;
        (at[FORWARD], at[LEFT], at[WIDTHS + 1], at[PITCH], at[SCALE]) = (12.2, 0.3, 0.05, 0.002, 0.01);
        let mut near = NearGround::default();
        near.take(&ground, &alone(&shape), &at, NEAR_M);
        near.linearised(&alone(&shape), &at);
        let (_, gradient, _) = near.linearised(&alone(&shape), &at);
        let step = 1e-5;
        for axis in [FORWARD, LEFT, HEADING, WIDTHS, WIDTHS + 1, OFFSETS + 2, CORNERS, PITCH, ROLL, SCALE] {
            let mut likelihood = |by: f64| {
                let mut moved = at;
                moved[axis] += by;
                near.linearised(&alone(&shape), &moved).0
            };
            let by = (likelihood(step) - likelihood(-step)) / (2.0 * step);
            assert!(
                (by - gradient[axis]).abs() < 0.03 * by.abs().max(1.0),
                "{axis}: {by} for {}",
                gradient[axis]
            );
        }
    }

    #[test]
    fn without_ground_the_prior_stands() {
        let shape = t_junction();
        let prior = prior(1.0);
        let empty = Ground::default();
        let fit = fit(&empty, &shape, &prior);
        assert!((fit.unknowns - prior.mean).norm() < 1e-9, "without ground the prior stands");
        assert!(fit.log_evidence.abs() < 1e-9, "and nothing speaks for or against it");
        let sigma_m = fit.covariance[(FORWARD, FORWARD)].sqrt();
        assert!((sigma_m - 3.0).abs() < 1e-9, "{sigma_m}");
        let moved = pose_of(&fit.unknowns).translation.vector - Vector2::new(12.0, 0.0);
        assert!(moved.norm() < 1e-9);
    }
}
