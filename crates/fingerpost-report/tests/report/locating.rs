//! The page of a located drive, from fixes written by hand.

use std::collections::BTreeMap;

use fingerpost_format::{LocationScores, LocationSummary, Recall};
use fingerpost_locate::{Fix, RISK, Rival, Status};
use fingerpost_map::{LatLon, OsmData, OsmNode, OsmWay, RoadGraph};
use fingerpost_report::{LocatedDrive, LocatingInput, locating_html};
use nalgebra::{Matrix2, Point2};

use crate::page::{closed_tags, svgs};

/// Parallel streets, each of some pieces that are ways of their own.
pub(crate) fn streets(count: i64, pieces: i64) -> RoadGraph {
    let mut osm = OsmData::default();
    for street in 0..count {
        for node in 0..=pieces {
            let at = LatLon::new(47.0 + 0.001 * street as f64, 9.0 + 0.001 * node as f64).unwrap();
            osm.nodes.push(OsmNode { id: street * (pieces + 1) + node, at });
        }
        for piece in 0..pieces {
            let first = street * (pieces + 1) + piece;
            osm.ways.push(OsmWay {
                id: street * pieces + piece,
                nodes: vec![first, first + 1],
                tags: BTreeMap::from([("highway".to_owned(), "residential".to_owned())]),
            });
        }
    }
    RoadGraph::from_osm(&osm).unwrap()
}

fn fix(row: u32, status: Status) -> Fix {
    let is_known = matches!(status, Status::Converged | Status::Coasting);
    Fix {
        t_s: 5.0 + 0.1 * f64::from(row),
        driven_m: f64::from(row),
        place_m: Point2::new(f64::from(row), 0.0),
        heading_rad: 0.0,
        covariance_m2: Matrix2::identity(),
        speed_scale: [0.0, 0.01],
        level_m: is_known.then_some(if status == Status::Converged { 5.0 } else { 40.0 }),
        status,
        mass: if is_known { 1.0 } else { 0.6 },
        off_map: 0.0,
        rivals: Vec::new(),
        hypotheses: 2,
    }
}

/// The vehicle of a fix, and one in the next street.
fn rivals(fix: &Fix) -> Vec<Rival> {
    let rival = |north_m, weight| Rival {
        place_m: fix.place_m + nalgebra::Vector2::new(0.0, north_m),
        heading_rad: 0.0,
        weight,
    };
    vec![rival(0.0, fix.mass), rival(111.0, 1.0 - fix.mass)]
}

/// A drive along a street, a row a metre; the truth is 3 m to its left, or 6 m.
fn drive(rows: &[(u32, Status)], truth: impl Fn(u32) -> Option<f64>) -> LocatedDrive {
    let mut drive = LocatedDrive::default();
    let mut row = 0;
    let mut places = Vec::new();
    for &(count, status) in rows {
        for _ in 0..count {
            let fix = fix(row, status);
            let true_m = truth(row).map(|left_m| fix.place_m + nalgebra::Vector2::new(0.0, left_m));
            drive.add(&fix, true_m, || rivals(&fix));
            places = rivals(&fix);
            row += 1;
        }
    }
    drive.end(places);
    drive
}

fn summary(truth: Option<LocationScores>) -> LocationSummary {
    LocationSummary {
        written_by: "fingerpost <test>".to_owned(),
        rows: 600,
        statuses: BTreeMap::new(),
        converged_s: None,
        risk: RISK,
        motion: fingerpost_format::MotionFaults::default(),
        most_hypotheses: 2,
        gps: None,
        map_notices: Vec::new(),
        row_ms: None,
        truth,
    }
}

fn page(graph: &RoadGraph, drive: &LocatedDrive, summary: &LocationSummary) -> String {
    let page = locating_html(&LocatingInput { title: "motion & <map>", graph, drive, summary });
    closed_tags(&page);
    assert!(page.contains("motion &amp; &lt;map&gt;") && page.contains("fingerpost &lt;test&gt;"));
    assert!(page.contains("OpenStreetMap contributors, ODbL"));
    for outside in ["http:", "https:", "<script", "url(", "NaN", "inf"] {
        assert!(!page.contains(outside), "{outside}");
    }
    page
}

#[test]
fn with_truth_the_page_compares_with_it() {
    use Status::{Ambiguous, Coasting, Converged};
    let rows = [(300, Ambiguous), (200, Converged), (50, Coasting), (50, Converged)];
    let drive = drive(&rows, |row| Some(if row >= 580 { 6.0 } else { 3.0 }));
    let scores = LocationScores {
        converged_m: Some(301.0),
        fix_error_m: None,
        lateral_error_m: None,
        longitudinal_error_m: None,
        recall: Some(Recall { lateral: [0.0, 0.25, 1.0], longitudinal: [1.0; 3] }),
        bound_violations: 20,
        longest_violation_s: 1.9,
        bound_m: None,
        nees: Some(1.5),
    };
    let page = page(&streets(3, 8), &drive, &summary(Some(scores)));
    // Map; at the start, after 50, 100, 200 and 400 m, on convergence and at the end; level, probability; Stanford diagram.
    assert_eq!(svgs(&page), 1 + 7 + 2 + 1);
    for words in [
        "At the end the place is known: within 5.0 m but for a probability of 0.1 %.",
        "It first converged after 300 m by the log",
        "on convergence, after 300 m",
        "at the end, 599 m",
        // 3 m are within the level of 5 m, 6 m are not; coasting and ambiguous rows are beyond the limit.
        ">230 rows</text>",
        ">20 rows</text>",
        ">350 rows</text>",
        ">0 rows</text>",
        "25 %",
        "(NEES) of converged rows: 1.5;",
        "class=\"truth\"",
        "class=\"true-place\"",
    ] {
        assert!(page.contains(words), "{words}");
    }
    assert_eq!(page.matches("id=\"roads\"").count(), 1, "the roads of the small maps are drawn once");
}

#[test]
fn without_truth_nothing_is_said_of_it() {
    let drive = drive(&[(120, Status::Ambiguous)], |_| None);
    let page = page(&streets(3, 8), &drive, &summary(None));
    // Map; at the start, after 50 and 100 m and at the end; level, probability.
    assert_eq!(svgs(&page), 1 + 4 + 2);
    for words in ["class=\"truth\"", "class=\"true-place\"", "Stanford", "NEES", "error"] {
        assert!(!page.contains(words), "{words}");
    }
    let why = "the likeliest place has a probability of 60 %, another, 111 m away, one of 40 %; what was driven fits both.";
    assert!(page.contains(&format!("At the end the place is ambiguous: {why}")), "{page}");
    assert!(page.contains("It never converged."));
}

#[test]
fn a_drive_of_no_rows_makes_a_page() {
    let page = page(&streets(1, 1), &LocatedDrive::default(), &summary(None));
    assert!(page.contains("No row of the motion log gave a fix."));
}

#[test]
fn a_map_of_twenty_thousand_roads_makes_a_page_of_a_few_megabytes() {
    let graph = streets(100, 200);
    assert_eq!(graph.ways().len(), 20_000);
    // Nothing is found, so that every map shows all of them.
    let drive = drive(&[(600, Status::Ambiguous)], |_| None);
    let bytes = page(&graph, &drive, &summary(None)).len();
    assert!(bytes < 3_000_000, "{bytes} bytes");
}
