//! The numbers of lane edges as text.

use std::fmt::Write;

use fingerpost_eval::{LaneCell, LaneDeviation, LaneEvaluation, LaneMean, LaneMeasure, TuSimpleScores};

/// One clip.
pub(super) fn clip_table(name: &str, evaluation: &LaneEvaluation, measure: &LaneMeasure) -> String {
    let LaneEvaluation { picture_px: [width, height], frames, .. } = evaluation;
    let mut text = format!("{name}: {frames} frames of {width} x {height} pixels\n");
    // Writing to a string cannot fail.
    if let Some(accuracy_pct) = evaluation.mean_accuracy_pct {
        text.push_str(&deviation_rows(evaluation, measure));
        let _ = writeln!(text, "mean accuracy {accuracy_pct:.2} %");
    } else {
        text.push_str("no lane edges in the truth\n");
    }
    if evaluation.frames_without_record > 0 {
        let _ = writeln!(
            text,
            "{} frames of the truth are not in the run; their edges count as false",
            evaluation.frames_without_record
        );
    }
    if let Some(share_pct) = evaluation.false_lanes_pct {
        let (falsely, all) = (evaluation.false_lane_frames, evaluation.unmarked_frames);
        let _ = writeln!(text, "false lanes: {falsely} of {all} frames without markings, {share_pct:.2} %");
    }
    if evaluation.edges_not_in_truth > 0 {
        let (false_edges, all) = (evaluation.false_edges, evaluation.edges_not_in_truth);
        let _ = writeln!(text, "found where there is no edge: {false_edges} of {all}");
    }
    if let Some(scores) = &evaluation.tusimple {
        let _ = writeln!(text, "{}", tusimple_line(scores));
    }
    text
}

/// A row for every region of interest.
fn deviation_rows(evaluation: &LaneEvaluation, measure: &LaneMeasure) -> String {
    let mut text = format!("{}    RMSD px    s.d. px    no output\n", head(measure));
    for (cells, deviation) in
        evaluation.cells.chunks(measure.thresholds_px2.len()).zip(&evaluation.deviations)
    {
        let LaneDeviation { edges, edges_without_output, .. } = deviation;
        let mean = number(deviation.rmsd_mean_px);
        let spread = number(deviation.rmsd_standard_deviation_px);
        // Writing to a string cannot fail.
        let _ =
            writeln!(text, "{}    {mean:>7}    {spread:>7}    {edges_without_output} of {edges}", row(cells));
    }
    text
}

/// The mean of several clips.
pub(super) fn mean_table(mean: &LaneMean, measure: &LaneMeasure) -> String {
    let mut text = format!("mean of {} clips\n{}    RMSD px\n", mean.clips, head(measure));
    for (cells, rmsd_px) in mean.cells.chunks(measure.thresholds_px2.len()).zip(&mean.rmsd_mean_px) {
        let _ = writeln!(text, "{}    {:>7}", row(cells), number(*rmsd_px));
    }
    let _ = writeln!(text, "mean accuracy {:.2} %", mean.mean_accuracy_pct);
    text
}

/// The benchmark's scores.
pub(super) fn tusimple_line(scores: &TuSimpleScores) -> String {
    let TuSimpleScores { pictures, accuracy, false_positives, false_negatives } = scores;
    format!(
        "TuSimple: accuracy {accuracy:.4}, FP {false_positives:.4}, FN {false_negatives:.4} over {pictures} pictures"
    )
}

fn head(measure: &LaneMeasure) -> String {
    let thresholds = measure.thresholds_px2.iter();
    let thresholds = thresholds.map(|threshold| format!("{:>10}", format!("<= {threshold} px²")));
    format!("ROI rows  {}", thresholds.collect::<Vec<_>>().join("  "))
}

fn row(cells: &[LaneCell]) -> String {
    let rows = cells.first().map_or(0, |cell| cell.roi_rows);
    let accuracies = cells.iter().map(|cell| format!("{:>10}", format!("{:.2} %", cell.accuracy_pct)));
    format!("{rows:>8}  {}", accuracies.collect::<Vec<_>>().join("  "))
}

fn number(px: Option<f64>) -> String {
    px.map_or("-".to_owned(), |px| format!("{px:.2}"))
}
