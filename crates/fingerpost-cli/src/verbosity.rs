//! How much is said on standard error: `-q`, `-v` and the environment's `RUST_LOG`.
//!
//! All that is said is a record of the crate `log`. The program's messages have a target of their own, [`MESSAGES`], and are
//! written as they are; every other record says its level and where it is from.

use std::env::{self, VarError};

use clap::{ArgAction, Args};
use env_filter::{Builder, Filter};
use log::{LevelFilter, Log, Metadata, Record};

use crate::output;

/// Target of the program's messages: results and what is wrong.
pub(crate) const MESSAGES: &str = "fingerpost::messages";
/// What the targets of this program's records begin with.
const PROGRAM: &str = "fingerpost";
/// The environment's filter, as for every program that logs through `log`.
const FILTER_VARIABLE: &str = "RUST_LOG";

/// The filter that the environment names.
pub(crate) fn of_environment() -> Option<String> {
    match env::var(FILTER_VARIABLE) {
        Ok(filter) => Some(filter),
        Err(VarError::NotPresent) => None,
        Err(VarError::NotUnicode(filter)) => Some(filter.to_string_lossy().into_owned()),
    }
}

/// How much is said.
#[derive(Debug, Clone, Copy, Args)]
pub(crate) struct Verbosity {
    /// Say besides what was read and chosen, and how long it took; -vv also what came of every frame or drive, in place of the progress
    /// bar. RUST_LOG, as in RUST_LOG=fingerpost::inputs=info, says it by module and level.
    #[arg(short, long, global = true, action = ArgAction::Count, conflicts_with = "quiet")]
    verbose: u8,
    /// Say nothing on standard error but what the program fails of: no results, no warnings, no progress bar.
    #[arg(short, long, global = true)]
    quiet: bool,
}

impl Verbosity {
    /// Says so much from now on; `environment` is what that asks for.
    pub(crate) fn begin(self, environment: Option<&str>) {
        let (filter, refused) = self.filter(environment);
        log::set_max_level(filter.filter());
        // There is none before this one.
        let _ = log::set_boxed_logger(Box::new(StandardError(filter)));
        if let Some(cause) = refused {
            output::message(&format!(
                "{FILTER_VARIABLE} is not used: {cause}; give levels, as in info or fingerpost::run=debug"
            ));
        }
    }

    /// The filter of these arguments and of the environment, where it names one, and why the environment's is not used.
    fn filter(self, environment: Option<&str>) -> (Filter, Option<String>) {
        if self.quiet {
            return (Builder::new().filter_module(MESSAGES, LevelFilter::Error).build(), None);
        }
        let mut filter = Builder::new();
        filter.filter_module(MESSAGES, LevelFilter::Info);
        match self.verbose {
            0 => (),
            1 => _ = filter.filter_module(PROGRAM, LevelFilter::Info),
            _ => _ = filter.filter_module(PROGRAM, LevelFilter::Debug),
        }
        // What the environment names replaces what the arguments say of the same.
        let refused =
            environment.and_then(|text| filter.try_parse(text).err().map(|cause| cause.to_string()));
        (filter.build(), refused)
    }
}

/// Standard error, for the records that pass a filter.
struct StandardError(Filter);

impl Log for StandardError {
    fn enabled(&self, metadata: &Metadata<'_>) -> bool {
        self.0.enabled(metadata)
    }

    fn log(&self, record: &Record<'_>) {
        match record.target() {
            // Not by what they say: RUST_LOG=info/map is about the other records.
            MESSAGES if self.enabled(record.metadata()) => output::line(&record.args().to_string()),
            target if target != MESSAGES && self.0.matches(record) => {
                output::line(&format!("[{} {target}] {}", record.level(), record.args()));
            }
            _ => (),
        }
    }

    fn flush(&self) {}
}

#[cfg(test)]
mod tests {
    use log::Level;

    use super::*;

    fn says(verbosity: Verbosity, environment: Option<&str>, level: Level, target: &str) -> bool {
        let (filter, _) = verbosity.filter(environment);
        filter.enabled(&Metadata::builder().level(level).target(target).build())
    }

    const USUAL: Verbosity = Verbosity { verbose: 0, quiet: false };
    const QUIET: Verbosity = Verbosity { quiet: true, ..USUAL };

    #[test]
    fn messages_are_said_unless_it_is_to_be_quiet_and_errors_always() {
        for environment in [None, Some("off"), Some("error"), Some("trace"), Some("fingerpost=off")] {
            assert!(says(USUAL, environment, Level::Info, MESSAGES), "{environment:?}");
            assert!(!says(QUIET, environment, Level::Info, MESSAGES), "{environment:?}");
            assert!(says(QUIET, environment, Level::Error, MESSAGES), "{environment:?}");
            assert!(!says(QUIET, environment, Level::Error, "hyper"), "{environment:?}");
        }
    }

    #[test]
    fn each_v_is_a_level_of_this_program_and_the_environment_says_it_by_module() {
        let verbose = |verbose| Verbosity { verbose, ..USUAL };
        for (level, from) in [(Level::Info, 1), (Level::Debug, 2)] {
            for count in 0..4 {
                assert_eq!(says(verbose(count), None, level, "fingerpost::inputs"), count >= from);
                assert!(!says(verbose(count), None, level, "hyper"));
            }
        }
        let one = Some("fingerpost::inputs=debug");
        assert!(says(USUAL, one, Level::Debug, "fingerpost::inputs"));
        assert!(!says(USUAL, one, Level::Info, "fingerpost::run"));
        assert!(says(verbose(1), one, Level::Info, "fingerpost::run"));
        assert!(says(USUAL, Some("info"), Level::Info, "hyper"));
        assert!(!says(verbose(1), Some("fingerpost=warn"), Level::Info, "fingerpost::run"));
    }

    #[test]
    fn a_filter_that_is_none_is_named_and_nothing_else_changes() {
        let (_, refused) = USUAL.filter(Some("fingerpost=loud"));
        assert!(refused.is_some_and(|cause| cause.contains("loud")));
        assert!(says(USUAL, Some("fingerpost=loud"), Level::Info, MESSAGES));
    }
}
