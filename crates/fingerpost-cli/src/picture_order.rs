//! Pictures that come out of their order.

use thiserror::Error;

/// A picture taken less than this before the one that was used last was passed by that one, seconds; one taken longer before it shows
/// that a clock was set, or that another drive begins. Lines hold pictures back for a few frames.
const PASSED_WITHIN_S: f64 = 1.0;

/// A picture that shows what a later one has shown already.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
#[error(
    "the picture was taken {before_s:.3} s before the one that was used last; it is left out, send pictures in the order of their times"
)]
pub(crate) struct OutOfOrder {
    before_s: f64,
}

impl OutOfOrder {
    /// Of a picture taken at `t_s` after one taken at `last_t_s` was used, seconds; none where it comes in order.
    pub(crate) fn of(last_t_s: Option<f64>, t_s: f64) -> Option<Self> {
        let before_s = last_t_s? - t_s;
        (before_s > 0.0 && before_s < PASSED_WITHIN_S).then_some(Self { before_s })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_picture_is_out_of_order_where_a_later_one_was_just_used() {
        let is_out_of_order = |last_t_s, t_s| OutOfOrder::of(last_t_s, t_s).is_some();
        assert!(is_out_of_order(Some(2.1), 2.0));
        assert!(!is_out_of_order(Some(2.0), 2.1));
        assert!(!is_out_of_order(Some(2.0), 2.0), "two pictures of one time");
        assert!(!is_out_of_order(None, 2.0), "the first one");
        assert!(!is_out_of_order(Some(60.0), 0.0), "a clock that was set");
    }
}
