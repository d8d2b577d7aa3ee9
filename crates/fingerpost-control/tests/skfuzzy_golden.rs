//! Inference against scikit-fuzzy's results, committed; `tools/golden/skfuzzy_golden.py` made them.

// A helper that unwraps is part of the test that calls it.
#![allow(clippy::unwrap_used)]

use fingerpost_control::{DEFAULT_RULES, Inference, RuleBase};

const GOLDEN: &str = include_str!("golden/skfuzzy.csv");

/// Rounding of sums over 200 pieces.
const MOST_OFF: f64 = 1e-9;

fn compared(name: &str, text: &str) -> [usize; 2] {
    let base = RuleBase::parse(text).unwrap();
    let outputs: Vec<&str> = base.outputs().collect();
    let (mut inference, mut with_value, mut without) = (Inference::default(), 0, 0);
    for line in GOLDEN.lines().filter(|line| line.starts_with(name)) {
        let cells: Vec<&str> = line.split(',').collect();
        let inputs: Vec<f64> = cells[3..].iter().map(|cell| cell.parse().unwrap()).collect();
        assert_eq!(inputs.len(), base.inputs().count());
        base.infer(&inputs, &mut inference);
        let output = outputs.iter().position(|output| *output == cells[1]).unwrap();
        let expected: Option<f64> = cells[2].parse().ok();
        let found = inference.outputs[output];
        let off = expected.unwrap_or(0.0) - found.unwrap_or(0.0);
        assert!(expected.is_some() == found.is_some() && off.abs() < MOST_OFF, "{line}: {found:?}");
        let count = if found.is_some() { &mut with_value } else { &mut without };
        *count += 1;
    }
    [with_value, without]
}

#[test]
fn the_shipped_rules_say_what_scikit_fuzzy_makes_of_them() {
    assert_eq!(compared("default.fuzzy", DEFAULT_RULES), [120, 0]);
}

#[test]
fn a_text_with_gaps_and_not_says_it_too() {
    let [with_value, without] = compared("tipping.fuzzy", include_str!("golden/tipping.fuzzy"));
    assert!(with_value >= 40 && without >= 20 && with_value + without == 120, "{with_value}, {without}");
}
