use fingerpost_eval::{
    EvalError, LaneError, LaneMeasure, evaluate_lanes, evaluate_tusimple, lane_picture_px, mean_of_lanes,
};
use fingerpost_format::{FrameRecord, LanesRecord, TrackState, TruthRecord, TuSimpleRecord};

use crate::made_by_hand::record;

const PICTURE_PX: [u32; 2] = [960, 540];

/// A straight edge over rows 539 to 339, which leans by `lean` columns a row from column `u` at the base.
fn edge(u: f64, lean: f64) -> Vec<[f64; 2]> {
    [0.0, 75.0, 200.0].map(|up| [u + lean * up, 539.0 - up]).to_vec()
}

fn truth(frame: u64, left: Vec<[f64; 2]>, right: Vec<[f64; 2]>) -> TruthRecord {
    TruthRecord { frame, lane_left_px: left, lane_right_px: right, ..TruthRecord::default() }
}

fn seen(frame: u64, left: Vec<[f64; 2]>, right: Vec<[f64; 2]>) -> FrameRecord {
    let lanes = LanesRecord { left_px: left, right_px: right, ..LanesRecord::default() };
    FrameRecord { lanes: Some(lanes), ..record(frame, TrackState::NoRoute) }
}

fn close(found: f64, expected: f64) {
    assert!((found - expected).abs() < 1e-9, "{found} is not {expected}");
}

#[test]
fn accuracy_and_deviation_by_hand() {
    let drive = [
        truth(0, edge(200.0, 1.0), edge(800.0, -1.5)),
        truth(1, edge(200.0, 1.0), edge(800.0, -1.5)),
        truth(2, edge(200.0, 1.0), Vec::new()),
        truth(3, edge(200.0, 1.0), edge(800.0, -1.5)),
    ];
    let run = [
        // Deviations 9 and 16 px².
        seen(0, edge(203.0, 1.0), edge(804.0, -1.5)),
        // Exact, and none.
        seen(1, edge(200.0, 1.0), Vec::new()),
        // 20.25 px², and an edge that is not there.
        seen(2, edge(195.5, 1.0), edge(700.0, -1.5)),
        // Frame 3 has no record.
    ];
    let found = evaluate_lanes(&run, &drive, PICTURE_PX, &LaneMeasure::default()).unwrap();
    // Seven edges; true are at 10: 9 and 0, at 15 the same, at 20: 16 too.
    let counts: Vec<_> = found.cells.iter().map(|cell| (cell.true_positives, cell.false_positives)).collect();
    assert_eq!(counts, [[(2, 5), (2, 5), (3, 4)]; 4].concat());
    close(found.cells[2].accuracy_pct, 300.0 / 7.0);
    close(found.mean_accuracy_pct.unwrap(), 100.0 * (2.0 + 2.0 + 3.0) / 21.0);
    // Roots 3, 4, 0 and 4.5: mean 2.875, squares 9, 16, 0 and 20.25.
    let of_100 = found.deviations[0];
    assert_eq!((of_100.roi_rows, of_100.edges, of_100.edges_without_output), (100, 7, 3));
    close(of_100.rmsd_mean_px.unwrap(), 2.875);
    close(of_100.rmsd_standard_deviation_px.unwrap(), (45.25 / 4.0 - 2.875_f64.powi(2)).sqrt());
    assert_eq!((found.frames, found.frames_without_record), (4, 1));
    assert_eq!((found.edges_not_in_truth, found.false_edges), (1, 1));
}

#[test]
fn a_larger_region_sees_more_of_an_edge_that_leaves_its_truth() {
    // Off by 0.05 px for every row above the base.
    let run = [seen(0, edge(200.0, 1.05), Vec::new())];
    let found =
        evaluate_lanes(&run, &[truth(0, edge(200.0, 1.0), Vec::new())], PICTURE_PX, &LaneMeasure::default())
            .unwrap();
    for (deviation, rows) in found.deviations.iter().zip([100.0, 120.0, 140.0, 150.0]) {
        // The mean of the squares of 0 to rows - 1 is (rows - 1) (2 rows - 1) / 6.
        let lpd = 0.05_f64.powi(2) * (rows - 1.0) * (2.0 * rows - 1.0) / 6.0;
        close(deviation.rmsd_mean_px.unwrap(), lpd.sqrt());
    }
    // 8.2, 11.9, 16.2 and 18.6 px².
    let accuracies: Vec<f64> = found.cells.iter().map(|cell| cell.accuracy_pct).collect();
    let expected = [[100.0, 100.0, 100.0], [0.0, 100.0, 100.0], [0.0, 0.0, 100.0], [0.0, 0.0, 100.0]];
    assert_eq!(accuracies, expected.concat());
}

#[test]
fn lanes_where_there_are_no_markings_are_false() {
    let unmarked: Vec<_> = (0..5).map(|frame| truth(frame, Vec::new(), Vec::new())).collect();
    let run = [
        seen(0, edge(200.0, 1.0), edge(800.0, -1.0)),
        seen(1, Vec::new(), Vec::new()),
        seen(2, Vec::new(), edge(800.0, -1.0)),
        record(3, TrackState::NoRoute),
        // Frame 4 has no record: nothing is claimed there, and nothing is right.
    ];
    let found = evaluate_lanes(&run, &unmarked, PICTURE_PX, &LaneMeasure::default()).unwrap();
    assert_eq!((found.unmarked_frames, found.false_lane_frames), (4, 2));
    close(found.false_lanes_pct.unwrap(), 50.0);
    assert_eq!((found.edges_not_in_truth, found.false_edges), (10, 3));
    assert_eq!((found.mean_accuracy_pct, found.cells.len(), found.deviations.len()), (None, 0, 0));

    // A frame with a marking on one side is marked, and the mean is that of marked clips.
    let half = [truth(0, edge(200.0, 1.0), Vec::new()), truth(1, Vec::new(), Vec::new())];
    let marked = evaluate_lanes(&run[..2], &half, PICTURE_PX, &LaneMeasure::default()).unwrap();
    assert_eq!((marked.unmarked_frames, marked.false_lane_frames, marked.false_edges), (1, 0, 1));
    close(marked.mean_accuracy_pct.unwrap(), 100.0);
    assert_eq!(mean_of_lanes(std::slice::from_ref(&found)), None);
    let mean = mean_of_lanes(&[found, marked]).unwrap();
    assert_eq!((mean.clips, mean.mean_accuracy_pct), (1, 100.0));
}

#[test]
fn the_mean_counts_every_clip_the_same() {
    let good = [truth(0, edge(200.0, 1.0), edge(800.0, -1.0))];
    let all = evaluate_lanes(
        &[seen(0, edge(200.0, 1.0), edge(800.0, -1.0))],
        &good,
        PICTURE_PX,
        &LaneMeasure::default(),
    )
    .unwrap();
    let many: Vec<_> = (0..3).map(|frame| truth(frame, edge(200.0, 1.0), edge(800.0, -1.0))).collect();
    let half: Vec<_> = (0..3).map(|frame| seen(frame, edge(202.0, 1.0), Vec::new())).collect();
    let half = evaluate_lanes(&half, &many, PICTURE_PX, &LaneMeasure::default()).unwrap();
    let mean = mean_of_lanes(&[all, half]).unwrap();
    close(mean.mean_accuracy_pct, 75.0);
    close(mean.cells[0].accuracy_pct, 75.0);
    assert_eq!((mean.cells[0].true_positives, mean.cells[0].false_positives), (5, 3));
    close(mean.rmsd_mean_px[3].unwrap(), 1.0);
    assert_eq!(mean_of_lanes(&[]), None);
}

#[test]
fn truth_of_other_frames_or_pictures_is_refused() {
    let drive = [truth(0, edge(200.0, 1.0), Vec::new()), truth(1, edge(200.0, 1.0), Vec::new())];
    let run = [seen(2, edge(200.0, 1.0), Vec::new())];
    let no_truth = EvalError::NoTruth { frame: 2, truths: 2, first: 0, last: 1 };
    assert_eq!(
        evaluate_lanes(&run, &drive, PICTURE_PX, &LaneMeasure::default()),
        Err(LaneError::Frames(no_truth))
    );
    assert_eq!(
        evaluate_lanes(&[], &drive, PICTURE_PX, &LaneMeasure::default()),
        Err(LaneError::Frames(EvalError::NoFrames))
    );
    let far = [truth(2, vec![[200.0, 400.0], [210.0, 390.0]], Vec::new())];
    assert_eq!(
        evaluate_lanes(&run, &far, PICTURE_PX, &LaneMeasure::default()),
        Err(LaneError::NoEdges { roi_rows: 100 })
    );

    let other = Some([640, 480]);
    assert_eq!(lane_picture_px(None, &drive, None), Err(LaneError::NoPictureSize));
    assert_eq!(lane_picture_px(Some(PICTURE_PX), &drive, None), Ok(PICTURE_PX));
    assert_eq!(lane_picture_px(None, &drive, Some(PICTURE_PX)), Ok(PICTURE_PX));
    let outside = Err(LaneError::Outside { frame: 0, row: 539.0, height: 480 });
    assert_eq!(lane_picture_px(other, &drive, None), outside);
    let sized = drive.map(|truth| TruthRecord { picture_px: Some(PICTURE_PX), ..truth });
    assert_eq!(lane_picture_px(None, &sized, None), Ok(PICTURE_PX));
    let differ = Err(LaneError::PictureSize { run_px: [640, 480], truth_px: PICTURE_PX });
    assert_eq!(lane_picture_px(other, &sized, None), differ);
    assert_eq!(lane_picture_px(None, &sized, other), differ);
    assert!(lane_picture_px(Some(PICTURE_PX), &sized, other).is_err());
    let [first, second] = sized;
    let changing = [first, TruthRecord { picture_px: other, ..second }];
    let changes = Err(LaneError::SizeChanges { frame: 1, picture_px: [640, 480], before_px: PICTURE_PX });
    assert_eq!(lane_picture_px(None, &changing, None), changes);
}

#[test]
fn the_benchmarks_scores_by_hand() {
    let rows: Vec<f64> = (340..540).step_by(10).map(f64::from).collect();
    let lane = |u: f64| vec![u; rows.len()];
    let label =
        |lanes: Vec<Vec<f64>>| TuSimpleRecord { lanes, h_samples: rows.clone(), ..Default::default() };
    let score = |left: f64, right: Option<f64>, lanes: Vec<Vec<f64>>| {
        let right = right.map_or(Vec::new(), |u| edge(u, 0.0));
        let run = [seen(0, edge(left, 0.0), right)];
        let found = evaluate_tusimple(&run, &[label(lanes)], Some(PICTURE_PX)).unwrap();
        [found.accuracy, found.false_positives, found.false_negatives]
    };
    let same = |found: [f64; 3], expected: [f64; 3]| {
        found.iter().zip(expected).for_each(|(found, expected)| close(*found, expected));
    };
    // 19 pixels agree, 20 do not.
    same(score(219.0, Some(801.0), vec![lane(200.0), lane(800.0)]), [1.0, 0.0, 0.0]);
    same(score(220.0, Some(801.0), vec![lane(200.0), lane(800.0)]), [0.5, 0.5, 0.5]);
    // Two of the twenty rows have no point: 0.9 agree, which is enough; four are too many.
    let from = |missing: usize| [vec![-2.0; missing], vec![200.0; rows.len() - missing]].concat();
    same(score(200.0, None, vec![from(2)]), [0.9, 0.0, 0.0]);
    same(score(200.0, None, vec![from(4)]), [0.8, 1.0, 1.0]);
    // Of five lanes the worst is forgiven: 1 + 1 + 0 + 0 over four, two of three missed.
    let five = [200.0, 300.0, 400.0, 500.0, 800.0].map(lane).to_vec();
    same(score(200.0, Some(800.0), five), [0.5, 0.0, 0.5]);
    // A slanted lane may be further off along the row: 20 px across are 28.3 px at 45 degrees.
    let slanted: Vec<f64> = rows.iter().map(|row| 200.0 + (539.0 - row)).collect();
    let off = |px: f64| {
        let run = [seen(0, edge(200.0 + px, 1.0), Vec::new())];
        evaluate_tusimple(&run, &[label(vec![slanted.clone()])], None).unwrap().accuracy
    };
    close(off(28.0), 1.0);
    close(off(28.5), 0.0);
}

#[test]
fn labels_that_do_not_fit_are_refused() {
    let run = [seen(0, edge(200.0, 0.0), Vec::new())];
    let refused = evaluate_tusimple(&run, &[], None);
    assert_eq!(refused, Err(LaneError::LabelCount { frames: 1, labels: 0 }));
    let small = Some([640, 480]);
    for (u, row) in [(700.0, 400.0), (600.0, 500.0)] {
        let label = TuSimpleRecord { lanes: vec![vec![u]], h_samples: vec![row], ..Default::default() };
        let refused = evaluate_tusimple(&run, std::slice::from_ref(&label), small);
        assert_eq!(refused, Err(LaneError::LabelOutside { line: 1, picture_px: [640, 480] }));
        assert!(evaluate_tusimple(&run, &[label], Some(PICTURE_PX)).is_ok());
    }
    let label = TuSimpleRecord { lanes: vec![vec![1.0]], h_samples: vec![1.0, 2.0], ..Default::default() };
    let refused = evaluate_tusimple(&run, &[label], None);
    assert_eq!(refused, Err(LaneError::LabelRows { line: 1, rows: 2, points: 1 }));
}

#[test]
fn edges_in_pictures_are_scored_like_labels() {
    let drive = [truth(0, edge(200.0, 0.0), edge(800.0, 0.0)), truth(1, Vec::new(), Vec::new())];
    let run = [seen(0, edge(210.0, 0.0), edge(830.0, 0.0)), seen(1, Vec::new(), Vec::new())];
    let scores = evaluate_lanes(&run, &drive, PICTURE_PX, &LaneMeasure::default()).unwrap().tusimple.unwrap();
    assert_eq!(scores.pictures, 1);
    close(scores.accuracy, 0.5);
    close(scores.false_positives, 0.5);
    close(scores.false_negatives, 0.5);
}
