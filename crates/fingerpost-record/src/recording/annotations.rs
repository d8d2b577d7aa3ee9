//! What is drawn into the camera's picture.

use fingerpost::lanes::Side;
use fingerpost::track::Followed;
use fingerpost_geometry::{Camera, Pixel};
use fingerpost_report::{Scene, sub_mask_colour};
use foxglove::messages::points_annotation::Type;
use foxglove::messages::{
    CircleAnnotation, ImageAnnotations, Point2 as PixelMessage, PointsAnnotation, TextAnnotation, Timestamp,
};
use nalgebra::{Isometry2, Point2};

use super::colour::{FEATURE, LANE, colour};

/// The lane's edges, the driving line and the followed feature's node.
pub(crate) fn annotations(timestamp: Timestamp, scene: &Scene<'_>) -> ImageAnnotations {
    let camera = &scene.setting.camera;
    let mut drawn = ImageAnnotations { timestamp: Some(timestamp), ..ImageAnnotations::default() };
    if let Some(lane) = &scene.output.lane {
        for edge in Side::BOTH.into_iter().filter_map(|side| lane.edge(side)) {
            drawn.points.push(strip(timestamp, edge.points_px.iter().copied(), LANE));
        }
    }
    let followed = scene.output.track.followed.as_ref();
    // The picture shows things where the configured mount puts them, which may not be where they are.
    let shown_from_road = followed.map_or_else(Isometry2::identity, Followed::shown_from_road);
    let line = scene.output.driving_line.iter().filter_map(|p| camera.pixel_of_ground(shown_from_road * p));
    let line = strip(timestamp, line, sub_mask_colour("driving_line"));
    if line.points.len() > 1 {
        drawn.points.push(line);
    }
    if let Some(node) = followed.and_then(|followed| node_pixel(camera, followed)) {
        drawn.circles.push(CircleAnnotation {
            timestamp: Some(timestamp),
            position: Some(message(node)),
            diameter: 16.0,
            thickness: 3.0,
            fill_color: None,
            outline_color: Some(colour(FEATURE, 1.0)),
            metadata: Vec::new(),
        });
        drawn.texts.extend(followed.map(|followed| TextAnnotation {
            timestamp: Some(timestamp),
            position: Some(message(node)),
            text: format!("{:.1} m", followed.vehicle_from_feature.translation.vector.x),
            font_size: 14.0,
            text_color: Some(colour(FEATURE, 1.0)),
            background_color: None,
            metadata: Vec::new(),
        }));
    }
    drawn
}

fn node_pixel(camera: &Camera, followed: &Followed) -> Option<Pixel> {
    let node = Point2::from(followed.matched.vehicle_from_feature.translation.vector);
    camera.pixel_of_ground(node).filter(|pixel| camera.contains(*pixel))
}

/// A pixel as Foxglove counts them: from the top left corner of the top left pixel, not from its centre.
fn message(pixel: Pixel) -> PixelMessage {
    PixelMessage { x: pixel.u + 0.5, y: pixel.v + 0.5 }
}

fn strip(timestamp: Timestamp, points: impl Iterator<Item = Pixel>, of: [u8; 3]) -> PointsAnnotation {
    PointsAnnotation {
        timestamp: Some(timestamp),
        r#type: Type::LineStrip as i32,
        points: points.map(message).collect(),
        outline_color: Some(colour(of, 1.0)),
        outline_colors: Vec::new(),
        fill_color: None,
        thickness: 3.0,
        metadata: Vec::new(),
    }
}
