//! The front as a table on standard error.

use fingerpost_format::{TuningFront, TuningPoint, TuningPurpose, TuningScores, TuningTrial};

use crate::output;

/// Prints the settings that the search began with, and the front below them.
pub(super) fn print(front: &TuningFront, done: &[TuningTrial]) {
    let [tuned, held_back] = front.drives;
    let side = |name: &str, drives: u64| format!("{name}, {}", counted(drives));
    output::message(&format!("{:15}  {:41}  {:41}", "", side("tuned", tuned), side("held back", held_back)));
    let columns = "missed  false  error, m, p50 and p95  by sigma";
    output::message(&format!("settings  trial  {columns}  {columns}  ms a frame"));
    let rows = [("defaults", &front.defaults)]
        .into_iter()
        .chain(front.front.iter().map(|point| (point.config.as_deref().unwrap_or_default(), point)));
    for (name, point) in rows {
        output::message(&row(name, point, done));
    }
    for trial in done.iter().filter(|trial| trial.purpose == TuningPurpose::HeldBack) {
        if let Some(cause) = &trial.error {
            output::message(&format!("trial {} failed on a drive that is held back: {cause}", trial.trial));
        }
    }
}

/// Drives in words.
pub(super) fn counted(drives: u64) -> String {
    if drives == 1 { "1 drive".to_owned() } else { format!("{drives} drives") }
}

fn row(name: &str, point: &TuningPoint, done: &[TuningTrial]) -> String {
    let on_tuned =
        |trial: &&TuningTrial| trial.trial == point.trial && trial.purpose == TuningPurpose::Search;
    let ms = number(done.iter().find(on_tuned).map(|trial| trial.ms_per_frame), 1);
    let [tuned, held_back] = [point.tuned, point.held_back].map(|scores| cells(scores.unwrap_or_default()));
    format!("{name:<8}  {:>5}  {tuned}  {held_back}  {ms:>10}", point.trial)
}

/// Features missed, percent; false detections a drive; errors; the 68th percentile of error by sigma.
fn cells(scores: TuningScores) -> String {
    let TuningScores { missed_share, false_per_drive, error_p50_m, error_p95_m, error_per_sigma_p68, .. } =
        scores;
    let missed = number(missed_share.map(|share| 100.0 * share), 0);
    let [false_, p50, p95, by_sigma] =
        [false_per_drive, error_p50_m, error_p95_m, error_per_sigma_p68].map(|v| number(v, 2));
    format!("{missed:>4} %  {false_:>5}  {p50:>12}  {p95:>8}  {by_sigma:>8}")
}

fn number(value: Option<f64>, digits: usize) -> String {
    value.map_or("-".to_owned(), |value| format!("{value:.digits$}"))
}
