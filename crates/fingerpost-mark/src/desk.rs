//! What the page asks and does, answered: no network here, so that any server can take it in.

use std::fmt;
use std::sync::{Mutex, MutexGuard, PoisonError};

use fingerpost_format::{MarksFile, Side};
use fingerpost_server::{Answer, Cause, Handler, Picture, Pictures, Request};
use serde::{Deserialize, Serialize};
use serde_json::json;

use crate::edge_curve::{EdgeCurve, traced};
use crate::lane_marks::{EdgeInFrame, LaneMarks};
use crate::session::{Edit, Session};

/// What is said of points that no edge of the pictures has.
const FAR_OUTSIDE: &str = "a point lies far outside the picture";

/// Where marks and truth go.
pub trait Keeper: Send {
    /// Keeps the marks; called after every edit. A program that ends in the middle must leave these marks or those before.
    ///
    /// # Errors
    /// Why they could not be kept.
    fn keep(&mut self, marks: &MarksFile) -> Result<(), Cause>;

    /// Writes truth made of the marks and gives the files' names.
    ///
    /// # Errors
    /// Why it could not be written.
    fn export(&mut self, marks: &LaneMarks) -> Result<Vec<String>, Cause>;
}

/// An edit as the page sends it.
#[derive(Debug, Deserialize)]
struct PageEdit {
    side: Side,
    frame: u64,
    /// An empty list: no edge there; null: no key frame.
    points_px: Option<Vec<[f64; 2]>>,
}

/// Points as the page sends them.
#[derive(Debug, Deserialize)]
struct PagePoints {
    points_px: Vec<[f64; 2]>,
}

/// Marks being made, their pictures, and where they are kept.
pub struct Desk {
    work: Mutex<Work>,
    pictures: Box<dyn Pictures>,
}

struct Work {
    session: Session,
    keeper: Box<dyn Keeper>,
}

impl fmt::Debug for Desk {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Desk").field("marks", self.work().session.marks()).finish_non_exhaustive()
    }
}

impl Desk {
    /// Goes on with marks.
    pub fn new(marks: LaneMarks, pictures: Box<dyn Pictures>, keeper: Box<dyn Keeper>) -> Self {
        Self { work: Mutex::new(Work { session: Session::new(marks), keeper }), pictures }
    }
}

impl Handler for Desk {
    fn answer(&self, request: Request<'_>) -> Answer {
        let path: Vec<&str> = request.path.trim_start_matches('/').split('/').collect();
        match (request.method, &path[..]) {
            ("GET", [""]) => Answer::text("text/html; charset=utf-8", include_str!("page/mark.html")),
            ("GET", ["mark.css"]) => Answer::text("text/css; charset=utf-8", include_str!("page/mark.css")),
            ("GET", [script @ ("mark.js" | "view.js")]) => Answer::text(
                "text/javascript; charset=utf-8",
                if *script == "mark.js" {
                    include_str!("page/mark.js")
                } else {
                    include_str!("page/view.js")
                },
            ),
            ("GET", ["api", "state"]) => Answer::json(200, &state(&self.work().session)),
            ("GET", ["api", "frames", frame, "picture"]) => {
                self.with_frame(frame, |frame| self.picture(frame))
            }
            ("GET", ["api", "frames", frame, "edges"]) => {
                self.with_frame(frame, |frame| Answer::json(200, &edges(self.work().session.marks(), frame)))
            }
            ("POST", ["api", "edit"]) => self.edit(request.body),
            ("POST", ["api", "undo"]) => self.step(Session::undo),
            ("POST", ["api", "redo"]) => self.step(Session::redo),
            ("POST", ["api", "curve"]) => self.curve(request.body),
            ("POST", ["api", "export"]) => self.export(),
            _ => Answer::refused(404, "there is no such page; open / instead"),
        }
    }
}

impl Desk {
    /// A thread that broke off in the middle leaves whole marks: an edit is one step.
    fn work(&self) -> MutexGuard<'_, Work> {
        self.work.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn with_frame(&self, frame: &str, answer: impl Fn(u64) -> Answer) -> Answer {
        let frames = self.work().session.marks().frames();
        match frame.parse().ok().filter(|frame| *frame < frames) {
            Some(frame) => answer(frame),
            None => Answer::refused(404, &format!("there is no frame {frame}; there are {frames}, from 0")),
        }
    }

    fn picture(&self, frame: u64) -> Answer {
        match self.pictures.picture(frame) {
            Ok(Picture { content_type, bytes }) => Answer { status: 200, content_type, body: bytes },
            Err(cause) => Answer::refused(500, &cause.to_string()),
        }
    }

    fn edit(&self, body: &[u8]) -> Answer {
        let edit: PageEdit = match serde_json::from_slice(body) {
            Ok(edit) => edit,
            Err(cause) => return Answer::refused(400, &format!("this is no edit ({cause})")),
        };
        let PageEdit { side, frame, points_px } = edit;
        let mut work = self.work();
        let frames = work.session.marks().frames();
        if frame >= frames {
            return Answer::refused(404, &format!("there is no frame {frame}; there are {frames}, from 0"));
        }
        if !work.session.marks().can_hold(points_px.as_deref().unwrap_or_default()) {
            return Answer::refused(400, FAR_OUTSIDE);
        }
        work.session.edit(&Edit { side, frame, points: points_px });
        work.kept(frame)
    }

    /// The curve through points that are being dragged.
    fn curve(&self, body: &[u8]) -> Answer {
        let points_px = match serde_json::from_slice(body) {
            Ok(PagePoints { points_px }) => points_px,
            Err(cause) => return Answer::refused(400, &format!("these are no points ({cause})")),
        };
        if !self.work().session.marks().can_hold(&points_px) {
            return Answer::refused(400, FAR_OUTSIDE);
        }
        let curve_px = EdgeCurve::new(&points_px).map_or_else(Vec::new, |curve| {
            let (far_row, near_row) = curve.rows();
            traced(far_row, near_row, |row| curve.column(row))
        });
        Answer::json(200, &json!({ "curve_px": curve_px }))
    }

    fn step(&self, step: impl Fn(&mut Session) -> Option<u64>) -> Answer {
        let mut work = self.work();
        match step(&mut work.session) {
            Some(frame) => work.kept(frame),
            None => Answer::refused(409, "there is nothing left to undo or redo"),
        }
    }

    fn export(&self) -> Answer {
        let mut work = self.work();
        let Work { session, keeper } = &mut *work;
        match keeper.export(session.marks()) {
            Ok(files) => Answer::json(200, &json!({ "files": files })),
            Err(cause) => Answer::refused(409, &cause.to_string()),
        }
    }
}

impl Work {
    /// Keeps the marks and says how they stand, with the edges of the frame that was edited.
    fn kept(&mut self, frame: u64) -> Answer {
        let marks = self.session.marks();
        match self.keeper.keep(&marks.to_file()) {
            Ok(()) => Answer::json(
                200,
                &json!({ "frame": frame, "state": state(&self.session), "edges": edges(marks, frame) }),
            ),
            Err(cause) => Answer::refused(500, &format!("the edit is made but could not be saved: {cause}")),
        }
    }
}

/// How marking stands.
#[derive(Debug, Serialize)]
struct State<'a> {
    input: &'a str,
    picture_px: [u32; 2],
    frames: u64,
    /// Key frames of the left edge, and whether it is there.
    left: Vec<(u64, bool)>,
    right: Vec<(u64, bool)>,
    can_undo: bool,
    can_redo: bool,
}

fn state(session: &Session) -> State<'_> {
    let marks = session.marks();
    State {
        input: marks.input(),
        picture_px: marks.picture_px(),
        frames: marks.frames(),
        left: marks.key_frames(Side::Left).collect(),
        right: marks.key_frames(Side::Right).collect(),
        can_undo: session.can_undo(),
        can_redo: session.can_redo(),
    }
}

/// Both edges of a frame.
#[derive(Debug, Serialize)]
struct Edges {
    left: EdgeInFrame,
    right: EdgeInFrame,
}

fn edges(marks: &LaneMarks, frame: u64) -> Edges {
    Edges { left: marks.at(Side::Left, frame), right: marks.at(Side::Right, frame) }
}
