//! Variables with their terms, and rules between them.

use super::membership::Membership;

/// A variable.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Variable {
    pub(super) name: String,
    /// Least and greatest value.
    pub(super) range: [f64; 2],
    pub(super) terms: Vec<Term>,
}

/// A word for a part of a variable's range.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Term {
    pub(super) name: String,
    pub(super) membership: Membership,
}

/// Whether a condition asks for a term or for its contrary.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Asks {
    Is,
    IsNot,
}

/// Variable and term by their places in the rule base.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Said {
    pub(super) variable: usize,
    pub(super) term: usize,
}

/// A rule: all conditions together lead to all conclusions.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Rule {
    pub(super) text: String,
    pub(super) conditions: Vec<(Asks, Said)>,
    pub(super) conclusions: Vec<Said>,
}

/// Variables and rules, made from text by [`RuleBase::parse`].
#[derive(Debug, Clone, PartialEq)]
pub struct RuleBase {
    pub(super) inputs: Vec<Variable>,
    pub(super) outputs: Vec<Variable>,
    pub(super) rules: Vec<Rule>,
}

impl RuleBase {
    /// The names of the inputs, in the order of the text.
    pub fn inputs(&self) -> impl Iterator<Item = &str> {
        self.inputs.iter().map(|variable| variable.name.as_str())
    }

    /// The names of the outputs, in the order of the text.
    pub fn outputs(&self) -> impl Iterator<Item = &str> {
        self.outputs.iter().map(|variable| variable.name.as_str())
    }

    /// The rules' texts without the word `rule`, in their order; rule 1 is the first.
    pub fn rules(&self) -> impl ExactSizeIterator<Item = &str> {
        self.rules.iter().map(|rule| rule.text.as_str())
    }
}
