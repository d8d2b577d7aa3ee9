//! Numbers in the names of pictures: decimal ones, whose order is that of their values, and times.
//!
//! A point between digits is a decimal point or parts two counts: 1.9 comes before 1.10 as versions and drives are counted, and behind
//! it as a number. It is a decimal point where the whole name is such a number, or where the digits behind it begin with a zero that
//! counts are not written with; and it is none where the digits behind it are of different lengths and end in zeros, which numbers are
//! not written with. Names that are of one length have the same order either way. A comma between digits is read as a point is.

use thiserror::Error;

/// Digits behind a decimal point that count: billionths.
const FRACTION_DIGITS: usize = 9;
/// One, in billionths.
const WHOLE: i128 = 1_000_000_000;

/// Stamps without a point, by their digits: milliseconds, microseconds and nanoseconds since 1970, and the nanoseconds in each. From
/// 2001 to 2033 they begin with a 1, which counts that are filled up with zeros do not.
const STAMPS: [(usize, i128); 3] = [(13, 1_000_000), (16, 1000), (19, 1)];

/// Middle step from time to time of a drive's pictures, nanoseconds: at 1000 to 0.01 a second, the rates that an input may have.
const STEPS_NS: std::ops::RangeInclusive<i128> = 1_000_000..=100_000_000_000;

/// Why pictures that are named by times have none.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum TimesDoubt {
    /// Most of them are, and some are not.
    #[error(
        "{others} of the {pictures} pictures, {first} first, are not named by a time as the others are: their order is by name, and may be \
         wrong; take out what is no picture of the drive, or give a times.txt"
    )]
    OtherNames {
        /// The first that is not.
        first: String,
        /// How many are not.
        others: usize,
        /// How many there are.
        pictures: usize,
    },
    /// Some have the time of another one.
    #[error(
        "{repeated} of the {pictures} pictures, {first} first, have the time of the picture before them in their names, so none of these times \
         is used; take out what is there twice, or give a times.txt"
    )]
    Repeated {
        /// The first that has.
        first: String,
        /// How many have.
        repeated: usize,
        /// How many there are.
        pictures: usize,
    },
}

impl TimesDoubt {
    /// The doubt about pictures with these names, without their endings and in their order, of which the times are not known; none
    /// where most of the names are no times at all.
    pub(crate) fn of(stems: &[&str]) -> Option<Self> {
        let pictures = stems.len();
        if let Some(names) = NumberedNames::of(stems) {
            let repeats: Vec<usize> = (1..pictures).filter(|&i| names.0[i] == names.0[i - 1]).collect();
            let first = stems[*repeats.first()?].to_owned();
            return names.are_plausible().then_some(Self::Repeated {
                first,
                repeated: repeats.len(),
                pictures,
            });
        }
        let numbers: Vec<Option<Number<'_>>> = stems.iter().map(|stem| Number::at_end_of(stem)).collect();
        // Decimal numbers are alike in the letters before them, stamps in their length too, and times with and without zeros at
        // their ends not.
        let kinds: [fn(&Number<'_>) -> usize; 3] = [
            |_| 0,
            |number| number.whole.len(),
            |number| usize::from(number.fraction.is_some_and(ends_in_zero)),
        ];
        // Counts behind a point may end in zeros; numbers that begin with zeros behind it are no counts.
        let are_counts = !numbers.iter().flatten().any(|number| number.fraction.is_some_and(is_padded));
        kinds.into_iter().take(if are_counts { 2 } else { 3 }).find_map(|kind| {
            let kinds: Vec<Option<(&str, usize)>> =
                numbers.iter().map(|number| number.map(|number| (number.letters, kind(&number)))).collect();
            let most = majority(&kinds)?;
            let alike: Vec<&str> =
                stems.iter().zip(&kinds).filter(|(_, kind)| **kind == most).map(|(stem, _)| *stem).collect();
            let mut times = NumberedNames::of(&alike)?;
            times.0.sort_unstable();
            times.times_s()?;
            let other = kinds.iter().position(|kind| *kind != most)?;
            let first = stems[other].to_owned();
            Some(Self::OtherNames { first, others: pictures - alike.len(), pictures })
        })
    }
}

/// What more than half of them are; none where they are nothing, or no such half is.
fn majority<T: Copy + PartialEq>(kinds: &[Option<T>]) -> Option<Option<T>> {
    // Boyer and Moore: what is left when unlike ones are taken away in pairs.
    let (mut most, mut left) = (None, 0);
    for kind in kinds {
        if left == 0 {
            most = *kind;
        }
        left = if *kind == most { left + 1 } else { left - 1 };
    }
    let count = kinds.iter().filter(|kind| **kind == most).count();
    (most.is_some() && 2 * count > kinds.len()).then_some(most)
}

/// Numbers that names end in, in billionths; of stamps they are nanoseconds.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct NumberedNames(pub(crate) Vec<i128>);

impl NumberedNames {
    /// The numbers of names, without their endings, that are decimal numbers or stamps behind the same letters; none where natural
    /// order is to order them.
    pub(crate) fn of(stems: &[&str]) -> Option<Self> {
        let parts: Vec<Number<'_>> =
            stems.iter().map(|stem| Number::at_end_of(stem)).collect::<Option<_>>()?;
        let first = parts.first()?;
        if parts.iter().any(|number| number.letters != first.letters) {
            return None;
        }
        if parts.iter().any(|number| number.fraction.is_some()) {
            return are_decimal(&parts).then(|| Self(parts.iter().map(Number::billionths).collect()));
        }
        let unit =
            STAMPS.iter().find(|(digits, _)| first.whole.len() == *digits).map(|(_, unit_ns)| *unit_ns)?;
        let is_stamp =
            |number: &Number<'_>| number.whole.len() == first.whole.len() && number.whole.starts_with('1');
        parts.iter().all(is_stamp).then(|| Self(parts.iter().map(|number| number.value() * unit).collect()))
    }

    /// The numbers as times, seconds since the first; none where they do not rise, or not as a drive's pictures do.
    pub(crate) fn times_s(&self) -> Option<Vec<f64>> {
        let first = *self.0.first()?;
        let rise = self.0.windows(2).all(|pair| pair[1] > pair[0]);
        (rise && self.are_plausible())
            .then(|| self.0.iter().map(|ns| (ns - first) as f64 / WHOLE as f64).collect())
    }

    /// Whether their middle step is one from picture to picture.
    fn are_plausible(&self) -> bool {
        let mut steps: Vec<i128> = self.0.windows(2).map(|pair| pair[1] - pair[0]).collect();
        steps.sort_unstable();
        steps.get(steps.len() / 2).is_some_and(|middle| STEPS_NS.contains(middle))
    }
}

/// The number at the end of a name.
#[derive(Debug, Clone, Copy)]
struct Number<'a> {
    letters: &'a str,
    whole: &'a str,
    fraction: Option<&'a str>,
}

impl<'a> Number<'a> {
    fn at_end_of(stem: &'a str) -> Option<Self> {
        let (rest, last) = split_digits(stem);
        let before = rest.strip_suffix(['.', ',']).map(split_digits).filter(|(_, whole)| !whole.is_empty());
        let (letters, whole, fraction) = match before {
            Some((letters, whole)) => (letters, whole, Some(last)),
            None => (rest, last, None),
        };
        // The largest stamp has nineteen digits.
        let is_number = !last.is_empty() && whole.len() <= 19 && !letters.ends_with(['.', ',', '-']);
        is_number.then_some(Self { letters, whole, fraction })
    }

    fn value(&self) -> i128 {
        self.whole.bytes().fold(0, |value, digit| value * 10 + i128::from(digit - b'0'))
    }

    fn billionths(&self) -> i128 {
        let digits = self.fraction.unwrap_or_default().bytes().chain(std::iter::repeat(b'0'));
        let fraction =
            digits.take(FRACTION_DIGITS).fold(0, |value, digit| value * 10 + i128::from(digit - b'0'));
        self.value() * WHOLE + fraction
    }
}

/// Whether the points in numbers of which some have one are decimal points.
fn are_decimal(numbers: &[Number<'_>]) -> bool {
    let fractions = || numbers.iter().filter_map(|number| number.fraction);
    let length = fractions().next().map_or(0, str::len);
    let are_even = fractions().all(|fraction| fraction.len() == length);
    let are_alone = numbers.iter().all(|number| number.letters.is_empty());
    if are_even {
        are_alone || fractions().any(is_padded)
    } else {
        !fractions().any(ends_in_zero) && (are_alone || fractions().any(is_padded))
    }
}

/// Whether digits behind a point begin as those of counts do not.
fn is_padded(fraction: &str) -> bool {
    fraction.len() > 1 && fraction.starts_with('0')
}

/// Whether digits behind a point end as those of numbers do not.
fn ends_in_zero(fraction: &str) -> bool {
    fraction.len() > 1 && fraction.ends_with('0')
}

/// A text and the digits at its end.
fn split_digits(text: &str) -> (&str, &str) {
    let digits = text.bytes().rev().take_while(u8::is_ascii_digit).count();
    text.split_at(text.len() - digits)
}

#[cfg(test)]
#[allow(clippy::float_cmp, reason = "times are the nearest numbers to those in the names")]
mod tests {
    use super::*;

    fn times_s(stems: &[&str]) -> Option<Vec<f64>> {
        NumberedNames::of(stems)?.times_s()
    }

    #[test]
    fn decimal_times_of_any_length_are_seconds() {
        for stems in [
            ["1305031102.05", "1305031102.1", "1305031102.15", "1305031103"],
            ["102.05", "102.1", "102.15", "103.0"],
            ["99.95", "100", "100.05", "100.9"],
            ["left_0.05", "left_0.1", "left_0.15", "left_1"],
            ["102,05", "102,1", "102,15", "103"],
            ["1305031102.050000", "1305031102.100000", "1305031102.150000", "1305031103.000000"],
        ] {
            let times = times_s(&stems).unwrap();
            assert_eq!(times[..2], [0.0, 0.05], "{stems:?}");
            assert_eq!(times[3..], [0.95], "{stems:?}");
        }
    }

    #[test]
    fn long_stamps_are_counts_since_1970() {
        for (ending, prefix) in [("", ""), ("000", ""), ("000000", ""), ("", "cam_")] {
            let stems =
                ["1403636579763", "1403636579813", "1403636580763"].map(|ms| format!("{prefix}{ms}{ending}"));
            let stems: Vec<&str> = stems.iter().map(String::as_str).collect();
            assert_eq!(times_s(&stems), Some(vec![0.0, 0.05, 1.0]), "{stems:?}");
        }
    }

    #[test]
    fn counts_are_no_times_and_keep_their_natural_order() {
        for stems in [
            &["0000000000", "0000000001"][..],
            &["9", "10", "11"],
            &["1.8", "1.9", "1.10"],
            &["run1.8", "run1.9", "run1.11"],
            &["102.5000000", "102.50000000"],
            &["frame.8", "frame.9", "frame.10"],
            &["a1.05", "b1.1"],
            &["1.2.3", "1.2.4"],
            &["0000001403636579763", "0000001403636579813"],
            &["a", "b"],
            &["1.5x", "1.6x"],
            &[],
        ] {
            assert_eq!(NumberedNames::of(stems), None, "{stems:?}");
        }
    }

    #[test]
    fn names_that_keep_others_from_being_times_are_doubted() {
        let other = |first: &str, pictures| {
            Some(TimesDoubt::OtherNames { first: first.to_owned(), others: 1, pictures })
        };
        for (stems, doubt) in [
            (&["102.05", "102.1", "102.15", "cover"][..], other("cover", 4)),
            (&["102.05", "102.1", "102.15", "left_103.5"], other("left_103.5", 4)),
            (&["1403636579763", "1403636579813", "14036365798"], other("14036365798", 3)),
            (&["102.1", "102.05", "102.10", "102.15"], other("102.10", 4)),
            (
                &["102.05", "102.05", "102.10", "102.15"],
                Some(TimesDoubt::Repeated { first: "102.05".to_owned(), repeated: 1, pictures: 4 }),
            ),
            (&["102.05", "102.1", "102.15"], None),
            (&["1", "2", "3", "cover"], None),
            (&["1.8", "1.9", "1.10", "1.11"], None),
            (&["102.05", "102.1", "a", "b"], None),
            (&["a", "b", "c"], None),
            (&[], None),
        ] {
            assert_eq!(TimesDoubt::of(stems), doubt, "{stems:?}");
        }
    }

    #[test]
    fn numbers_that_do_not_rise_as_pictures_do_are_no_times() {
        for stems in [&["1.5", "1.50"][..], &["0.5", "500.25", "1000.75"], &["0.00001", "0.00002"], &["1.5"]]
        {
            assert_eq!(times_s(stems), None, "{stems:?}");
        }
    }
}
