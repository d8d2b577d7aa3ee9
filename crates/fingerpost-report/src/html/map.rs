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
                " Circles: features; filled where arrived at, ringed where detected, crossed where missed, grey where the drive did not come to, dashed where that is not known."
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

/// What a feature is drawn as. Summaries that name no outcome may still say in which frame it was found.
fn class(feature: Option<&FeatureSummary>) -> &'static str {
    match feature {
        Some(FeatureSummary { outcome: Some(outcome), .. }) => match outcome {
            FeatureOutcome::Arrived => "feature arrived",
            FeatureOutcome::Detected => "feature detected",
            FeatureOutcome::Missed => "feature missed",
            FeatureOutcome::NotReached => "feature ahead",
        },
        Some(FeatureSummary { arrived_frame: Some(_), .. }) => "feature arrived",
        Some(FeatureSummary { detected_frame: Some(_), .. }) => "feature detected",
        Some(_) | None => "feature unknown",
    }
}

fn features(input: &ReportInput<'_>, route: &Route, plane: &TangentPlane, fit: &Fit) -> Markup {
    // Both are in the order of the route, which may pass a node twice.
    html! {
        @for (i, feature) in route.features.iter().enumerate() {
            @let [x, y] = fit.at(plane.map_from_wgs84(feature.at));
            @let class = class(input.summary.features.get(i));
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_feature_of_which_nothing_is_known_is_not_drawn_as_one_that_was_not_reached() {
        let unknown = FeatureSummary::default();
        let detected = FeatureSummary { detected_frame: Some(3), ..unknown.clone() };
        let arrived = FeatureSummary { arrived_frame: Some(5), ..detected.clone() };
        let not_reached = FeatureSummary { outcome: Some(FeatureOutcome::NotReached), ..unknown.clone() };
        for (feature, expected) in [
            (None, "feature unknown"),
            (Some(&unknown), "feature unknown"),
            (Some(&detected), "feature detected"),
            (Some(&arrived), "feature arrived"),
            (Some(&not_reached), "feature ahead"),
        ] {
            assert_eq!(class(feature), expected, "{feature:?}");
        }
    }
}
