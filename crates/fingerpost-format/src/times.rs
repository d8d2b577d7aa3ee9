//! `times.txt`: seconds, one a line, for a folder of pictures.

use thiserror::Error;

/// A `times.txt` that cannot be used.
#[derive(Debug, PartialEq, Error)]
pub enum TimesError {
    /// A line is not a number of seconds.
    #[error(
        "line {line} of times.txt is not a number of seconds up to ten thousand million: {text:?}; mend it or remove the file"
    )]
    NotANumber {
        /// Line number, from one.
        line: usize,
        /// What stands there.
        text: String,
    },
    /// Time runs backwards.
    #[error("times.txt runs backwards at line {line}; sort it like the pictures")]
    Backwards {
        /// Line number, from one.
        line: usize,
    },
}

/// Largest time to either side of zero, seconds: 1970 and 317 years. Counts of milliseconds since then are beyond it, and
/// differences of what is within are exact to microseconds.
const LARGEST_S: f64 = 1e10;

/// The times of a `times.txt`, counted from its first line, seconds.
///
/// # Errors
/// [`TimesError`] names the first line that is no number, is beyond 1e10 seconds, or lies before the one above it.
///
/// ```
/// assert_eq!(fingerpost_format::parse_times("5.0\n5.1e0\n").unwrap().len(), 2);
/// assert!(fingerpost_format::parse_times("5.0\n4.9\n").is_err());
/// ```
pub fn parse_times(text: &str) -> Result<Vec<f64>, TimesError> {
    let mut times: Vec<f64> = Vec::new();
    for (i, line) in text.lines().enumerate().filter(|(_, line)| !line.trim().is_empty()) {
        let time = line.trim().parse::<f64>().ok().filter(|time| time.abs() <= LARGEST_S);
        let time = time.ok_or_else(|| TimesError::NotANumber { line: i + 1, text: line.to_owned() })?;
        if times.last().is_some_and(|last| time < *last) {
            return Err(TimesError::Backwards { line: i + 1 });
        }
        times.push(time);
    }
    let first = times.first().copied().unwrap_or(0.0);
    Ok(times.into_iter().map(|time| time - first).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_span_of_accepted_times_is_infinite() {
        let numbers =
            ["-1.7e308", "-1e300", "-1e11", "-1e10", "0", "1e10", "1.7e12", "1e300", "1.7e308", "inf", "NaN"];
        for (i, first) in numbers.iter().enumerate() {
            for last in &numbers[i..] {
                let is_possible = |text: &str| text.parse::<f64>().unwrap().abs() <= 1e10;
                let read = parse_times(&format!("{first}\n{last}\n"));
                assert_eq!(read.is_ok(), is_possible(first) && is_possible(last), "{first} to {last}");
                assert!(read.unwrap_or_default().iter().all(|t_s| t_s.is_finite()), "{first} to {last}");
            }
        }
    }
}
