//! Where a vehicle was found on the map, on one self-contained page.

mod drive;
mod moments;
mod over_time;
mod stanford;
mod words;

use fingerpost_format::{LocationScores, LocationSummary, Recall};
use fingerpost_map::RoadGraph;
use maud::{Markup, html};

pub use self::drive::LocatedDrive;
use crate::html::{MAP_DATA, facts, metres, number, page};
use crate::palette;

/// What the page is made of.
#[derive(Debug, Clone, Copy)]
pub struct LocatingInput<'a> {
    /// Title of the page: what was located.
    pub title: &'a str,
    /// The roads of the map.
    pub graph: &'a RoadGraph,
    /// The drive, its last row added and ended.
    pub drive: &'a LocatedDrive,
    /// The same in numbers.
    pub summary: &'a LocationSummary,
}

/// The page, which needs nothing from outside.
pub fn locating_html(input: &LocatingInput<'_>) -> String {
    let LocatingInput { title, summary, drive, .. } = *input;
    let body = html! {
        header {
            h1 { (title) }
            @for sentence in words::result(drive, summary) { p { (sentence) } }
        }
        (facts(&numbers(input)))
        h2 { "Map" }
        (drive.fixes.map(input.graph))
        h2 { "How one place is left" }
        (moments::moments(input))
        h2 { "Over time" }
        (over_time::over_time(input))
        @if let Some(scores) = &summary.truth {
            h2 { "Against truth" }
            (stanford::diagram(drive))
            (recall(scores))
        }
        footer {
            p { (MAP_DATA) }
            p { "Written by " (summary.written_by) "." }
        }
    };
    page(title, &body)
}

fn numbers(input: &LocatingInput<'_>) -> Vec<(&'static str, String)> {
    let LocatingInput { summary, drive, .. } = *input;
    let mut facts = vec![("rows of the motion log", summary.rows.to_string())];
    facts.extend(drive.fixes.rows.iter().map(|(&status, rows)| {
        let (name, _) = palette::fix_status(status);
        (name, format!("{rows} rows"))
    }));
    facts.extend(drive.last.as_ref().map(|fix| ("driven, by the log", format!("{:.0} m", fix.driven_m))));
    facts.push(("most hypotheses at a time", summary.most_hypotheses.to_string()));
    if let Some(gps) = &summary.gps {
        facts.push(("GPS places not believed", format!("{} of {}", gps.not_believed, gps.places)));
    }
    if let Some(scores) = &summary.truth {
        facts.extend(scores.fix_error_m.map(|error| ("error from convergence on", metres(error))));
        facts.extend(scores.bound_m.map(|level| ("protection level, converged", metres(level))));
        facts.push(("converged rows outside their level", scores.bound_violations.to_string()));
    }
    facts
}

/// How often the place was how near, and whether the covariances are honest.
fn recall(scores: &LocationScores) -> Markup {
    html! {
        @if let Some(Recall { lateral, longitudinal }) = scores.recall {
            table {
                thead { tr {
                    th { "rows from convergence on within" }
                    @for metres in ["1 m", "3 m", "5 m"] { th class="n" { (metres) } }
                } }
                tbody {
                    @for (name, shares) in [("across the true heading", lateral), ("along it", longitudinal)] {
                        tr {
                            td { (name) }
                            @for share in shares { td class="n" { (number(100.0 * share)) " %" } }
                        }
                    }
                }
            }
        }
        @if let Some(nees) = scores.nees {
            p {
                "Mean normalised squared error (NEES) of converged rows: " (number(nees)) "; 2 where covariances are \
                 honest, more where they claim too much. Neighbouring rows share their error, so that one drive alone says \
                 little."
            }
        }
    }
}
