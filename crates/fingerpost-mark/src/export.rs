//! Truth from marks.

use fingerpost_format::{Side, TUSIMPLE_NO_POINT, TruthRecord, TuSimpleRecord};
use thiserror::Error;

use crate::edge_curve::EdgeCurve;
use crate::lane_marks::{LaneMarks, Marked, hundredth};

/// Rows between the samples of the TuSimple benchmark.
const SAMPLE_ROWS: u32 = 10;

/// Marks from which no truth can be made.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
pub enum ExportError {
    /// Frames in which an edge is not marked.
    #[error(
        "the {side} edge is not marked in frames {first} to {last}; mark it in frame {first} and in frame {last}, or say \
         there that it has no edge"
    )]
    Unmarked {
        /// `left` or `right`.
        side: &'static str,
        /// First of the frames.
        first: u64,
        /// Last of them.
        last: u64,
    },
    /// An input without frames.
    #[error("the input has no frames; there is nothing to export")]
    NoFrames,
}

/// Truth of every frame: the edges' points in the picture, and the time that `t_s` gives for each frame. What marks do not
/// tell of a vehicle is zero.
///
/// # Errors
/// [`ExportError`] when an edge is not known in every frame.
pub fn truth_of_marks(marks: &LaneMarks, t_s: impl Fn(u64) -> f64) -> Result<Vec<TruthRecord>, ExportError> {
    if marks.frames() == 0 {
        return Err(ExportError::NoFrames);
    }
    check_known(marks, Side::Left, "left")?;
    check_known(marks, Side::Right, "right")?;
    let edge = |side, frame| {
        marks.at(side, frame).curve_px.iter().map(|point| point.map(hundredth)).collect::<Vec<_>>()
    };
    let record = |frame| TruthRecord {
        frame,
        t_s: t_s(frame),
        picture_px: Some(marks.picture_px()),
        lane_left_px: edge(Side::Left, frame),
        lane_right_px: edge(Side::Right, frame),
        ..TruthRecord::default()
    };
    Ok((0..marks.frames()).map(record).collect())
}

/// The same as labels of the TuSimple benchmark, at every tenth row that an edge reaches in any frame; `raw_file` names the
/// pictures. Points outside the picture are none.
///
/// # Errors
/// [`ExportError`] as for [`truth_of_marks`].
pub fn tusimple_of_marks(
    marks: &LaneMarks,
    raw_file: impl Fn(u64) -> String,
) -> Result<Vec<TuSimpleRecord>, ExportError> {
    let truth = truth_of_marks(marks, |_| 0.0)?;
    let curves: Vec<[Option<EdgeCurve>; 2]> = truth
        .iter()
        .map(|truth| [EdgeCurve::new(&truth.lane_left_px), EdgeCurve::new(&truth.lane_right_px)])
        .collect();
    let reached = |row: f64| {
        curves.iter().flatten().flatten().any(|curve| {
            let (far_row, near_row) = curve.rows();
            (far_row..=near_row).contains(&row)
        })
    };
    let [width, height] = marks.picture_px();
    let h_samples: Vec<f64> =
        (0..height).step_by(SAMPLE_ROWS as usize).map(f64::from).filter(|row| reached(*row)).collect();
    let lane = |curve: &EdgeCurve| -> Vec<f64> {
        let (far_row, near_row) = curve.rows();
        let column = |row: &f64| {
            let u = hundredth(curve.column(*row));
            let inside = (far_row..=near_row).contains(row) && (0.0..f64::from(width)).contains(&u);
            if inside { u } else { TUSIMPLE_NO_POINT }
        };
        h_samples.iter().map(column).collect()
    };
    Ok(truth
        .iter()
        .zip(&curves)
        .map(|(truth, curves)| TuSimpleRecord {
            lanes: curves.iter().flatten().map(lane).collect(),
            h_samples: h_samples.clone(),
            raw_file: raw_file(truth.frame),
        })
        .collect())
}

fn check_known(marks: &LaneMarks, side: Side, name: &'static str) -> Result<(), ExportError> {
    let unmarked = |frame: &u64| marks.at(side, *frame).marked == Marked::Unmarked;
    let Some(first) = (0..marks.frames()).find(unmarked) else { return Ok(()) };
    let last = (first..marks.frames()).take_while(unmarked).last().unwrap_or(first);
    Err(ExportError::Unmarked { side: name, first, last })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn marks() -> LaneMarks {
        let mut marks = LaneMarks::new("drive", [640, 480], 3);
        marks.set(Side::Left, 0, Some(&[[100.0, 479.0], [200.0, 379.0]]));
        marks.set(Side::Left, 2, Some(&[[-20.0, 479.0], [80.0, 379.0]]));
        marks.set(Side::Right, 0, Some(&[]));
        marks.set(Side::Right, 2, Some(&[[500.0, 470.0], [420.0, 400.0]]));
        marks
    }

    #[test]
    fn every_frame_has_its_edges() {
        let truth = truth_of_marks(&marks(), |frame| frame as f64 / 25.0).unwrap();
        assert_eq!(truth.len(), 3);
        assert_eq!((truth[1].frame, truth[1].picture_px), (1, Some([640, 480])));
        assert!((truth[2].t_s - 0.08).abs() < 1e-12);
        assert_eq!(truth[1].lane_left_px.first(), Some(&[40.0, 479.0]));
        assert_eq!(truth[1].lane_left_px.last(), Some(&[140.0, 379.0]));
        assert!(truth[0].lane_right_px.is_empty() && truth[1].lane_right_px.is_empty());
        assert_eq!(truth[2].lane_right_px.first(), Some(&[500.0, 470.0]));
    }

    #[test]
    fn labels_have_a_column_at_every_tenth_row() {
        let labels = tusimple_of_marks(&marks(), |frame| format!("{frame:06}.jpg")).unwrap();
        assert_eq!(labels[2].raw_file, "000002.jpg");
        assert_eq!(labels[2].h_samples, (38..48).map(|ten| 10.0 * f64::from(ten)).collect::<Vec<_>>());
        assert_eq!(labels[0].lanes.len(), 1);
        assert_eq!((labels[0].lanes[0][0], labels[0].lanes[0][9]), (199.0, 109.0));
        // Left of the picture, and above the edge's far end.
        assert_eq!((labels[2].lanes[0][8], labels[2].lanes[0][9]), (TUSIMPLE_NO_POINT, TUSIMPLE_NO_POINT));
        assert_eq!((labels[2].lanes[1][0], labels[2].lanes[1][2]), (TUSIMPLE_NO_POINT, 420.0));
    }

    #[test]
    fn edges_that_are_not_known_are_named() {
        let mut marks = marks();
        marks.set(Side::Right, 2, None);
        let refused = truth_of_marks(&marks, |_| 0.0).unwrap_err();
        assert_eq!(refused, ExportError::Unmarked { side: "right", first: 1, last: 2 });
        let nothing = LaneMarks::new("drive", [640, 480], 0);
        assert_eq!(tusimple_of_marks(&nothing, |_| String::new()), Err(ExportError::NoFrames));
    }
}
