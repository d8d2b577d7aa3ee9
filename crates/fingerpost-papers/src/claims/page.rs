//! The page: what each claim comes to, with plots. Every word about results follows from the figures.

mod lanes;

use std::fmt::Write;

use fingerpost_report::{IntervalPlot, IntervalPoint, IntervalSeries, interval_svg};

use super::axes::Axis;
use super::drives::ROADS;
use super::feature_claims::{CLAIMS, Claim, Metric, Test};
use super::measurements::Measurements;
use super::scatter::Mean;
use super::verdict::{Compared, Outcome, verdict};

/// Folder of the plots beside the page.
pub const PLOTS_FOLDER: &str = "papers";

/// The page and its plots by name.
pub struct Page {
    /// Markdown.
    pub text: String,
    /// File names in [`PLOTS_FOLDER`], and SVG.
    pub plots: Vec<(String, String)>,
}

/// What all drives together are called.
const ALL: &str = "all roads together";

/// A claim's comparisons on a kind of roads.
type Judged = (&'static str, Vec<JudgedTest>);
/// One of them with its figures; none where nothing was measured.
type JudgedTest = (Test, Option<Compared>);

/// What was asked for.
pub struct Asked<'a> {
    /// The command that makes the page again.
    pub command: &'a str,
    /// Drives of each kind of roads.
    pub drives: u64,
    /// Most seconds of each drive.
    pub seconds: f64,
}

impl Page {
    /// The page of these measurements.
    pub fn of(measurements: &Measurements, asked: &Asked<'_>) -> Self {
        let mut page = Self { text: head(asked), plots: Vec::new() };
        for claim in &CLAIMS {
            page.claim(measurements, claim);
        }
        page.lanes(measurements);
        page
    }

    fn line(&mut self, text: &str) {
        self.text.push_str(text);
        self.text.push('\n');
    }

    fn plot(&mut self, name: &str, title: &str, svg: String) {
        let file = format!("{name}.svg");
        self.line(&format!("![{title}]({PLOTS_FOLDER}/{file})\n"));
        self.plots.push((file, svg));
    }

    fn claim(&mut self, measurements: &Measurements, claim: &Claim) {
        let Claim { title, source, words, measured, axis, .. } = claim;
        self.line(&format!("## {title}\n\n> {words}\n> ({source})\n\n{measured}\n"));
        let kinds = ROADS.map(|road| (road.words, vec![road.name]));
        let all = (ALL, ROADS.map(|road| road.name).to_vec());
        let judged: Vec<Judged> = [all]
            .into_iter()
            .chain(kinds)
            .map(|(words, names)| {
                let tests = claim.tests.iter().map(|test| (*test, judge(measurements, &names, axis, test)));
                (words, tests.collect())
            })
            .collect();
        let outcomes: Vec<(&str, Outcome)> =
            judged.iter().map(|(road, tests)| (*road, of_all(tests))).collect();
        if let [(_, all), kinds @ ..] = outcomes.as_slice() {
            self.line(&format!("{} {}\n", verdict(*all, kinds), sentence(axis, &judged)));
        }
        for metric in claim.metrics.iter().take(2) {
            let name = format!("{}_{}", claim.name, metric.name);
            let plot_title = format!("{title}: {}", metric.label);
            self.plot(&name, &plot_title, interval_svg(&plot_of(measurements, claim, metric)));
        }
        self.line(&tests_table(axis, &judged));
        self.line(&figures_table(measurements, claim));
    }
}

/// What stands above the claims.
fn head(asked: &Asked<'_>) -> String {
    let Asked { command, drives, seconds } = asked;
    let roads: Vec<String> = ROADS.iter().map(|road| road.words.to_owned()).collect();
    format!(
        "# The papers' claims, measured again\n\n\
         This page is written by `{command}`; plots, figures and verdicts follow from simulated drives with fixed seeds and nothing \
         else. The papers are those of [CONVENTIONS.md](../CONVENTIONS.md).\n\n\
         Claims about features, surface and motion are measured with the papers' own settings (`papers.toml`) on {drives} drives \
         of up to {seconds} s each of three kinds: {}. The drives are those of the built-in town, 512 x 384 pixels, and 10 frames a second where nothing \
         else is said. One setting is changed at a time, on the same drives.\n\n\
         - Road surface: the largest F1 measure over all thresholds, at places half a metre apart in the ground view, against the \
         simulator's roads.\n\
         - Followed: share of the frames with a feature 5 to 12 m ahead in which it is placed within 1 m.\n\
         - Way measured wrongly: the errors forward of all steps between frames against the way driven.\n\n\
         Every comparison is made drive by drive. Its difference has a 95 % interval (Student's t), and counts only where all of the \
         interval lies on one side; else it is open. A claim holds where all its comparisons do on all drives together and none fails \
         on a kind of roads; \"here only\" where it does on some kinds. In the plots large dots are means with that interval, small \
         ones the drives. Simulated drives are no recorded ones, and this program's stages are not the papers' programs.\n\n",
        roads.join(", ")
    )
}

fn judge(measurements: &Measurements, roads: &[&str], axis: &Axis, test: &Test) -> Option<Compared> {
    let keys = [test.of, test.against].map(|value| axis.key(value, test.metric.name));
    let pairs = |road: &&str| measurements.pairs(road, [keys[0].as_str(), keys[1].as_str()]);
    let pairs: Vec<[f64; 2]> = roads.iter().flat_map(pairs).collect();
    test.expectation.judge(test.metric.better, &pairs)
}

/// All must hold; one that fails is enough for the claim to fail.
fn of_all(tests: &[JudgedTest]) -> Outcome {
    let outcomes = tests.iter().map(|(_, compared)| compared.as_ref().map_or(Outcome::Open, |c| c.outcome));
    outcomes.min().unwrap_or(Outcome::Open)
}

/// The figures of a claim's first comparison on every kind of roads.
fn sentence(axis: &Axis, judged: &[Judged]) -> String {
    let part = |(road, tests): &Judged| {
        let (test, compared) = tests.first()?;
        let Compared { means, difference, .. } = compared.as_ref()?;
        Some(format!(
            "on {road} {} with {} against {} with {} ({})",
            number(means[0]),
            axis.value_name(test.of),
            number(means[1]),
            axis.value_name(test.against),
            of_difference(difference)
        ))
    };
    let parts: Vec<String> = judged.iter().filter_map(part).collect();
    let label = judged.first().and_then(|(_, tests)| tests.first()).map_or("", |(test, _)| test.metric.label);
    if parts.is_empty() { String::new() } else { format!("{}: {}.", capital(label), parts.join("; ")) }
}

fn tests_table(axis: &Axis, judged: &[Judged]) -> String {
    let mut text =
        "| roads | comparison | figures | difference (95 %) | drives | |\n|---|---|---|---|---|---|\n"
            .to_owned();
    for (road, tests) in judged {
        for (test, compared) in tests {
            let comparison = format!(
                "{}: {} {} {}",
                test.metric.label,
                axis.value_name(test.of),
                test.expectation.words(),
                axis.value_name(test.against)
            );
            let cells = match compared {
                Some(Compared { means, difference, outcome }) => format!(
                    "{} and {} | {} | {} | {}",
                    number(means[0]),
                    number(means[1]),
                    of_difference(difference),
                    difference.count,
                    outcome.words()
                ),
                None => "- | - | 0 | open".to_owned(),
            };
            let _ = writeln!(text, "| {road} | {comparison} | {cells} |");
        }
    }
    text
}

/// Every value's mean and the half width of its interval.
fn figures_table(measurements: &Measurements, claim: &Claim) -> String {
    let axis = &claim.axis;
    let names: Vec<String> = axis.values.iter().map(|value| axis.value_name(*value)).collect();
    let mut text =
        format!("| {} | {} |\n|---|{}\n", axis.label, names.join(" | "), "---|".repeat(names.len()));
    for metric in claim.metrics {
        for road in ROADS {
            let cell = |value: &f64| {
                measurements
                    .mean(road.name, &axis.key(*value, metric.name))
                    .map_or("-".to_owned(), |mean| with_interval(&mean))
            };
            let cells: Vec<String> = axis.values.iter().map(cell).collect();
            let _ = writeln!(text, "| {}, {} | {} |", metric.label, road.short, cells.join(" | "));
        }
    }
    text
}

fn plot_of(measurements: &Measurements, claim: &Claim, metric: &Metric) -> IntervalPlot {
    let axis = &claim.axis;
    let series = ROADS.iter().map(|road| IntervalSeries {
        label: road.short.to_owned(),
        points: axis
            .values
            .iter()
            .map(|value| {
                let key = axis.key(*value, metric.name);
                let mean = measurements.mean(road.name, &key)?;
                let values = measurements.of(road.name, &key).into_iter().map(|(_, value)| value).collect();
                Some(IntervalPoint { mean: mean.value, interval: [mean.low(), mean.high()], values })
            })
            .collect(),
    });
    IntervalPlot {
        title: claim.title.to_owned(),
        x_label: axis.label.to_owned(),
        xs: axis.values.iter().map(|value| axis.value_name(*value)).collect(),
        y_label: metric.label.to_owned(),
        series: series.collect(),
    }
}

fn of_difference(difference: &Mean) -> String {
    let signed =
        |value: f64| if value < 0.0 { format!("-{}", number(-value)) } else { format!("+{}", number(value)) };
    if difference.within.is_finite() {
        format!("{}, {} to {}", signed(difference.value), signed(difference.low()), signed(difference.high()))
    } else {
        format!("{}, one drive", signed(difference.value))
    }
}

fn with_interval(mean: &Mean) -> String {
    if mean.within.is_finite() {
        format!("{} ± {}", number(mean.value), number(mean.within))
    } else {
        number(mean.value)
    }
}

/// To a tenth; what is no number is a dash.
fn number(value: f64) -> String {
    if value.is_finite() { format!("{value:.1}") } else { "-".to_owned() }
}

fn capital(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}
