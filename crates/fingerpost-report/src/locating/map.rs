//! The roads, the fixes by status, and where the vehicle was.

use fingerpost_locate::Status;
use fingerpost_map::RoadGraph;
use maud::{Markup, html};
use nalgebra::Point2;

use super::LocatingInput;
use crate::html::{Fit, Sheet, joined, legend, px};
use crate::palette;
use crate::series::thinned_path;

/// Room around what was driven, metres: a block of a town, so that the next roads are seen.
const AROUND_M: f64 = 100.0;
/// Bends of roads that are smaller than this are left out, pixels.
const ROAD_STEP_PX: f64 = 1.5;

/// The map of what was driven; of all roads where no place was found and none is known.
pub(super) fn map(input: &LocatingInput<'_>) -> Markup {
    let drive = input.drive;
    let is_found = |status: Status| matches!(status, Status::Converged | Status::Coasting);
    let found: Vec<Point2<f64>> = drive
        .track
        .iter()
        .filter(|piece| is_found(piece.status))
        .flat_map(|piece| piece.points.iter().copied())
        .collect();
    let driven = || found.iter().chain(&drive.truth).copied();
    let fit = if driven().next().is_some() {
        let around = [-AROUND_M, AROUND_M];
        let corners = |p: Point2<f64>| around.map(|by| Point2::new(p.x + by, p.y + by));
        Fit::new(Sheet::PAGE, driven().flat_map(corners))
    } else {
        Fit::new(Sheet::PAGE, input.graph.nodes().iter().map(|node| node.p_in_map))
    };
    let statuses = drive.rows.keys().map(|&status| palette::fix_status(status));
    // With how far down its name is written: a round trip ends where it starts.
    let ends = [
        (drive.truth.first(), "start", -7.0),
        (drive.converged.as_ref().map(|first| &first.place_m), "converged", -7.0),
        (drive.last.as_ref().map(|fix| &fix.place_m), "end", 17.0),
    ];
    html! {
        (legend("status", statuses.map(|(name, rgb)| (name.to_owned(), rgb))))
        figure class="chart map" {
            figcaption {
                "North is up. Grey: roads. Coloured: the likeliest place, by status."
                @if !drive.truth.is_empty() { " Dashed: where the vehicle was." }
            }
            svg viewBox=(fit.view_box()) role="img" aria-label="Map of the drive" {
                path class="road" d=(roads(input.graph, &fit)) {}
                @for status in drive.rows.keys() {
                    path class={ "fixes" @if !is_found(*status) { " vague" } } stroke=(palette::css(palette::fix_status(*status).1))
                        d=(track(input, *status, &fit)) {}
                }
                @if !drive.truth.is_empty() {
                    polyline class="truth" points=(fit.path(drive.truth.iter().copied())) {}
                }
                @for (place, name, down) in ends {
                    @if let Some([x, y]) = place.map(|place| fit.at(*place)).filter(|at| fit.shows(*at, *at)) {
                        g class="feature" {
                            circle cx=(px(x)) cy=(px(y)) r="5" {}
                            text x=(px(x + 9.0)) y=(px(y + down)) { (name) }
                        }
                    }
                }
                (fit.scale_bar())
            }
        }
    }
}

/// The roads that the picture shows, as the data of an SVG path.
pub(super) fn roads(graph: &RoadGraph, fit: &Fit) -> String {
    let mut data = String::new();
    for way in graph.ways() {
        let line: Vec<[f64; 2]> = graph.way_line(way).into_iter().map(|p| fit.at(p)).collect();
        // Points of a way in a row between which it is seen.
        let mut seen: Vec<[f64; 2]> = Vec::new();
        for ends in line.windows(2) {
            if fit.shows(ends[0], ends[1]) {
                if seen.is_empty() {
                    seen.push(ends[0]);
                }
                seen.push(ends[1]);
            } else {
                add_line(&mut data, std::mem::take(&mut seen), ROAD_STEP_PX);
            }
        }
        add_line(&mut data, seen, ROAD_STEP_PX);
    }
    data
}

/// Places of one status, as the data of an SVG path.
fn track(input: &LocatingInput<'_>, status: Status, fit: &Fit) -> String {
    let mut data = String::new();
    for piece in input.drive.track.iter().filter(|piece| piece.status == status) {
        let points: Vec<[f64; 2]> = piece.points.iter().map(|p| fit.at(*p)).collect();
        if points.iter().any(|at| fit.shows(*at, *at)) {
            add_line(&mut data, points, 0.5);
        }
    }
    data
}

/// Goes on with a line, thinned to points that far apart; a single point becomes a dot.
fn add_line(data: &mut String, points: Vec<[f64; 2]>, step_px: f64) {
    let points = thinned_path(points.into_iter(), step_px);
    if points.is_empty() {
        return;
    }
    data.push('M');
    data.push_str(&joined(points.iter().copied()));
    if points.len() == 1 {
        data.push_str("h0");
    }
}
