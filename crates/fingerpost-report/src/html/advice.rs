//! The advice of a run: the line that led, steering angle, speed, and the rules that fired.

use maud::{Markup, html};

use super::ReportInput;
use super::chart::{Chart, Curve};
use super::curves::{bands, legend};
use super::tables::list;
use crate::palette;

/// Charts and rules; none where no frame has advice.
pub(crate) fn advice(input: &ReportInput<'_>) -> Option<Markup> {
    let seconds = input.timeline.seconds.clone()?;
    let advice = &input.timeline.advice;
    let chart = |title: &str, unit, values, (label, class, series)| Chart {
        curves: vec![Curve { label, class, values: series }],
        bands: bands(&seconds, &advice.lines, |line| line.as_deref().map(line_band)),
        strip: bands(&seconds, &advice.stops, |stop| stop.as_deref().map(stop_band)),
        ..Chart::over(seconds.clone(), title, unit, values)
    };
    let charts = [
        chart(
            "Steering angle; coloured by what is steered along, below where the vehicle is to stop",
            "degrees to the left",
            -10.0..=10.0,
            ("steer", "one", &advice.steer_deg),
        ),
        chart("Speed to have", "metres a second", 0.0..=8.0, ("speed", "one", &advice.speed_mps)),
        chart(
            "Vehicle beside what is steered along",
            "metres to the left",
            -0.5..=0.5,
            ("offset", "one", &advice.offset_m),
        ),
    ];
    charts[0].has_values().then(|| {
        html! {
            (legend("along", LINES.map(line_in_colour).into_iter()))
            @for chart in charts.iter().filter(|chart| chart.has_values()) { (chart.figure()) }
            @if advice.stops_begun.count > 0 {
                h3 { "Stops" }
                (list(&advice.stops_begun))
            }
            @if !input.rules.is_empty() {
                h3 { "Rules that fired" }
                (rules(input))
            }
        }
    })
}

fn rules(input: &ReportInput<'_>) -> Markup {
    let fired = &input.timeline.advice.rules;
    html! {
            div class="wide" { table {
                thead { tr { th { "rule" } th { "" } th { "frames" } th { "mean strength" } th { "largest" } } }
                tbody {
                    @for (number, text) in (1..).zip(input.rules) {
                        @if let Some(rule) = fired.get(&number) {
                            tr {
                                td { (number) }
                                td { (text) }
                                td { (rule.frames) }
                                td { (format!("{:.2}", rule.sum / rule.frames as f64)) }
                                td { (format!("{:.2}", rule.most)) }
                            }
                        }
                    }
                }
            } }
        @if fired.is_empty() { p { "No rule fired." } }
    }
}

/// What can be steered along, as the files have it.
const LINES: [&str; 3] = ["driving_line", "lane", "centreline"];

fn line_in_colour(line: &str) -> (String, palette::Rgb) {
    let colour = match line {
        "driving_line" => palette::sub_mask("driving_line"),
        "lane" => palette::LANE,
        _ => palette::CENTRELINE,
    };
    (line.replace('_', " "), colour)
}

fn line_band(line: &str) -> (String, String) {
    let (name, colour) = line_in_colour(line);
    (name, palette::css(colour))
}

fn stop_band(stop: &str) -> (String, String) {
    (format!("stop: {}", stop.replace('_', " ")), palette::css(palette::REJECTED))
}
