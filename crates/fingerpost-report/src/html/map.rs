//! The route with its features, where the vehicle was believed to be, and where it was.

use fingerpost_format::FeatureSummary;
use fingerpost_geometry::Polyline;
use fingerpost_map::{Route, TangentPlane};
use maud::{Markup, html};
use nalgebra::Point2;

use super::ReportInput;
use super::chart::{joined, px, ticks};
use crate::palette;
use crate::series::{MAX_POINTS, thinned_path};

const WIDTH: f64 = 960.0;
const MAX_HEIGHT: f64 = 520.0;
const MARGIN: f64 = 34.0;

/// Map frame to picture.
struct Fit {
    low: [f64; 2],
    high: [f64; 2],
    px_per_m: f64,
}

impl Fit {
    fn new(points: &[Point2<f64>]) -> Self {
        let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        for point in points {
            for (axis, value) in [point.x, point.y].into_iter().enumerate() {
                (low[axis], high[axis]) = (low[axis].min(value), high[axis].max(value));
            }
        }
        let room = [WIDTH, MAX_HEIGHT].map(|side| side - 2.0 * MARGIN);
        // A route along one axis has no extent on the other.
        let px_per_m = (room[0] / (high[0] - low[0]).max(1.0)).min(room[1] / (high[1] - low[1]).max(1.0));
        Self { low, high, px_per_m }
    }

    fn at(&self, p_in_map: Point2<f64>) -> [f64; 2] {
        let spare = WIDTH - 2.0 * MARGIN - (self.high[0] - self.low[0]) * self.px_per_m;
        [
            MARGIN + 0.5 * spare + (p_in_map.x - self.low[0]) * self.px_per_m,
            MARGIN + (self.high[1] - p_in_map.y) * self.px_per_m,
        ]
    }

    fn height(&self) -> f64 {
        2.0 * MARGIN + (self.high[1] - self.low[1]) * self.px_per_m
    }

    fn path(&self, points: impl Iterator<Item = Point2<f64>>) -> String {
        joined(thinned_path(points.map(|p| self.at(p)), WIDTH / MAX_POINTS as f64).into_iter())
    }
}

/// The map, where there is a route with a line.
pub(crate) fn map(input: &ReportInput<'_>) -> Option<Markup> {
    let route = input.route?;
    let plane = route.plane()?;
    let line = route.polyline().ok()?;
    let fit = Fit::new(line.points());
    let title = "Map of the route";
    Some(html! {
        figure class="chart map" {
            figcaption {
                "North is up. Grey: route."
                " Coloured: where the vehicle was believed to be, by state."
                @if input.truth.is_some() { " Dashed: where it was." }
                " Circles: features; filled where arrived at, ringed where detected, crossed where neither."
            }
            svg viewBox={ "0 0 " (WIDTH) " " (px(fit.height() + 14.0)) } role="img" aria-label=(title) {
                polyline class="route" points=(fit.path(line.points().iter().copied())) {}
                @for (colour, path) in believed(input, &line, &fit) {
                    polyline class="believed" stroke=(colour) points=(path) {}
                }
                @if let Some(truth) = input.truth {
                    polyline class="truth" points=(fit.path(truth.iter().map(|t| Point2::new(t.x_m, t.y_m)))) {}
                }
                (features(input, route, &plane, &fit))
                (scale_bar(&fit))
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
    let outcome = |id: i64| -> Option<&FeatureSummary> {
        input.summary.features.iter().find(|feature| feature.id == id)
    };
    html! {
        @for (i, feature) in route.features.iter().enumerate() {
            @let [x, y] = fit.at(plane.map_from_wgs84(feature.at));
            @let seen = outcome(feature.id);
            @let class = match seen {
                Some(seen) if seen.arrived_frame.is_some() => "feature arrived",
                Some(seen) if seen.detected_frame.is_some() => "feature detected",
                _ => "feature missed",
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

/// A bar of a round length, about a fifth of the width.
fn scale_bar(fit: &Fit) -> Markup {
    let length_m = ticks(0.0, 0.2 * WIDTH / fit.px_per_m, 2).last().copied().unwrap_or(1.0);
    let (x, y) = (MARGIN, fit.height() + 2.0);
    html! {
        line class="scale" x1=(px(x)) x2=(px(x + length_m * fit.px_per_m)) y1=(px(y)) y2=(px(y)) {}
        text x=(px(x)) y=(px(y - 5.0)) { (length_m) " m" }
    }
}
