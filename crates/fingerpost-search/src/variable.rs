//! What may be varied, and between what.

use thiserror::Error;

/// Significant digits of a searched number: finer than any setting's effect, short enough to be read in a file.
const DIGITS: i32 = 4;

/// A variable whose range is none.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
pub enum VariableError {
    /// There is nothing between the limits.
    #[error("nothing can be searched from {least} to {most}; give two finite numbers, the lesser first")]
    Range {
        /// Lower limit given.
        least: f64,
        /// Upper limit given.
        most: f64,
    },
    /// A logarithm has no zero.
    #[error(
        "a range from {least} cannot be searched by its logarithm; give a lower limit above zero, or search it linearly"
    )]
    Logarithm {
        /// Lower limit given.
        least: f64,
    },
    /// There is nothing to choose from.
    #[error("{count} choices leave nothing to search; give two at the least")]
    Choices {
        /// Choices given.
        count: usize,
    },
}

/// How the numbers of a range are spread.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scale {
    /// Equal differences are as likely.
    Linear,
    /// Equal ratios are as likely.
    Logarithmic,
}

/// A number that is searched for. Within the search it is a gene, 0 at its lower limit and 1 at its upper one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Variable {
    least: f64,
    most: f64,
    kind: Kind,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Kind {
    Real(Scale),
    Whole(Scale),
    Choice,
}

impl Variable {
    /// A number from `least` to `most`, to four significant digits.
    ///
    /// # Errors
    /// [`VariableError`] when there is nothing between them, or no logarithm of them.
    pub fn real(least: f64, most: f64, scale: Scale) -> Result<Self, VariableError> {
        Self::ranged(least, most, scale, Kind::Real(scale))
    }

    /// A whole number from `least` to `most`.
    ///
    /// # Errors
    /// As [`Variable::real`].
    pub fn whole(least: i32, most: i32, scale: Scale) -> Result<Self, VariableError> {
        Self::ranged(f64::from(least), f64::from(most), scale, Kind::Whole(scale))
    }

    /// One of `count` things by its number, counted from zero.
    ///
    /// # Errors
    /// [`VariableError::Choices`] for fewer than two.
    pub fn choice(count: usize) -> Result<Self, VariableError> {
        if count < 2 {
            return Err(VariableError::Choices { count });
        }
        Ok(Self { least: 0.0, most: (count - 1) as f64, kind: Kind::Choice })
    }

    fn ranged(least: f64, most: f64, scale: Scale, kind: Kind) -> Result<Self, VariableError> {
        if !(least.is_finite() && most.is_finite() && least < most) {
            return Err(VariableError::Range { least, most });
        }
        if scale == Scale::Logarithmic && least <= 0.0 {
            return Err(VariableError::Logarithm { least });
        }
        Ok(Self { least, most, kind })
    }

    /// The value of a gene.
    pub fn value(&self, gene: f64) -> f64 {
        let gene = gene.clamp(0.0, 1.0);
        match self.kind {
            Kind::Real(scale) => rounded(self.scaled(gene, scale)).clamp(self.least, self.most),
            Kind::Whole(scale) => self.scaled(gene, scale).round(),
            // Every choice has an equal part of the genes.
            Kind::Choice => (gene * (self.most + 1.0)).floor().min(self.most),
        }
    }

    /// The gene of a value; one out of range counts as the nearest limit.
    pub fn gene(&self, value: f64) -> f64 {
        let value = if value.is_finite() { value.clamp(self.least, self.most) } else { self.least };
        match self.kind {
            Kind::Real(Scale::Linear) | Kind::Whole(Scale::Linear) => {
                (value - self.least) / (self.most - self.least)
            }
            Kind::Real(Scale::Logarithmic) | Kind::Whole(Scale::Logarithmic) => {
                libm::log(value / self.least) / libm::log(self.most / self.least)
            }
            Kind::Choice => (value + 0.5) / (self.most + 1.0),
        }
    }

    fn scaled(&self, gene: f64, scale: Scale) -> f64 {
        match scale {
            Scale::Linear => self.least + gene * (self.most - self.least),
            Scale::Logarithmic => self.least * libm::pow(self.most / self.least, gene),
        }
    }
}

/// A number to [`DIGITS`] significant digits: the one that is nearest to these in decimals.
fn rounded(value: f64) -> f64 {
    if value == 0.0 {
        return 0.0;
    }
    let place = DIGITS - 1 - libm::log10(value.abs()).floor() as i32;
    // Dividing by a power of ten gives the decimal number itself, multiplying by a tenth does not.
    if place >= 0 {
        let power = 10_f64.powi(place);
        (value * power).round() / power
    } else {
        let power = 10_f64.powi(-place);
        (value / power).round() * power
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn values(variable: Variable, genes: &[f64]) -> Vec<f64> {
        genes.iter().map(|&gene| variable.value(gene)).collect()
    }

    fn genes(variable: Variable, values: &[f64]) -> Vec<f64> {
        values.iter().map(|&value| variable.gene(value)).collect()
    }

    #[test]
    fn genes_reach_from_limit_to_limit_and_back() {
        let log = Variable::real(0.01, 1.0, Scale::Logarithmic).unwrap();
        assert_eq!(values(log, &[0.0, 0.5, 1.0]), [0.01, 0.1, 1.0]);
        assert!((log.gene(0.1) - 0.5).abs() < 1e-12);
        let frames = Variable::whole(1, 5, Scale::Linear).unwrap();
        assert_eq!(values(frames, &[0.0, 0.6, 2.0]), [1.0, 3.0, 5.0]);
        assert_eq!(genes(frames, &[3.0, 9.0, f64::NAN]), [0.5, 1.0, 0.0]);
        let choice = Variable::choice(3).unwrap();
        assert_eq!(values(choice, &[0.0, 0.34, 0.5, 1.0]), [0.0, 1.0, 1.0, 2.0]);
        let all = [0.0, 1.0, 2.0];
        assert_eq!(values(choice, &genes(choice, &all)), all);
    }

    #[test]
    fn values_have_four_digits_and_stay_inside() {
        let value = |least, most, gene| values(Variable::real(least, most, Scale::Linear).unwrap(), &[gene]);
        assert_eq!(value(0.0, 1.0, 1.0 / 3.0), [0.3333]);
        assert_eq!(value(0.0, 3e6, 1.0 / 7.0), [428_600.0]);
        assert_eq!(value(-1.0, 1.0, 0.5), [0.0]);
        assert_eq!(value(0.123_456, 0.2, 0.0), [0.1235]);
        assert_eq!(value(0.123_44, 0.2, 0.0), [0.123_44]);
    }

    #[test]
    fn ranges_without_anything_in_them_are_refused() {
        for (least, most) in [(1.0, 1.0), (2.0, 1.0), (f64::NAN, 1.0), (0.0, f64::INFINITY)] {
            let error = Variable::real(least, most, Scale::Linear).unwrap_err();
            assert!(matches!(error, VariableError::Range { .. }), "{error}");
        }
        let error = Variable::real(0.0, 1.0, Scale::Logarithmic).unwrap_err();
        assert!(error.to_string().contains("linearly"), "{error}");
        assert_eq!(Variable::choice(1), Err(VariableError::Choices { count: 1 }));
    }
}
