//! The marks of a drive, and what an edge is in any of its frames.

use std::collections::BTreeMap;

use fingerpost_format::{EdgeMark, MARKS_VERSION, MarksFile, Side, is_near_picture};
use serde::Serialize;

use crate::edge_curve::{EdgeCurve, tidy, traced};

/// Lane edges in key frames.
///
/// Between two key frames an edge is interpolated: at each row linearly in time between the columns of the two curves,
/// from a nearest to a farthest row that move linearly as well; a curve goes straight on for the rows that it lacks. Where
/// one of the two key frames says that there is no edge, there is none between them. Before the first key frame and behind
/// the last an edge is not known.
#[derive(Debug, Clone, PartialEq)]
pub struct LaneMarks {
    input: String,
    picture_px: [u32; 2],
    frames: u64,
    /// Points of the left edge from near to far, by key frame; none where there is no edge.
    left: BTreeMap<u64, Vec<[f64; 2]>>,
    right: BTreeMap<u64, Vec<[f64; 2]>>,
}

/// What is known of an edge in a frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Marked {
    /// Nothing: the frame does not lie between key frames.
    Unmarked,
    /// There is none.
    Absent,
    /// Where it is.
    Present,
}

/// An edge in a frame.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct EdgeInFrame {
    /// What is known of it.
    pub marked: Marked,
    /// Whether the frame is one of its key frames.
    pub key: bool,
    /// The points to be dragged, `[u, v]` pixels near to far; of an interpolated edge those of the key frame before, moved.
    pub points_px: Vec<[f64; 2]>,
    /// The curve, likewise.
    pub curve_px: Vec<[f64; 2]>,
}

impl EdgeInFrame {
    fn without_points(marked: Marked, key: bool) -> Self {
        Self { marked, key, points_px: Vec::new(), curve_px: Vec::new() }
    }
}

impl LaneMarks {
    /// No marks of a drive of so many frames.
    pub fn new(input: &str, picture_px: [u32; 2], frames: u64) -> Self {
        Self { input: input.to_owned(), picture_px, frames, left: BTreeMap::new(), right: BTreeMap::new() }
    }

    /// The marks of a file.
    pub fn from_file(file: &MarksFile) -> Self {
        let edge =
            |marks: &[EdgeMark]| marks.iter().map(|mark| (mark.frame, tidy(&mark.points_px))).collect();
        Self {
            left: edge(&file.left),
            right: edge(&file.right),
            ..Self::new(&file.input, file.picture_px, file.frames)
        }
    }

    /// What a file of these marks holds.
    pub fn to_file(&self) -> MarksFile {
        let edge = |side| {
            let marks = self.edge(side).iter();
            marks.map(|(frame, points)| EdgeMark { frame: *frame, points_px: points.clone() }).collect()
        };
        MarksFile {
            version: MARKS_VERSION,
            input: self.input.clone(),
            picture_px: self.picture_px,
            frames: self.frames,
            left: edge(Side::Left),
            right: edge(Side::Right),
        }
    }

    /// Name of the input.
    pub fn input(&self) -> &str {
        &self.input
    }

    /// Width and height of the pictures.
    pub const fn picture_px(&self) -> [u32; 2] {
        self.picture_px
    }

    /// Number of frames.
    pub const fn frames(&self) -> u64 {
        self.frames
    }

    /// Key frames of an edge and whether it is there, in their order.
    pub fn key_frames(&self, side: Side) -> impl Iterator<Item = (u64, bool)> {
        self.edge(side).iter().map(|(frame, points)| (*frame, !points.is_empty()))
    }

    /// The points of an edge in a key frame; an empty list where the edge is not there, none where it is no key frame.
    pub fn points(&self, side: Side, frame: u64) -> Option<&[[f64; 2]]> {
        self.edge(side).get(&frame).map(Vec::as_slice)
    }

    /// Whether points can be those of an edge: all are numbers and lie in the picture or not far outside.
    pub fn can_hold(&self, points: &[[f64; 2]]) -> bool {
        points.iter().all(|point| is_near_picture(*point, self.picture_px))
    }

    /// Makes a frame a key frame with these points (an empty list: no edge), or no key frame any more.
    ///
    /// Points are put in order, and to a hundredth of a pixel. A frame behind the last, and points of which one
    /// [cannot be one](Self::can_hold), change nothing.
    pub fn set(&mut self, side: Side, frame: u64, points: Option<&[[f64; 2]]>) {
        if frame >= self.frames || !self.can_hold(points.unwrap_or_default()) {
            return;
        }
        let edge = match side {
            Side::Left => &mut self.left,
            Side::Right => &mut self.right,
        };
        match points {
            Some(points) => {
                let rounded: Vec<[f64; 2]> = points.iter().map(|point| point.map(hundredth)).collect();
                edge.insert(frame, tidy(&rounded));
            }
            None => {
                edge.remove(&frame);
            }
        }
    }

    /// An edge in any frame.
    pub fn at(&self, side: Side, frame: u64) -> EdgeInFrame {
        let edge = self.edge(side);
        let before = edge.range(..=frame).next_back();
        let after = edge.range(frame..).next();
        let (Some((&from, near_points)), Some((&to, far_points))) = (before, after) else {
            return EdgeInFrame::without_points(Marked::Unmarked, false);
        };
        let key = from == to;
        let (Some(old), Some(new)) = (EdgeCurve::new(near_points), EdgeCurve::new(far_points)) else {
            return EdgeInFrame::without_points(Marked::Absent, key);
        };
        let share = if key { 0.0 } else { (frame - from) as f64 / (to - from) as f64 };
        let mixed = |a: f64, b: f64| a + (b - a) * share;
        let (far_row, near_row) = (mixed(old.rows().0, new.rows().0), mixed(old.rows().1, new.rows().1));
        let column = |row: f64| mixed(old.column(row), new.column(row));
        let points_px = if key {
            near_points.clone()
        } else {
            let (old_far, old_near) = old.rows();
            let length = (old_near - old_far).max(f64::MIN_POSITIVE);
            let moved = |row: f64| far_row + (row - old_far) / length * (near_row - far_row);
            near_points
                .iter()
                .map(|point| [column(moved(point[1])), moved(point[1])].map(hundredth))
                .collect()
        };
        let curve_px = traced(far_row, near_row, column);
        EdgeInFrame { marked: Marked::Present, key, points_px, curve_px }
    }

    fn edge(&self, side: Side) -> &BTreeMap<u64, Vec<[f64; 2]>> {
        match side {
            Side::Left => &self.left,
            Side::Right => &self.right,
        }
    }
}

/// Finer than any hand, and short in a file.
pub(crate) fn hundredth(px: f64) -> f64 {
    (100.0 * px).round() / 100.0
}

#[cfg(test)]
mod tests {
    use super::*;

    fn marks() -> LaneMarks {
        let mut marks = LaneMarks::new("drive", [960, 540], 41);
        marks.set(Side::Left, 10, Some(&[[100.0, 500.0], [200.0, 400.0]]));
        marks.set(Side::Left, 20, Some(&[[110.0, 520.0], [230.0, 400.0]]));
        marks.set(Side::Left, 30, Some(&[]));
        marks
    }

    fn column(edge: &EdgeInFrame, row: f64) -> f64 {
        EdgeCurve::new(&edge.curve_px).unwrap().column(row)
    }

    #[test]
    fn between_key_frames_an_edge_moves_row_by_row() {
        let marks = marks();
        let found = marks.at(Side::Left, 15);
        assert_eq!((found.marked, found.key), (Marked::Present, false));
        // Columns 200 and 230 at row 400, 150 and 180 at 450: half way.
        assert!((column(&found, 400.0) - 215.0).abs() < 1e-9);
        assert!((column(&found, 450.0) - 165.0).abs() < 1e-9);
        // The nearest row is half way too, and there the first curve goes straight on: 90 and 120.
        assert_eq!(found.curve_px.first().map(|point| point.map(hundredth)), Some([105.0, 510.0]));
        assert_eq!(found.points_px, [[105.0, 510.0], [215.0, 400.0]]);
        let found = marks.at(Side::Left, 11);
        assert!((column(&found, 450.0) - 153.0).abs() < 1e-9);
    }

    #[test]
    fn what_is_not_marked_is_not_known_and_absence_is_not_interpolated() {
        let marks = marks();
        let state = |frame| (marks.at(Side::Left, frame).marked, marks.at(Side::Left, frame).key);
        assert_eq!(state(9), (Marked::Unmarked, false));
        assert_eq!(state(10), (Marked::Present, true));
        assert_eq!(state(21), (Marked::Absent, false));
        assert_eq!(state(30), (Marked::Absent, true));
        assert_eq!(state(31), (Marked::Unmarked, false));
        assert_eq!(marks.at(Side::Right, 10).marked, Marked::Unmarked);
    }

    #[test]
    fn marks_become_a_file_and_come_back() {
        let mut marks = marks();
        assert_eq!(LaneMarks::from_file(&marks.to_file()), marks);
        marks.set(Side::Left, 41, Some(&[[1.0, 1.0]]));
        marks.set(Side::Left, 12, Some(&[[1.0, 1.0], [1.0, f64::NAN]]));
        marks.set(Side::Left, 13, Some(&[[1.0, 1.0], [1.0, -1e300]]));
        marks.set(Side::Left, 20, None);
        assert_eq!(marks.key_frames(Side::Left).collect::<Vec<_>>(), [(10, true), (30, false)]);
        assert_eq!(marks.points(Side::Left, 20), None);
    }
}
