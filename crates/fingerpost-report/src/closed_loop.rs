//! Closed-loop drives of every controller on one self-contained page.

use fingerpost_format::{ClosedLoop, ErrorQuantiles, LoopDrive, LoopEnd, LoopGroup};
use maud::{Markup, html};

use crate::html::page;

/// What the page is made of.
#[derive(Debug, Clone, Copy)]
pub struct ClosedLoopInput<'a> {
    /// The table.
    pub table: &'a ClosedLoop,
    /// Arguments that drive one of these drives again, but for `--seed`, `--conditions` and `--controllers`.
    pub again: &'a str,
    /// The program, its version and commit.
    pub written_by: &'a str,
}

/// The page, which needs nothing from outside.
pub fn closed_loop_html(input: &ClosedLoopInput<'_>) -> String {
    let ClosedLoop { drives_wanted, interrupted, groups, not_arrived } = input.table;
    let title = "Closed-loop drives";
    let body = html! {
        header {
            h1 { (title) }
            p class="dim" {
                "A simulated vehicle driven by the advice alone, by camera, map and route. "
                (drives_wanted) " drives were asked for" @if *interrupted { "; not all are done" } "."
            }
        }
        h2 { "By controller and conditions" }
        p class="dim" {
            "Arrived: at the route's end, with the middle of both axles on the road all along. Distances are from the middle of \
             the lane, every half metre of all drives; in junctions: within 15 m of a feature of the route. Off unsaid: drives in \
             which the middle of an axle was off the road while there was a line to steer along and nothing said lost."
        }
        (groups_table(groups))
        h2 { "Drives that did not arrive" }
        @if not_arrived.is_empty() { p { "None." } } @else {
            p class="dim" { "Each is driven again, with a report, by " code { (input.again) } " and what its row says." }
            (failures(not_arrived))
        }
        footer { p { "Written by " (input.written_by) "." } }
    };
    page(title, &body)
}

fn metres(error_m: Option<ErrorQuantiles>) -> String {
    error_m.map_or("-".to_owned(), |m| format!("{:.2} / {:.2} / {:.2}", m.p50, m.p95, m.max))
}

fn groups_table(groups: &[LoopGroup]) -> Markup {
    let ends: Vec<LoopEnd> = LoopEnd::ALL
        .into_iter()
        .filter(|end| *end != LoopEnd::Arrived && groups.iter().any(|group| count(group, *end) > 0))
        .collect();
    html! {
        table {
            thead { tr {
                th { "controller" } th { "conditions" } th { "drives" } th { "arrived" }
                th { "between junctions, m (median / p95 / largest)" } th { "in junctions, m" }
                th { "a wheel off" } th { "off unsaid" }
                @for end in &ends { th { (end.words()) } }
            } }
            tbody {
                @for group in groups {
                    tr {
                        td { (group.controller) }
                        td { (group.conditions.as_deref().unwrap_or("all")) }
                        td { (group.drives) }
                        td { (group.arrived) " (" (format!("{:.1}", 100.0 * group.arrived as f64 / group.drives.max(1) as f64)) " %)" }
                        td { (metres(group.straight_m)) }
                        td { (metres(group.junction_m)) }
                        td { (group.wheel_off_drives) }
                        td { (group.claimed_off_drives) }
                        @for end in &ends { td { (count(group, *end)) } }
                    }
                }
            }
        }
    }
}

fn count(group: &LoopGroup, end: LoopEnd) -> u64 {
    group.ends.iter().filter(|(found, _)| *found == end).map(|(_, count)| count).sum()
}

fn failures(drives: &[LoopDrive]) -> Markup {
    html! {
        table {
            thead { tr { th { "arguments" } th { "end" } th { "at" } th { "said" } } }
            tbody {
                @for drive in drives {
                    tr {
                        td { code {
                            "--seed " (drive.seed) " --conditions " (drive.conditions) " --controllers " (drive.controller)
                        } }
                        td { (drive.end.words()) }
                        td { (format!("{:.0} of {:.0} m", drive.end_m, drive.route_m)) }
                        td { (drive.error.as_deref().unwrap_or(&drive.because)) }
                    }
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn failures_are_counted_by_kind_and_can_be_driven_again() {
        let lost = LoopDrive {
            seed: 17,
            conditions: "wet".to_owned(),
            controller: "fuzzy".to_owned(),
            end: LoopEnd::StoppedLost,
            because: "stop: lost".to_owned(),
            ..LoopDrive::default()
        };
        let group = LoopGroup {
            controller: "fuzzy".to_owned(),
            drives: 8,
            arrived: 7,
            ends: vec![(LoopEnd::Arrived, 7), (LoopEnd::StoppedLost, 1)],
            ..LoopGroup::default()
        };
        let table = ClosedLoop {
            drives_wanted: 8,
            groups: vec![group],
            not_arrived: vec![lost],
            ..Default::default()
        };
        let page = closed_loop_html(&ClosedLoopInput {
            table: &table,
            again: "fingerpost campaign",
            written_by: "a test",
        });
        assert!(page.contains("--seed 17 --conditions wet --controllers fuzzy"));
        assert!(page.contains("87.5 %") && page.contains("stopped, lost") && !page.contains("out of time"));
    }
}
