//! A track as other programs read it: GeoJSON and GPX for maps, pose files of TUM and KITTI for comparing trajectories.
//!
//! Only points that are worth following are in it: a fix that is ambiguous or lost jumps between places that are all possible.

use std::fmt::Write;

use serde_json::json;

use crate::FixStatus;

/// A point of a track.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TrackPoint {
    /// Time, seconds.
    pub t_s: f64,
    /// Latitude and longitude, degrees.
    pub lat_lon: [f64; 2],
    /// East and north of the plane's origin, metres.
    pub place_m: [f64; 2],
    /// Heading, radians anticlockwise from east.
    pub heading_rad: f64,
    /// What the fix is worth.
    pub status: FixStatus,
    /// Whether the point before is that of the row before.
    pub joins: bool,
}

/// Digits after the point of degrees of place: about a centimetre, as exact as a fix is written anyhow.
const PLACE_DIGITS: i32 = 7;

/// Splits a track where rows are missing from it or `differ` says so.
fn parts(
    points: &[TrackPoint],
    differ: impl Fn(&TrackPoint, &TrackPoint) -> bool,
) -> impl Iterator<Item = &[TrackPoint]> {
    points.chunk_by(move |one, next| next.joins && !differ(one, next))
}

/// A FeatureCollection (RFC 7946) of a line for each time without interruption in which the fix was worth the same, a point where
/// that was one row; with `status`, `from_s` and `to_s`.
pub fn track_geojson(points: &[TrackPoint]) -> String {
    let rounded = |degrees: f64| (degrees * 10_f64.powi(PLACE_DIGITS)).round() / 10_f64.powi(PLACE_DIGITS);
    let features: Vec<_> = parts(points, |one, next| one.status != next.status)
        .map(|part| {
            let places: Vec<_> =
                part.iter().map(|point| [rounded(point.lat_lon[1]), rounded(point.lat_lon[0])]).collect();
            let geometry = match &places[..] {
                [place] => json!({ "type": "Point", "coordinates": place }),
                _ => json!({ "type": "LineString", "coordinates": places }),
            };
            let times_s = [part.first(), part.last()].map(|point| point.map(|point| point.t_s));
            let status = part.first().map(|point| point.status);
            json!({
                "type": "Feature",
                "geometry": geometry,
                "properties": { "status": status, "from_s": times_s[0], "to_s": times_s[1] },
            })
        })
        .collect();
    format!("{}\n", json!({ "type": "FeatureCollection", "features": features }))
}

/// A GPX 1.1 track, a segment for each time without interruption. Its times are the points', counted from 1970-01-01 00:00 UTC.
pub fn track_gpx(points: &[TrackPoint]) -> String {
    let segments = parts(points, |_, _| false);
    gpx(segments.map(|part| part.iter().map(|point| (point.t_s, point.lat_lon))))
}

/// GPS positions of a drive, latitude and longitude in degrees, with their times since its first frame, seconds, as a GPX 1.1 track
/// whose times are counted from 1970-01-01 00:00 UTC.
pub fn gps_gpx(positions: &[(f64, [f64; 2])]) -> String {
    gpx([positions.iter().copied()])
}

fn gpx<P: Iterator<Item = (f64, [f64; 2])>>(segments: impl IntoIterator<Item = P>) -> String {
    let mut gpx = String::from(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<gpx version=\"1.1\" creator=\"fingerpost\" \
         xmlns=\"http://www.topografix.com/GPX/1/1\">\n<trk>\n",
    );
    for segment in segments {
        gpx.push_str("<trkseg>\n");
        for (t_s, [lat, lon]) in segment {
            // Writing to a String does not fail.
            let _ = writeln!(
                gpx,
                "<trkpt lat=\"{lat:.7}\" lon=\"{lon:.7}\"><time>{}</time></trkpt>",
                utc_time(t_s)
            );
        }
        gpx.push_str("</trkseg>\n");
    }
    gpx.push_str("</trk>\n</gpx>\n");
    gpx
}

/// Milliseconds in a second and seconds in a day.
const MS: i64 = 1000;
const DAY_S: i64 = 86_400;

/// Universal time of seconds since 1970-01-01 00:00 UTC, as ISO 8601 and RFC 3339 have it, to a millisecond.
///
/// Source: H. Hinnant, "chrono-compatible low-level date algorithms"; years are counted from March.
pub fn utc_time(t_s: f64) -> String {
    let all_ms = (t_s * MS as f64).round() as i64;
    let (whole_s, ms) = (all_ms.div_euclid(MS), all_ms.rem_euclid(MS));
    let (days, of_day_s) = (whole_s.div_euclid(DAY_S) + 719_468, whole_s.rem_euclid(DAY_S));
    let (era, of_era) = (days.div_euclid(146_097), days.rem_euclid(146_097));
    let years = (of_era - of_era / 1460 + of_era / 36_524 - of_era / 146_096) / 365;
    let of_year = of_era - (365 * years + years / 4 - years / 100);
    let months = (5 * of_year + 2) / 153;
    let day = of_year - (153 * months + 2) / 5 + 1;
    let month = if months < 10 { months + 3 } else { months - 9 };
    let year = years + 400 * era + i64::from(month <= 2);
    let (hour, minute, second) = (of_day_s / 3600, of_day_s / 60 % 60, of_day_s % 60);
    format!("{year:04}-{month:02}-{day:02}T{hour:02}:{minute:02}:{second:02}.{ms:03}Z")
}

/// Days of a date since 1970-01-01, by the same source.
pub(crate) const fn days_since_1970(year: i64, month: i64, day: i64) -> i64 {
    let year = if month <= 2 { year - 1 } else { year };
    let era = year.div_euclid(400);
    let of_era = year - 400 * era;
    let months = if month > 2 { month - 3 } else { month + 9 };
    let of_year = (153 * months + 2) / 5 + day - 1;
    era * 146_097 + of_era * 365 + of_era / 4 - of_era / 100 + of_year - 719_468
}

/// A pose a line as the RGB-D benchmark of TU Munich has it: time, place and quaternion, in the plane with x east, y north, z up.
pub fn track_tum(points: &[TrackPoint]) -> String {
    let mut lines =
        String::from("# timestamp tx ty tz qx qy qz qw; x east, y north of the map's plane, metres\n");
    for TrackPoint { t_s, place_m: [east, north], heading_rad, .. } in points {
        let (sin, cos) = libm::sincos(0.5 * heading_rad);
        let _ = writeln!(lines, "{t_s:.6} {east:.4} {north:.4} 0 0 0 {sin:.8} {cos:.8}");
    }
    lines
}

/// A pose a line as KITTI's odometry benchmark has it: the upper three rows of its matrix, from the frame of the first pose, with x
/// to the right, y down and z ahead.
pub fn track_kitti(points: &[TrackPoint]) -> String {
    let mut lines = String::new();
    let Some(first) = points.first() else { return lines };
    let (sin, cos) = libm::sincos(first.heading_rad);
    for TrackPoint { place_m: [east, north], heading_rad, .. } in points {
        let (east, north) = (east - first.place_m[0], north - first.place_m[1]);
        let (ahead, right) = (east * cos + north * sin, east * sin - north * cos);
        let (turned, straight) = libm::sincos(heading_rad - first.heading_rad);
        let _ = writeln!(
            lines,
            "{straight:.8} 0 {:.8} {right:.4} 0 1 0 0 {turned:.8} 0 {straight:.8} {ahead:.4}",
            -turned
        );
    }
    lines
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{FRAC_1_SQRT_2, FRAC_PI_2, PI};

    use super::*;

    /// North for 10 m, then west for 5 m; the second row after a gap.
    fn points() -> Vec<TrackPoint> {
        let point = |t_s: f64, place_m: [f64; 2], heading_rad: f64, status, joins| {
            let lat_lon = [48.0 + place_m[1] * 1e-5, 8.0 + place_m[0] * 1e-5];
            TrackPoint { t_s, lat_lon, place_m, heading_rad, status, joins }
        };
        vec![
            point(0.0, [100.0, 50.0], FRAC_PI_2, FixStatus::Converged, false),
            point(1.0, [100.0, 60.0], FRAC_PI_2, FixStatus::Converged, true),
            point(1.5, [95.0, 60.0], PI, FixStatus::Coasting, true),
            point(4.0, [90.0, 60.0], PI, FixStatus::Converged, false),
        ]
    }

    #[test]
    fn kitti_has_right_down_and_ahead_of_the_first_pose() {
        let lines = track_kitti(&points());
        let rows: Vec<Vec<f64>> = lines
            .lines()
            .map(|line| line.split(' ').map(|number| number.parse().unwrap_or(f64::NAN)).collect())
            .collect();
        let close = |row: &[f64], expected: [f64; 12]| {
            row.len() == 12 && row.iter().zip(expected).all(|(seen, expected)| (seen - expected).abs() < 1e-7)
        };
        assert!(close(&rows[0], [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0]));
        assert!(close(&rows[1], [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 10.0]));
        // Turned to the left, ahead (third column) is to the left of what was ahead at first.
        assert!(close(&rows[2], [0.0, 0.0, -1.0, -5.0, 0.0, 1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 10.0]), "{lines}");
    }

    #[test]
    fn tum_has_the_heading_about_the_upward_axis() {
        let lines = track_tum(&points());
        let second: Vec<f64> = lines
            .lines()
            .nth(2)
            .map(|line| line.split(' ').map(|number| number.parse().unwrap_or(f64::NAN)).collect())
            .unwrap_or_default();
        let expected = [1.0, 100.0, 60.0, 0.0, 0.0, 0.0, FRAC_1_SQRT_2, FRAC_1_SQRT_2];
        assert!(
            second.iter().zip(expected).all(|(seen, expected)| (seen - expected).abs() < 1e-7),
            "{lines}"
        );
        assert_eq!(second.len(), 8);
    }

    #[test]
    fn lines_end_where_rows_are_missing_or_the_status_changes() {
        let geojson: serde_json::Value = serde_json::from_str(&track_geojson(&points())).unwrap_or_default();
        let features = geojson["features"].as_array().cloned().unwrap_or_default();
        let kinds: Vec<_> = features
            .iter()
            .map(|feature| (feature["geometry"]["type"].as_str(), feature["properties"]["status"].as_str()))
            .collect();
        assert_eq!(
            kinds,
            [
                (Some("LineString"), Some("converged")),
                (Some("Point"), Some("coasting")),
                (Some("Point"), Some("converged"))
            ]
        );
        // GeoJSON has longitude first.
        assert_eq!(features[0]["geometry"]["coordinates"][1], json!([8.001, 48.0006]));
        assert_eq!(track_gpx(&points()).matches("<trkseg>").count(), 2);
    }

    #[test]
    fn times_are_those_of_the_calendar() {
        // `date -u -d @951868799 +%FT%T`, and the like.
        for (t_s, expected) in [
            (0.0, "1970-01-01T00:00:00.000Z"),
            (951_868_799.25, "2000-02-29T23:59:59.250Z"),
            (1_709_251_200.0, "2024-03-01T00:00:00.000Z"),
            (-0.5, "1969-12-31T23:59:59.500Z"),
        ] {
            assert_eq!(utc_time(t_s), expected);
        }
    }

    #[test]
    fn dates_are_days_of_the_calendar() {
        for (date, midnight) in [
            ((1970, 1, 1), "1970-01-01T00:00:00.000Z"),
            ((2000, 2, 29), "2000-02-29T00:00:00.000Z"),
            ((2011, 9, 26), "2011-09-26T00:00:00.000Z"),
        ] {
            let (year, month, day) = date;
            assert_eq!(utc_time((days_since_1970(year, month, day) * DAY_S) as f64), midnight);
        }
    }
}
