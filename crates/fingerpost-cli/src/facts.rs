//! What is said of what was read: in words with `-v`, and in results.

use std::collections::BTreeMap;

use fingerpost::Config;
use fingerpost_format::MapNoticeRecord;
use fingerpost_geometry::{Camera, Distortion, View};
use fingerpost_map::{MapNotice, RoadGraph, Route};
use fingerpost_record::kind_name;
use serde_json::Value;

use crate::changed_settings::differing;

/// A camera: its pictures, its lens and how it is mounted.
pub(crate) fn of_camera(camera: &Camera) -> String {
    let (width, height) = (camera.width(), camera.height());
    let View::Calibrated { intrinsics, distortion, mount, .. } = camera.view() else {
        return format!("camera of {width} x {height} pixels, known by four points on the road");
    };
    let lens = match distortion {
        Distortion::None => "no distortion",
        Distortion::BrownConrady { .. } => "Brown-Conrady distortion",
        Distortion::KannalaBrandt { .. } => "Kannala-Brandt distortion",
    };
    let angle = |rad: f64| rad.to_degrees();
    format!(
        "camera of {width} x {height} pixels, focal length {:.1} pixels, {lens}, {:.2} m above the road, pitch {:.2}°, yaw {:.2}°, \
         roll {:.2}°",
        intrinsics.fx,
        mount.height_m,
        angle(mount.pitch_rad),
        angle(mount.yaw_rad),
        angle(mount.roll_rad)
    )
}

/// A map's roads.
pub(crate) fn of_roads(graph: &RoadGraph) -> String {
    let (ways, segments, nodes) = (graph.ways().len(), graph.segments().len(), graph.nodes().len());
    format!("map with {ways} roads, of {segments} straight pieces between {nodes} nodes")
}

/// What of a map was not understood, as in results.
pub(crate) fn of_notices(graph: &RoadGraph) -> Vec<MapNoticeRecord> {
    let record = |notice: &MapNotice| MapNoticeRecord {
        kind: notice.kind.as_str().to_owned(),
        count: notice.count,
        first: notice.first.clone(),
    };
    graph.notices().iter().map(record).collect()
}

/// A route: its length, and its features by kind.
pub(crate) fn of_route(route: &Route) -> String {
    let length = route.polyline().map_or("no length".to_owned(), |line| format!("{:.0} m", line.length_m()));
    let mut kinds: BTreeMap<&str, usize> = BTreeMap::new();
    route.features.iter().for_each(|feature| *kinds.entry(kind_name(feature.kind)).or_default() += 1);
    let kinds: Vec<String> = kinds.iter().map(|(kind, count)| format!("{kind} {count}")).collect();
    let kinds = if kinds.is_empty() { String::new() } else { format!(" ({})", kinds.join(", ")) };
    let features = match route.features.len() {
        1 => "1 feature".to_owned(),
        count => format!("{count} features"),
    };
    format!("route of {length} with {features}{kinds}")
}

/// Settings that are not the default, each with the default: `track.detect_present = 0.9 (default 0.8)`.
pub(crate) fn of_settings(config: &Config) -> Vec<String> {
    let text = |value: &Value| if value.is_null() { "none".to_owned() } else { value.to_string() };
    differing(&config.to_json(), &Config::default().to_json())
        .iter()
        .map(|(key, [value, default])| format!("{key} = {} (default {})", text(value), text(default)))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn settings_are_named_where_they_differ_and_nowhere_else() {
        let mut config = Config::default();
        assert!(of_settings(&config).is_empty());
        let usual = config.track.detect_sigma_m;
        config.track.detect_sigma_m = usual + 1.0;
        config.can.speed = Some("WHEELS.SPEED".to_owned());
        assert_eq!(
            of_settings(&config),
            [
                "can.speed = \"WHEELS.SPEED\" (default none)".to_owned(),
                format!("track.detect_sigma_m = {} (default {usual})", usual + 1.0)
            ]
        );
    }
}
