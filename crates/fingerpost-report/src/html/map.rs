//! The route with its features, where the vehicle was believed to be, and where it was.

use fingerpost_format::{FeatureOutcome, FeatureSummary};
use fingerpost_geometry::Polyline;
use fingerpost_map::{Route, TangentPlane};
use maud::{Markup, html};
use nalgebra::Point2;

use super::ReportInput;
use super::chart::px;
use super::fit::{Fit, Sheet};
use crate::palette;

/// The map, where there is a route with a line.
pub(crate) fn map(input: &ReportInput<'_>) -> Option<Markup> {
    let route = input.route?;
    let plane = route.plane()?;
    let line = route.polyline().ok()?;
    let fit = Fit::new(Sheet::PAGE, line.points().iter().copied());
    let title = "Map of the route";
    Some(html! {
        figure class="chart map" {
            figcaption {
                "North is up. Grey: route."
                " Coloured: where the vehicle was believed to be, by state."
                @if input.truth.is_some() { " Dashed: where it was." }
                " Circles: features; filled where arrived at, ringed where detected, crossed where missed, grey where the drive did not come to."
            }
            svg viewBox=(fit.view_box()) role="img" aria-label=(title) {
                polyline class="route" points=(fit.path(line.points().iter().copied())) {}
                @for (colour, path) in believed(input, &line, &fit) {
                    polyline class="believed" stroke=(colour) points=(path) {}
                }
                @if let Some(truth) = input.truth {
                    polyline class="truth" points=(fit.path(truth.iter().map(|t| Point2::new(t.x_m, t.y_m)))) {}
                }
                (features(input, route, &plane, &fit))
                (fit.scale_bar())
            }
        }
    })
}

fn believed(input: &ReportInput<'_>, line: &Polyline, fit: &Fit) -> Vec<(String, String)> {
    let stretches = input.timeline.route_states.joined();
    let paths = input.timeline.route_m.along(&stretches).map(|(&state, places)| {
        let points = places.into_iter().map(|m| line.at(m).0);
        (palette::css(palette::state(state).1), fit.path(points))
    });
    paths.collect()
}

fn features(input: &ReportInput<'_>, route: &Route, plane: &TangentPlane, fit: &Fit) -> Markup {
    // Both are in the order of the route, which may pass a node twice.
    let outcome =
        |i: usize| input.summary.features.get(i).and_then(|feature: &FeatureSummary| feature.outcome);
    html! {
        @for (i, feature) in route.features.iter().enumerate() {
            @let [x, y] = fit.at(plane.map_from_wgs84(feature.at));
            @let class = match outcome(i) {
                Some(FeatureOutcome::Arrived) => "feature arrived",
                Some(FeatureOutcome::Detected) => "feature detected",
                Some(FeatureOutcome::Missed) => "feature missed",
                Some(FeatureOutcome::NotReached) | None => "feature ahead",
            };
            g class=(class) {
                title { (i + 1) ": " (palette::kind(feature.kind)) " " (feature.id) " " (feature.name) }
                circle cx=(px(x)) cy=(px(y)) r="6" {}
                @if class == "feature missed" {
                    path d={ "M" (px(x - 4.0)) "," (px(y - 4.0)) "l8,8m0,-8l-8,8" } {}
                }
                text x=(px(x + 9.0)) y=(px(y - 7.0)) { (i + 1) }
            }
        }
    }
}
