//! Which variables matter: each changed by itself.

use crate::variable::Variable;

/// How far a variable is changed to either side, in genes: to a quarter of its range from a start in its middle.
const STEP: f64 = 0.25;

/// The start with one variable changed, down and up, variable by variable: the index of the variable and all values. What does not
/// differ from the start, or is not allowed, is left out.
///
/// These are the elementary effects of M. D. Morris, "Factorial sampling plans for preliminary computational experiments",
/// Technometrics 33(2), 1991, taken at the start alone and not along random paths: what is asked is which settings matter near
/// those in use.
pub fn one_at_a_time(
    variables: &[Variable],
    start: &[f64],
    allowed: &dyn Fn(&[f64]) -> bool,
) -> Vec<(usize, Vec<f64>)> {
    let changed = |index: usize, variable: &Variable, step: f64| {
        let mut values = start.to_vec();
        let value = values.get_mut(index)?;
        let before = *value;
        *value = variable.value(variable.gene(before) + step);
        let differs = (*value - before).abs() > 0.0;
        (differs && allowed(&values)).then_some((index, values))
    };
    let both = |(index, variable)| [-STEP, STEP].map(|step| changed(index, variable, step));
    variables.iter().enumerate().flat_map(both).flatten().collect()
}

/// How much each of `variables` matters: over all objectives, the largest change that it made as a share of the largest that any
/// made. `changed` are the indices and objectives of what [`one_at_a_time`] gave. An objective that can no longer be told counts as
/// the largest change.
pub fn effects(variables: usize, start: &[f64], changed: &[(usize, Vec<f64>)]) -> Vec<f64> {
    let change = |objective: usize, variable: usize| {
        let of_variable = changed.iter().filter(|(index, _)| *index == variable);
        let changes = of_variable
            .filter_map(|(_, values)| Some((values.get(objective)? - start.get(objective)?).abs()));
        changes.filter(|change| !change.is_nan()).fold(0.0, f64::max)
    };
    let mut sums = vec![0.0; variables];
    for objective in 0..start.len() {
        let changes: Vec<f64> = (0..variables).map(|variable| change(objective, variable)).collect();
        let largest = changes.iter().copied().filter(|change| change.is_finite()).fold(0.0, f64::max);
        for (sum, change) in sums.iter_mut().zip(changes) {
            *sum += if change.is_infinite() {
                1.0
            } else if largest > 0.0 {
                change / largest
            } else {
                0.0
            };
        }
    }
    sums
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::variable::Scale;

    #[test]
    fn each_variable_is_changed_by_itself_where_that_is_allowed() {
        let unit = Variable::real(0.0, 1.0, Scale::Linear).unwrap();
        let variables = [unit, Variable::choice(2).unwrap(), unit];
        let points = one_at_a_time(&variables, &[0.5, 0.0, 1.0], &|values| values[0] < 0.7);
        let expected = [(0, vec![0.25, 0.0, 1.0]), (1, vec![0.5, 1.0, 1.0]), (2, vec![0.5, 0.0, 0.75])];
        assert_eq!(points, expected);
    }

    #[test]
    fn the_largest_change_of_every_objective_counts_alike() {
        let start = [1.0, 0.01];
        let changed = [
            (0, vec![1.5, 0.01]),
            (0, vec![0.0, 0.01]),
            (1, vec![1.1, 0.03]),
            (2, vec![f64::INFINITY, 0.02]),
        ];
        let effects = effects(4, &start, &changed);
        for (effect, expected) in effects.iter().zip([1.0, 1.1, 1.5, 0.0]) {
            assert!((effect - expected).abs() < 1e-9, "{effect} {expected}");
        }
    }
}
