//! What the page asks, answered: no network here, so that any server can take it in.

use std::fmt;

use fingerpost_format::{FrameRecord, Summary};
use fingerpost_geometry::Camera;
use fingerpost_server::{Answer, Cause, Handler, Picture, Pictures, Request};
use serde::Serialize;

use crate::classes::{NetworkClasses, PageClasses};
use crate::compare::Differences;
use crate::feel::FeelPage;
use crate::overview::Overview;
use crate::page_files::{markup, page_file};
use crate::route_map::{PageRunMap, RunMap};
use crate::shapes::shapes;

/// Where records come from.
pub trait Records: Send + Sync {
    /// The line of `frames.jsonl` at an index from zero.
    ///
    /// # Errors
    /// Why it cannot be read.
    fn line(&self, index: usize) -> Result<Vec<u8>, Cause>;
}

/// What of the road a ground view shows, metres in the vehicle frame.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct GroundArea {
    /// Its lower edge, ahead of the rear axle.
    pub near_m: f64,
    /// Its upper edge.
    pub far_m: f64,
    /// Its left and right edge, from the vehicle's middle.
    pub half_width_m: f64,
}

/// A finished run as a page.
pub struct RunPage {
    run: Run,
    records: Box<dyn Records>,
    pictures: Option<Box<dyn Pictures>>,
    ground_views: Option<Box<dyn Pictures>>,
    road_surfaces: Option<Box<dyn Pictures>>,
    classes: Option<Box<dyn Pictures>>,
    camera: Option<Camera>,
    feel: Result<FeelPage, String>,
    comparison: Option<Comparison>,
}

/// Another run of the same drive.
struct Comparison {
    other: Box<RunPage>,
    differences: Differences,
}

/// What the page is told of the whole run.
#[derive(Debug, Serialize)]
struct Run {
    title: String,
    /// Whether there are pictures to be asked for.
    has_pictures: bool,
    /// What ground views show; none where there are none.
    ground_area: Option<GroundArea>,
    /// Whether the probability of road in that area can be asked for.
    has_road_surfaces: bool,
    /// What the road network can be asked to see in the pictures.
    classes: PageClasses,
    /// Width and height of the pictures, pixels; none where the run does not say.
    picture_px: Option<[u32; 2]>,
    #[serde(flatten)]
    overview: Overview,
    summary: Option<Summary>,
    config_toml: Option<String>,
    /// Where the vehicle is on the map; none where the run never says it.
    map: Option<PageRunMap>,
}

impl fmt::Debug for RunPage {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("RunPage").field("title", &self.run.title).finish_non_exhaustive()
    }
}

impl RunPage {
    /// A page of a run of that title, whose `overview` was made of these records.
    pub fn new(title: &str, overview: Overview, records: Box<dyn Records>) -> Self {
        let run = Run {
            title: title.to_owned(),
            has_pictures: false,
            ground_area: None,
            has_road_surfaces: false,
            classes: PageClasses { legend: Vec::new(), lacking: None },
            picture_px: None,
            overview,
            summary: None,
            config_toml: None,
            map: None,
        };
        let feel = Err("settings cannot be felt here".to_owned());
        Self {
            run,
            records,
            pictures: None,
            ground_views: None,
            road_surfaces: None,
            classes: None,
            camera: None,
            feel,
            comparison: None,
        }
    }

    /// With another run of the same drive, and what differs between the two.
    #[must_use]
    pub fn with_comparison(mut self, other: Self, differences: Differences) -> Self {
        self.comparison = Some(Comparison { other: Box::new(other), differences });
        self
    }

    /// With the part on which settings are felt, or what it lacks.
    #[must_use]
    pub fn with_feel(mut self, feel: Result<FeelPage, String>) -> Self {
        self.feel = feel;
        self
    }

    /// With the drive's pictures.
    #[must_use]
    pub fn with_pictures(mut self, pictures: Box<dyn Pictures>) -> Self {
        (self.run.has_pictures, self.pictures) = (true, Some(pictures));
        self
    }

    /// With the ground views of the drive, each of that part of the road.
    #[must_use]
    pub fn with_ground_views(mut self, views: Box<dyn Pictures>, area: GroundArea) -> Self {
        (self.run.ground_area, self.ground_views) = (Some(area), Some(views));
        self
    }

    /// With the probability of road in the area of the ground views, as pictures of it.
    #[must_use]
    pub fn with_road_surfaces(mut self, surfaces: Box<dyn Pictures>) -> Self {
        (self.run.has_road_surfaces, self.road_surfaces) = (true, Some(surfaces));
        self
    }

    /// With what the road network sees in the pictures, or why that cannot be shown.
    #[must_use]
    pub fn with_classes(mut self, classes: Result<NetworkClasses, String>) -> Self {
        match classes {
            Ok(NetworkClasses { legend, pictures }) => {
                self.run.classes = PageClasses { legend, lacking: None };
                self.classes = Some(pictures);
            }
            Err(lacking) => self.run.classes.lacking = Some(lacking),
        }
        self
    }

    /// With the vehicle's places on the map.
    #[must_use]
    pub fn with_map(mut self, map: &RunMap) -> Self {
        self.run.map = Some(map.page_map());
        self
    }

    /// With the camera that took them: places on the road are drawn into the picture.
    #[must_use]
    pub fn with_camera(mut self, camera: Camera) -> Self {
        self.camera = Some(camera);
        self
    }

    /// With the run's summary and its settings as `config.toml` has them.
    #[must_use]
    pub fn with_results(mut self, summary: Option<Summary>, config_toml: Option<String>) -> Self {
        self.run.picture_px = summary.as_ref().and_then(|summary| summary.picture_px);
        (self.run.summary, self.run.config_toml) = (summary, config_toml);
        self
    }

    fn with_index(&self, index: &str, answer: impl Fn(usize) -> Answer) -> Answer {
        let frames = self.run.overview.frames().len();
        match index.parse().ok().filter(|index| *index < frames) {
            Some(index) => answer(index),
            None => Answer::refused(404, &format!("there is no record {index}; there are {frames}, from 0")),
        }
    }

    fn compared(&self, answer: impl Fn(&Comparison) -> Answer) -> Answer {
        match &self.comparison {
            Some(comparison) => answer(comparison),
            None => Answer::refused(404, "To compare two runs, give the other one with --with."),
        }
    }

    fn record(&self, index: usize) -> Answer {
        let line = match self.records.line(index) {
            Ok(line) => line,
            Err(cause) => return Answer::refused(500, &cause.to_string()),
        };
        let record: FrameRecord = match serde_json::from_slice(&line) {
            Ok(record) => record,
            Err(cause) => return Answer::refused(500, &format!("record {index} is no frame's ({cause})")),
        };
        let shapes = match serde_json::to_vec(&shapes(&record, self.camera.as_ref())) {
            Ok(shapes) => shapes,
            Err(cause) => return Answer::refused(500, &format!("its shapes have no JSON form ({cause})")),
        };
        // The record goes out as it was written, with every digit.
        let body = [b"{\"record\":", line.as_slice(), b",\"shapes\":", shapes.as_slice(), b"}"].concat();
        Answer { status: 200, content_type: "application/json", body }
    }

    /// The picture of a record's frame, of one kind.
    fn picture(&self, index: usize, of_kind: Option<&dyn Pictures>) -> Answer {
        let (Some(pictures), Some(frame)) = (of_kind, self.run.overview.frames().get(index)) else {
            return Answer::refused(404, "no pictures were given; say where they are with --input");
        };
        match pictures.picture(*frame) {
            Ok(Picture { content_type, bytes }) => Answer { status: 200, content_type, body: bytes },
            Err(cause) => Answer::refused(500, &cause.to_string()),
        }
    }
}

impl Handler for RunPage {
    fn answer(&self, request: Request<'_>) -> Answer {
        let path: Vec<&str> = request.path.trim_start_matches('/').split('/').collect();
        match (request.method, &path[..]) {
            ("GET", [""]) => markup("look"),
            ("GET", [part @ ("feel" | "compare")]) => markup(part),
            ("GET", ["api", "differences"]) => {
                self.compared(|compared| Answer::json(200, &compared.differences))
            }
            (_, ["api", "other", path @ ..]) => self.compared(|compared| {
                let path = format!("/api/{}", path.join("/"));
                compared.other.answer(Request { path: &path, ..request })
            }),
            (_, ["api", "feel", path @ ..]) => match &self.feel {
                Ok(feel) => feel.answer(self.run.overview.frames().len(), request, path),
                Err(lacking) => Answer::refused(404, lacking),
            },
            ("GET", [name]) if name.contains('.') => page_file(name),
            ("GET", ["api", "run"]) => Answer::json(200, &self.run),
            ("GET", ["api", "records", index]) => self.with_index(index, |index| self.record(index)),
            ("GET", ["api", "records", index, "picture"]) => {
                self.with_index(index, |index| self.picture(index, self.pictures.as_deref()))
            }
            ("GET", ["api", "records", index, "ground_view"]) => {
                self.with_index(index, |index| self.picture(index, self.ground_views.as_deref()))
            }
            ("GET", ["api", "records", index, "road_surface"]) => {
                self.with_index(index, |index| self.picture(index, self.road_surfaces.as_deref()))
            }
            ("GET", ["api", "records", index, "classes"]) => {
                self.with_index(index, |index| self.picture(index, self.classes.as_deref()))
            }
            _ => Answer::refused(404, "there is no such page; open / instead"),
        }
    }
}
