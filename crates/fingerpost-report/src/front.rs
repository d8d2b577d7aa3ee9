//! A search of settings on one self-contained page: every pair of objectives, and the front as a table.

use fingerpost_format::{
    TuningFront, TuningObjective, TuningPoint, TuningPurpose, TuningScores, TuningTrial,
};
use maud::{Markup, html};

use crate::html::{number, page, px, ticks};

/// What the page is made of.
#[derive(Debug, Clone, Copy)]
pub struct FrontInput<'a> {
    /// Title of the page.
    pub title: &'a str,
    /// The front.
    pub front: &'a TuningFront,
    /// All trials.
    pub trials: &'a [TuningTrial],
    /// The program, its version and commit.
    pub written_by: &'a str,
}

/// Size of a plot, and its margins, picture units.
const SIZE: [f64; 2] = [470.0, 330.0];
const LEFT: f64 = 56.0;
const RIGHT: f64 = 16.0;
const TOP: f64 = 14.0;
const BOTTOM: f64 = 46.0;
/// Room between the outermost points and the frame, as a share of what the plot spans.
const ROOM: f64 = 0.06;

/// The page, which needs nothing from outside.
pub fn front_html(input: &FrontInput<'_>) -> String {
    let FrontInput { title, front, .. } = *input;
    let objectives = &front.objectives;
    let pairs = (0..objectives.len()).flat_map(|i| (i + 1..objectives.len()).map(move |j| [i, j]));
    let body = html! {
        header {
            h1 { (title) }
            p class="dim" {
                "Settings that no tried ones beat in everything on the drives that were searched with, and what became \
                 of them on those that were held back. All objectives are better when smaller."
            }
        }
        h2 { "Objectives, two at a time" }
        p class="legend" {
            span class="chip" style="--chip: var(--dim)" { "tried" }
            span class="chip" style="--chip: var(--one)" { "front" }
            span class="chip" style="--chip: var(--two)" { "defaults" }
            "Rings: the same on the drives held back."
        }
        div class="pairs" { @for pair in pairs { (plot(input, pair.map(|i| objectives[i]))) } }
        h2 { "Front" }
        (table(input))
        h2 { "Settings" }
        (settings(front))
        footer { p { "Written by " (input.written_by) "." } }
    };
    page(title, &body)
}

/// A point of a plot.
struct Dot {
    place: [f64; 2],
    label: String,
    /// CSS class that colours it.
    class: &'static str,
    radius: f64,
}

/// The dots of a pair of objectives, the most important last, so that they lie above the others.
fn dots(input: &FrontInput<'_>, pair: [TuningObjective; 2]) -> Vec<Dot> {
    let dot = |label: String, scores: Option<&TuningScores>, ms: f64, class, radius| {
        let [x, y] = pair.map(|objective| objective.of(scores?, ms));
        Some(Dot { place: [x?, y?], label, class, radius })
    };
    let ms = |trial: u64, purpose| {
        let same = |done: &&TuningTrial| done.trial == trial && done.purpose == purpose;
        input.trials.iter().find(same).map_or(f64::NAN, |done| done.ms_per_frame)
    };
    let on = |point: &TuningPoint, purpose, scores: Option<&TuningScores>, class, radius| {
        let name = point.config.as_deref().unwrap_or("defaults");
        let of = if purpose == TuningPurpose::HeldBack { ", held back" } else { "" };
        dot(format!("{name}{of}"), scores, ms(point.trial, purpose), class, radius)
    };
    let tried =
        input.trials.iter().filter(|trial| trial.purpose == TuningPurpose::Search).filter_map(|trial| {
            dot(format!("trial {}", trial.trial), trial.scores.as_ref(), trial.ms_per_frame, "tried", 2.5)
        });
    let (front, defaults) = (&input.front.front, &input.front.defaults);
    let held_back = |p: &TuningPoint, class| on(p, TuningPurpose::HeldBack, p.held_back.as_ref(), class, 4.0);
    let rings = front.iter().filter_map(|p| held_back(p, "one held"));
    let rings = rings.chain(held_back(defaults, "two held"));
    let tuned = front.iter().filter_map(|p| on(p, TuningPurpose::Search, p.tuned.as_ref(), "one", 4.5));
    let first = on(defaults, TuningPurpose::Search, defaults.tuned.as_ref(), "two", 5.5);
    tried
        .chain(rings)
        .chain(tuned)
        .chain(first)
        .filter(|dot| dot.place.iter().all(|v| v.is_finite()))
        .collect()
}

fn plot(input: &FrontInput<'_>, pair: [TuningObjective; 2]) -> Markup {
    let dots = dots(input, pair);
    let limits = |axis: usize| {
        let values = || dots.iter().map(|dot| dot.place[axis]);
        let (low, high) =
            (values().fold(f64::INFINITY, f64::min), values().fold(f64::NEG_INFINITY, f64::max));
        let extent = if high > low { high - low } else { low.abs().max(1.0) };
        (low - ROOM * extent, high + ROOM * extent)
    };
    let ((x0, x1), (y0, y1)) = (limits(0), limits(1));
    let [width, height] = SIZE;
    let x = |v: f64| LEFT + (v - x0) / (x1 - x0) * (width - LEFT - RIGHT);
    let y = |v: f64| TOP + (y1 - v) / (y1 - y0) * (height - TOP - BOTTOM);
    let title = format!("{} against {}", pair[1].label(), pair[0].label());
    html! {
        figure class="chart" {
            svg viewBox={ "0 0 " (width) " " (height) } role="img" aria-label=(title) {
                @for v in ticks(y0, y1, 5).into_iter().filter(|v| *v >= 0.0) {
                    line class="grid" x1=(px(LEFT)) x2=(px(width - RIGHT)) y1=(px(y(v))) y2=(px(y(v))) {}
                    text x=(px(LEFT - 6.0)) y=(px(y(v) + 4.0)) text-anchor="end" { (number(v)) }
                }
                @for v in ticks(x0, x1, 6).into_iter().filter(|v| *v >= 0.0) {
                    line class="grid" x1=(px(x(v))) x2=(px(x(v))) y1=(px(TOP)) y2=(px(height - BOTTOM)) {}
                    text x=(px(x(v))) y=(px(height - BOTTOM + 17.0)) text-anchor="middle" { (number(v)) }
                }
                text class="dim" x=(px(width - RIGHT)) y=(px(height - 8.0)) text-anchor="end" { (pair[0].label()) }
                text class="dim" x=(px(LEFT + 6.0)) y=(px(TOP + 4.0)) { (pair[1].label()) }
                @for Dot { place, label, class, radius } in &dots {
                    circle class=(class) cx=(px(x(place[0]))) cy=(px(y(place[1]))) r=(radius) { title { (label) } }
                }
            }
        }
    }
}

/// The settings that the search began with, and the front.
fn rows(front: &TuningFront) -> impl Iterator<Item = (&str, &TuningPoint)> {
    let named = front.front.iter().map(|point| (point.config.as_deref().unwrap_or_default(), point));
    [("defaults", &front.defaults)].into_iter().chain(named)
}

fn table(input: &FrontInput<'_>) -> Markup {
    let front = input.front;
    let columns = ["missed, %", "false a drive", "p50, m", "p95, m", "error by sigma, p68"];
    let cells = |scores: Option<TuningScores>| {
        let scores = scores.unwrap_or_default();
        let cells = [
            scores.missed_share.map(|share| 100.0 * share),
            scores.false_per_drive,
            scores.error_p50_m,
            scores.error_p95_m,
            scores.error_per_sigma_p68,
        ];
        html! { @for cell in cells { td class="n" { (shown(cell)) } } }
    };
    let ms = |point: &TuningPoint| {
        let same = |done: &&TuningTrial| done.trial == point.trial && done.purpose == TuningPurpose::Search;
        input.trials.iter().find(same).map(|trial| trial.ms_per_frame)
    };
    html! {
        table {
            tr {
                th {} th {}
                th colspan="5" { "tuned, " (front.drives[0]) " drives" }
                th colspan="5" { "held back, " (front.drives[1]) " drives" }
                th {}
            }
            tr {
                th { "settings" } th class="n" { "trial" }
                @for column in columns.iter().chain(&columns) { th class="n" { (column) } }
                th class="n" { "ms a frame" }
            }
            @for (name, point) in rows(front) {
                tr {
                    td { (name) } td class="n" { (point.trial) }
                    (cells(point.tuned)) (cells(point.held_back))
                    td class="n" { (shown(ms(point))) }
                }
            }
        }
    }
}

/// Every searched setting, row by row, a column a point.
fn settings(front: &TuningFront) -> Markup {
    html! {
        table {
            tr {
                th { "key" }
                @for (name, _) in rows(front) { th class="n" { (name.strip_suffix(".toml").unwrap_or(name)) } }
            }
            @for key in front.defaults.settings.keys() {
                tr {
                    td { (key) }
                    @for (_, point) in rows(front) {
                        td class="n" { (point.settings.get(key).map(ToString::to_string).unwrap_or_default()) }
                    }
                }
            }
        }
    }
}

fn shown(value: Option<f64>) -> String {
    value.map_or("-".to_owned(), number)
}

#[cfg(test)]
mod tests {
    use super::*;
    use fingerpost_format::TriedSettings;

    #[test]
    fn the_page_shows_front_defaults_and_what_was_held_back() {
        let scores = |missed, p95| TuningScores {
            missed_share: Some(missed),
            error_p95_m: Some(p95),
            ..TuningScores::default()
        };
        let point = |trial, config: Option<&str>, tuned, held_back| TuningPoint {
            trial,
            config: config.map(str::to_owned),
            settings: TriedSettings::from([("track.<detect>".to_owned(), trial.into())]),
            tuned: Some(tuned),
            held_back: Some(held_back),
        };
        let front = TuningFront {
            objectives: vec![TuningObjective::Missed, TuningObjective::ErrorP95],
            trials: 2,
            drives: [3, 1],
            defaults: point(0, None, scores(0.2, 0.9), scores(0.3, 1.0)),
            front: vec![point(1, Some("01.toml"), scores(0.1, 0.8), scores(0.4, 1.2))],
        };
        let trials = [0, 1].map(|trial| TuningTrial {
            trial,
            purpose: TuningPurpose::Search,
            settings: TriedSettings::new(),
            scores: Some(scores(0.1, 0.8)),
            ms_per_frame: 7.5,
            error: None,
        });
        let page =
            front_html(&FrontInput { title: "A & B", front: &front, trials: &trials, written_by: "x" });
        for words in [
            "A &amp; B",
            "01.toml, held back",
            "track.&lt;detect&gt;",
            "class=\"two\"",
            "7.5",
            "<td class=\"n\">40</td>",
        ] {
            assert!(page.contains(words), "{words}");
        }
        assert_eq!(page.matches("<svg").count(), 1);
        assert!(!page.contains("http") && !page.contains("NaN"));
    }
}
