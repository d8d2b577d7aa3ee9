//! How well two results agree.

use crate::results::Agreement;

/// At least `share` of the values differ by at most `tolerance`.
pub fn within(ours: &[u8], theirs: &[u8], tolerance: u8, share: f64) -> Agreement {
    let near = ours.iter().zip(theirs).filter(|(a, b)| a.abs_diff(**b) <= tolerance).count();
    share_of(near, ours.len().max(theirs.len()), share, &format!("within {tolerance}"))
}

/// At least `share` of the values are the same.
pub fn same(ours: &[u8], theirs: &[u8], share: f64) -> Agreement {
    let same = ours.iter().zip(theirs).filter(|(a, b)| a == b).count();
    share_of(same, ours.len().max(theirs.len()), share, "the same")
}

/// At least `share` of `all` values are as `condition` says.
pub fn share_of(good: usize, all: usize, share: f64, condition: &str) -> Agreement {
    let found = good as f64 / all.max(1) as f64;
    let text = format!("{:.3} % {condition} (of {} %)", 100.0 * found, 100.0 * share);
    Agreement { found: text, holds: all > 0 && found >= share }
}

/// All values are the same.
pub fn identical<T: PartialEq>(ours: &[T], theirs: &[T]) -> Agreement {
    let same = ours.iter().zip(theirs).filter(|(a, b)| a == b).count();
    let all = ours.len().max(theirs.len());
    let found = if same == all { "identical".to_owned() } else { format!("{} of {all} differ", all - same) };
    Agreement { found, holds: all > 0 && same == all }
}

/// No two values differ by more than `bound`.
pub fn floats_within(ours: &[f32], theirs: &[f32], bound: f32) -> Agreement {
    let largest = ours.iter().zip(theirs).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
    let holds = !ours.is_empty() && ours.len() == theirs.len() && largest <= bound;
    Agreement { found: format!("largest difference {largest:.1e} (of {bound:.0e})"), holds }
}

/// The figure is at most `bound`.
pub fn at_most(what: &str, found: f64, bound: f64) -> Agreement {
    Agreement { found: format!("{what} {found:.4} (of {bound})"), holds: found <= bound }
}
