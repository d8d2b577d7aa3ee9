//! Many drives in numbers.
#![allow(clippy::unwrap_used, reason = "a failed expectation is a failed test")]

use fingerpost_eval::{
    CampaignTally, Claim, ClaimError, DriveClaims, EdgeScene, RoadEdgeScores, error_quantiles,
};
use fingerpost_format::{CampaignDrive, TruthSummary};

/// A place of the route's first feature that is off by so much.
fn claim(distance_m: f64) -> Claim {
    Claim { place: Some(0), error: Some(ClaimError { distance_m, per_sigma: [1.0; 2] }), present: None }
}

/// A drive past four features whose position errors are `errors_m`.
fn drive(seed: u64, conditions: &str, detected: u64, errors_m: &[f64]) -> (CampaignDrive, DriveClaims) {
    let truth = TruthSummary {
        features_total: 4,
        features_detected: detected,
        arrivals: detected,
        position_error_m: error_quantiles(errors_m.iter().copied()),
        motion_error_pct: Some(seed as f64),
        ..TruthSummary::default()
    };
    (
        CampaignDrive { seed, conditions: conditions.to_owned(), truth, ..CampaignDrive::default() },
        DriveClaims {
            claims: errors_m.iter().map(|&error_m| claim(error_m)).collect(),
            ..DriveClaims::default()
        },
    )
}

/// Two edges in each of nine sections, 3 m aside, and a surface that goes so far.
fn edges(surface_m: f64) -> RoadEdgeScores {
    let mut scores = RoadEdgeScores::default();
    scores.add(&EdgeScene {
        is_road: |[_, left_m]: [f64; 2]| left_m.abs() < 3.0,
        is_shown: |_: [f64; 2]| true,
        probability: |[_, left_m]: [f64; 2]| Some(if left_m.abs() < surface_m { 1.0 } else { 0.0 }),
    });
    scores
}

fn names() -> Vec<String> {
    ["wet", "dusk", "dust"].map(str::to_owned).to_vec()
}

#[test]
fn sums_and_quantiles_are_over_the_frames_of_all_drives() {
    let mut tally = CampaignTally::new(&names(), 4);
    let few = drive(2, "dusk", 4, &[9.0]);
    let many = drive(1, "wet", 3, &[0.1; 99]);
    let failed = CampaignDrive { error: Some("no route".to_owned()), ..drive(3, "wet", 4, &[]).0 };
    for (drive, claims) in [few, many, (failed, DriveClaims::default())] {
        tally.add(drive, claims);
    }
    let campaign = tally.campaign();
    assert!(campaign.interrupted, "three of four are done");
    let total = &campaign.total;
    assert_eq!((total.drives, total.drives_failed), (3, 1));
    assert_eq!((total.features_total, total.features_detected, total.arrivals), (8, 7, 7));
    assert!((total.found_share.unwrap() - 7.0 / 8.0).abs() < 1e-9);
    assert_eq!(total.false_share, Some(0.0));
    let error_m = total.position_error_m.unwrap();
    assert!(error_m.p95 < 0.2 && error_m.max > 8.0, "one bad frame of a hundred: {error_m:?}");
    assert!((total.motion_error_pct.unwrap().max - 2.0).abs() < 1e-9);
    let groups: Vec<_> = campaign.conditions.iter().map(|group| group.conditions.as_deref()).collect();
    assert_eq!(groups, [Some("wet"), Some("dusk")], "no drive was in dust");
    assert_eq!(campaign.conditions[0].features_total, 4);
    assert_eq!(
        (campaign.worst[0].seed, campaign.worst[0].missed),
        (1, 1),
        "a miss weighs more than an error"
    );
    assert_eq!(campaign.worst[1].seed, 2);
}

#[test]
fn edges_are_counted_over_the_drives_that_have_some() {
    let mut tally = CampaignTally::new(&names(), 3);
    for (seed, conditions, surface_m) in [(1, "wet", 3.0), (2, "dusk", 4.0)] {
        let (drive, claims) = drive(seed, conditions, 4, &[0.2]);
        tally.add(drive, DriveClaims { road_edges: edges(surface_m), ..claims });
    }
    let (none, claims) = drive(3, "dust", 4, &[0.2]);
    tally.add(none, claims);
    let campaign = tally.campaign();
    let total = campaign.total.road_edges.unwrap();
    assert_eq!((total.edges, total.missed), (36, 0));
    assert!((total.within_share - 0.5).abs() < 1e-9 && (total.error_m.p95 - 1.0).abs() < 0.05, "{total:?}");
    let shares = campaign.conditions.iter().map(|group| group.road_edges.map(|edges| edges.within_share));
    let shares: Vec<Option<bool>> = shares.map(|share| share.map(|share| share > 0.5)).collect();
    assert_eq!(shares, [Some(true), Some(false), None]);
}

#[test]
fn the_order_of_the_drives_does_not_matter() {
    let drives = [drive(1, "wet", 4, &[0.2]), drive(2, "dusk", 4, &[0.4]), drive(3, "wet", 2, &[0.3])];
    let campaign = |order: [usize; 3]| {
        let mut tally = CampaignTally::new(&names(), 3);
        for i in order {
            tally.add(drives[i].0.clone(), drives[i].1.clone());
        }
        tally.campaign()
    };
    assert_eq!(campaign([0, 1, 2]), campaign([2, 0, 1]));
    assert!(!campaign([0, 1, 2]).interrupted);
}
