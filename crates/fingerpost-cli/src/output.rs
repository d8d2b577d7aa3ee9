//! What the program says: data on standard output, everything else on standard error.

use std::io::{self, Write};

use anyhow::{Context, Result};
use indicatif::{ProgressBar, ProgressStyle};
use serde::Serialize;

/// A line on standard error. Where nobody can read it any more, the program goes on without saying it.
pub(crate) fn message(text: &str) {
    let _ = writeln!(io::stderr(), "{text}");
}

/// Data on standard output, as one JSON object on a line.
pub(crate) fn print_json<T: Serialize>(data: &T) -> Result<()> {
    let text = serde_json::to_string(data).context("the result cannot be written as JSON")?;
    print_text(&text)
}

/// Data on standard output, as a line of text.
pub(crate) fn print_text(text: &str) -> Result<()> {
    writeln!(io::stdout(), "{text}").context("standard output cannot be written; check where it leads")
}

/// An error with everything that led to it on one line; causes that a message already holds are not said twice.
pub(crate) fn cause_chain(error: &anyhow::Error) -> String {
    error.chain().map(ToString::to_string).fold(String::new(), |chain, cause| match chain {
        chain if chain.is_empty() => cause,
        chain if chain.contains(&cause) => chain,
        chain => format!("{chain}: {cause}"),
    })
}

/// A bar on standard error, shown where that is a terminal; without a length it counts.
pub(crate) fn progress(length: Option<u64>, unit: &str) -> ProgressBar {
    let (bar, template) = match length {
        Some(length) => (
            ProgressBar::new(length),
            format!("{{wide_bar}} {{pos}}/{{len}} {unit}, {{per_sec}}, {{eta}} left"),
        ),
        None => (ProgressBar::no_length(), format!("{{spinner}} {{pos}} {unit}, {{per_sec}}")),
    };
    match ProgressStyle::with_template(&template) {
        Ok(style) => bar.with_style(style),
        Err(_) => bar,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cause_that_is_said_is_not_said_again() {
        let error = anyhow::anyhow!("disk full").context("a.txt cannot be written (disk full)");
        assert_eq!(cause_chain(&error), "a.txt cannot be written (disk full)");
        let error = anyhow::anyhow!("disk full").context("the run ended");
        assert_eq!(cause_chain(&error), "the run ended: disk full");
    }
}
