//! The line before each frame that is given to `fingerpost advise`.

use serde_json::{Map, Value};
use thiserror::Error;

/// What is said of a frame before its pixels.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct FrameHeader {
    /// Seconds since any moment.
    pub t_s: f64,
    /// Width and height, pixels; the pixels' red, green and blue bytes follow, row by row.
    pub size_px: [usize; 2],
    /// Speed, m/s, positive forward.
    pub speed_mps: Option<f64>,
    /// Yaw rate, rad/s, positive to the left.
    pub yaw_rate_rps: Option<f64>,
    /// Latitude and longitude, degrees.
    pub lat_lon_deg: Option<[f64; 2]>,
}

/// A line that says nothing sound of a frame.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum FrameHeaderError {
    /// It is no JSON object.
    #[error(
        "the line before a frame is no JSON object ({cause}); write {{\"t_s\": 0.1, \"width\": 640, \"height\": 480}}"
    )]
    Syntax {
        /// What the reader says.
        cause: String,
    },
    /// It does not say how large the frame is.
    #[error(
        "the line before a frame does not say its width and height; give both as whole numbers of pixels"
    )]
    NoSize,
    /// A number is missing or none.
    #[error("{key:?} of the line before a frame is no finite number in range; give {expected}")]
    Number {
        /// Its key.
        key: &'static str,
        /// What would be one.
        expected: &'static str,
        /// Width and height of the frame that follows, pixels.
        size_px: [usize; 2],
    },
}

/// Largest speed, m/s: nothing on roads is faster.
const MOST_MPS: f64 = 200.0;
/// Largest yaw rate, rad/s: a turn a second.
const MOST_RPS: f64 = std::f64::consts::TAU;

impl FrameHeader {
    /// Reads the line.
    ///
    /// # Errors
    /// [`FrameHeaderError`] says what is wrong.
    pub fn parse(line: &str) -> Result<Self, FrameHeaderError> {
        let read = |line: &str| serde_json::from_str::<Map<String, Value>>(line);
        let fields = read(line).or_else(|cause| {
            // Python writes numbers that are none like this, and the frame's size is known all the same.
            let without =
                line.replace("-Infinity", "\"\"").replace("Infinity", "\"\"").replace("NaN", "\"\"");
            read(&without).map_err(|_| FrameHeaderError::Syntax { cause: cause.to_string() })
        })?;
        let side = |key: &str| fields.get(key).and_then(Value::as_u64).filter(|side| *side > 0);
        let (Some(width), Some(height)) = (side("width"), side("height")) else {
            return Err(FrameHeaderError::NoSize);
        };
        let size_px = [width as usize, height as usize];
        let number = |key: &'static str, most: f64, expected: &'static str| {
            let wrong = FrameHeaderError::Number { key, expected, size_px };
            match fields.get(key) {
                None | Some(Value::Null) => Ok(None),
                Some(value) => match value.as_f64().filter(|number| number.abs() <= most) {
                    Some(number) => Ok(Some(number)),
                    None => Err(wrong),
                },
            }
        };
        let (t_s, latitude) =
            (number("t_s", f64::MAX, "seconds")?, number("lat", 90.0, "degrees, -90 to 90")?);
        let longitude = number("lon", 180.0, "degrees, -180 to 180")?;
        let missing = |key, expected| FrameHeaderError::Number { key, expected, size_px };
        let lat_lon_deg = match (latitude, longitude) {
            (Some(latitude), Some(longitude)) => Some([latitude, longitude]),
            (None, None) => None,
            (None, Some(_)) => return Err(missing("lat", "both \"lat\" and \"lon\", or neither")),
            (Some(_), None) => return Err(missing("lon", "both \"lat\" and \"lon\", or neither")),
        };
        Ok(Self {
            t_s: t_s.ok_or_else(|| missing("t_s", "seconds"))?,
            size_px,
            speed_mps: number("speed_mps", MOST_MPS, "metres a second, -200 to 200")?,
            yaw_rate_rps: number("yaw_rate_rps", MOST_RPS, "radians a second, -6.28 to 6.28")?,
            lat_lon_deg,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_said_is_read() {
        let line = r#"{"t_s": 1.5, "width": 4, "height": 3, "speed_mps": 6, "yaw_rate_rps": -0.1, "lat": 47.5, "lon": 9, "other": []}"#;
        let expected = FrameHeader {
            t_s: 1.5,
            size_px: [4, 3],
            speed_mps: Some(6.0),
            yaw_rate_rps: Some(-0.1),
            lat_lon_deg: Some([47.5, 9.0]),
        };
        assert_eq!(FrameHeader::parse(line), Ok(expected));
        let bare = FrameHeader::parse(r#"{"t_s": 0, "width": 4, "height": 3, "speed_mps": null}"#).unwrap();
        assert_eq!(bare, FrameHeader { size_px: [4, 3], ..FrameHeader::default() });
    }

    #[test]
    fn numbers_that_are_none_leave_the_size_known() {
        for (line, key) in [
            (r#"{"t_s": NaN, "width": 4, "height": 3}"#, "t_s"),
            (r#"{"width": 4, "height": 3}"#, "t_s"),
            (r#"{"t_s": 1, "width": 4, "height": 3, "speed_mps": -Infinity}"#, "speed_mps"),
            (r#"{"t_s": 1, "width": 4, "height": 3, "yaw_rate_rps": "fast"}"#, "yaw_rate_rps"),
            (r#"{"t_s": 1, "width": 4, "height": 3, "lat": 91, "lon": 0}"#, "lat"),
            (r#"{"t_s": 1, "width": 4, "height": 3, "lat": 47}"#, "lon"),
        ] {
            let error = FrameHeader::parse(line).unwrap_err();
            assert!(
                matches!(error, FrameHeaderError::Number { key: found, size_px: [4, 3], .. } if found == key),
                "{error}"
            );
        }
    }

    #[test]
    fn what_is_no_header_is_refused() {
        for line in ["", "hello", "[]", r#"{"t_s": 1"#] {
            assert!(matches!(FrameHeader::parse(line), Err(FrameHeaderError::Syntax { .. })), "{line}");
        }
        for line in [
            r#"{"t_s": 1}"#,
            r#"{"t_s": 1, "width": 0, "height": 3}"#,
            r#"{"t_s": 1, "width": 1.5, "height": 3}"#,
        ] {
            assert_eq!(FrameHeader::parse(line), Err(FrameHeaderError::NoSize), "{line}");
        }
    }
}
