//! `route.geojson`: written and read back, by hand, and broken.

// Functions shared by tests fail their test by unwrapping.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

use fingerpost_map::{
    Arm, ArmRole, FeatureKind, LatLon, Parking, Route, RouteFeature, RouteFileError, RoutePoint, read_route,
    write_route,
};
use serde_json::Value;

fn at(lat_deg: f64, lon_deg: f64) -> LatLon {
    LatLon::new(lat_deg, lon_deg).unwrap()
}

fn arm(role: ArmRole, bearing_rad: f64, end: LatLon) -> Arm {
    let surface = (role == ArmRole::Exit).then(|| "asphalt".to_owned());
    Arm {
        role,
        bearing_rad,
        points: vec![at(48.5, 8.5), end],
        width_m: 5.5,
        surface,
        beside: Default::default(),
    }
}

/// Northwards to a junction, then left; a side road leaves to the east.
fn route() -> Route {
    let feature = RouteFeature {
        id: 24_546_162,
        at: at(48.5, 8.5),
        name: "Neckarstraße \"x\"".to_owned(),
        kind: FeatureKind::Junction,
        turn_rad: 1.55,
        arms: vec![
            arm(ArmRole::Approach, -1.55, at(48.499, 8.5)),
            arm(ArmRole::Exit, 3.1, at(48.5, 8.499)),
            arm(ArmRole::Side, 0.02, at(48.5, 8.501_234_567)),
        ],
        route_m: 55.6,
    };
    let line = vec![
        RoutePoint { node: None, at: at(48.499_500_001, 8.5) },
        RoutePoint { node: Some(24_546_162), at: at(48.5, 8.5) },
        RoutePoint { node: Some(-3), at: at(48.5, 8.499) },
    ];
    Route { name: "Home".to_owned(), line, features: vec![feature] }
}

#[test]
fn what_is_written_is_read_back() {
    let text = write_route(&route()).unwrap();
    let read = read_route(&text).unwrap();
    assert_eq!(write_route(&read).unwrap(), text);
    assert_eq!((&read.name, &read.line), (&route().name, &route().line));
    let (seen, expected) = (&read.features[0], &route().features[0]);
    assert_eq!(
        (seen.id, seen.kind, &seen.name, seen.at),
        (expected.id, expected.kind, &expected.name, expected.at)
    );
    assert!((seen.turn_rad - expected.turn_rad).abs() < 1e-8);
    for (seen, expected) in seen.arms.iter().zip(&expected.arms) {
        assert_eq!(
            (seen.role, &seen.points, &seen.surface),
            (expected.role, &expected.points, &expected.surface)
        );
        assert!((seen.bearing_rad - expected.bearing_rad).abs() < 1e-8);
    }
}

#[test]
fn angles_and_positions_are_as_documented() {
    let root: Value = serde_json::from_str(&write_route(&route()).unwrap()).unwrap();
    let point = &root["features"][1];
    assert_eq!(point["geometry"]["coordinates"], serde_json::json!([8.5, 48.5]), "longitude first");
    assert_eq!(point["properties"]["kind"], "junction");
    let number = |value: &Value| value.as_f64().unwrap();
    assert!((number(&point["properties"]["turn_deg"]) - 88.8085).abs() < 1e-3, "left is positive");
    // Clockwise from north: the approach leaves southwards, the exit westwards, the side road eastwards.
    for (arm, expected_deg) in [(0, 178.81), (1, 272.38), (2, 88.85)] {
        let bearing_deg = number(&point["properties"]["arms"][arm]["bearing_deg"]);
        assert!((bearing_deg - expected_deg).abs() < 0.01, "arm {arm}: {bearing_deg}");
    }
}

/// A file written by hand: no names, surfaces or node numbers, elevations, members in any order, something of its own.
const BY_HAND: &str = r#"{"type": "FeatureCollection", "crs": null, "features": [
  {"type": "Feature", "id": 7, "geometry": {"type": "Point", "coordinates": [8.5, 48.5, 110.0]}, "properties": {
    "id": 1, "kind": "side_road", "turn_deg": -3, "route_m": 111.2, "colour": "red", "arms": [
      {"role": "approach", "bearing_deg": 180, "width_m": 4, "points": [[8.5, 48.5], [8.5, 48.499]]},
      {"role": "exit", "bearing_deg": 0, "width_m": 4, "points": [[8.5, 48.5], [8.5, 48.501]]},
      {"role": "side", "bearing_deg": 270, "width_m": 3, "points": [[8.5, 48.5], [8.499, 48.5]]}]}},
  {"type": "Feature", "geometry": {"type": "LineString", "coordinates": [[8.5, 48.499], [8.5, 48.5]]}, "properties": null}
]}"#;

#[test]
fn files_written_by_hand_are_read() {
    let route = read_route(BY_HAND).unwrap();
    assert_eq!(route.line[0], RoutePoint { node: None, at: at(48.499, 8.5) });
    let feature = &route.features[0];
    assert_eq!((feature.kind, feature.name.as_str()), (FeatureKind::SideRoad, ""));
    assert!((feature.arms[2].bearing_rad - std::f64::consts::PI).abs() < 1e-12, "270 degrees is west");
    assert!((feature.arms[0].bearing_rad + std::f64::consts::FRAC_PI_2).abs() < 1e-12);
}

#[test]
fn broken_files_say_what_and_where() {
    let broken = |from: &str, to: &str| {
        assert!(BY_HAND.contains(from), "{from}");
        read_route(&BY_HAND.replacen(from, to, 1)).unwrap_err().to_string()
    };
    assert!(read_route("").unwrap_err().to_string().contains("not valid JSON"));
    assert!(read_route(&BY_HAND[..300]).unwrap_err().to_string().contains("not valid JSON"));
    assert!(read_route("{\"type\":\"Feature\"}").unwrap_err().to_string().contains("FeatureCollection"));
    let turn = broken("\"turn_deg\": -3,", "");
    assert!(turn.starts_with("feature 1 of the route file") && turn.contains("turn_deg"), "{turn}");
    assert!(broken("\"side_road\"", "\"roundabout\"").contains("roundabout"));
    assert!(broken("\"role\": \"exit\"", "\"role\": \"side\"").contains("one approach and one exit"));
    assert!(broken("\"width_m\": 4", "\"width_m\": -4").contains("width_m"));
    assert!(broken("[[8.5, 48.5], [8.499, 48.5]]", "[[8.5, 48.5]]").contains("not two at least"));
    assert!(broken("[8.499, 48.5]", "[8.499, 148.5]").contains("no place"));
    assert!(broken("LineString", "Polygon").contains("Polygon"));
    assert!(broken("[[8.5, 48.499], [8.5, 48.5]]}", "[[8.5, 48.5]]}").contains("feature 2"));
    assert!(
        broken("\"properties\": null", "\"properties\": {\"node_ids\": [1]}").contains("1 node_ids for 2")
    );
}

#[test]
fn numbers_that_no_road_has_are_refused_wherever_they_stand() {
    let keys = ["\"turn_deg\": -3", "\"route_m\": 111.2", "\"bearing_deg\": 270", "\"width_m\": 3"];
    let absurd = ["1e7", "-1e7", "9223372036854775808", "1e308", "-1e308", "1e-308", "361.5", "-9000"];
    for key in keys {
        let (name, _) = key.split_once(':').unwrap();
        for number in absurd {
            let text = BY_HAND.replacen(key, &format!("{name}: {number}"), 1);
            assert_ne!(text, BY_HAND);
            let (name, read) = (name.trim_matches('"'), read_route(&text));
            // Next to nothing is as good a turn as none.
            if (name, number) == ("turn_deg", "1e-308") {
                assert!(read.is_ok(), "{read:?}");
                continue;
            }
            let error = read.unwrap_err().to_string();
            assert!(error.contains(name) && error.starts_with("feature 1"), "{name} {number}: {error}");
        }
    }
}

#[test]
fn numbers_that_contradict_each_other_are_refused() {
    // From a metre to the route's length off: what is farther than half a wide junction is another place.
    for route_m in (0..=111).map(f64::from) {
        let text = BY_HAND.replacen("111.2", &route_m.to_string(), 1);
        let (read, off_m) = (read_route(&text), 111.2 - route_m);
        match read {
            Ok(_) => assert!(off_m < 15.5, "{route_m}"),
            Err(error) => {
                let words = format!("its route_m is {route_m:.1} and its place is at 111.2 m");
                assert!(off_m > 14.5 && error.to_string().contains(&words), "{error}");
            }
        }
    }
    for bearing_deg in 0..360 {
        let text = BY_HAND.replacen("\"bearing_deg\": 270", &format!("\"bearing_deg\": {bearing_deg}"), 1);
        let off_deg = (bearing_deg - 270_i32).abs();
        assert_eq!(read_route(&text).is_ok(), off_deg.min(360 - off_deg) <= 60, "{bearing_deg}");
    }
    for turn_deg in -180..=180 {
        let text = BY_HAND.replacen("\"turn_deg\": -3", &format!("\"turn_deg\": {turn_deg}"), 1);
        assert_eq!(read_route(&text).is_ok(), i32::abs(turn_deg) <= 60, "{turn_deg}");
    }
    let moved = BY_HAND.replacen("[[8.5, 48.5], [8.499, 48.5]]", "[[8.51, 48.5], [8.499, 48.5]]", 1);
    assert!(read_route(&moved).unwrap_err().to_string().contains("an arm begins"));
}

#[test]
fn a_route_that_is_no_number_is_not_written() {
    let mut broken = route();
    broken.features[0].turn_rad = f64::NAN;
    assert!(matches!(write_route(&broken), Err(RouteFileError::Json { .. })));
    broken = route();
    broken.line[0].at.lat_deg = f64::INFINITY;
    assert!(matches!(write_route(&broken), Err(RouteFileError::Json { .. })));
}

#[test]
fn what_lies_beside_an_arm_is_written_and_read_and_silence_is_not() {
    let with = |role: &str, beside: &str| {
        let text = format!("\"role\": \"{role}\"");
        BY_HAND.replacen(&text, &format!("{text}, {beside}"), 1)
    };
    let route =
        read_route(&with("side", r#""left": {"pavement": true, "parking": "half_on_kerb"}"#)).unwrap();
    let [left, right] = route.features[0].arms[2].beside;
    assert_eq!((left.pavement, left.parking), (Some(true), Some(Parking::HalfOnKerb)));
    assert!(right.is_silent());
    let written = write_route(&route).unwrap();
    assert!(written.contains(r#""left":{"pavement":true,"parking":"half_on_kerb"}"#), "{written}");
    assert_eq!(written.matches("\"left\"").count(), 1);
    assert_eq!(read_route(&written).unwrap(), route);
    let error = read_route(&with("side", r#""right": {"kerb": "high"}"#)).unwrap_err().to_string();
    assert!(error.contains("high"), "{error}");
}
