//! Many drives from seeds.

use std::fs;
use std::path::Path;

use fingerpost_format::{Campaign, CampaignDrive};
use tempfile::TempDir;

use crate::program::call_line;

/// Two small drives under two conditions.
fn small(out: &Path, more: &str) -> String {
    let out = out.display();
    format!("campaign --drives 2 --seed 5 --conditions ideal,clear --size 160x120 --fps 4 --out {out} {more}")
}

#[test]
fn drives_follow_from_their_seeds_on_any_number_of_threads() {
    let (one, two) = (TempDir::new().unwrap(), TempDir::new().unwrap());
    let called = call_line(&small(one.path(), "--threads 1 --json")).done();
    call_line(&small(two.path(), "--threads 2")).done();
    let read = |folder: &Path| fs::read_to_string(folder.join("campaign.json")).unwrap();
    assert_eq!(read(one.path()), read(two.path()));
    assert!(called.stderr.contains("ideal") && called.stderr.contains("worst:"), "{}", called.stderr);
    assert!(!called.stderr.contains("u{a}"), "a table has lines: {}", called.stderr);
    let campaign: Campaign = serde_json::from_str(&read(one.path())).unwrap();
    assert_eq!(campaign, serde_json::from_str(&called.stdout).unwrap());
    assert!(!campaign.interrupted);
    let drives: Vec<_> =
        campaign.drives.iter().map(|drive| (drive.seed, drive.conditions.as_str())).collect();
    assert_eq!(drives, [(5, "ideal"), (6, "clear")]);
    assert!(campaign.drives.iter().all(|drive| (2..=4).contains(&drive.features.len()) && drive.frames > 20));
    let sum: u64 = campaign.drives.iter().map(|drive| drive.truth.features_total).sum();
    assert_eq!((campaign.total.features_total, campaign.total.drives), (sum, 2));
    let edges = |drive: &CampaignDrive| drive.road_edges.map_or(0, |edges| edges.edges);
    let sum: u64 = campaign.drives.iter().map(edges).sum();
    let all = campaign.total.road_edges.unwrap();
    assert_eq!(all.edges, sum);
    assert!(called.stderr.contains("0.3 m, %"), "{}", called.stderr);
    let clear = campaign.drives[1].road_edges.unwrap();
    assert!(clear.edges > 5 * campaign.drives[1].frames, "most sections have edges to be seen: {clear:?}");
    assert!(clear.within_share > 0.7 && clear.error_m.p50 < 0.15, "{clear:?}");
}

#[test]
fn worlds_follow_from_their_seeds_and_are_measured_like_other_drives() {
    let (one, two) = (TempDir::new().unwrap(), TempDir::new().unwrap());
    let line = |out: &Path, more: &str| {
        let out = out.display();
        format!("campaign --drives 2 --seed 8 --conditions world --size 160x120 --fps 4 --out {out} {more}")
    };
    call_line(&line(one.path(), "--threads 1")).done();
    call_line(&line(two.path(), "--threads 2")).done();
    let read = |folder: &Path| fs::read_to_string(folder.join("campaign.json")).unwrap();
    assert_eq!(read(one.path()), read(two.path()));
    let campaign: Campaign = serde_json::from_str(&read(one.path())).unwrap();
    let total = &campaign.total;
    assert_eq!((total.drives, total.drives_failed), (2, 0));
    assert!(campaign.drives.iter().all(|drive| drive.frames > 20 && drive.route_m > 100.0));
    let found = total.features_detected as f64 / total.features_total as f64;
    assert!((total.found_share.unwrap() - found).abs() < 1e-9);
    let ordered =
        total.error_per_sigma.is_none_or(|by| by.p68 <= by.p95 && by.p95 <= by.p99 && by.p99 <= by.max);
    assert!(ordered && total.confident_frames_off <= total.confident_frames, "{total:?}");
}

#[test]
fn a_drive_can_be_had_again_with_its_report() {
    let out = TempDir::new().unwrap();
    call_line(&format!("{} --reports", small(out.path(), "").replace("--drives 2", "--drives 1"))).done();
    let run = out.path().join("ideal_5");
    for name in ["report.html", "frames.jsonl", "truth.jsonl", "route.geojson", "pictures/frame_000010.png"] {
        assert!(run.join(name).exists(), "{name}");
    }
}

#[test]
fn what_cannot_be_driven_is_refused() {
    let out = TempDir::new().unwrap();
    let out = out.path().display();
    call_line(&format!("campaign --drives 0 --out {out}")).refused(2, &["--drives"]);
    call_line(&format!("campaign --drives 1 --conditions sleet --out {out}")).refused(2, &["sleet", "clear"]);
    call_line(&format!("campaign --drives 9 --seed 18446744073709551615 --out {out}"))
        .refused(1, &["--seed", "smaller"]);
}
