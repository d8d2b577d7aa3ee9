//! Features that are seen, and that are not.

use super::*;

#[test]
fn a_start_thirty_metres_off_is_mended_by_two_features() {
    for off_m in [-30.0, 30.0] {
        let mut progress = started(100.0 + off_m);
        let mut true_m = 100.0;
        let mut seen = Vec::new();
        for feature_m in [150.0, 240.0] {
            let forward_m = feature_m - 10.0 - true_m;
            drive(&mut progress, forward_m);
            true_m += forward_m;
            progress = look(&progress, feature_m, Some(10.0));
            assert_sound(&progress);
            seen.push(near(&progress, true_m));
        }
        assert!(seen[0] > 0.02, "possible after one: {seen:?}");
        assert!(seen[1] > 0.9, "{seen:?}");
    }
}

#[test]
fn a_feature_passed_unseen_moves_the_mass() {
    let mut progress = started(100.0);
    drive(&mut progress, 40.0);
    // It should be 20 m ahead, and there is nothing like it.
    let after = look(&progress, 160.0, None);
    assert_sound(&after);
    assert!(
        after.elsewhere() > 0.3 && near(&after, 140.0) > 0.2,
        "a wrong map is as likely as a wrong start"
    );
    // Where the belief is wide, the part that cannot have seen it yet is what remains.
    let mut wide = started(100.0);
    wide.advance(Travel::Unknown, 4.0);
    let seen_from_m = 140.0 - 40.0;
    let before = wide.mass_behind(seen_from_m + 20.0);
    let after = look(&wide, 160.0, None);
    assert!(after.mass_behind(seen_from_m + 20.0) < 0.6 * before);
}

#[test]
fn places_that_look_alike_are_kept_until_a_third_feature_tells() {
    let features_m = [100.0, 180.0, 300.0, 380.0];
    let both = |progress: &Progress, feature_m: f64, ahead_m| {
        let first = look(progress, feature_m, ahead_m);
        look(&first, feature_m + 80.0, ahead_m)
    };
    let mut progress = unknown();
    assert_eq!(progress.components().count(), 0);
    // A feature 10 m ahead: the first or the second of either pair.
    progress = both(&both(&progress, features_m[0], Some(10.0)), features_m[2], Some(10.0));
    let found: Vec<f64> = features_m.iter().map(|feature_m| near(&progress, feature_m - 10.0)).collect();
    for weight in &found {
        assert!((0.15..0.25).contains(weight), "four alike: {found:?}");
    }
    // The next one after 80 m: it was the first of a pair.
    drive(&mut progress, 80.0);
    progress = both(&both(&progress, features_m[0], Some(10.0)), features_m[2], Some(10.0));
    let found: Vec<f64> = [170.0, 370.0].iter().map(|route_m| near(&progress, *route_m)).collect();
    for weight in &found {
        assert!((0.4..0.5).contains(weight), "two alike: {found:?}");
    }
    // Another after 120 m: there is one only beyond the first pair.
    drive(&mut progress, 120.0);
    progress = look(&progress, features_m[2], Some(10.0));
    assert!(near(&progress, 290.0) > 0.95);
}

#[test]
fn what_is_seen_twice_is_conditioned_on_afresh() {
    let mut before = started(100.0);
    drive(&mut before, 30.0);
    let once = look(&before, 140.0, Some(11.0));
    assert_eq!(format!("{:?}", look(&before, 140.0, Some(11.0))), format!("{once:?}"), "same bytes");
    let (mean_m, sigma_m) = once.moments_m();
    assert!((mean_m - 129.0).abs() < 0.2 && (0.5..0.8).contains(&sigma_m), "{mean_m} {sigma_m}");
}

#[test]
fn features_teach_the_scale() {
    let mut progress = started(0.0);
    let mut true_m = 0.0;
    // Every half metre is in truth 0.52 m.
    for feature_m in [104.0, 208.0, 312.0, 416.0, 520.0] {
        drive(&mut progress, 100.0);
        true_m += 104.0;
        progress = look(&progress, feature_m + 10.0, Some(feature_m + 10.0 - true_m));
    }
    let (mean, sigma) = progress.scale_error();
    assert!((mean - 0.04).abs() < 2.0 * sigma && sigma < 0.01, "{mean} {sigma}");
}

#[test]
fn the_belief_that_expects_what_is_seen_has_the_more_evidence() {
    // A side road 20 m ahead, by a progress between the features before and behind it and by one that lies elsewhere.
    let between = |from_m: f64, to_m: f64| Progress::between(&config(), [from_m, to_m], ROUTE_M);
    let (here, elsewhere) = (between(400.0, 500.0), between(900.0, 1000.0));
    assert!(here.probability_between(395.0, 505.0) > 0.99);
    assert!(here.log_evidence().abs() < 1e-9, "{}", here.log_evidence());
    let evidence = |progress: &Progress| look(progress, 450.0, Some(20.0)).log_evidence();
    assert!(evidence(&here) > 2.0, "{}", evidence(&here));
    assert!(evidence(&elsewhere).abs() < 0.1, "{}", evidence(&elsewhere));
    // Nothing seen where it must be speaks against it.
    assert!(look(&started(430.0), 450.0, None).log_evidence() < -2.0);
}
