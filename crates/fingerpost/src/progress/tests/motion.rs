//! Motion that is measured, told by the bus, unknown or absurd.

use super::*;

#[test]
fn a_gap_leaves_the_truth_within_what_is_believed() {
    // Goes on, brakes to a stop, or speeds up, while nothing is known for five seconds.
    for true_m in [50.0, 10.0, 65.0] {
        let mut progress = started(100.0);
        drive(&mut progress, 20.0);
        for _ in 0..50 {
            progress.advance(Travel::Unknown, 0.1);
        }
        let (mean_m, sigma_m) = progress.moments_m();
        assert!((mean_m - 120.0 - true_m).abs() < 2.0 * sigma_m, "{mean_m} {sigma_m}");
        assert!(sigma_m < 25.0, "{sigma_m}");
    }
}

#[test]
fn a_gap_is_as_long_however_often_it_is_told() {
    let gap = |steps: u32| {
        let mut progress = started(100.0);
        drive(&mut progress, 20.0);
        (0..steps).for_each(|_| progress.advance(Travel::Unknown, 8.0 / f64::from(steps)));
        progress.moments_m()
    };
    let ((once_m, once_sigma_m), (often_m, often_sigma_m)) = (gap(1), gap(160));
    assert!((once_m - often_m).abs() < 0.1, "{once_m} {often_m}");
    assert!(
        often_sigma_m > 0.99 * once_sigma_m && often_sigma_m < 1.2 * once_sigma_m,
        "{once_sigma_m} {often_sigma_m}"
    );
}

#[test]
fn one_lost_frame_costs_little() {
    let mut progress = started(100.0);
    drive(&mut progress, 20.0);
    let (before_m, before_sigma_m) = progress.moments_m();
    progress.advance(Travel::Unknown, 0.05);
    let (mean_m, sigma_m) = progress.moments_m();
    assert!((mean_m - before_m - 0.5).abs() < 0.1, "{mean_m} {before_m}");
    assert!(sigma_m - before_sigma_m < 0.05, "{sigma_m} {before_sigma_m}");
}

#[test]
fn the_scale_makes_unsure_in_proportion_to_the_distance() {
    let mut progress = started(10.0);
    drive(&mut progress, 100.0);
    let (mean_m, sigma_m) = progress.moments_m();
    assert!((mean_m - 110.0).abs() < 0.01, "{mean_m}");
    // A start of 3 m and 3 % of 100 m.
    assert!((sigma_m - 18.0_f64.sqrt()).abs() < 0.1, "{sigma_m}");
}

#[test]
fn a_speed_from_the_bus_errs_in_one_direction() {
    let mut progress = started(10.0);
    for _ in 0..200 {
        progress.advance(Travel::Speed { forward_mps: 10.0, sigma_mps: 0.3 }, 0.05);
    }
    let (mean_m, sigma_m) = progress.moments_m();
    assert!((mean_m - 110.0).abs() < 1e-6, "{mean_m}");
    assert!((3.0..6.01).contains(&sigma_m), "{sigma_m}");
}

#[test]
fn standing_makes_neither_surer_nor_less_sure() {
    let mut progress = started(10.0);
    drive(&mut progress, 50.0);
    let before = progress.moments_m();
    for _ in 0..10_000 {
        progress.advance(Travel::Measured { forward_m: 0.0, sigma_m: 0.0 }, 0.1);
    }
    let after = progress.moments_m();
    assert!((after.0 - before.0).abs() < 1e-6 && (after.1 - before.1).abs() < 1e-6, "{before:?} {after:?}");
}

#[test]
fn without_a_start_what_was_driven_lies_behind() {
    let mut progress = unknown();
    let (mean_m, sigma_m) = progress.moments_m();
    assert!((mean_m - 0.5 * ROUTE_M).abs() < 10.0 && (sigma_m - ROUTE_M / 12.0_f64.sqrt()).abs() < 10.0);
    drive(&mut progress, 400.0);
    assert!(progress.probability_between(0.0, 350.0) < 0.01);
    assert!((progress.probability_between(400.0, 1200.0) - 0.5).abs() < 0.02);
    drive(&mut progress, 3.0 * ROUTE_M);
    assert_sound(&progress);
}

#[test]
fn absurd_input_changes_nothing_or_is_a_gap() {
    let mut progress = started(100.0);
    drive(&mut progress, 50.0);
    let before = format!("{progress:?}");
    for dt_s in [f64::NAN, -1.0, 0.0, f64::NEG_INFINITY] {
        progress.advance(Travel::Measured { forward_m: 1.0, sigma_m: 0.1 }, dt_s);
    }
    assert_eq!(format!("{progress:?}"), before, "no time, no news");
    for travel in [
        Travel::Measured { forward_m: f64::NAN, sigma_m: 0.1 },
        Travel::Measured { forward_m: 1.0, sigma_m: f64::NAN },
        Travel::Measured { forward_m: 1e300, sigma_m: 1e300 },
        Travel::Speed { forward_mps: f64::INFINITY, sigma_mps: 0.1 },
    ] {
        let mut faulty = progress.clone();
        faulty.advance(travel, 0.1);
        let mut gap = progress.clone();
        gap.advance(Travel::Unknown, 0.1);
        assert_eq!(format!("{faulty:?}"), format!("{gap:?}"), "{travel:?}");
    }
    for dt_s in [1e-300, 1e9, f64::INFINITY, f64::MAX] {
        progress.advance(Travel::Unknown, dt_s);
        assert_sound(&progress);
        progress.advance(Travel::Measured { forward_m: -30.0, sigma_m: 0.0 }, dt_s);
        assert_sound(&progress);
    }
    for (start_m, route_m) in [(f64::NAN, 100.0), (0.0, f64::NAN), (-1e12, 0.0), (1e12, -5.0)] {
        let mut odd = Progress::new(&config(), Some(start_m), route_m);
        drive(&mut odd, 100.0);
        assert_sound(&look(&odd, 50.0, Some(10.0)));
        assert_sound(&odd.conditioned(
            f64::NAN,
            &FeatureOutcome { places: &[], looked_for_m: None, map_wrong_share: 0.02, log_excess: 0.0 },
        ));
    }
}

#[test]
fn absurd_features_leave_sound_numbers() {
    let progress = started(100.0);
    let odd = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 0.0, -1.0, 1e-300, 1e300];
    for likelihood in odd {
        for ahead_m in odd {
            for sigma_m in odd {
                let places = [FeaturePlace { likelihood, ahead_m, sigma_m }; 3];
                for bound in odd {
                    let looked_for_m = Some([bound, 40.0]);
                    let outcome = FeatureOutcome {
                        places: &places,
                        looked_for_m,
                        map_wrong_share: bound,
                        log_excess: 0.0,
                    };
                    assert_sound(&progress.conditioned(110.0, &outcome));
                }
            }
        }
    }
}

#[test]
fn a_route_of_twenty_kilometres_is_held_like_a_short_one() {
    let mut progress = Progress::new(&config(), None, 20_000.0);
    drive(&mut progress, 5_000.0);
    assert_sound(&progress);
    progress = look(&progress, 12_000.0, Some(10.0));
    assert!(near(&progress, 11_990.0) > 0.05, "{}", near(&progress, 11_990.0));
    drive(&mut progress, 90.0);
    progress = look(&progress, 12_090.0, Some(10.0));
    assert!(near(&progress, 12_080.0) > 0.9, "{}", near(&progress, 12_080.0));
}

#[test]
fn no_call_allocates() {
    let route = fingerpost_geometry::Polyline::new(
        [(0.0, 0.0), (900.0, 0.0), (900.0, 900.0)].map(|(x, y)| nalgebra::Point2::new(x, y)),
    )
    .unwrap();
    let mut progress = unknown();
    let allocated = allocation_counter::measure(|| {
        for step in 0..200 {
            let travelled_m = 5.0 * f64::from(step);
            progress.advance(Travel::Measured { forward_m: 5.0, sigma_m: 0.1 }, 0.5);
            progress.observe_gps(&route, nalgebra::Point2::new(travelled_m.min(900.0), 3.0));
            for feature_m in [200.0, 280.0, 400.0, 520.0] {
                progress = look(&progress, feature_m, Some(10.0));
            }
        }
    });
    assert_eq!(allocated.count_total, 0);
    assert_sound(&progress);
}
