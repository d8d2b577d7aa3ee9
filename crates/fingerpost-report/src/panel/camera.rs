//! The camera's picture with the lane, the driving line and the feature drawn into it.

mod lanes;

use fingerpost::feature_masks::SubMaskKind;
use fingerpost::matching::Participation;
use fingerpost::track::Followed;
use fingerpost_geometry::{Camera, Pixel, Polyline};
use fingerpost_vision::picture::Rect;
use nalgebra::{Isometry2, Point2};

use super::classes::Classes;
use crate::draw::{Canvas, Paint, TextSize};
use crate::palette;
use crate::scene::Scene;

pub(crate) const LEGEND: &str = "Green ribbon: driving line at the vehicle's width. Circle: the feature's node with its \
    distance and P(F). Lines: the feature's arms in the colours of their masks, dashed where they take no part. \
    Violet: the lane's edges, paler where nothing new is seen; strokes across them: paint that was read, red where it does \
    not fit; thin and dashed: straight lines considered, white ones kept. \
    Orange: the road's edge by the network, as broad as it is in doubt.";

/// Step at which lines on the road are taken into the picture, metres; what lies between is straight to the eye.
const STEP_M: f64 = 0.5;
/// How far from the node arms are drawn, metres: beyond it they are a few pixels of clutter near the horizon.
const ARM_LENGTH_M: f64 = 25.0;

/// Draws the camera's picture into `area`, which has its proportions.
pub(crate) fn draw(canvas: &mut Canvas, area: Rect, scene: &Scene<'_>) {
    let size = scene.picture.size();
    match Classes::of(scene) {
        Some(classes) => canvas.picture(area, size, |u, v| classes.with_doubt(u, v)),
        None => canvas.picture(area, size, |u, v| scene.picture.get(u, v).unwrap_or_default()),
    }
    let lens = Lens { camera: &scene.setting.camera, area };
    canvas.clipped(area, |canvas| {
        lanes::draw(canvas, &lens, scene);
        arms(canvas, &lens, scene);
        driving_line(canvas, &lens, scene);
        node(canvas, &lens, scene);
    });
}

fn driving_line(canvas: &mut Canvas, lens: &Lens<'_>, scene: &Scene<'_>) {
    let followed = scene.output.track.followed.as_ref();
    let shown_from_road = followed.map_or_else(Isometry2::identity, Followed::shown_from_road);
    let Ok(line) = Polyline::new(scene.output.driving_line.iter().map(|p| shown_from_road * p)) else {
        return;
    };
    let half_m = 0.5 * scene.setting.vehicle_width_m;
    let colour = palette::sub_mask("driving_line");
    if let (Ok(left), Ok(right)) = (line.offset(half_m), line.offset(-half_m)) {
        let sides = lens.stretches(sampled(&left, left.length_m()));
        let others = lens.stretches(sampled(&right, right.length_m()));
        for (left, right) in sides.iter().zip(&others) {
            let corners: Vec<[f64; 2]> = left.iter().chain(right.iter().rev()).copied().collect();
            canvas.polygon(&corners, Paint::glaze(colour, 0.32));
        }
    }
    for stretch in lens.stretches(sampled(&line, line.length_m())) {
        canvas.polyline(&stretch, 2.5, Paint::glaze(colour, 0.95));
    }
}

fn arms(canvas: &mut Canvas, lens: &Lens<'_>, scene: &Scene<'_>) {
    let Some((followed, model)) = scene.followed() else { return };
    for (index, arm) in model.arms.iter().enumerate() {
        let course = arm.course.transformed(&followed.matched.vehicle_from_feature);
        let takes_part = followed.matched.subs.iter().any(|sub| {
            matches!(sub.kind, SubMaskKind::Arm { index: of, .. } if of == index)
                && sub.participation == Participation::TakesPart
        });
        for stretch in lens.stretches(sampled(&course, ARM_LENGTH_M.min(course.length_m()))) {
            let colour = palette::sub_mask(&arm.label);
            if takes_part {
                canvas.polyline(&stretch, 3.0, Paint::glaze(colour, 0.9));
            } else {
                canvas.dashed(&stretch, 2.0, [6.0, 6.0], Paint::glaze(colour, 0.7));
            }
        }
    }
}

fn node(canvas: &mut Canvas, lens: &Lens<'_>, scene: &Scene<'_>) {
    let Some((followed, _)) = scene.followed() else { return };
    // The camera is drawn as configured: its picture shows the node where the ground view does.
    let shown = followed.matched.vehicle_from_feature.translation.vector;
    let Some(centre) = lens.at(shown.into()) else { return };
    let place = followed.vehicle_from_feature.translation.vector;
    canvas.ring(centre, 8.0, 5.0, Paint::glaze(palette::SHADE, 0.6));
    canvas.ring(centre, 8.0, 2.5, Paint::solid(palette::UPDATED));
    let p = followed.matched.p.map_or_else(|| "no arm seen".to_owned(), |p| format!("P(F) {p:.2}"));
    let text = format!("{:.1} m  {p}", place.x);
    canvas.label([centre[0] + 14.0, centre[1] - 26.0], TextSize::SmallBold, palette::UPDATED, &text);
}

/// The places along the first `length_m` metres of a line, close enough to be joined by straight lines in the picture.
fn sampled(line: &Polyline, length_m: f64) -> impl Iterator<Item = Point2<f64>> {
    let steps = (length_m / STEP_M).ceil().max(1.0) as usize;
    (0..=steps).map(move |i| line.at(length_m * i as f64 / steps as f64).0)
}

/// The camera with its picture laid on an area of a canvas.
struct Lens<'a> {
    camera: &'a Camera,
    area: Rect,
}

impl Lens<'_> {
    /// Where a place on the road (vehicle frame, metres) lies on the canvas.
    fn at(&self, p_in_vehicle: Point2<f64>) -> Option<[f64; 2]> {
        let place = self.of_pixel(self.camera.pixel_of_ground(p_in_vehicle)?);
        // Places beside or below the lens are thrown far out of the picture, some to its other side.
        let reach = 8.0 * self.area.width as f64;
        place.iter().all(|c| c.abs() < reach).then_some(place)
    }

    /// Where a pixel of the camera's picture lies on the canvas.
    fn of_pixel(&self, pixel: Pixel) -> [f64; 2] {
        let scale = self.area.width as f64 / self.camera.width() as f64;
        [
            self.area.x as f64 + (pixel.u + 0.5) * scale - 0.5,
            self.area.y as f64 + (pixel.v + 0.5) * scale - 0.5,
        ]
    }

    /// The stretches of a line on the road that the lens sees.
    fn stretches(&self, points: impl Iterator<Item = Point2<f64>>) -> Vec<Vec<[f64; 2]>> {
        let mut stretches = vec![Vec::new()];
        for point in points {
            match (self.at(point), stretches.last_mut()) {
                (Some(place), Some(stretch)) => stretch.push(place),
                (None, Some(stretch)) if !stretch.is_empty() => stretches.push(Vec::new()),
                _ => {}
            }
        }
        stretches
    }
}
