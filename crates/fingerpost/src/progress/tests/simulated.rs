//! Whole drives with features, wrong maps and look-alikes: are the errors as large as the belief says?

use super::*;

/// How the scale error goes over a drive.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Scale {
    Constant,
    Changing,
}

/// Squared errors over their variances.
#[derive(Default)]
struct Squares(Vec<f64>);

impl Squares {
    fn mean(&self) -> f64 {
        self.0.iter().sum::<f64>() / self.0.len() as f64
    }

    fn beyond(&self, sigmas: f64) -> f64 {
        self.0.iter().filter(|&&square| square > sigmas * sigmas).count() as f64 / self.0.len() as f64
    }
}

#[derive(Default)]
struct Drive {
    /// Of the progress, as a feature is about to be seen.
    before: Squares,
    /// Of the progress, once it was.
    after: Squares,
    /// Of the scale error, once it was.
    scale: Squares,
    sigma_m: Vec<f64>,
    scale_sigma: f64,
}

/// A drive of 1800 m past features 60 to 120 m apart, of which one in fifty does not exist and one in five has a look-alike.
fn drive_past_features(seed: u64, course: Scale, drive: &mut Drive) {
    let mut numbers = Numbers(seed);
    let mut true_m = 20.0;
    let mut progress = started(true_m + config().start_sigma_m * numbers.normal());
    let mut scale_error = config().drift_share * numbers.normal();
    let mut feature_m = 60.0;
    while true_m < 1800.0 {
        let forward_m = 0.5;
        true_m += forward_m;
        if course == Scale::Changing {
            let kept = libm::exp(-forward_m / 2000.0_f64);
            scale_error =
                kept * scale_error + config().drift_share * (1.0 - kept * kept).sqrt() * numbers.normal();
        }
        let noise_m = 0.02 * numbers.normal();
        let measured_m = forward_m / (1.0 + scale_error) + noise_m;
        progress.advance(Travel::Measured { forward_m: measured_m, sigma_m: 0.02 }, 0.05);
        if feature_m - true_m > 10.0 {
            continue;
        }
        let square = |progress: &Progress| {
            let (mean_m, sigma_m) = progress.moments_m();
            ((mean_m - true_m) / sigma_m).powi(2)
        };
        drive.before.0.push(square(&progress));
        drive.sigma_m.push(progress.moments_m().1);
        let mut places = Vec::new();
        if numbers.uniform() > 0.02 {
            let ahead_m = feature_m - true_m + 0.7 * numbers.normal();
            places.push(FeaturePlace { likelihood: 300.0, ahead_m, sigma_m: 0.7 });
        }
        if numbers.uniform() < 0.2 {
            let ahead_m = numbers.between(3.0, 40.0);
            places.push(FeaturePlace { likelihood: 10.0, ahead_m, sigma_m: 0.7 });
        }
        let looked_for_m = Some([-20.0, 40.0]);
        let outcome =
            FeatureOutcome { places: &places, looked_for_m, map_wrong_share: 0.02, log_excess: 0.0 };
        progress = progress.conditioned(feature_m, &outcome);
        assert_sound(&progress);
        drive.after.0.push(square(&progress));
        let (mean, sigma) = progress.scale_error();
        drive.scale.0.push(((mean - scale_error) / sigma).powi(2));
        drive.scale_sigma = sigma;
        feature_m += numbers.between(60.0, 120.0);
    }
}

/// Bounds of the mean of squared errors over their variances: a scale that does not change is known better than is believed, as
/// the belief allows for one that does.
#[test]
fn errors_are_as_large_as_the_belief_says() {
    for (course, least, least_scale) in [(Scale::Changing, 0.85, 0.85), (Scale::Constant, 0.5, 0.3)] {
        let mut drive = Drive::default();
        (0..200).for_each(|seed| drive_past_features(1 + seed, course, &mut drive));
        let Drive { before, after, scale, sigma_m, scale_sigma } = &mut drive;
        for (name, squares, least) in
            [("before", before, least), ("after", after, least), ("scale", scale, least_scale)]
        {
            let (mean, beyond) = (squares.mean(), squares.beyond(3.0));
            assert!((least..1.15).contains(&mean), "{course:?}, {name} a feature: {mean}");
            // A Gaussian has 0.27 % beyond three.
            assert!(beyond < 0.006, "{course:?}, {name} a feature: {beyond}");
        }
        sigma_m.sort_by(f64::total_cmp);
        let median_m = sigma_m.get(sigma_m.len() / 2).copied().unwrap_or(f64::NAN);
        assert!(median_m < 1.7, "what is believed is of use before a feature: {median_m}");
        assert!(*scale_sigma < 0.4 * config().drift_share, "and the scale is learnt: {scale_sigma}");
    }
}
