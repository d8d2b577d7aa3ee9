//! Receivers that are off, late, frozen or jump.

use fingerpost_geometry::Polyline;
use nalgebra::Point2;

use super::*;

fn straight() -> Polyline {
    Polyline::new([Point2::new(0.0, 0.0), Point2::new(ROUTE_M, 0.0)]).unwrap()
}

/// Out along a road and back on it, 8 m beside.
fn there_and_back() -> Polyline {
    let points = [(0.0, 0.0), (900.0, 0.0), (900.0, 8.0), (0.0, 8.0)];
    Polyline::new(points.map(|(x, y)| Point2::new(x, y))).unwrap()
}

/// Drives 200 s at 10 m/s or less with a fix each second that is `off_m` off, and white noise of a metre.
fn drive_with_gps(progress: &mut Progress, seed: u64, mps: f64, off_m: f64) -> f64 {
    let (route, mut numbers, mut true_m) = (straight(), Numbers(seed), 100.0);
    for _ in 0..200 {
        for _ in 0..10 {
            progress.advance(Travel::Measured { forward_m: 0.1 * mps, sigma_m: 0.01 }, 0.1);
            true_m += 0.1 * mps;
        }
        let fix_m = true_m + off_m + numbers.normal();
        progress.observe_gps(&route, Point2::new(fix_m, 2.0 + numbers.normal()));
        assert_sound(progress);
    }
    true_m
}

#[test]
fn many_fixes_make_no_surer_than_the_slow_error_allows() {
    for (off_m, mps) in [(0.0, 9.0), (36.0, 9.0), (-18.0, 9.0), (5.0, 1.5)] {
        let mut progress = unknown();
        let true_m = drive_with_gps(&mut progress, 7, mps, off_m);
        let (mean_m, sigma_m) = progress.moments_m();
        assert!(sigma_m > 3.5, "{off_m}: {sigma_m}");
        assert!((mean_m - true_m - off_m).abs() < 3.0, "{off_m}: {mean_m} {true_m}");
    }
}

#[test]
fn a_start_is_not_given_up_for_a_receiver_that_is_off() {
    for off_m in [36.0, -36.0] {
        let mut progress = started(100.0);
        let true_m = drive_with_gps(&mut progress, 3, 1.0, off_m);
        assert!(
            progress.probability_between(true_m - 15.0, true_m + 15.0) > 0.5,
            "{:?}",
            progress.components().collect::<Vec<_>>()
        );
        assert_eq!(progress.gps_jumps(), 1);
    }
}

#[test]
fn the_same_fix_a_thousand_times_does_not_make_sure() {
    let route = straight();
    let mut progress = unknown();
    let fix = Point2::new(500.0, 1.0);
    assert_eq!(progress.observe_gps(&route, fix), GpsUse::Accepted { innovation_m: 0.0 });
    let once = progress.moments_m();
    assert!((once.0 - 500.0).abs() < 0.5 && (5.0..7.0).contains(&once.1), "{once:?}");
    for _ in 0..1000 {
        progress.advance(Travel::Measured { forward_m: 0.0, sigma_m: 0.001 }, 1.0);
        assert_eq!(progress.observe_gps(&route, fix), GpsUse::NothingNew);
    }
    assert!(progress.moments_m().1 > once.1 - 1e-6);
    // Nor does a receiver that is frozen while the vehicle drives hold it.
    for _ in 0..100 {
        drive(&mut progress, 10.0);
        assert_eq!(progress.observe_gps(&route, fix), GpsUse::NothingNew);
    }
    assert!((progress.moments_m().0 - 1500.0).abs() < 1.0);
}

#[test]
fn a_jump_is_counted_and_moves_little() {
    let route = straight();
    let mut progress = started(100.0);
    for second in 1..=20 {
        drive(&mut progress, 10.0);
        progress.observe_gps(&route, Point2::new(100.0 + 10.0 * f64::from(second), 1.0));
    }
    assert_eq!(progress.gps_jumps(), 0);
    for second in 21..=25 {
        drive(&mut progress, 10.0);
        progress.observe_gps(&route, Point2::new(190.0 + 10.0 * f64::from(second), 1.0));
    }
    assert_eq!(progress.gps_jumps(), 1);
    assert!(near(&progress, 350.0) > 0.3 && progress.probability_between(340.0, 360.0) > 0.7);
    let far = progress.observe_gps(&route, Point2::new(300.0, 80.0));
    assert_eq!(far, GpsUse::NothingNew, "not moved");
    drive(&mut progress, 10.0);
    assert_eq!(progress.observe_gps(&route, Point2::new(300.0, 80.0)), GpsUse::OffRoute { distance_m: 80.0 });
    assert_eq!(progress.observe_gps(&route, Point2::new(f64::NAN, 0.0)), GpsUse::NothingNew);
}

#[test]
fn both_passes_of_the_same_place_are_kept() {
    let route = there_and_back();
    let mut progress = Progress::new(&config(), None, route.length_m());
    progress.observe_gps(&route, Point2::new(300.0, 5.0));
    let (out, back) =
        (progress.probability_between(280.0, 320.0), progress.probability_between(1488.0, 1528.0));
    assert!(out > 0.2 && back > 0.2 && out + back > 0.95, "{out} {back}");
    // Driving on tells them apart.
    drive(&mut progress, 60.0);
    progress.observe_gps(&route, Point2::new(362.0, 5.0));
    assert!(progress.probability_between(340.0, 380.0) > 0.9);
    // A vehicle that knows where it is stays on its pass, even where the other is nearer.
    let mut known = Progress::new(&config(), Some(300.0), route.length_m());
    for fix in 1..30 {
        drive(&mut known, 10.0);
        known.observe_gps(&route, Point2::new(300.0 + 10.0 * f64::from(fix), 9.0));
    }
    assert!(known.probability_between(580.0, 600.0) > 0.9);
}

#[test]
fn a_feature_tells_how_far_gps_is_off() {
    let route = straight();
    let mut progress = started(100.0);
    let mut true_m = 100.0;
    for feature_m in [200.0, 300.0, 400.0] {
        for _ in 0..9 {
            drive(&mut progress, 10.0);
            true_m += 10.0;
            progress.observe_gps(&route, Point2::new(true_m + 10.0, 1.0));
        }
        drive(&mut progress, feature_m - 10.0 - true_m);
        true_m = feature_m - 10.0;
        progress = look(&progress, feature_m, Some(10.0));
    }
    for _ in 0..5 {
        drive(&mut progress, 10.0);
        true_m += 10.0;
        progress.observe_gps(&route, Point2::new(true_m + 10.0, 1.0));
    }
    let (mean_m, sigma_m) = progress.moments_m();
    assert!((mean_m - true_m).abs() < 1.5 && sigma_m < 2.5, "{} {sigma_m}", mean_m - true_m);
}

#[test]
fn errors_with_gps_are_as_large_as_the_belief_says() {
    let (route, mut squares) = (straight(), Vec::new());
    for seed in 0..200 {
        let mut numbers = Numbers(500 + seed);
        let mut progress = unknown();
        let scale_error = config().drift_share * numbers.normal();
        let slow_m = progress.noise.gps_slow_m;
        let (mut true_m, mut error_m) = (100.0, slow_m * numbers.normal());
        for second in 1..=150 {
            let forward_m = 10.0 / (1.0 + scale_error);
            progress.advance(Travel::Measured { forward_m, sigma_m: 0.05 }, 1.0);
            true_m += 10.0;
            let kept = libm::exp(-1.0_f64 / 100.0);
            error_m = kept * error_m + slow_m * (1.0 - kept * kept).sqrt() * numbers.normal();
            let fix_m = true_m + error_m + progress.noise.gps_white_m * numbers.normal();
            progress.observe_gps(&route, Point2::new(fix_m, 2.0));
            if second % 50 == 0 {
                let (mean_m, sigma_m) = progress.moments_m();
                squares.push(((mean_m - true_m) / sigma_m).powi(2));
            }
        }
    }
    let mean = squares.iter().sum::<f64>() / squares.len() as f64;
    assert!((0.75..1.25).contains(&mean), "{mean}");
}
