//! Whether figures bear a claim out, by the drives' scatter.

use super::scatter::Mean;

/// Which figures are good.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Better {
    Higher,
    Lower,
}

/// What a claim says of two settings.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Expectation {
    /// The first is better.
    BetterThan,
    /// The first is worse.
    WorseThan,
    /// The first is no worse than by this much.
    NoWorseBy(f64),
}

/// What comes of it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Outcome {
    /// The figures speak against it.
    Fails,
    /// They leave it open.
    Open,
    /// They bear it out.
    Holds,
}

impl Outcome {
    /// How it is said.
    pub(super) const fn words(self) -> &'static str {
        match self {
            Self::Fails => "does not hold",
            Self::Open => "open",
            Self::Holds => "holds",
        }
    }
}

/// A comparison with its figures.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Compared {
    /// Both settings' means, and the mean of their differences drive by drive, the first less the second.
    pub(super) means: [f64; 2],
    pub(super) difference: Mean,
    pub(super) outcome: Outcome,
}

impl Expectation {
    /// Holds pairs of figures, each of one drive, against the expectation; none without pairs.
    ///
    /// With a 95 % interval of the mean difference: a setting is better where all of it is on the good side of zero, and no
    /// worse where all of it is on the good side of what is allowed.
    pub(super) fn judge(self, better: Better, pairs: &[[f64; 2]]) -> Option<Compared> {
        let differences: Vec<f64> = pairs.iter().map(|pair| pair[0] - pair[1]).collect();
        let difference = Mean::of(&differences)?;
        let count = pairs.len() as f64;
        let means = [0, 1].map(|i| pairs.iter().map(|pair| pair[i]).sum::<f64>() / count);
        // By how much the first is better.
        let (low, high) = match better {
            Better::Higher => (difference.low(), difference.high()),
            Better::Lower => (-difference.high(), -difference.low()),
        };
        let outcome = match self {
            Self::BetterThan if low > 0.0 => Outcome::Holds,
            Self::BetterThan if high < 0.0 => Outcome::Fails,
            Self::WorseThan if high < 0.0 => Outcome::Holds,
            Self::WorseThan if low > 0.0 => Outcome::Fails,
            // Where there is no more to lose than that, nothing is shown.
            Self::NoWorseBy(margin) if better == Better::Higher && means[1] <= margin => Outcome::Open,
            Self::NoWorseBy(margin) if low > -margin => Outcome::Holds,
            Self::NoWorseBy(margin) if high < 0.0 && 0.5 * (low + high) < -margin => Outcome::Fails,
            _ => Outcome::Open,
        };
        Some(Compared { means, difference, outcome })
    }

    /// How it is said.
    pub(super) fn words(self) -> String {
        match self {
            Self::BetterThan => "better than".to_owned(),
            Self::WorseThan => "worse than".to_owned(),
            Self::NoWorseBy(margin) => format!("no worse, by {margin}, than"),
        }
    }
}

/// The verdict: what came of a claim on all drives together, and on each kind of roads.
///
/// It holds where all drives together bear it out and no kind of roads speaks against it.
pub(super) fn verdict(all: Outcome, kinds: &[(&str, Outcome)]) -> String {
    let of = |wanted: Outcome| -> Vec<&str> {
        kinds.iter().filter(|(_, outcome)| *outcome == wanted).map(|(kind, _)| *kind).collect()
    };
    let (holds, fails) = (of(Outcome::Holds), of(Outcome::Fails));
    if all == Outcome::Holds && fails.is_empty() {
        return "**Holds**.".to_owned();
    }
    if !holds.is_empty() {
        let others = if fails.is_empty() { "open" } else { "not so" };
        return format!("**Holds here only**: on {}; elsewhere {others}.", listed(&holds));
    }
    if all == Outcome::Fails || !fails.is_empty() {
        let on = if fails.is_empty() { String::new() } else { format!(": not on {}", listed(&fails)) };
        return format!("**Does not hold**{on}.");
    }
    "**Cannot be told from these drives**.".to_owned()
}

fn listed(names: &[&str]) -> String {
    match names {
        [] => String::new(),
        [one] => (*one).to_owned(),
        [others @ .., last] => format!("{} and {last}", others.join(", ")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pairs(differences: &[f64]) -> Vec<[f64; 2]> {
        differences.iter().map(|d| [50.0 + d, 50.0]).collect()
    }

    fn outcome(expectation: Expectation, better: Better, differences: &[f64]) -> Outcome {
        expectation.judge(better, &pairs(differences)).unwrap().outcome
    }

    #[test]
    fn only_what_stands_out_of_the_scatter_counts() {
        use Expectation::{BetterThan, NoWorseBy, WorseThan};
        let (clear, slight, none) = ([4.0, 5.0, 6.0, 5.0], [4.0, -3.0, 5.0, -4.0], [0.1, -0.1, 0.1, -0.1]);
        assert_eq!(outcome(BetterThan, Better::Higher, &clear), Outcome::Holds);
        assert_eq!(outcome(BetterThan, Better::Lower, &clear), Outcome::Fails);
        assert_eq!(outcome(WorseThan, Better::Lower, &clear), Outcome::Holds);
        assert_eq!(outcome(BetterThan, Better::Higher, &slight), Outcome::Open);
        assert_eq!(outcome(NoWorseBy(1.0), Better::Higher, &none), Outcome::Holds);
        assert_eq!(outcome(NoWorseBy(1.0), Better::Lower, &clear), Outcome::Fails);
        // A loss that may be larger than what is allowed, or none.
        assert_eq!(outcome(NoWorseBy(1.0), Better::Higher, &slight), Outcome::Open);
        assert_eq!(outcome(BetterThan, Better::Higher, &[9.0]), Outcome::Open, "one drive shows nothing");
        assert_eq!(BetterThan.judge(Better::Higher, &[]), None);
    }

    #[test]
    fn where_there_is_nothing_to_lose_nothing_is_shown() {
        let pairs = [[0.0, 0.0]; 4];
        let judged = Expectation::NoWorseBy(5.0).judge(Better::Higher, &pairs).unwrap();
        assert_eq!(judged.outcome, Outcome::Open);
    }

    #[test]
    fn the_verdict_names_the_roads() {
        use Outcome::{Fails, Holds, Open};
        assert_eq!(verdict(Holds, &[("a", Holds), ("b", Open)]), "**Holds**.");
        let here = "**Holds here only**: on a and b; elsewhere not so.";
        assert_eq!(verdict(Holds, &[("a", Holds), ("b", Holds), ("c", Fails)]), here);
        assert_eq!(verdict(Open, &[("a", Holds), ("b", Open)]), "**Holds here only**: on a; elsewhere open.");
        assert_eq!(verdict(Open, &[("a", Fails), ("b", Open)]), "**Does not hold**: not on a.");
        assert_eq!(verdict(Fails, &[]), "**Does not hold**.");
        assert_eq!(verdict(Open, &[("a", Open)]), "**Cannot be told from these drives**.");
    }
}
