//! The report page: whole, well-formed, escaped, small.

use crate::locating::streets;
use crate::painted_run::{camera, painted_run};
use fingerpost_format::{
    DepartureRecord, DriveSummary, FeatureOutcome, FeatureSummary, FixRecord, FixStatus, FrameRecord,
    LaneEdgeRecord, LanesRecord, MarkingRecord, MotionRecord, Side, Summary, TrackState, TruthRecord,
};
use fingerpost_report::{KeyFrames, KeyReason, ReportInput, Thresholds, Timeline, report_html};

const THRESHOLDS: Thresholds = Thresholds { detect: 0.9, lost: 0.3 };

/// Every inline SVG of a page, parsed.
pub(crate) fn svgs(page: &str) -> usize {
    let mut count = 0;
    for rest in page.split("<svg").skip(1) {
        let svg = format!("<svg{}</svg>", rest.split("</svg>").next().unwrap());
        roxmltree::Document::parse(&svg).unwrap();
        count += 1;
    }
    count
}

/// Every element is closed.
pub(crate) fn closed_tags(page: &str) {
    for tag in ["figure", "details", "table", "article", "div", "ul", "body", "html", "svg"] {
        let opened = page.matches(&format!("<{tag}>")).count() + page.matches(&format!("<{tag} ")).count();
        assert_eq!(opened, page.matches(&format!("</{tag}>")).count(), "<{tag}>");
    }
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}

#[test]
fn the_page_of_a_drive_holds_everything() {
    let name = "Milkmaid's Lane & <Orchard> Road";
    let run = painted_run(&camera(), name, &mut |_| {});
    let reasons: Vec<KeyReason> = run.key_frames.frames().iter().map(|key| key.reason).collect();
    for reason in
        [KeyReason::FirstFrame, KeyReason::Detection { feature: 0 }, KeyReason::Arrival { feature: 0 }]
    {
        assert!(reasons.contains(&reason), "{reason:?} in {reasons:?}");
    }
    let page = report_html(&ReportInput {
        title: "a <painted> drive",
        made_from: &[],
        timeline: &Timeline::of(&run.records, Some(&run.truth)),
        summary: &run.summary,
        truth: Some(&run.truth),
        route: Some(&run.route),
        roads: None,
        thresholds: THRESHOLDS,
        rules: &[],
        config_toml: "[track]\nlost_present = 0.5 # <0.5>\n",
        key_frames: &run.key_frames,
    });
    // Map, P(F), distance, error, speed, stage times.
    assert_eq!(svgs(&page), 6);
    assert!(page.contains(&escaped(name)) && !page.contains("<Orchard>"));
    assert!(page.contains("a &lt;painted&gt; drive") && page.contains("lost_present = 0.5 # &lt;0.5&gt;"));
    for key in run.key_frames.frames() {
        assert!(page.contains(&escaped(&key.why)), "{}", key.why);
        let has_lanes = key.pictures.iter().any(|picture| picture.stage == "lane steps");
        assert_eq!(
            key.pictures.len(),
            7 + usize::from(has_lanes),
            "composed, five stages and what the network sees, and the lane's"
        );
        assert!(key.pictures.iter().all(|picture| picture.jpeg.starts_with(&[0xFF, 0xD8])));
    }
    let with_lanes = run.key_frames.frames().iter().filter(|key| key.pictures.len() == 8).count();
    assert!(with_lanes > 0, "lanes are looked for");
    assert_eq!(page.matches("data:image/jpeg;base64,").count(), 7 * reasons.len() + with_lanes);
    assert!(page.contains("OpenStreetMap contributors, ODbL"));
    for outside in ["http:", "https:", "<script", "url("] {
        assert!(!page.contains(outside), "nothing from outside: {outside}");
    }
    closed_tags(&page);
}

fn record(frame: u64, state: TrackState, why: String) -> FrameRecord {
    FrameRecord {
        camera: None,
        sought: None,
        frame,
        t_s: frame as f64 / 30.0,
        state,
        feature: None,
        motion: None,
        mount: None,
        signals: None,
        surface: None,
        driving_line_m: Vec::new(),
        driving_line_curvature_per_m: Vec::new(),
        centreline: None,
        no_centreline: None,
        lanes: None,
        fix: None,
        advice: None,
        route_m: None,
        stage_ms: std::collections::BTreeMap::new(),
        why,
        error: None,
    }
}

#[test]
fn the_chart_shows_the_bounds_that_decide_and_the_page_what_became_of_each_feature() {
    let records: Vec<FrameRecord> =
        (0..30).map(|frame| record(frame, TrackState::Searching, String::new())).collect();
    let feature = |id, outcome| FeatureSummary {
        id,
        kind: "bend".to_owned(),
        outcome: Some(outcome),
        detected_frame: (outcome == FeatureOutcome::Arrived).then_some(3),
        arrived_frame: (outcome == FeatureOutcome::Arrived).then_some(5),
        arrived_forward_m: (outcome == FeatureOutcome::Arrived).then_some(6.5),
        ..FeatureSummary::default()
    };
    let drive = DriveSummary {
        distance_m: Some(59.0),
        duration_s: 6.0,
        mean_speed_mps: Some(9.8),
        unmeasured_s: 0.12,
        motion_share: 0.98,
        remarks: vec!["the drive ended <early>".to_owned(), "does it begin there?".to_owned()],
        ..DriveSummary::default()
    };
    let outcomes = [FeatureOutcome::Arrived, FeatureOutcome::Missed, FeatureOutcome::NotReached];
    let summary = Summary {
        drive: Some(drive),
        features: (1..).zip(outcomes).map(|(id, outcome)| feature(id, outcome)).collect(),
        ..Summary::default()
    };
    let page = report_html(&ReportInput {
        title: "bounds",
        made_from: &[
            ("command", "fingerpost run 'a & b'".to_owned()),
            ("camera", "c.toml: 640 x 480".to_owned()),
        ],
        timeline: &Timeline::of(&records, None),
        summary: &summary,
        truth: None,
        route: None,
        roads: None,
        thresholds: THRESHOLDS,
        rules: &[],
        config_toml: "",
        key_frames: &KeyFrames::default(),
    });
    assert!(page.contains("tracked from 0.90") && page.contains("lost below 0.30"));
    for words in [
        "<dd>59.0 m, without 0.12 s in which it was not measured</dd>",
        "<dd>9.8 m/s</dd>",
        "<dd>98 %</dd>",
        "The drive ended &lt;early&gt;.",
        "Does it begin there?</p>",
        "<dd>1 of 2</dd>",
        "features not reached",
        "<td class=\"n\">6.5 m</td>",
        "<td>not reached</td>",
        "fingerpost run 'a &amp; b'",
        "c.toml: 640 x 480",
    ] {
        assert!(page.contains(words), "{words}");
    }
    assert!(!page.contains("frames with a lane"), "none was looked for");
    assert_eq!(page.matches("<tr class=\"missed\">").count(), 1, "what was not reached was not missed");
    closed_tags(&page);
}

#[test]
fn losses_are_listed_with_their_reasons_once_each() {
    let state = |frame: u64| if frame % 10 < 3 { TrackState::Lost } else { TrackState::Searching };
    let mut records: Vec<FrameRecord> =
        (0..600).map(|frame| record(frame, state(frame), format!("reason {frame}."))).collect();
    records[5].error = Some("cannot be decoded: <end> of file".to_owned());
    let page = report_html(&ReportInput {
        title: "losses",
        made_from: &[],
        timeline: &Timeline::of(&records, None),
        summary: &Summary::default(),
        truth: None,
        route: None,
        roads: None,
        thresholds: THRESHOLDS,
        rules: &[],
        config_toml: "",
        key_frames: &KeyFrames::default(),
    });
    assert!(page.contains("reason 0.") && page.contains("reason 10.") && page.contains("reason 390."));
    assert!(!page.contains("reason 1.") && !page.contains("reason 400."));
    assert!(page.contains("and 20 more"), "60 losses, 40 listed");
    assert!(page.contains("cannot be decoded: &lt;end&gt; of file"));
    assert!(!page.contains("OpenStreetMap"), "no map, no attribution");
}

/// Fixes along a street, 3 m beside the true places; the first half without a level.
#[test]
fn fixes_have_a_map_of_the_roads_and_their_level_over_time() {
    let graph = streets(3, 10);
    let at = |frame: u64| 9.0 + 1e-5 * frame as f64;
    let fix = |frame: u64| FixRecord {
        lat: 47.000_027,
        lon: at(frame),
        heading_rad: 0.0,
        sigma_m: 2.0,
        bound_m: (frame >= 50).then_some(8.0),
        status: Some(if frame >= 50 { FixStatus::Converged } else { FixStatus::Ambiguous }),
        measurements: Vec::new(),
    };
    let moved = |forward_m| MotionRecord { forward_m, left_m: 0.0, yaw_rad: 0.0, quality: 1.0, doubt: None };
    let records: Vec<FrameRecord> = (0..100)
        .map(|frame| FrameRecord {
            fix: Some(fix(frame)),
            motion: Some(moved(0.76)),
            ..record(frame, TrackState::NoRoute, String::new())
        })
        .collect();
    let truth: Vec<TruthRecord> = (0..100)
        .map(|frame| TruthRecord { frame, lat: 47.0, lon: at(frame), ..TruthRecord::default() })
        .collect();
    let page = |records: &[FrameRecord], roads| {
        report_html(&ReportInput {
            title: "located",
            made_from: &[],
            timeline: &Timeline::of(records, Some(&truth)),
            summary: &Summary::default(),
            truth: Some(&truth),
            route: None,
            roads,
            thresholds: THRESHOLDS,
            rules: &[],
            config_toml: "",
            key_frames: &KeyFrames::default(),
        })
    };
    let with_roads = page(&records, Some(&graph));
    assert!(with_roads.contains("Place on the map") && with_roads.contains("OpenStreetMap"));
    assert!(with_roads.contains("Map of the drive") && with_roads.contains(">converged</text>"));
    let without_roads = page(&records, None);
    assert_eq!(svgs(&with_roads), svgs(&without_roads) + 1);
    assert!(without_roads.contains("distance of the fix from the true place"));
    let nowhere: Vec<FrameRecord> =
        records.iter().map(|record| FrameRecord { fix: None, ..record.clone() }).collect();
    assert!(!page(&nowhere, Some(&graph)).contains("Place on the map"));
}

#[test]
fn the_lane_has_curves_and_its_warnings_a_list() {
    let edge = |offset_m| LaneEdgeRecord {
        offset_m,
        heading_rad: 0.0,
        curvature_per_m: 0.0,
        marking: MarkingRecord::default(),
        kept_frames: 0,
    };
    let frame = |frame: u64| {
        let warned = (20..30).contains(&frame) || (70..75).contains(&frame);
        let departure = DepartureRecord {
            warning: warned.then_some(Side::Right),
            lateral_speed_mps: Some(-0.4),
            time_to_crossing_s: None,
            silent_because: (frame > 90).then(|| "turn_signal".to_owned()),
        };
        let lanes = LanesRecord {
            left: (frame > 5).then(|| edge(1.7)),
            right: Some(edge(-1.6)),
            width_m: Some(3.3),
            departure: Some(departure),
            ..LanesRecord::default()
        };
        FrameRecord { lanes: Some(lanes), ..record(frame, TrackState::NoRoute, format!("reason {frame}.")) }
    };
    let page = |records: &[FrameRecord]| {
        report_html(&ReportInput {
            title: "lane",
            made_from: &[],
            timeline: &Timeline::of(records, None),
            summary: &Summary::default(),
            truth: None,
            route: None,
            roads: None,
            thresholds: THRESHOLDS,
            rules: &[],
            config_toml: "",
            key_frames: &KeyFrames::default(),
        })
    };
    let records: Vec<FrameRecord> = (0..100).map(frame).collect();
    let shown = page(&records);
    assert_eq!(svgs(&shown), 4, "P(F), edges, width, speed across");
    assert_eq!(shown.matches("<title>warning: right</title>").count(), 2);
    assert_eq!(shown.matches("<title>no warning: turn signal</title>").count(), 1);
    assert!(shown.contains("reason 20.") && shown.contains("reason 70.") && !shown.contains("reason 21."));
    let without = page(&[record(0, TrackState::NoRoute, String::new())]);
    assert!(!without.contains("Lane</h2>"), "nothing of a lane where there is none");
}

#[test]
fn a_run_of_many_frames_makes_a_small_page_and_one_of_none_a_page() {
    let mut records = Vec::new();
    let mut truth = Vec::new();
    for frame in 0..30_000_u64 {
        let state = if frame % 7 < 3 { TrackState::Tracking } else { TrackState::Searching };
        let mut one = record(frame, state, String::new());
        one.route_m = Some(frame as f64);
        one.feature = (state == TrackState::Tracking).then(|| fingerpost_format::FeatureRecord {
            id: 1,
            kind: "bend".to_owned(),
            p: Some(0.5 + 0.4 * libm::sin(frame as f64 * 0.37)),
            sub: [("approach".to_owned(), 0.9), ("exit".to_owned(), (frame % 5) as f64 * 0.2)].into(),
            contrast: Default::default(),
            confidence: None,
            present: None,
            rivals: Vec::new(),
            forward_m: 12.0,
            left_m: 0.0,
            heading_rad: 0.0,
            sigma_m: [0.1, 0.1],
        });
        records.push(one);
        truth.push(TruthRecord {
            frame,
            feature_id: Some(1),
            feature_forward_m: Some(12.0),
            feature_left_m: Some(0.3),
            ..TruthRecord::default()
        });
    }
    let page = |records: &[FrameRecord], truth: Option<&[TruthRecord]>| {
        report_html(&ReportInput {
            title: "long",
            made_from: &[],
            timeline: &Timeline::of(records, truth),
            summary: &Summary::default(),
            truth,
            route: None,
            roads: None,
            thresholds: THRESHOLDS,
            rules: &[],
            config_toml: "",
            key_frames: &KeyFrames::default(),
        })
    };
    let long = page(&records, Some(&truth));
    assert_eq!(svgs(&long), 4, "P(F), distance, error, true speed");
    assert!(long.len() < 1_000_000, "{} bytes", long.len());
    let empty = page(&[], None);
    assert!(empty.contains("No frame was processed."));
    let unseen = [record(0, TrackState::Searching, String::new())];
    assert!(page(&unseen, None).contains("No feature of the route came into view"));
}
