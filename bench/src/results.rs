//! What was measured, as a table and as JSON.

use fingerpost_vision::simd::InstructionSet;
use serde::Serialize;

use crate::growth::Growth;
use crate::machine::Machine;
use crate::measure::Measured;

/// An instruction set's name, as options have it.
pub fn set_name(set: InstructionSet) -> String {
    format!("{set:?}").to_lowercase()
}

/// How well results agree with a peer's.
#[derive(Debug, Clone, Serialize)]
pub struct Agreement {
    pub found: String,
    pub holds: bool,
}

/// One comparison; the first contestant is Fingerpost, the second the peer that it must beat.
#[derive(Debug, Clone, Serialize)]
pub struct Row {
    pub what: String,
    pub size: String,
    /// Instruction set that Fingerpost's kernels used at the most, in sections that measure several.
    pub instruction_set: Option<String>,
    pub contestants: Vec<Measured>,
    /// The peer's time over Fingerpost's.
    pub ratio: f64,
    /// Ratio that is promised, where one is.
    pub promised_ratio: Option<f64>,
    /// Fingerpost's time that is promised at most, where one is, milliseconds.
    pub promised_ms: Option<f64>,
    pub agreement: Option<Agreement>,
}

impl Row {
    pub fn new(what: &str, size: &str, contestants: Vec<Measured>, promised_ratio: Option<f64>) -> Self {
        let ms = |index: usize| contestants.get(index).map_or(f64::NAN, |measured| measured.median_ms);
        let ratio = ms(1) / ms(0);
        Self {
            what: what.to_owned(),
            size: size.to_owned(),
            instruction_set: None,
            contestants,
            ratio,
            promised_ratio,
            promised_ms: None,
            agreement: None,
        }
    }

    /// Whether everything promised of it holds.
    pub fn holds(&self) -> bool {
        let ours_ms = self.contestants.first().map_or(f64::NAN, |measured| measured.median_ms);
        self.promised_ratio.is_none_or(|promised| self.ratio >= promised)
            && self.promised_ms.is_none_or(|promised| ours_ms <= promised)
            && self.agreement.as_ref().is_none_or(|agreement| agreement.holds)
    }
}

/// A single figure.
#[derive(Debug, Clone, Serialize)]
pub struct Figure {
    pub what: String,
    pub value: f64,
    pub unit: &'static str,
    /// What it is promised to be at most.
    pub promised_most: Option<f64>,
}

impl Figure {
    pub fn holds(&self) -> bool {
        self.promised_most.is_none_or(|most| self.value <= most)
    }
}

/// A part of the benchmark.
#[derive(Debug, Clone, Serialize)]
pub struct Section {
    pub title: String,
    /// How it was measured.
    pub note: String,
    pub rows: Vec<Row>,
    pub figures: Vec<Figure>,
    pub growths: Vec<Growth>,
}

impl Section {
    pub fn new(title: &str, note: &str) -> Self {
        let (title, note) = (title.to_owned(), note.to_owned());
        Self { title, note, rows: Vec::new(), figures: Vec::new(), growths: Vec::new() }
    }

    pub fn holds(&self) -> bool {
        self.rows.iter().all(Row::holds)
            && self.figures.iter().all(Figure::holds)
            && self.growths.iter().all(Growth::holds)
    }
}

/// Everything.
#[derive(Debug, Serialize)]
pub struct Results {
    pub machine: Machine,
    pub footage: String,
    pub sections: Vec<Section>,
}

impl Results {
    /// The table for people.
    pub fn table(&self) -> String {
        let mut text = format!("{}\nfootage: {}\n", self.machine.sentence(), self.footage);
        for section in &self.sections {
            text += &format!("\n{}\n{}\n", section.title, section.note);
            for row in &section.rows {
                text += &row_line(row);
            }
            for figure in &section.figures {
                text += &figure_line(figure);
            }
            text.extend(section.growths.iter().map(Growth::lines));
        }
        text
    }
}

fn verdict(holds: bool, promised: bool) -> &'static str {
    match (holds, promised) {
        (true, true) => "holds",
        (true, false) => "",
        (false, _) => "FALLS SHORT",
    }
}

fn row_line(row: &Row) -> String {
    let ms = |measured: &Measured| format!("{} {}", measured.name, milliseconds(measured.median_ms));
    let contestants: Vec<String> = row.contestants.iter().map(ms).collect();
    let ratio = if row.ratio.is_finite() { format!("{:.2}x", row.ratio) } else { String::new() };
    let promised = row.promised_ratio.map_or(String::new(), |promised| format!("of {promised}x"));
    let agreement = row.agreement.as_ref().map_or("", |agreement| agreement.found.as_str());
    let says = verdict(row.holds(), row.promised_ratio.is_some() || row.agreement.is_some());
    let at_most = row.promised_ms.map_or(String::new(), |promised| format!(" (at most {promised} ms)"));
    let set = row.instruction_set.as_ref().map_or(String::new(), |set| format!(", {set}"));
    let line = format!(
        "  {:<50} {:<24} {ratio:>8} {promised:<8} {says:<12} {}{at_most}  {agreement}",
        row.what,
        format!("{}{set}", row.size),
        contestants.join(", ")
    );
    format!("{}\n", line.trim_end())
}

fn figure_line(figure: &Figure) -> String {
    let promised = figure.promised_most.map_or_else(String::new, |most| format!("at most {most}"));
    let says = verdict(figure.holds(), figure.promised_most.is_some());
    let line = format!(
        "  {:<75} {:>12} {:<12} {promised:<12} {says}",
        figure.what,
        number(figure.value),
        figure.unit
    );
    format!("{}\n", line.trim_end())
}

fn milliseconds(ms: f64) -> String {
    if ms < 0.1 { format!("{:.4} ms", ms) } else { format!("{ms:.3} ms") }
}

fn number(value: f64) -> String {
    match value.abs() {
        large if large >= 1000.0 => format!("{value:.0}"),
        middling if middling >= 10.0 => format!("{value:.1}"),
        _ => format!("{value:.3}"),
    }
}
