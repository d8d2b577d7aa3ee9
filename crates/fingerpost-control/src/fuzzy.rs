//! Mamdani fuzzy control: rules that are text.
//!
//! E. H. Mamdani and S. Assilian, "An experiment in linguistic synthesis with a fuzzy logic controller", International Journal of
//! Man-Machine Studies 7(1), 1975: the conditions of a rule hold as far as the least of them does (minimum), a conclusion is
//! cut there, what several rules conclude is joined (maximum), and its centroid is the output.
//!
//! # The text
//!
//! One statement a line; `#` begins a comment. `input` and `output` name a variable and its range, what is beyond it counts as its
//! end; the lines below them name its terms by the corners of their triangle (three numbers) or trapezoid (four). `rule`
//! says one thing:
//!
//! ```text
//! input offset_deg -30 30
//!   right   -30 -30 -10 0
//!   middle  -10   0  10
//!   left      0  10  30 30
//! output turn_deg -60 60
//!   to_right -40 -20 0
//!   on       -10   0 10
//!   to_left    0  20 40
//! rule if offset_deg is left then turn_deg is to_right
//! rule if offset_deg is not left and offset_deg is not right then turn_deg is on
//! ```
//!
//! What the controller's variables mean says [`FuzzyController`]; the shipped rules are [`DEFAULT_RULES`].

mod controller;
mod inference;
mod membership;
mod parse;
mod rule_base;

use thiserror::Error;

pub use controller::{DEFAULT_RULES, FuzzyController};
pub use inference::Inference;
pub use membership::Membership;
pub use rule_base::RuleBase;

/// A rule text that cannot be used.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum FuzzyError {
    /// A line is no statement.
    #[error("line {line} of the fuzzy rules: {found:?} is not understood; write {expected}")]
    Statement {
        /// Its number, from one.
        line: usize,
        /// What stands there.
        found: String,
        /// What could stand there.
        expected: &'static str,
    },
    /// A line has a number that cannot be used.
    #[error("line {line} of the fuzzy rules: {found:?} cannot be used; give {expected}")]
    Number {
        /// The line's number, from one.
        line: usize,
        /// What stands there.
        found: String,
        /// What could stand there.
        expected: &'static str,
    },
    /// A name stands for two things.
    #[error("line {line} of the fuzzy rules: {name:?} is there already; take another name")]
    Twice {
        /// The line's number, from one.
        line: usize,
        /// The name.
        name: String,
    },
    /// A name stands for nothing.
    #[error("line {line} of the fuzzy rules: there is no {what} {name:?}; there are {known}")]
    Unknown {
        /// The line's number, from one.
        line: usize,
        /// What is looked for.
        what: &'static str,
        /// The name.
        name: String,
        /// Names that there are.
        known: String,
    },
    /// A variable means nothing to the controller.
    #[error("the fuzzy rules have an {what} {name:?}, which means nothing here; there are {known}")]
    Meaning {
        /// What it is in the text.
        what: &'static str,
        /// Its name.
        name: String,
        /// Names that mean something.
        known: String,
    },
    /// Something is missing from the text as a whole.
    #[error("the fuzzy rules have no {what}; add one")]
    Missing {
        /// What is missing.
        what: &'static str,
    },
}
