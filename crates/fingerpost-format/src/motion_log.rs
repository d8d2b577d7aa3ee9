//! Motion logs and logs of poses, as CSV.

use std::fmt::Write;

use crate::columns::{ColumnsError, parse_columns, parse_usable_columns};

/// One line of a motion log.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MotionLogRow {
    /// Time, seconds.
    pub t_s: f64,
    /// Speed forward, metres a second; negative when reversing.
    pub speed_mps: f64,
    /// Yaw rate, radians a second, positive to the left.
    pub yaw_rate_rps: f64,
}

/// One line of a log of true poses.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PoseLogRow {
    /// Time, seconds.
    pub t_s: f64,
    /// Latitude, degrees.
    pub lat: f64,
    /// Longitude, degrees.
    pub lon: f64,
    /// Heading, radians anticlockwise from east.
    pub heading_rad: f64,
}

/// A motion log.
#[derive(Debug, Clone, PartialEq)]
pub struct MotionLog {
    /// Its rows, in the order of time.
    pub rows: Vec<MotionLogRow>,
    /// What is wrong with the lines that are none of them: no numbers, or no later than the row before.
    pub passed_over: Vec<ColumnsError>,
}

/// A motion log: `t_s,speed_mps,yaw_rate_rps`. Lines that cannot be used are passed over.
///
/// # Errors
/// [`ColumnsError`], where the header names no such columns; and where half of the lines cannot be used or more, the first of them.
pub fn parse_motion_log(text: &str) -> Result<MotionLog, ColumnsError> {
    let (rows, passed_over) = parse_usable_columns(text, ["t_s", "speed_mps", "yaw_rate_rps"])?;
    let row = |[t_s, speed_mps, yaw_rate_rps]: [f64; 3]| MotionLogRow { t_s, speed_mps, yaw_rate_rps };
    Ok(MotionLog { rows: rows.into_iter().map(row).collect(), passed_over })
}

/// The text of a motion log.
pub fn motion_log_text(rows: &[MotionLogRow]) -> String {
    let mut text = String::from("t_s,speed_mps,yaw_rate_rps\n");
    for MotionLogRow { t_s, speed_mps, yaw_rate_rps } in rows {
        // Writing to a String does not fail.
        let _ = writeln!(text, "{t_s:.6},{speed_mps:.6},{yaw_rate_rps:.6}");
    }
    text
}

/// The text of a log of true poses.
pub fn pose_log_text(rows: &[PoseLogRow]) -> String {
    let mut text = String::from("t_s,lat,lon,heading_rad\n");
    for PoseLogRow { t_s, lat, lon, heading_rad } in rows {
        let _ = writeln!(text, "{t_s:.6},{lat:.9},{lon:.9},{heading_rad:.6}");
    }
    text
}

/// The rows of a log of true poses: `t_s,lat,lon,heading_rad`.
///
/// # Errors
/// [`ColumnsError`] names the first line that cannot be used.
pub fn parse_pose_log(text: &str) -> Result<Vec<PoseLogRow>, ColumnsError> {
    let rows = parse_columns(text, ["t_s", "lat", "lon", "heading_rad"])?;
    let row = |[t_s, lat, lon, heading_rad]: [f64; 4]| PoseLogRow { t_s, lat, lon, heading_rad };
    Ok(rows.into_iter().map(row).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_written_reads_back() {
        let rows = [0.0, 0.1].map(|t_s| MotionLogRow { t_s, speed_mps: 8.25, yaw_rate_rps: -0.5 });
        let read = parse_motion_log(&motion_log_text(&rows)).expect("a log");
        assert_eq!((read.rows, read.passed_over), (rows.to_vec(), Vec::new()));
        let rows = [0.0, 0.1].map(|t_s| PoseLogRow { t_s, lat: 49.0125, lon: 8.5, heading_rad: 1.5 });
        assert_eq!(parse_pose_log(&pose_log_text(&rows)).expect("a log"), rows);
    }
}
