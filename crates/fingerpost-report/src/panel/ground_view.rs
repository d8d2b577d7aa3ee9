//! The ground view with the places where the feature may be, and the edges of its road.

use fingerpost::track::{Followed, PossiblePlace};
use nalgebra::{Isometry2, Matrix3, Point2, Vector2};

use super::ground_plot::GroundPlot;
use crate::draw::{Canvas, Paint};
use crate::palette;
use crate::scene::Scene;

pub(crate) const LEGEND: &str = "The road from above. Yellow circle: where the followed feature is believed to be, with its \
    two-sigma ellipse. White ellipses: every place where the feature may be, the fainter the less probable; in cyan the edges of the road \
    at the likeliest. Green: driving line. Orange: the road's middle by the edges of its surface, \
    which are drawn thin. Hatched: not seen.";

/// Corners of the ellipse of uncertainty.
const ELLIPSE_CORNERS: usize = 48;
/// Standard deviations that the ellipse shows.
const ELLIPSE_SIGMAS: f64 = 2.0;

/// How much a place of no weight would still be seen of.
const FAINTEST: f64 = 0.15;

/// Pieces in which the road's middle is drawn.
const CENTRELINE_STEPS: usize = 24;

/// Draws the ground view.
pub(crate) fn draw(canvas: &mut Canvas, plot: &GroundPlot<'_>, scene: &Scene<'_>) {
    let colour = &scene.evidence.ground.colour;
    plot.raster(canvas, scene.evidence.validity, |column, row| colour.get(column, row).unwrap_or_default());
    plot.metre_lines(canvas);
    canvas.clipped(plot.area, |canvas| {
        let followed = scene.output.track.followed.as_ref();
        let shown_from_road = followed.map_or_else(Isometry2::identity, Followed::shown_from_road);
        let line: Vec<[f64; 2]> =
            scene.output.driving_line.iter().map(|p| plot.at(shown_from_road * p)).collect();
        canvas.polyline(&line, 2.5, Paint::glaze(palette::sub_mask("driving_line"), 0.9));
        centreline(canvas, plot, scene);
        for ends in &scene.evidence.track.edges {
            let ends = ends.map(|end| plot.at(shown_from_road * end));
            canvas.polyline(&ends, 1.5, Paint::glaze(palette::ACCEPTED, 0.9));
        }
        for PossiblePlace { vehicle_from_feature, covariance, weight } in &scene.evidence.track.places {
            let paint = Paint::glaze(palette::TEXT, FAINTEST + (1.0 - FAINTEST) * weight);
            ellipse(canvas, plot, &(shown_from_road * vehicle_from_feature), covariance, paint);
        }
        if let Some(followed) = &scene.output.track.followed {
            // The view is made for the configured mount: what it shows is where the masks lie in it.
            let pose = &followed.matched.vehicle_from_feature;
            ellipse(canvas, plot, pose, &followed.covariance, Paint::glaze(palette::UPDATED, 0.8));
            heading(canvas, plot, pose);
        }
    });
}

/// The place of a pose with how sure it is.
fn ellipse(
    canvas: &mut Canvas,
    plot: &GroundPlot<'_>,
    pose: &Isometry2<f64>,
    covariance: &Matrix3<f64>,
    paint: Paint,
) {
    let Some(root) = covariance.fixed_view::<2, 2>(0, 0).into_owned().cholesky() else { return };
    let corners: Vec<[f64; 2]> = (0..=ELLIPSE_CORNERS)
        .map(|i| i as f64 / ELLIPSE_CORNERS as f64 * std::f64::consts::TAU)
        .map(|angle| root.l() * Vector2::new(libm::cos(angle), libm::sin(angle)))
        .map(|offset| plot.at((pose.translation.vector + offset * ELLIPSE_SIGMAS).into()))
        .collect();
    canvas.polyline(&corners, 1.5, paint);
}

/// The road's edges section by section, and its middle.
fn centreline(canvas: &mut Canvas, plot: &GroundPlot<'_>, scene: &Scene<'_>) {
    for section in &scene.evidence.centreline.sections {
        let [near_m, far_m] = section.forward_m;
        for edge in section.edges.iter().flatten() {
            let reach_m = 0.5 * (far_m - near_m) * edge.slope;
            let ends = [(near_m, edge.left_m - reach_m), (far_m, edge.left_m + reach_m)];
            canvas.polyline(
                &ends.map(|(x, y)| plot.at(Point2::new(x, y))),
                1.0,
                Paint::solid(palette::CENTRELINE),
            );
        }
    }
    let sections = &scene.evidence.centreline.sections;
    if let (Some(centreline), Some(last)) = (&scene.output.centreline, sections.last()) {
        let place = |i: usize| f64::from(i as u8) / CENTRELINE_STEPS as f64 * last.forward_m[1];
        let middle: Vec<[f64; 2]> = (0..=CENTRELINE_STEPS)
            .map(|i| plot.at(Point2::new(place(i), centreline.left_m(place(i)))))
            .collect();
        canvas.polyline(&middle, 2.0, Paint::glaze(palette::CENTRELINE, 0.9));
    }
}

/// The node and the direction in which the approach leads to it.
fn heading(canvas: &mut Canvas, plot: &GroundPlot<'_>, vehicle_from_feature: &Isometry2<f64>) {
    let node = plot.at(vehicle_from_feature * Point2::origin());
    let behind = plot.at(vehicle_from_feature * Point2::new(-1.5, 0.0));
    canvas.arrow(behind, node, 2.0, Paint::solid(palette::UPDATED));
    canvas.ring(node, 6.0, 2.0, Paint::solid(palette::UPDATED));
}
