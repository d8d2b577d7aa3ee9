//! Files of KITTI's raw and odometry sequences.
//!
//! Source: A. Geiger, P. Lenz, C. Stiller and R. Urtasun, "Vision meets robotics: the KITTI dataset", IJRR 2013, and the
//! development kits' `readme.txt` and `dataformat.txt`.

use thiserror::Error;

use crate::track_files::days_since_1970;

/// A file of a sequence that cannot be used.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum KittiError {
    /// A line of the calibration is missing.
    #[error("there is no line {keys} with {numbers} numbers; give the calibration of the sequence's day")]
    NoCalibration {
        /// How the line may begin.
        keys: String,
        /// How many numbers follow.
        numbers: usize,
    },
    /// A line of GPS and inertial unit is none.
    #[error("it has {found} numbers in place of the {wanted} of a line of oxts; copy it again")]
    Oxts {
        /// Numbers found.
        found: usize,
        /// Numbers of a line.
        wanted: usize,
    },
    /// A time is none.
    #[error("line {line} is no time as in 2011-09-26 13:02:25.964389445: {text:?}")]
    Time {
        /// Line number, from one.
        line: usize,
        /// What stands there.
        text: String,
    },
}

/// What GPS and inertial unit say in one line of `oxts/data`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct KittiOxts {
    /// Latitude, degrees.
    pub lat_deg: f64,
    /// Longitude, degrees.
    pub lon_deg: f64,
    /// Heading, radians anticlockwise from east.
    pub heading_rad: f64,
    /// Speed forward, m/s.
    pub speed_mps: f64,
    /// Yaw rate, rad/s, positive to the left.
    pub yaw_rate_rps: f64,
}

/// Numbers of a line of `oxts/data`.
const OXTS_NUMBERS: usize = 30;

/// The projection matrix of rectified camera `camera` by rows: `P_rect_02` of a raw sequence's `calib_cam_to_cam.txt`, `P2` of an
/// odometry sequence's `calib.txt`.
///
/// # Errors
/// [`KittiError::NoCalibration`] when there is no such line of twelve numbers.
pub fn kitti_projection(text: &str, camera: u8) -> Result<[f64; 12], KittiError> {
    let keys = [format!("P_rect_{camera:02}:"), format!("P{camera}:")];
    let numbers = text.lines().find_map(|line| {
        let rest = keys.iter().find_map(|key| line.trim_start().strip_prefix(key.as_str()))?;
        let numbers: Option<Vec<f64>> = rest.split_whitespace().map(|number| number.parse().ok()).collect();
        <[f64; 12]>::try_from(numbers?).ok()
    });
    numbers.ok_or_else(|| KittiError::NoCalibration { keys: keys.join(" or "), numbers: 12 })
}

/// A line of `oxts/data`.
///
/// # Errors
/// [`KittiError::Oxts`] when it does not have its thirty finite numbers.
pub fn kitti_oxts(text: &str) -> Result<KittiOxts, KittiError> {
    let numbers: Vec<f64> = text
        .split_whitespace()
        .map_while(|number| number.parse().ok())
        .filter(|number: &f64| number.is_finite())
        .collect();
    let wrong = || KittiError::Oxts { found: numbers.len(), wanted: OXTS_NUMBERS };
    let numbers: [f64; OXTS_NUMBERS] = numbers[..].try_into().map_err(|_| wrong())?;
    // lat lon alt roll pitch yaw vn ve vf vl vu ax ay az af al au wx wy wz wf wl wu ...
    let [lat_deg, lon_deg, _, _, _, heading_rad, _, _, speed_mps, ..] = numbers;
    Ok(KittiOxts { lat_deg, lon_deg, heading_rad, speed_mps, yaw_rate_rps: numbers[22] })
}

/// The times of a `timestamps.txt`.
///
/// # Errors
/// [`KittiError::Time`] names the first line that is no time.
pub fn kitti_timestamps(text: &str) -> Result<Vec<KittiTime>, KittiError> {
    text.lines()
        .enumerate()
        .filter(|(_, line)| !line.trim().is_empty())
        .map(|(i, line)| {
            time(line.trim()).ok_or_else(|| KittiError::Time { line: i + 1, text: line.to_owned() })
        })
        .collect()
}

/// A moment of a sequence's clock, nanoseconds since 1970 as if it kept UTC.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct KittiTime(i64);

impl KittiTime {
    /// Seconds since another moment.
    pub fn since_s(self, other: Self) -> f64 {
        self.0.saturating_sub(other.0) as f64 / 1e9
    }
}

fn time(line: &str) -> Option<KittiTime> {
    let (date, clock) = line.split_once(' ')?;
    let mut date = date.splitn(3, '-').map(|part| part.parse::<u32>().ok());
    let (year, month, day) = (date.next()??, date.next()??, date.next()??);
    let mut clock = clock.trim().splitn(3, ':');
    let (hour, minute) = (clock.next()?.parse::<u32>().ok()?, clock.next()?.parse::<u32>().ok()?);
    let second: f64 = clock.next()?.parse().ok()?;
    let is_time = (1970..2200).contains(&year)
        && (1..=12).contains(&month)
        && (1..=31).contains(&day)
        && hour < 24
        && minute < 60
        && (0.0..61.0).contains(&second);
    let days = days_since_1970(i64::from(year), i64::from(month), i64::from(day));
    let minutes = (days * 24 + i64::from(hour)) * 60 + i64::from(minute);
    is_time.then(|| KittiTime(minutes * 60_000_000_000 + (second * 1e9).round() as i64))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_of_a_drive_over_midnight_go_on() {
        let times = kitti_timestamps(
            "2011-09-26 23:59:59.900000000\n2011-09-27 00:00:00.000000000\n\n2011-09-27 00:00:00.103500000\n",
        )
        .expect("times");
        let since: Vec<f64> = times.iter().map(|time| time.since_s(times[0])).collect();
        assert_eq!(since, [0.0, 0.1, 0.2035]);
        let error = kitti_timestamps("2011-09-26 23:59:59.9\nnoon\n").unwrap_err().to_string();
        assert!(error.contains("line 2") && error.contains("noon"), "{error}");
    }

    #[test]
    fn matrices_of_both_kinds_of_sequence_are_found() {
        let raw = "calib_time: 09-Jan-2012\nP_rect_02: 7.2e+02 0 6.0e+02 4.4e+01 0 7.2e+02 1.7e+02 2.1e-01 0 0 1 2.7e-03\n";
        assert_eq!(kitti_projection(raw, 2).map(|p| [p[0], p[2], p[6]]), Ok([720.0, 600.0, 170.0]));
        let odometry = "P0: 1 0 2 0 0 1 3 0 0 0 1 0\nP2: 7 0 8 0 0 7 9 0 0 0 1 0\n";
        assert_eq!(kitti_projection(odometry, 2).map(|p| [p[0], p[2], p[6]]), Ok([7.0, 8.0, 9.0]));
        let error = kitti_projection("P2: 1 2 3\n", 2).unwrap_err().to_string();
        assert!(error.contains("P_rect_02") && error.contains("12 numbers"), "{error}");
    }

    #[test]
    fn a_line_of_oxts_has_thirty_numbers() {
        let numbers: Vec<String> = (0..30).map(|i| format!("{i}.5")).collect();
        let expected =
            KittiOxts { lat_deg: 0.5, lon_deg: 1.5, heading_rad: 5.5, speed_mps: 8.5, yaw_rate_rps: 22.5 };
        assert_eq!(kitti_oxts(&numbers.join(" ")), Ok(expected));
        assert_eq!(kitti_oxts("1 2 NaN"), Err(KittiError::Oxts { found: 2, wanted: 30 }));
    }
}
