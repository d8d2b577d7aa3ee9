//! The few places of a run where a value is greatest, apart in time.

/// Places that are named for each value.
const PEAKS: usize = 3;
/// How far apart they are at least, seconds: nearer ones are of the same event.
const APART_S: f64 = 2.0;

/// The greatest of the values, each with its index in the run, the greatest first. `times_s` has the time of every index.
pub(crate) fn greatest_apart(
    values: impl IntoIterator<Item = (usize, f64)>,
    times_s: &[f64],
) -> Vec<(usize, f64)> {
    let mut greatest: Vec<(usize, f64)> = values.into_iter().collect();
    // Of equal ones the earlier first.
    greatest.sort_by(|a, b| b.1.total_cmp(&a.1));
    let time_s = |index: usize| times_s.get(index).copied().unwrap_or(f64::NAN);
    let mut chosen: Vec<(usize, f64)> = Vec::new();
    for (index, value) in greatest {
        if chosen.len() == PEAKS {
            break;
        }
        if chosen.iter().all(|(other, _)| (time_s(*other) - time_s(index)).abs() >= APART_S) {
            chosen.push((index, value));
        }
    }
    chosen
}
