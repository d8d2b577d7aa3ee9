//! The followed feature as markers for RViz and Foxglove.

use foxglove::messages::{Color, SceneEntity, SceneUpdate};

use crate::frames::BASE_LINK;
use crate::messages::{Colour, Header, Marker, MarkerArray, Pose, Vector3};

// Kinds and actions of `visualization_msgs/Marker`.
const LINE_STRIP: i32 = 4;
const SPHERE: i32 = 2;
const TEXT_VIEW_FACING: i32 = 9;
const ADD: i32 = 0;
const DELETE_ALL: i32 = 3;

/// Height of letters, metres: those of a lorry's number plate, readable over a view of 20 m.
const LETTERS_M: f64 = 0.8;

/// A scene as markers that take the place of those before.
pub(crate) fn markers(stamp_ns: u64, scene: &SceneUpdate) -> MarkerArray {
    let gone = Marker { header: Header::new(stamp_ns, BASE_LINK), action: DELETE_ALL, ..Marker::default() };
    let drawn = scene.entities.iter().flat_map(of_entity).zip(0..).map(|(marker, id)| Marker {
        header: Header::new(stamp_ns, BASE_LINK),
        ns: "feature".to_owned(),
        id,
        action: ADD,
        frame_locked: true,
        ..marker
    });
    MarkerArray { markers: std::iter::once(gone).chain(drawn).collect() }
}

fn of_entity(entity: &SceneEntity) -> impl Iterator<Item = Marker> {
    let lines = entity.lines.iter().map(|line| Marker {
        kind: LINE_STRIP,
        scale: Vector3 { x: line.thickness, ..Vector3::default() },
        colour: colour(line.color.as_ref()),
        points: line.points.iter().map(|p| Vector3 { x: p.x, y: p.y, z: p.z }).collect(),
        ..Marker::default()
    });
    let spheres = entity.spheres.iter().map(|sphere| Marker {
        kind: SPHERE,
        pose: pose(sphere.pose.as_ref()),
        scale: sphere.size.as_ref().map_or_else(Vector3::default, vector),
        colour: colour(sphere.color.as_ref()),
        ..Marker::default()
    });
    let texts = entity.texts.iter().map(|text| Marker {
        kind: TEXT_VIEW_FACING,
        pose: pose(text.pose.as_ref()),
        scale: Vector3 { z: LETTERS_M, ..Vector3::default() },
        colour: colour(text.color.as_ref()),
        text: text.text.clone(),
        ..Marker::default()
    });
    lines.chain(spheres).chain(texts)
}

fn vector(vector: &foxglove::messages::Vector3) -> Vector3 {
    Vector3 { x: vector.x, y: vector.y, z: vector.z }
}

fn pose(pose: Option<&foxglove::messages::Pose>) -> Pose {
    let position = pose.and_then(|pose| pose.position.as_ref()).map(vector);
    Pose { position: position.unwrap_or_default(), ..Pose::default() }
}

fn colour(colour: Option<&Color>) -> Colour {
    colour.map_or_else(Colour::default, |colour| Colour {
        r: colour.r as f32,
        g: colour.g as f32,
        b: colour.b as f32,
        a: colour.a as f32,
    })
}

#[cfg(test)]
mod tests {
    use fingerpost_record::recording::feature_entities;
    use foxglove::messages::{LinePrimitive, Point3, TextPrimitive, Timestamp};

    use super::*;

    #[test]
    fn what_is_not_followed_any_more_goes() {
        let sent = markers(3, &feature_entities(Timestamp::MIN, None));
        assert_eq!(sent.markers.len(), 1);
        assert_eq!((sent.markers[0].action, sent.markers[0].header.frame_id.as_str()), (3, "base_link"));
    }

    #[test]
    fn lines_and_texts_keep_their_place_and_have_numbers_of_their_own() {
        let line = LinePrimitive {
            thickness: 3.5,
            points: vec![Point3 { x: 9.0, y: -2.0, z: 0.0 }; 2],
            ..Default::default()
        };
        let text = TextPrimitive { text: "1 12.0 m".to_owned(), ..Default::default() };
        let entity = SceneEntity { lines: vec![line], texts: vec![text], ..Default::default() };
        let sent = markers(3, &SceneUpdate { deletions: Vec::new(), entities: vec![entity] }).markers;
        let drawn: Vec<(i32, i32, i32)> = sent[1..].iter().map(|m| (m.id, m.kind, m.action)).collect();
        assert_eq!(drawn, [(0, LINE_STRIP, ADD), (1, TEXT_VIEW_FACING, ADD)]);
        assert!((sent[1].points[0].y + 2.0).abs() < 1e-12 && (sent[1].scale.x - 3.5).abs() < 1e-12);
        assert!(sent[2].text == "1 12.0 m" && sent[2].scale.z > 0.0);
    }
}
