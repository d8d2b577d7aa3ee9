//! From the inputs' values to the outputs', by the rules.

use super::rule_base::{Asks, Rule, RuleBase, Variable};

/// Places of an output's range, both ends with it, at which what the rules conclude is kept.
pub(super) const SAMPLES: usize = 201;

/// Results of an inference, and its memory.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Inference {
    /// How far each rule's conditions hold, 0 to 1, in the order of the rules.
    pub strengths: Vec<f64>,
    /// Value of each output, in their order; none where no rule that concludes on it holds at all.
    pub outputs: Vec<Option<f64>>,
    joined: Vec<f64>,
}

impl RuleBase {
    /// Infers the outputs' values from those of the inputs, in the order of the text. An input without a value is at the low end of
    /// its range.
    pub fn infer(&self, values: &[f64], inference: &mut Inference) {
        let value = |input: usize| {
            let [least, most] = self.inputs[input].range;
            values.get(input).map_or(least, |value| value.clamp(least, most))
        };
        let holds = |rule: &Rule| {
            let shares = rule.conditions.iter().map(|(asks, said)| {
                let share = self.inputs[said.variable].terms[said.term].membership.of(value(said.variable));
                if *asks == Asks::Is { share } else { 1.0 - share }
            });
            shares.fold(1.0, f64::min)
        };
        inference.strengths.clear();
        inference.strengths.extend(self.rules.iter().map(holds));
        inference.outputs.clear();
        for (output, variable) in self.outputs.iter().enumerate() {
            inference.joined.clear();
            inference.joined.resize(SAMPLES, 0.0);
            for (rule, strength) in
                self.rules.iter().zip(&inference.strengths).filter(|(_, strength)| **strength > 0.0)
            {
                for said in rule.conclusions.iter().filter(|said| said.variable == output) {
                    let membership = &variable.terms[said.term].membership;
                    for (i, joined) in inference.joined.iter_mut().enumerate() {
                        *joined = joined.max(strength.min(membership.of(place(variable, i))));
                    }
                }
            }
            inference.outputs.push(centroid(variable, &inference.joined));
        }
    }
}

/// A sample's place in the range of a variable.
fn place(variable: &Variable, sample: usize) -> f64 {
    let [least, most] = variable.range;
    least + (most - least) * sample as f64 / (SAMPLES - 1) as f64
}

/// Centroid of the area under the line through the samples; none without an area.
fn centroid(variable: &Variable, joined: &[f64]) -> Option<f64> {
    let step = place(variable, 1) - place(variable, 0);
    let (mut area, mut moment) = (0.0, 0.0);
    for (i, ends) in joined.windows(2).enumerate() {
        let (y1, y2) = (ends[0], ends[1]);
        area += 0.5 * step * (y1 + y2);
        moment += step * (0.5 * (y1 + y2) * place(variable, i) + step * (y1 + 2.0 * y2) / 6.0);
    }
    (area > 0.0).then(|| moment / area)
}
