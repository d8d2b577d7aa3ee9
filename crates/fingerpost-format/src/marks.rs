//! `marks.json`: lane edges marked by hand in some frames of a drive, from which truth is made.
//!
//! ```json
//! {"version": 1, "input": "drive.mp4", "picture_px": [960, 540], "frames": 221,
//!  "left": [{"frame": 0, "points_px": [[174.2, 539.0], [312.9, 431.0], [461.7, 330.0]]}],
//!  "right": [{"frame": 0, "points_px": []}]}
//! ```
//!
//! A frame that is listed is a key frame of that edge; its points are `[u, v]` pixels from near to far, and none say that
//! the edge is not there. In the frames between two key frames the edge is interpolated.

use serde::{Deserialize, Serialize};
use thiserror::Error;

/// The version that is written and read.
pub const MARKS_VERSION: u32 = 1;

/// How far outside the picture a point may lie, in widths and heights of it: edges leave it at its sides. A point farther off
/// is a slip, and a curve through it would have more rows than memory has room for.
const REACH: f64 = 10.0;

/// Marks of a drive.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct MarksFile {
    /// [`MARKS_VERSION`].
    pub version: u32,
    /// Name of the input that was marked, for people.
    #[serde(default)]
    pub input: String,
    /// Width and height of its pictures.
    pub picture_px: [u32; 2],
    /// Number of its frames.
    pub frames: u64,
    /// Key frames of the left edge of the vehicle's lane, the inner edge of its marking; frames ascend.
    pub left: Vec<EdgeMark>,
    /// Key frames of the right edge, likewise.
    pub right: Vec<EdgeMark>,
}

/// An edge in a key frame.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct EdgeMark {
    /// Index of the frame, from zero.
    pub frame: u64,
    /// Points on the edge, `[u, v]` pixels near to far, so that rows descend; none where there is no edge.
    pub points_px: Vec<[f64; 2]>,
}

/// Marks that cannot be used.
#[derive(Debug, Error)]
pub enum MarksError {
    /// The text is no marks file.
    #[error("it holds no lane marks ({cause}); give a marks.json, as `fingerpost mark` writes it")]
    Parse {
        /// What the parser says.
        cause: serde_json::Error,
    },
    /// A version that this program does not know.
    #[error(
        "its marks have version {found} and this program knows {MARKS_VERSION}; use the program that wrote them"
    )]
    Version {
        /// Version of the file.
        found: u32,
    },
    /// Key frames out of order, or beyond the drive's end.
    #[error(
        "frame {frame} of its {side} edge comes out of order or behind the last of {frames} frames; mend or remove it"
    )]
    Frame {
        /// `left` or `right`.
        side: &'static str,
        /// The frame.
        frame: u64,
        /// Number of frames.
        frames: u64,
    },
    /// Points that make no edge.
    #[error(
        "the points of frame {frame} of its {side} edge do not lead from near to far, each in a row above the one before; \
         mend or remove them"
    )]
    Points {
        /// `left` or `right`.
        side: &'static str,
        /// The frame.
        frame: u64,
    },
    /// A point that no edge of these pictures has.
    #[error("a point of frame {frame} of its {side} edge lies far outside the pictures; mend or remove it")]
    Outside {
        /// `left` or `right`.
        side: &'static str,
        /// The frame.
        frame: u64,
    },
    /// Marks that cannot be written.
    #[error("the marks cannot be written as JSON ({cause})")]
    Write {
        /// What the writer says.
        cause: serde_json::Error,
    },
}

/// Marks from the text of a file, checked.
///
/// # Errors
/// [`MarksError`] when it holds no marks, or such as cannot be.
pub fn marks_from_json(text: &str) -> Result<MarksFile, MarksError> {
    let marks: MarksFile = serde_json::from_str(text).map_err(|cause| MarksError::Parse { cause })?;
    if marks.version != MARKS_VERSION {
        return Err(MarksError::Version { found: marks.version });
    }
    check("left", &marks.left, &marks)?;
    check("right", &marks.right, &marks)?;
    Ok(marks)
}

/// Whether a point `[u, v]` can be one of an edge in pictures of that size: on them, or not far outside.
pub fn is_near_picture(point: [f64; 2], picture_px: [u32; 2]) -> bool {
    let near = |at: f64, size: u32| (-REACH..=1.0 + REACH).contains(&(at / f64::from(size.max(1))));
    near(point[0], picture_px[0]) && near(point[1], picture_px[1])
}

/// The text of a file, a key frame a line.
///
/// # Errors
/// [`MarksError::Write`] when a number has no JSON form.
pub fn marks_to_json(marks: &MarksFile) -> Result<String, MarksError> {
    let write = |cause| MarksError::Write { cause };
    let lines = |edge: &[EdgeMark]| -> Result<String, MarksError> {
        let lines = edge.iter().map(|mark| serde_json::to_string(mark).map_err(write));
        let lines: Vec<String> = lines.collect::<Result<_, _>>()?;
        Ok(if lines.is_empty() { "[]".to_owned() } else { format!("[\n  {}\n ]", lines.join(",\n  ")) })
    };
    let MarksFile { version, input, picture_px: [width, height], frames, left, right } = marks;
    Ok(format!(
        "{{\"version\": {version}, \"input\": {}, \"picture_px\": [{width}, {height}], \"frames\": {frames},\n \"left\": \
         {},\n \"right\": {}}}\n",
        serde_json::to_string(input).map_err(write)?,
        lines(left)?,
        lines(right)?
    ))
}

fn check(side: &'static str, edge: &[EdgeMark], marks: &MarksFile) -> Result<(), MarksError> {
    let MarksFile { frames, picture_px, .. } = *marks;
    let mut next = 0;
    for EdgeMark { frame, points_px } in edge {
        if *frame < next || *frame >= frames {
            return Err(MarksError::Frame { side, frame: *frame, frames });
        }
        next = frame + 1;
        let finite = points_px.iter().flatten().all(|coordinate| coordinate.is_finite());
        if !finite || points_px.windows(2).any(|pair| pair[1][1] >= pair[0][1]) {
            return Err(MarksError::Points { side, frame: *frame });
        }
        if !points_px.iter().all(|point| is_near_picture(*point, picture_px)) {
            return Err(MarksError::Outside { side, frame: *frame });
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn marks() -> MarksFile {
        MarksFile {
            version: MARKS_VERSION,
            input: "a \"drive\".mp4".to_owned(),
            picture_px: [960, 540],
            frames: 21,
            left: vec![
                EdgeMark { frame: 0, points_px: vec![[100.5, 539.0], [200.0, 400.25]] },
                EdgeMark { frame: 20, points_px: Vec::new() },
            ],
            right: Vec::new(),
        }
    }

    #[test]
    fn marks_come_back_as_they_were() {
        let text = marks_to_json(&marks()).unwrap();
        assert_eq!(marks_from_json(&text).unwrap(), marks());
        assert_eq!(text.lines().count(), 6);
    }

    #[test]
    fn marks_that_cannot_be_are_refused() {
        let refused = |change: fn(&mut MarksFile)| {
            let mut changed = marks();
            change(&mut changed);
            marks_from_json(&marks_to_json(&changed).unwrap()).unwrap_err().to_string()
        };
        assert!(refused(|marks| marks.version = 2).contains("version 2"));
        assert!(refused(|marks| marks.left[1].frame = 21).contains("frame 21 of its left edge"));
        assert!(refused(|marks| marks.left[1].frame = 0).contains("frame 0 of its left edge"));
        assert!(refused(|marks| marks.left[0].points_px[1][1] = 539.0).contains("from near to far"));
        assert!(refused(|marks| marks.left[0].points_px[1][1] = -1e9).contains("far outside the pictures"));
        assert!(refused(|marks| marks.left[0].points_px[0][0] = 1e300).contains("frame 0 of its left edge"));
        assert!(marks_from_json("[]").unwrap_err().to_string().contains("no lane marks"));
    }
}
