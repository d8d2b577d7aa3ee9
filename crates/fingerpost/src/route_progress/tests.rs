//! The progress of a route by its start, features and GPS.

use super::*;

fn route() -> Polyline {
    Polyline::new([Point2::new(0.0, 0.0), Point2::new(100.0, 0.0), Point2::new(100.0, 100.0)]).unwrap()
}

#[test]
fn dead_reckoning_grows_unsure_and_a_feature_ends_it() {
    let mut progress = RouteProgress::new(&RouteProgressConfig::default(), Some(10.0));
    for _ in 0..100 {
        progress.advance(Travel::Measured { forward_m: 1.0, sigma_m: 0.0 }, 0.1);
    }
    let (mean, sigma) = progress.belief_m().unwrap();
    assert!((mean - 110.0).abs() < 1e-9 && (sigma - 6.0).abs() < 1e-6, "{mean} {sigma}");
    progress.observe(105.0, 0.4);
    assert!((progress.belief_m().unwrap().0 - 105.0).abs() < 1e-9);
}

#[test]
fn a_way_that_is_not_known_is_any_that_a_vehicle_can_have_driven() {
    let driven = |travel: Travel| {
        let mut progress = RouteProgress::new(&RouteProgressConfig::default(), Some(10.0));
        for _ in 0..10 {
            progress.advance(Travel::Measured { forward_m: 0.8, sigma_m: 0.01 }, 0.1);
        }
        let (before_m, before_sigma_m) = progress.belief_m().unwrap();
        for _ in 0..20 {
            progress.advance(travel, 0.1);
        }
        let (mean_m, sigma_m) = progress.belief_m().unwrap();
        (mean_m - before_m, sigma_m - before_sigma_m, progress.at_least_m())
    };
    // At 8 m/s: 4 m to a stand, or 23 m with 4 m/s² up to 50 km/h.
    let (mean_m, added_m, at_least_m) = driven(Travel::Unknown);
    let ([least_m, most_m], uniform) = ([4.0, 23.0], 12_f64.sqrt());
    assert!((mean_m - 0.5 * (least_m + most_m)).abs() < 1.0, "{mean_m}");
    assert!((added_m - (most_m - least_m) / uniform).abs() < 1.0, "{added_m}");
    assert!(at_least_m < 18.0 + least_m, "{at_least_m}");
    let (mean_m, added_m, _) = driven(Travel::Speed { forward_mps: 8.0, sigma_mps: 0.26 });
    assert!((mean_m - 16.0).abs() < 1e-9 && (added_m - 0.52).abs() < 1e-9, "{mean_m} {added_m}");
    let (mean_m, added_m, _) = driven(Travel::Measured { forward_m: 0.0, sigma_m: 0.0 });
    assert!(mean_m.abs() < 1e-9 && added_m.abs() < 1e-9, "a stand is known");
}

#[test]
fn a_feature_that_is_not_where_it_was_expected_leaves_a_doubt_that_the_next_one_ends() {
    let start = || RouteProgress::new(&RouteProgressConfig::default(), Some(10.0));
    let sigma_m = 0.4;
    let means = |progress: &RouteProgress| progress.beliefs_m().map(|(mean, _)| mean).collect::<Vec<_>>();
    let mut progress = start();
    progress.observe_found(30.0, 13.0, sigma_m);
    assert_eq!(means(&progress), [13.0], "within what was expected");

    let surprised = || {
        let mut progress = start();
        progress.observe_found(30.0, 18.0, sigma_m);
        progress.observe(18.1, sigma_m);
        progress.advance(Travel::Measured { forward_m: 20.0, sigma_m: 0.0 }, 0.1);
        progress
    };
    assert_eq!(means(&surprised()), [38.1, 30.0]);
    assert!(surprised().at_least_m() < 30.0 - 9.0, "neither is given up");
    for (next_m, believed) in [(38.3, vec![38.3]), (30.5, vec![30.5]), (50.0, vec![50.0, 38.1])] {
        let mut progress = surprised();
        progress.observe_found(60.0, next_m, sigma_m);
        assert_eq!(means(&progress), believed);
    }
    let mut lost_and_found = surprised();
    lost_and_found.observe_found(30.0, 38.2, sigma_m);
    assert_eq!(means(&lost_and_found), [38.2, 30.0], "the same feature again proves nothing");
    let mut with_gps = surprised();
    with_gps.observe_gps(&route(), Point2::new(62.0, 0.0));
    let left = means(&with_gps);
    assert!(
        left.iter().all(|mean| *mean > 38.0),
        "a position that contradicts the doubt alone ends it: {left:?}"
    );
}

#[test]
fn gps_places_a_vehicle_that_knew_nothing() {
    let mut progress = RouteProgress::new(&RouteProgressConfig::default(), None);
    assert!(progress.belief_m().is_none());
    let used = progress.observe_gps(&route(), Point2::new(60.0, 3.0));
    assert!(matches!(used, GpsUse::Accepted { .. }));
    assert!((progress.belief_m().unwrap().0 - 60.0).abs() < 0.1);
    let far = progress.observe_gps(&route(), Point2::new(60.0, -80.0));
    assert_eq!(far, GpsUse::OffRoute { distance_m: 80.0 });
}

#[test]
fn without_a_start_the_distance_driven_is_the_least() {
    let mut progress = RouteProgress::new(&RouteProgressConfig::default(), None);
    progress.advance(Travel::Measured { forward_m: 40.0, sigma_m: 0.0 }, 0.1);
    assert!((progress.at_least_m() - 36.4).abs() < 1e-9);
}

/// A drive of 400 m at 8 m/s with a fix each second, `off_m` off by the time since the start.
fn drive(start_m: f64, off_m: impl Fn(f64) -> f64) -> RouteProgress {
    let straight = Polyline::new([Point2::new(0.0, 0.0), Point2::new(1000.0, 0.0)]).unwrap();
    let mut progress = RouteProgress::new(&RouteProgressConfig::default(), Some(start_m));
    for second in 1..=50 {
        for _ in 0..10 {
            progress.elapse(0.1);
            progress.advance(Travel::Measured { forward_m: 0.8, sigma_m: 0.0 }, 0.1);
        }
        let t_s = f64::from(second);
        progress.observe_gps(&straight, Point2::new(8.0 * t_s + off_m(t_s), 1.0));
    }
    progress
}

fn holds(progress: &RouteProgress, route_m: f64) -> bool {
    progress.beliefs_m().any(|(mean_m, sigma_m)| (route_m - mean_m).abs() < 2.0 * sigma_m)
}

#[test]
fn a_receiver_that_is_off_leaves_the_true_place_possible() {
    let stands = |t_s: f64| if t_s > 15.0 { 8.0 * (15.0 - t_s) } else { 0.0 };
    let jumps = |t_s: f64| if (20.0..30.0).contains(&t_s) { 100.0 } else { 0.0 };
    let offs: [&dyn Fn(f64) -> f64; 7] =
        [&|_| 15.0, &|_| -15.0, &|_| 36.0, &|t_s| t_s, &|t_s| -t_s, &stands, &jumps];
    for (case, off_m) in offs.iter().enumerate() {
        let progress = drive(0.0, off_m);
        assert!(holds(&progress, 400.0), "{case}: {:?}", progress.beliefs_m().collect::<Vec<_>>());
        assert!(progress.at_least_m() < 400.0, "{case}: a feature here is not passed over");
    }
}

#[test]
fn a_start_that_is_wrong_leaves_the_place_by_gps_possible() {
    for start_m in [-12.0, 20.0, 60.0, -60.0] {
        let progress = drive(start_m, |_| 0.0);
        assert!(holds(&progress, 400.0), "{start_m}: {:?}", progress.beliefs_m().collect::<Vec<_>>());
    }
}

#[test]
fn fixes_that_err_alike_are_not_many_witnesses() {
    let sound = drive(0.0, |_| 0.0);
    let (mean_m, sigma_m) = sound.belief_m().unwrap();
    assert!((mean_m - 400.0).abs() < 0.5 && sigma_m > 4.0, "{mean_m} {sigma_m}");
    assert_eq!(sound.beliefs_m().count(), 1, "nothing is in doubt");
}

#[test]
fn a_feature_says_how_far_gps_is_off() {
    let mut progress = drive(0.0, |_| 15.0);
    progress.observe_found(420.0, 400.0, 0.4);
    let straight = Polyline::new([Point2::new(0.0, 0.0), Point2::new(1000.0, 0.0)]).unwrap();
    for second in 1..=5 {
        progress.elapse(1.0);
        progress.advance(Travel::Measured { forward_m: 8.0, sigma_m: 0.0 }, 0.1);
        progress.observe_gps(&straight, Point2::new(415.0 + 8.0 * f64::from(second), 1.0));
    }
    let (mean_m, sigma_m) = progress.belief_m().unwrap();
    assert!((mean_m - 440.0).abs() < 1.0 && sigma_m < 2.5, "{mean_m} {sigma_m}");
}
