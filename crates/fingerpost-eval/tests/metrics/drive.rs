//! What a drive was, of hand-made records.

use fingerpost_eval::{DriveTotals, FeatureIdentity, FeatureOutcomes};
use fingerpost_format::{
    CameraRecord, CameraRecordState, DriveSummary, FeatureOutcome, FeatureSummary, FrameRecord,
    LaneEdgeRecord, LanesRecord, MarkingRecord, MotionDoubtRecord, SignalsRecord, SoughtRecord, TrackState,
};

use crate::made_by_hand::{moved, record, seen};

/// Quality from which a motion of these records was measured.
const MEASURED: f64 = 0.1;
/// Places of a route's three features, metres along it.
const AT_M: [f64; 3] = [20.0, 60.0, 159.0];

fn clear(record: FrameRecord) -> FrameRecord {
    let camera = CameraRecord { state: CameraRecordState::Clear, contrast: 20.0, needed_contrast: 2.0 };
    FrameRecord { camera: Some(camera), ..record }
}

/// A frame of a drive at 10 m/s, ten frames a second, of which nothing but the motion is known.
fn driven(frame: u64, state: TrackState) -> FrameRecord {
    let driven = clear(record(frame, state));
    let route_m = (state != TrackState::NoRoute).then_some(frame as f64);
    FrameRecord { route_m, ..if frame > 0 { moved(driven, 1.0, 0.0) } else { driven } }
}

fn with_quality(record: FrameRecord, quality: f64, doubt: Option<MotionDoubtRecord>) -> FrameRecord {
    let motion = record.motion.map(|motion| fingerpost_format::MotionRecord { quality, doubt, ..motion });
    FrameRecord { motion, ..record }
}

fn summaries(records: &[FrameRecord]) -> (DriveSummary, Vec<FeatureSummary>) {
    let features: Vec<FeatureIdentity> = (0..)
        .zip(AT_M)
        .map(|(id, at_m)| FeatureIdentity {
            id,
            name: format!("Road {id}"),
            kind: "side_road".to_owned(),
            at_m,
        })
        .collect();
    let has_route = records.iter().any(|record| record.state != TrackState::NoRoute);
    let mut outcomes = FeatureOutcomes::new(if has_route { &features } else { &[] });
    let mut totals = DriveTotals::new(MEASURED, |doubt| format!("{doubt:?} was seen"));
    for record in records {
        outcomes.add(record);
        totals.add(record);
    }
    let features = outcomes.into_summaries();
    (totals.into_summary(&features, vec!["said before".to_owned()]), features)
}

fn outcomes(features: &[FeatureSummary]) -> Vec<Option<FeatureOutcome>> {
    features.iter().map(|feature| feature.outcome).collect()
}

/// The one remark beside the one that was said before.
fn remark(drive: &DriveSummary) -> &str {
    assert_eq!((drive.remarks.len(), drive.remarks[0].as_str()), (2, "said before"), "{:?}", drive.remarks);
    &drive.remarks[1]
}

#[test]
fn a_drive_is_so_long_and_so_much_of_it_is_known() {
    let edge = LaneEdgeRecord {
        offset_m: 1.7,
        heading_rad: 0.0,
        curvature_per_m: 0.0,
        marking: MarkingRecord::default(),
        kept_frames: 0,
    };
    let records: Vec<FrameRecord> = (0..=80)
        .map(|frame| {
            let lanes = LanesRecord { left: (frame > 60).then_some(edge), ..LanesRecord::default() };
            let mut record = FrameRecord { lanes: Some(lanes), ..driven(frame, TrackState::Searching) };
            if (10..30).contains(&frame) {
                let state = if frame < 25 { TrackState::Tracking } else { TrackState::Arrived };
                record = FrameRecord {
                    feature: seen(frame, state, 0, 29.0 - frame as f64, 0.0).feature,
                    state,
                    ..record
                };
            }
            // A motion that goes on as before was not measured.
            if (40..60).contains(&frame) { with_quality(record, 0.05, None) } else { record }
        })
        .collect();
    let (drive, features) = summaries(&records);
    assert_eq!((drive.distance_m, drive.mean_speed_mps), (Some(60.0), Some(10.0)));
    assert_eq!((drive.duration_s, drive.unmeasured_s), (8.0, 2.0));
    assert_eq!((drive.motion_share, drive.lane_share, drive.feature_share), (0.75, Some(0.25), Some(0.25)));
    assert_eq!(drive.remarks, ["said before"]);
    let expected = [FeatureOutcome::Arrived, FeatureOutcome::Missed, FeatureOutcome::NotReached];
    assert_eq!(outcomes(&features), expected.map(Some));
    assert_eq!((features[0].detected_forward_m, features[0].arrived_forward_m), (Some(19.0), Some(4.0)));
}

#[test]
fn nothing_found_has_its_reason() {
    let drive =
        |frames: u64, state| -> Vec<FrameRecord> { (0..frames).map(|frame| driven(frame, state)).collect() };
    let short = summaries(&drive(12, TrackState::Searching)).0;
    assert_eq!(
        remark(&short),
        "no feature was found: the drive ended at 11 m of the route, and the first one, side road Road 0, lies at 20 m"
    );
    let (far, features) = summaries(&drive(100, TrackState::Searching));
    assert!(remark(&far).contains("passed 2") && remark(&far).contains("reach"), "{:?}", far.remarks);
    assert_eq!(features[2].outcome, Some(FeatureOutcome::NotReached));
    let mut nowhere = drive(30, TrackState::Searching);
    nowhere.iter_mut().for_each(|record| record.route_m = None);
    let (nowhere, features) = summaries(&nowhere);
    assert!(remark(&nowhere).contains("--start-m"), "{:?}", nowhere.remarks);
    assert_eq!(outcomes(&features), [None; 3]);
    // Where it began is known, and not where it went from there.
    let mut lost = drive(30, TrackState::Searching);
    lost.iter_mut().skip(10).for_each(|record| record.route_m = None);
    let lost = summaries(&lost).0;
    assert!(remark(&lost).ends_with("the last place of it that is known lies at 9 m"), "{:?}", lost.remarks);

    let mut dark = drive(30, TrackState::NoRoute);
    dark.iter_mut().skip(1).for_each(|record| *record = with_quality(record.clone(), 0.0, None));
    let dark = summaries(&dark).0;
    assert!(remark(&dark).contains("no motion was measured") && dark.distance_m.is_none(), "{dark:?}");
    let mut unlit = drive(30, TrackState::NoRoute);
    unlit.iter_mut().for_each(|record| record.camera.as_mut().unwrap().state = CameraRecordState::Black);
    assert!(remark(&summaries(&unlit).0).contains("in none of the 30 frames"));
    let mut broken = drive(3, TrackState::NoRoute);
    broken.iter_mut().for_each(|record| record.error = Some("no picture".to_owned()));
    assert!(remark(&summaries(&broken).0).contains("no frame could be used"));
    let mut unmarked = drive(30, TrackState::NoRoute);
    unmarked.iter_mut().for_each(|record| record.lanes = Some(LanesRecord::default()));
    assert!(remark(&summaries(&unmarked).0).contains("no lane was found"));
    assert_eq!(summaries(&drive(30, TrackState::NoRoute)).0.feature_share, None);
}

#[test]
fn a_motion_that_is_not_believed_counts_nowhere_and_leaves_open_what_was_reached() {
    let doubt = MotionDoubtRecord::ViewStandsStill;
    let records: Vec<FrameRecord> = (0..=40)
        .map(|frame| {
            let record = driven(frame, TrackState::Searching);
            let doubted = with_quality(record.clone(), 0.0, Some(doubt));
            if frame > 10 { FrameRecord { route_m: Some(10.0), ..doubted } } else { record }
        })
        .collect();
    let (drive, features) = summaries(&records);
    assert_eq!((drive.distance_m, drive.mean_speed_mps, drive.motion_share), (None, None, 0.25));
    assert_eq!(drive.motion_doubts, [(doubt, 30)].into());
    assert_eq!(outcomes(&features), [None; 3], "nobody knows how far it came");
    assert!(
        drive.remarks[1].contains("not believed in 30 of 40 frames")
            && drive.remarks[1].contains("frames: ViewStandsStill was seen;")
    );
    let no_feature = &drive.remarks[2];
    assert!(no_feature.contains("how far along the route the drive went is not known"), "{no_feature}");
    assert!(no_feature.ends_with("lies at 10 m") && !no_feature.contains("--start-m"), "{no_feature}");
}

#[test]
fn time_without_a_measured_motion_is_said_and_lowers_no_mean_speed() {
    let unknown = |record: FrameRecord| with_quality(moved(record, 0.0, 0.0), 0.0, None);
    let unseen = |record: FrameRecord| {
        let mut record = unknown(record);
        record.camera.as_mut().unwrap().state = CameraRecordState::Black;
        record
    };
    let doubted = |record| with_quality(record, 1.0, Some(MotionDoubtRecord::NothingToGoBy));
    let without = |record: FrameRecord| FrameRecord { motion: None, ..record };
    let broken = |record: FrameRecord| FrameRecord {
        motion: None,
        camera: None,
        error: Some("no picture".to_owned()),
        ..record
    };
    type Change<'a> = &'a dyn Fn(FrameRecord) -> FrameRecord;
    let seen_again = |record| moved(record, 11.0, 0.0);
    // What ten frames of a hundred are, and the one behind them; metres and seconds that are left over.
    let cases: [(&str, Change<'_>, Change<'_>, f64, f64); 6] = [
        ("covered, then too long a gap", &unseen, &unknown, 89.0, 1.1),
        ("covered, then found again", &unseen, &seen_again, 100.0, 0.0),
        ("doubted", &doubted, &|record| record, 90.0, 1.0),
        ("without a motion", &without, &|record| record, 90.0, 1.0),
        ("broken", &broken, &without, 89.0, 1.1),
        ("not measured", &unknown, &|record| record, 90.0, 1.0),
    ];
    for (name, change, behind, metres, seconds) in cases {
        let records: Vec<FrameRecord> = (0..=100)
            .map(|frame| match frame {
                40..50 => change(driven(frame, TrackState::NoRoute)),
                50 => behind(driven(frame, TrackState::NoRoute)),
                _ => driven(frame, TrackState::NoRoute),
            })
            .collect();
        let drive = summaries(&records).0;
        assert_eq!((drive.distance_m, drive.unmeasured_s), (Some(metres), seconds), "{name}");
        assert_eq!(drive.mean_speed_mps, Some(10.0), "{name}");
        assert_eq!(drive.lane_share, None, "{name}: no lane was looked for");
    }
}

/// With the speed of the bus frames are advised by it, and there is nothing to ask for.
#[test]
fn a_doubted_motion_asks_for_the_bus_where_it_gave_no_speed() {
    let with_speed_from = |first: u64| -> DriveSummary {
        let records: Vec<FrameRecord> = (0..=40)
            .map(|frame| {
                let record = driven(frame, TrackState::NoRoute);
                if frame <= 20 {
                    return record;
                }
                let speed_mps = (frame >= first).then_some(10.0);
                FrameRecord {
                    signals: Some(SignalsRecord { speed_mps, ..SignalsRecord::default() }),
                    ..with_quality(record, 0.0, Some(MotionDoubtRecord::ViewStandsStill))
                }
            })
            .collect();
        summaries(&records).0
    };
    let [never, half, always] = [100, 31, 0].map(with_speed_from);
    assert!(remark(&never).contains("nothing is advised in them") && remark(&never).contains("--can"));
    assert!(remark(&half).contains("in the 10 of them") && remark(&half).contains("--can"));
    assert!(!remark(&always).contains("advised") && !remark(&always).contains("--can"), "{always:?}");
    assert_eq!((always.distance_m, always.unmeasured_s), (Some(20.0), 2.0));
}

#[test]
fn the_best_match_is_one_of_a_feature_that_was_passed() {
    let mut records: Vec<FrameRecord> = (0..100).map(|frame| driven(frame, TrackState::Searching)).collect();
    for (frame, id, p) in [(15, 0, 0.31), (95, 2, 0.77)] {
        records[frame].sought = Some(SoughtRecord {
            id,
            p: Some(p),
            sub: Default::default(),
            contrast: Default::default(),
            present: None,
            forward_m: 10.0,
            left_m: 0.0,
        });
    }
    let (drive, features) = summaries(&records);
    assert_eq!(features[2].max_p, Some(0.77));
    assert!(remark(&drive).contains("P(F) of 0.31"), "{:?}", drive.remarks);
}
