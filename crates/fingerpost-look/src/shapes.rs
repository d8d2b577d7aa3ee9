//! What a frame's record knows of places: on the road, and where the camera's picture shows it.
//!
//! The camera is turned by what the record says of its mount, as the method turns it: pitch with the suspension's part, and roll.
//! A record has standard deviations alone, so the outline of a doubt has its axes along those of the vehicle.

use std::f64::consts::TAU;

use fingerpost_format::{FrameRecord, MountRecord};
use fingerpost_geometry::{Camera, Pixel, View};
use nalgebra::{Point2, Point3};
use serde::Serialize;

/// How far curves of the road are drawn, metres: the reach of the default ground view.
const REACH_M: f64 = 20.0;
/// Step along them, metres; what lies between is straight to the eye.
const STEP_M: f64 = 0.5;
/// Distance between the lines of the metre grid, metres.
const GRID_STEP_M: f64 = 5.0;
/// How far ahead the metre grid reaches, metres.
const GRID_REACH_M: f64 = 40.0;
/// How far to either side, metres.
const GRID_BESIDE_M: f64 = 10.0;
/// Standard deviations that the outline of a doubt shows, as annotated pictures do.
const DOUBT_SIGMAS: f64 = 2.0;
/// Corners of such an outline.
const DOUBT_CORNERS: usize = 48;
/// How far away the horizon is taken to be, metres: less than a hundredth of a pixel from where it is.
const HORIZON_M: f64 = 1e7;
/// How far to either side the horizon is drawn, radians; a picture shows less.
const HORIZON_RAD: f64 = 1.2;
/// Places of the horizon to either side of its middle: a lens bends it.
const HORIZON_STEPS: i32 = 24;

/// What a shape is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum ShapeKind {
    /// The horizon of the camera as it is turned in this frame.
    Horizon,
    /// The line through the followed feature.
    DrivingLine,
    /// The road's middle.
    Centreline,
    /// An edge of the lane.
    LaneEdge,
    /// The followed feature's node.
    Feature,
    /// Two standard deviations about a place.
    Doubt,
    /// Another place where the feature may be.
    Rival,
    /// The likeliest place of a feature that is searched for.
    Sought,
    /// A line of the metre grid on the road.
    MetreGrid,
    /// A road of the map.
    Road,
    /// The route from the vehicle's place on.
    Route,
}

/// A place or line of a frame.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Shape {
    /// What it is.
    pub kind: ShapeKind,
    /// The same in words, with its numbers.
    pub label: String,
    /// `[forward, left]` in the vehicle frame, metres: a point, a line, or an outline that ends where it begins; empty where the
    /// record has it in the picture alone.
    pub ground_m: Vec<[f64; 2]>,
    /// The stretches of it that the camera sees, `[u, v]` pixels of the picture as it was taken.
    pub picture_px: Vec<Vec<[f64; 2]>>,
}

/// The shapes of a record, what lies over the others last. Without a camera only those that the record has in pixels are in the
/// picture.
pub fn shapes(record: &FrameRecord, camera: Option<&Camera>) -> Vec<Shape> {
    let camera = camera.map(|camera| turned(camera, record.mount.as_ref()));
    let lens = Lens { camera };
    let mut shapes: Vec<Shape> = lens.horizon().into_iter().collect();
    if !record.driving_line_m.is_empty() {
        shapes.push(lens.shape(ShapeKind::DrivingLine, "driving line", record.driving_line_m.clone()));
    }
    if let Some(found) = &record.centreline {
        let line = RoadCurve {
            offset_m: found.offset_m,
            heading_rad: found.heading_rad,
            curvature_per_m: found.curvature_per_m.unwrap_or(0.0),
        };
        shapes.push(lens.shape(ShapeKind::Centreline, "the road's middle", line.places()));
    }
    shapes.extend(lane_edges(record));
    shapes.extend(feature_shapes(record, &lens));
    shapes
}

/// The horizon of a camera, and lines on the road every five metres ahead and to either side.
pub fn metre_grid(camera: &Camera) -> Vec<Shape> {
    let lens = Lens { camera: Some(camera.clone()) };
    let lines = |most: i32| (-most..=most).map(|line| f64::from(line) * GRID_STEP_M);
    let (far, beside) = ((GRID_REACH_M / GRID_STEP_M) as i32, (GRID_BESIDE_M / GRID_STEP_M) as i32);
    let across = lines(far).filter(|ahead_m| *ahead_m > 0.0).map(|ahead_m| {
        let places = sampled(-GRID_BESIDE_M, GRID_BESIDE_M).map(|left_m| [ahead_m, left_m]).collect();
        lens.shape(ShapeKind::MetreGrid, &format!("{ahead_m:.0} m ahead"), places)
    });
    let along = lines(beside).map(|left_m| {
        let places = sampled(0.0, GRID_REACH_M).map(|ahead_m| [ahead_m, left_m]).collect();
        lens.shape(ShapeKind::MetreGrid, &format!("{left_m:.0} m to the left"), places)
    });
    lens.horizon().into_iter().chain(across).chain(along).collect()
}

/// Places from one end to the other, metres.
fn sampled(from_m: f64, to_m: f64) -> impl Iterator<Item = f64> {
    let steps = ((to_m - from_m) / STEP_M) as usize;
    (0..=steps).map(move |step| from_m + step as f64 * STEP_M)
}

/// The camera as it is turned in the frame.
fn turned(camera: &Camera, by: Option<&MountRecord>) -> Camera {
    let (View::Calibrated { mount, .. }, Some(by)) = (camera.view(), by) else { return camera.clone() };
    let mut mount = *mount;
    mount.pitch_rad += (by.pitch_deg + by.suspension_pitch_deg).to_radians();
    mount.roll_rad += by.roll_deg.to_radians();
    // An absurd estimate is left out.
    camera.with_mount(mount).unwrap_or_else(|_| camera.clone())
}

fn lane_edges(record: &FrameRecord) -> Vec<Shape> {
    let Some(lanes) = &record.lanes else { return Vec::new() };
    let sides = [("left", &lanes.left_px, lanes.left), ("right", &lanes.right_px, lanes.right)];
    let known = sides.into_iter().filter(|(_, points_px, edge)| !points_px.is_empty() || edge.is_some());
    known
        .map(|(side, points_px, edge)| {
            let on_road = edge.map(|edge| RoadCurve {
                offset_m: edge.offset_m,
                heading_rad: edge.heading_rad,
                curvature_per_m: edge.curvature_per_m,
            });
            Shape {
                kind: ShapeKind::LaneEdge,
                label: format!("the lane's {side} edge"),
                ground_m: on_road.map(|curve| curve.places()).unwrap_or_default(),
                picture_px: vec![points_px.clone()],
            }
        })
        .collect()
}

fn feature_shapes(record: &FrameRecord, lens: &Lens) -> Vec<Shape> {
    let mut shapes = Vec::new();
    if let Some(feature) = &record.feature {
        for rival in &feature.rivals {
            let place = [rival.forward_m, rival.left_m];
            let text = format!("it may be {:.1} m ahead: {:.2}", rival.forward_m, rival.present);
            shapes.push(lens.shape(ShapeKind::Doubt, &text, outline(place, rival.sigma_m)));
            shapes.push(lens.shape(ShapeKind::Rival, &text, vec![place]));
        }
        let place = [feature.forward_m, feature.left_m];
        let [ahead_m, across_m] = feature.sigma_m;
        let doubt = format!("two standard deviations: {ahead_m:.2} m ahead, {across_m:.2} m across, each");
        shapes.push(lens.shape(ShapeKind::Doubt, &doubt, outline(place, feature.sigma_m)));
        let p = feature.p.map_or_else(String::new, |p| format!(", P(F) {p:.2}"));
        let text =
            format!("{} {}, {:.1} m ahead{p}", feature.kind.replace('_', " "), feature.id, feature.forward_m);
        shapes.push(lens.shape(ShapeKind::Feature, &text, vec![place]));
    }
    if let Some(sought) = &record.sought {
        let present = sought.present.map_or_else(String::new, |present| format!(": {present:.2}"));
        let text = format!("{} may be {:.1} m ahead{present}", sought.id, sought.forward_m);
        shapes.push(lens.shape(ShapeKind::Sought, &text, vec![[sought.forward_m, sought.left_m]]));
    }
    shapes
}

/// The outline of what may be with two standard deviations, `[forward, left]` metres.
fn outline([forward_m, left_m]: [f64; 2], [ahead_m, across_m]: [f64; 2]) -> Vec<[f64; 2]> {
    let corner = |index: usize| {
        let angle = TAU * index as f64 / DOUBT_CORNERS as f64;
        [
            forward_m + DOUBT_SIGMAS * ahead_m * libm::cos(angle),
            left_m + DOUBT_SIGMAS * across_m * libm::sin(angle),
        ]
    };
    (0..=DOUBT_CORNERS).map(corner).collect()
}

/// A line along the road as records have it.
struct RoadCurve {
    offset_m: f64,
    heading_rad: f64,
    curvature_per_m: f64,
}

impl RoadCurve {
    fn places(&self) -> Vec<[f64; 2]> {
        let left =
            |x: f64| self.offset_m + libm::tan(self.heading_rad) * x + 0.5 * self.curvature_per_m * x * x;
        sampled(0.0, REACH_M).map(|x| [x, left(x)]).collect()
    }
}

/// The camera of a frame, where it is known.
pub(crate) struct Lens {
    pub(crate) camera: Option<Camera>,
}

impl Lens {
    /// A place or line of the road with what of it the camera sees.
    pub(crate) fn shape(&self, kind: ShapeKind, label: &str, ground_m: Vec<[f64; 2]>) -> Shape {
        let pixels = ground_m.iter().map(|&[x, y]| self.camera.as_ref()?.pixel_of_ground(Point2::new(x, y)));
        let picture_px = self.stretches(pixels);
        // Records have no more digits.
        let ground_m = ground_m.into_iter().map(|place| place.map(|m| (m * 1e4).round() / 1e4)).collect();
        Shape { kind, label: label.to_owned(), ground_m, picture_px }
    }

    /// None without a camera, and of one that is known by points of the road alone.
    fn horizon(&self) -> Option<Shape> {
        let camera = self.camera.as_ref()?;
        let View::Calibrated { mount, .. } = camera.view() else { return None };
        let far = |step: i32| {
            let angle = HORIZON_RAD * f64::from(step) / f64::from(HORIZON_STEPS) + mount.yaw_rad;
            let (x, y) = (HORIZON_M * libm::cos(angle), HORIZON_M * libm::sin(angle));
            camera.project(Point3::new(x, y, mount.height_m))
        };
        let picture_px = self.stretches((-HORIZON_STEPS..=HORIZON_STEPS).map(far));
        let label = "horizon of the camera as it is turned in this frame".to_owned();
        Some(Shape { kind: ShapeKind::Horizon, label, ground_m: Vec::new(), picture_px })
    }

    /// Pixels without those that are not seen.
    fn stretches(&self, pixels: impl Iterator<Item = Option<Pixel>>) -> Vec<Vec<[f64; 2]>> {
        let mut stretches = vec![Vec::new()];
        for pixel in pixels {
            match (pixel.filter(|pixel| self.is_near(*pixel)), stretches.last_mut()) {
                (Some(Pixel { u, v }), Some(stretch)) => {
                    stretch.push([u, v].map(|px| (px * 100.0).round() / 100.0))
                }
                (None, Some(stretch)) if !stretch.is_empty() => stretches.push(Vec::new()),
                _ => {}
            }
        }
        stretches.retain(|stretch| !stretch.is_empty());
        stretches
    }

    /// Places beside or below the lens are thrown far out of the picture, some to its other side.
    fn is_near(&self, pixel: Pixel) -> bool {
        self.camera.as_ref().is_some_and(|camera| {
            let most = 4.0 * camera.width().max(camera.height()) as f64;
            pixel.u.abs() < most && pixel.v.abs() < most
        })
    }
}

#[cfg(test)]
mod tests;
