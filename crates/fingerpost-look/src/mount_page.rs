//! The page on which a drive is set up by eye: its questions, its camera's mount and the start of its route, answered.

mod page_mount;
mod sources;

use std::fmt;

use fingerpost_geometry::{Camera, Intrinsics, Mount, View};
use fingerpost_server::{Answer, Cause, Handler, Picture, Pictures, Request};
use serde::Deserialize;
use serde_json::json;

use self::page_mount::PageMount;
pub use self::sources::{GroundViews, Kept, MountSearch, SearchState, SetUpKeeper};
use crate::page_files::{markup, page_file};
use crate::route_map::RouteMap;
use crate::run_page::GroundArea;
use crate::shapes::metre_grid;

/// The frames of a drive that the page shows.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct DriveFrames {
    /// What the drive is called.
    pub title: String,
    /// How many are shown.
    pub count: u64,
    /// From the number of one to that of the next: of a long video not every frame is shown.
    pub step: u64,
}

/// What the page asks its program for.
pub struct DriveSources {
    /// The drive's pictures.
    pub pictures: Box<dyn Pictures>,
    /// The same from above.
    pub ground_views: Box<dyn GroundViews>,
    /// Where is saved what was set up.
    pub keeper: Box<dyn SetUpKeeper>,
    /// The search for the mount.
    pub search: Box<dyn MountSearch>,
}

/// A camera that is calibrated, so that it has a mount.
#[derive(Debug, Clone)]
struct MountedCamera {
    camera: Camera,
    intrinsics: Intrinsics,
    mount: Mount,
}

/// A route and where on it the drive begins before anybody has moved it.
#[derive(Debug, Clone)]
struct BegunRoute {
    map: RouteMap,
    start_m: f64,
}

/// A drive that is set up.
pub struct MountPage {
    frames: DriveFrames,
    area: GroundArea,
    begun: MountedCamera,
    route: Option<BegunRoute>,
    sources: DriveSources,
}

/// What is to be kept.
#[derive(Debug, Deserialize)]
struct SetUp {
    mount: PageMount,
    start_m: Option<f64>,
}

impl fmt::Debug for MountPage {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("MountPage").field("frames", &self.frames).finish_non_exhaustive()
    }
}

impl MountPage {
    /// A page of a drive that begins with the mount of `camera`; none for a camera that is known by points and has no mount. Ground
    /// views show `area`.
    pub fn new(frames: DriveFrames, camera: Camera, area: GroundArea, sources: DriveSources) -> Option<Self> {
        let View::Calibrated { intrinsics, mount, .. } = *camera.view() else { return None };
        let begun = MountedCamera { camera, intrinsics, mount };
        Some(Self { frames, area, begun, route: None, sources })
    }

    /// With the route of the drive, whose first frame is taken `start_m` metres along it.
    #[must_use]
    pub fn with_route(mut self, map: RouteMap, start_m: f64) -> Self {
        self.route = Some(BegunRoute { map, start_m });
        self
    }

    fn drive(&self) -> Answer {
        let MountedCamera { camera, intrinsics, mount } = &self.begun;
        let route = self.route.as_ref();
        let route =
            route.map(|BegunRoute { map, start_m }| json!({ "start_m": start_m, "map": map.page_map() }));
        Answer::json(
            200,
            &json!({
                "title": self.frames.title,
                "frames": self.frames.count,
                "frame_step": self.frames.step,
                "picture_px": [camera.width(), camera.height()],
                "focal_px": [intrinsics.fx, intrinsics.fy],
                "ground_area": self.area,
                "mount": PageMount::of(mount),
                "route": route,
            }),
        )
    }

    /// The camera on a mount of the page, or the answer that says why there is none.
    fn camera(&self, mount: PageMount) -> Result<Camera, Answer> {
        let mounted = self.begun.camera.with_mount(mount.in_place_of(self.begun.mount));
        mounted.map_err(|cause| Answer::refused(400, &cause.to_string()))
    }

    fn with_camera(&self, mount: &str, answer: impl FnOnce(&Camera) -> Answer) -> Answer {
        match PageMount::of_path(mount) {
            None => Answer::refused(400, "a mount is HEIGHT_M,PITCH_DEG,YAW_DEG,ROLL_DEG"),
            Some(mount) => self.camera(mount).map_or_else(|refusal| refusal, |camera| answer(&camera)),
        }
    }

    fn with_frame(&self, frame: &str, picture: impl FnOnce(u64) -> Result<Picture, Cause>) -> Answer {
        let DriveFrames { count, step, .. } = self.frames;
        let is_shown = |frame: &u64| frame.is_multiple_of(step) && frame / step < count;
        let Some(frame) = frame.parse().ok().filter(is_shown) else {
            let which = format!("there is no frame {frame}; there are {count}, from 0 in steps of {step}");
            return Answer::refused(404, &which);
        };
        match picture(frame) {
            Ok(Picture { content_type, bytes }) => Answer { status: 200, content_type, body: bytes },
            Err(cause) => Answer::refused(422, &cause.to_string()),
        }
    }

    /// A place of the route, or the answer that says why it is none.
    fn start(&self, start_m: f64) -> Result<(&RouteMap, f64), Answer> {
        let Some(BegunRoute { map, .. }) = &self.route else {
            return Err(Answer::refused(404, "the drive has no route; give one with --route"));
        };
        let length_m = map.length_m();
        if (0.0..=length_m).contains(&start_m) {
            return Ok((map, start_m));
        }
        Err(Answer::refused(400, &format!("the route is {length_m:.1} m long; start_m is 0 to that")))
    }

    fn shapes_with_route(&self, camera: &Camera, start_m: &str) -> Answer {
        match self.start(start_m.parse().unwrap_or(f64::NAN)) {
            Ok((map, start_m)) => {
                Answer::json(200, &[metre_grid(camera), map.shapes(camera, start_m)].concat())
            }
            Err(refusal) => refusal,
        }
    }

    fn keep(&self, body: &[u8]) -> Answer {
        let SetUp { mount, start_m } = match serde_json::from_slice(body) {
            Ok(set_up) => set_up,
            Err(cause) => return Answer::refused(400, &format!("this is no mount and start ({cause})")),
        };
        if let Some(Err(refusal)) = start_m.map(|start_m| self.start(start_m)) {
            return refusal;
        }
        match self.camera(mount).map(|camera| self.sources.keeper.keep(&camera, start_m)) {
            Ok(Ok(kept)) => Answer::json(200, &kept),
            Ok(Err(cause)) => Answer::refused(500, &cause.to_string()),
            Err(refusal) => refusal,
        }
    }

    fn search(&self, body: &[u8]) -> Answer {
        let mount: PageMount = match serde_json::from_slice(body) {
            Ok(mount) => mount,
            Err(cause) => return Answer::refused(400, &format!("this is no mount ({cause})")),
        };
        match self.camera(mount).map(|camera| self.sources.search.begin(&camera)) {
            Ok(Ok(())) => self.search_state(),
            Ok(Err(cause)) => Answer::refused(409, &cause.to_string()),
            Err(refusal) => refusal,
        }
    }

    fn search_state(&self) -> Answer {
        let state = match self.sources.search.state() {
            SearchState::Idle => json!({ "is": "idle" }),
            SearchState::Running { frames, of } => json!({ "is": "running", "frames": frames, "of": of }),
            SearchState::Failed { cause } => json!({ "is": "failed", "cause": cause }),
            SearchState::Found { mount, said } => {
                json!({ "is": "found", "mount": PageMount::of(&mount), "said": said })
            }
        };
        Answer::json(200, &state)
    }
}

impl Handler for MountPage {
    fn answer(&self, request: Request<'_>) -> Answer {
        let path: Vec<&str> = request.path.trim_start_matches('/').split('/').collect();
        match (request.method, &path[..]) {
            ("GET", [""]) => markup("mount"),
            ("GET", [name]) if name.contains('.') => page_file(name),
            ("GET", ["api", "drive"]) => self.drive(),
            ("GET", ["api", "frames", frame, "picture"]) => {
                self.with_frame(frame, |frame| self.sources.pictures.picture(frame))
            }
            ("GET", ["api", "mounts", mount, "shapes"]) => {
                self.with_camera(mount, |camera| Answer::json(200, &metre_grid(camera)))
            }
            ("GET", ["api", "mounts", mount, "starts", start_m, "shapes"]) => {
                self.with_camera(mount, |camera| self.shapes_with_route(camera, start_m))
            }
            ("GET", ["api", "mounts", mount, "frames", frame]) => self.with_camera(mount, |camera| {
                self.with_frame(frame, |frame| self.sources.ground_views.ground_view(frame, camera))
            }),
            ("GET", ["api", "search"]) => self.search_state(),
            ("POST", ["api", "search"]) => self.search(request.body),
            ("POST", ["api", "search", "stop"]) => {
                self.sources.search.stop();
                self.search_state()
            }
            ("POST", ["api", "set_up"]) => self.keep(request.body),
            _ => Answer::refused(404, "there is no such page; open / instead"),
        }
    }
}
