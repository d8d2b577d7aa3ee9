//! From text to a rule base.

use super::FuzzyError;
use super::membership::Membership;
use super::rule_base::{Asks, Rule, RuleBase, Said, Term, Variable};

const STATEMENT: &str = "\"input NAME FROM TO\", \"output NAME FROM TO\", \"rule if ... then ...\" or, below an input or output, \
                         \"TERM A B C\" or \"TERM A B C D\"";
const RULE: &str =
    "\"if VARIABLE is TERM and VARIABLE is not TERM then VARIABLE is TERM and VARIABLE is TERM\"";

/// Whose terms are being read.
#[derive(Debug, Clone, Copy)]
enum Reading {
    Nothing,
    Input,
    Output,
}

impl RuleBase {
    /// Reads a rule text.
    ///
    /// # Errors
    /// [`FuzzyError`] names the line and what could stand there.
    pub fn parse(text: &str) -> Result<Self, FuzzyError> {
        let mut base = Self { inputs: Vec::new(), outputs: Vec::new(), rules: Vec::new() };
        let mut reading = Reading::Nothing;
        for (line, statement) in (1..).zip(text.lines()) {
            let statement = statement.split('#').next().unwrap_or_default().trim();
            let words: Vec<&str> = statement.split_whitespace().collect();
            match (words.as_slice(), reading) {
                ([], _) => {}
                (["input", name, range @ ..], _) => {
                    let variable = base.variable(line, name, range)?;
                    base.inputs.push(variable);
                    reading = Reading::Input;
                }
                (["output", name, range @ ..], _) => {
                    let variable = base.variable(line, name, range)?;
                    base.outputs.push(variable);
                    reading = Reading::Output;
                }
                (["rule", words @ ..], _) => {
                    let rule = base.rule(line, words)?;
                    base.rules.push(rule);
                    reading = Reading::Nothing;
                }
                ([name, corners @ ..], Reading::Input) => {
                    add_term(base.inputs.last_mut(), line, name, corners)?
                }
                ([name, corners @ ..], Reading::Output) => {
                    add_term(base.outputs.last_mut(), line, name, corners)?
                }
                _ => return Err(not_understood(line, statement, STATEMENT)),
            }
        }
        for (what, missing) in [
            ("input with terms", base.inputs.iter().all(|variable| variable.terms.is_empty())),
            ("output with terms", base.outputs.iter().all(|variable| variable.terms.is_empty())),
            ("rule", base.rules.is_empty()),
        ] {
            if missing {
                return Err(FuzzyError::Missing { what });
            }
        }
        Ok(base)
    }

    fn variable(&self, line: usize, name: &str, range: &[&str]) -> Result<Variable, FuzzyError> {
        if self.inputs().chain(self.outputs()).any(|known| known == name) {
            return Err(FuzzyError::Twice { line, name: name.to_owned() });
        }
        let [from, to] = numbers(line, range)?.try_into().map_err(|_| FuzzyError::Number {
            line,
            found: range.join(" "),
            expected: "the least and the greatest value",
        })?;
        if from >= to {
            let expected = "a least value below the greatest";
            return Err(FuzzyError::Number { line, found: range.join(" "), expected });
        }
        Ok(Variable { name: name.to_owned(), range: [from, to], terms: Vec::new() })
    }

    fn rule(&self, line: usize, words: &[&str]) -> Result<Rule, FuzzyError> {
        let text = words.join(" ");
        let not_understood = || not_understood(line, &text, RULE);
        let Some((&"if", said)) = words.split_first() else { return Err(not_understood()) };
        let then = said.iter().position(|word| *word == "then").ok_or_else(not_understood)?;
        let (conditions, conclusions) = (&said[..then], &said[then + 1..]);
        let conditions = conditions.split(|word| *word == "and").map(|clause| match clause {
            [variable, "is", "not", term] => {
                Ok((Asks::IsNot, found(line, "input", &self.inputs, variable, term)?))
            }
            [variable, "is", term] => Ok((Asks::Is, found(line, "input", &self.inputs, variable, term)?)),
            _ => Err(not_understood()),
        });
        let conditions = conditions.collect::<Result<_, _>>()?;
        let conclusions = conclusions.split(|word| *word == "and").map(|clause| match clause {
            [variable, "is", term] => found(line, "output", &self.outputs, variable, term),
            _ => Err(not_understood()),
        });
        let conclusions = conclusions.collect::<Result<_, _>>()?;
        Ok(Rule { text, conditions, conclusions })
    }
}

/// Adds a term to the variable that is being read.
fn add_term(
    variable: Option<&mut Variable>,
    line: usize,
    name: &str,
    corners: &[&str],
) -> Result<(), FuzzyError> {
    let Some(variable) = variable else { return Err(not_understood(line, name, STATEMENT)) };
    if variable.terms.iter().any(|term| term.name == name)
        || matches!(name, "is" | "not" | "and" | "then" | "if")
    {
        return Err(FuzzyError::Twice { line, name: name.to_owned() });
    }
    let membership = match *numbers(line, corners)?.as_slice() {
        [a, b, c] => Membership::triangle([a, b, c]),
        [a, b, c, d] => Membership::trapezoid([a, b, c, d]),
        _ => None,
    };
    let membership = membership.ok_or_else(|| FuzzyError::Number {
        line,
        found: corners.join(" "),
        expected: "three or four corners in ascending order",
    })?;
    variable.terms.push(Term { name: name.to_owned(), membership });
    Ok(())
}

fn numbers(line: usize, words: &[&str]) -> Result<Vec<f64>, FuzzyError> {
    let number = |word: &&str| {
        let number = word.parse::<f64>().ok().filter(|number| number.is_finite());
        number.ok_or_else(|| FuzzyError::Number { line, found: (*word).to_owned(), expected: "a number" })
    };
    words.iter().map(number).collect()
}

fn found(
    line: usize,
    what: &'static str,
    variables: &[Variable],
    variable: &str,
    term: &str,
) -> Result<Said, FuzzyError> {
    let unknown = |what, name: &str, known: Vec<&str>| FuzzyError::Unknown {
        line,
        what,
        name: name.to_owned(),
        known: known.join(", "),
    };
    let index = variables.iter().position(|known| known.name == variable);
    let names = || variables.iter().map(|known| known.name.as_str()).collect();
    let index = index.ok_or_else(|| unknown(what, variable, names()))?;
    let terms = &variables[index].terms;
    let term_names = || terms.iter().map(|known| known.name.as_str()).collect();
    let place = terms.iter().position(|known| known.name == term);
    Ok(Said { variable: index, term: place.ok_or_else(|| unknown("term", term, term_names()))? })
}

fn not_understood(line: usize, found: &str, expected: &'static str) -> FuzzyError {
    FuzzyError::Statement { line, found: found.to_owned(), expected }
}
