//! Edits that can be undone.

use fingerpost_format::Side;

use crate::lane_marks::LaneMarks;

/// What an edge becomes in a frame.
#[derive(Debug, Clone, PartialEq)]
pub struct Edit {
    /// Which edge.
    pub side: Side,
    /// In which frame.
    pub frame: u64,
    /// Its points; an empty list where there is no edge, none where the frame is to be no key frame.
    pub points: Option<Vec<[f64; 2]>>,
}

/// Marks being made.
#[derive(Debug, Clone)]
pub struct Session {
    marks: LaneMarks,
    /// What takes back each edit that was made, the last one at the end.
    back: Vec<Edit>,
    /// What makes each edit again that was taken back.
    forth: Vec<Edit>,
}

impl Session {
    /// Goes on with marks.
    pub fn new(marks: LaneMarks) -> Self {
        Self { marks, back: Vec::new(), forth: Vec::new() }
    }

    /// The marks as they are.
    pub const fn marks(&self) -> &LaneMarks {
        &self.marks
    }

    /// Whether there is an edit to take back.
    pub fn can_undo(&self) -> bool {
        !self.back.is_empty()
    }

    /// Whether there is an edit that was taken back.
    pub fn can_redo(&self) -> bool {
        !self.forth.is_empty()
    }

    /// Makes an edit; edits that were taken back are gone. One that changes nothing is none.
    pub fn edit(&mut self, edit: &Edit) {
        let opposite = self.make(edit);
        if self.marks.points(edit.side, edit.frame) != opposite.points.as_deref() {
            self.back.push(opposite);
            self.forth.clear();
        }
    }

    /// Takes the last edit back and says in which frame it was; none where there is none.
    pub fn undo(&mut self) -> Option<u64> {
        let edit = self.back.pop()?;
        let opposite = self.make(&edit);
        self.forth.push(opposite);
        Some(edit.frame)
    }

    /// Makes the edit again that was last taken back, and says in which frame.
    pub fn redo(&mut self) -> Option<u64> {
        let edit = self.forth.pop()?;
        let opposite = self.make(&edit);
        self.back.push(opposite);
        Some(edit.frame)
    }

    /// Makes an edit and gives the one that takes it back.
    fn make(&mut self, edit: &Edit) -> Edit {
        let Edit { side, frame, points } = edit;
        let before = self.marks.points(*side, *frame).map(<[_]>::to_vec);
        self.marks.set(*side, *frame, points.as_deref());
        Edit { side: *side, frame: *frame, points: before }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn edit(frame: u64, points: Option<&[[f64; 2]]>) -> Edit {
        Edit { side: Side::Left, frame, points: points.map(<[_]>::to_vec) }
    }

    #[test]
    fn edits_are_taken_back_in_their_order_and_made_again() {
        let empty = LaneMarks::new("drive", [960, 540], 9);
        let mut session = Session::new(empty.clone());
        session.edit(&edit(3, Some(&[[1.0, 2.0]])));
        session.edit(&edit(3, Some(&[[5.0, 2.0]])));
        session.edit(&edit(7, Some(&[])));
        let all = session.marks().clone();
        assert_eq!([session.undo(), session.undo()], [Some(7), Some(3)]);
        assert_eq!(session.marks().points(Side::Left, 3), Some(&[[1.0, 2.0]][..]));
        assert_eq!([session.redo(), session.redo(), session.redo()], [Some(3), Some(7), None]);
        assert_eq!(*session.marks(), all);
        while session.undo().is_some() {}
        assert_eq!(*session.marks(), empty);
        assert!(session.can_redo() && !session.can_undo());
        session.edit(&edit(0, Some(&[[1.0, 1.0]])));
        assert!(!session.can_redo());
    }

    #[test]
    fn an_edit_that_changes_nothing_is_none() {
        let mut session = Session::new(LaneMarks::new("drive", [960, 540], 9));
        session.edit(&edit(3, None));
        session.edit(&edit(9, Some(&[[1.0, 1.0]])));
        assert!(!session.can_undo());
        session.edit(&edit(3, Some(&[[1.0, 1.0]])));
        session.edit(&edit(3, Some(&[[1.0, 1.0]])));
        assert_eq!([session.undo(), session.undo()], [Some(3), None]);
    }
}
