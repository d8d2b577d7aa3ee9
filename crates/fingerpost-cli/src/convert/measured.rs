//! Measurements that a recording's topics say beside its pictures.

use std::fmt;

/// Measurements of one topic, until the pictures' times are known.
#[derive(Debug)]
pub(super) struct Measured<T> {
    /// Name of the topic; empty where the recording has none.
    topic: String,
    /// What they are, in the plural.
    what: &'static str,
    /// With their times, nanoseconds.
    values: Vec<(u64, T)>,
}

/// Measurements of one topic with their times, nanoseconds, which grow.
#[derive(Debug, Clone, Copy)]
pub(super) struct Timed<'a, T> {
    pub(super) topic: &'a str,
    pub(super) values: &'a [(u64, T)],
}

/// Measurements that are stamped before the first picture or after the last.
#[derive(Debug)]
pub(super) struct Outside<'a> {
    topic: &'a str,
    what: &'static str,
    count: usize,
    all: usize,
    /// When the first and the last of all were, seconds after the first picture.
    span_s: [f64; 2],
    /// When the last picture was.
    last_picture_s: f64,
}

impl<T> Measured<T> {
    pub(super) fn of(topic: Option<&str>, what: &'static str) -> Self {
        Self { topic: topic.unwrap_or_default().to_owned(), what, values: Vec::new() }
    }

    pub(super) fn add(&mut self, at_ns: u64, value: T) {
        self.values.push((at_ns, value));
    }

    pub(super) fn is_empty(&self) -> bool {
        self.values.is_empty()
    }

    /// Those from the first picture to the last, in the order of time, and what is to be said of the others.
    pub(super) fn during(&mut self, first_ns: u64, last_ns: u64) -> (Timed<'_, T>, Option<Outside<'_>>) {
        self.values.sort_by_key(|(at_ns, _)| *at_ns);
        let Self { topic, what, values } = self;
        let begin = values.partition_point(|(at_ns, _)| *at_ns < first_ns);
        let end = values.partition_point(|(at_ns, _)| *at_ns <= last_ns).max(begin);
        let inside = &values[begin..end];
        let outside = values.first().zip(values.last()).filter(|_| inside.len() < values.len());
        let outside = outside.map(|((first, _), (last, _))| Outside {
            topic,
            what,
            count: values.len() - inside.len(),
            all: values.len(),
            span_s: [*first, *last].map(|at_ns| seconds_after(at_ns, first_ns)),
            last_picture_s: seconds_after(last_ns, first_ns),
        });
        (Timed { topic, values: inside }, outside)
    }
}

impl fmt::Display for Outside<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { topic, what, count, all, span_s: [from_s, to_s], last_picture_s } = self;
        if count < all {
            return write!(
                f,
                "{count} of the {all} {what} of {topic} are not used: they are stamped before the first picture or after the last, which \
                 is {last_picture_s:.1} s after it; all are stamped {from_s:.1} to {to_s:.1} s after the first"
            );
        }
        write!(
            f,
            "none of the {all} {what} of {topic} is used: they are stamped {from_s:.1} to {to_s:.1} s after the first picture, and the \
             last picture is {last_picture_s:.1} s after it; their clock is another one"
        )
    }
}

/// Negative before.
pub(super) fn seconds_after(at_ns: u64, since_ns: u64) -> f64 {
    (i128::from(at_ns) - i128::from(since_ns)) as f64 * 1e-9
}

#[cfg(test)]
mod tests {
    use super::*;

    const S: u64 = 1_000_000_000;

    /// How many of the measurements are used, and what is said.
    fn during(stamps_s: &[u64]) -> (usize, String) {
        let mut measured = Measured::of(Some("/imu"), "inertial measurements");
        stamps_s.iter().for_each(|at_s| measured.add(at_s * S, ()));
        let (inside, outside) = measured.during(10_000 * S, 10_020 * S);
        assert!(inside.values.is_sorted_by_key(|(at_ns, ())| *at_ns));
        (inside.values.len(), outside.map_or(String::new(), |outside| outside.to_string()))
    }

    #[test]
    fn what_was_measured_before_or_after_the_pictures_is_counted() {
        assert_eq!(during(&[]), (0, String::new()));
        assert_eq!(during(&[10_020, 10_000, 10_007]), (3, String::new()));
        let (used, said) = during(&[10_025, 10_010, 9_990]);
        assert!(used == 1 && said.contains("2 of the 3") && said.contains("-10.0 to 25.0 s"), "{said}");
        // Hours ahead, hours behind, since the start of a computer, and on both sides.
        for stamps_s in [[17_200, 17_201], [2_800, 2_801], [0, 20], [1, 90_000]] {
            let (used, said) = during(&stamps_s);
            assert!(used == 0 && said.contains("none of the 2") && said.contains("/imu"), "{said}");
            assert!(said.contains("20.0 s after it") && said.contains("another one"), "{said}");
        }
    }
}
