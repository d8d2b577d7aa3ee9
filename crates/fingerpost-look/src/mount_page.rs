//! The page on which a camera's mount is set up by eye: questions and the mount as they come from it, answered.

use std::fmt;

use fingerpost_geometry::{Camera, Intrinsics, Mount, View};
use fingerpost_server::{Answer, Cause, Handler, Picture, Pictures, Request};
use serde::{Deserialize, Serialize};
use serde_json::json;

use crate::page_files::page_file;
use crate::run_page::GroundArea;
use crate::shapes::metre_grid;

/// Where ground views come from.
pub trait GroundViews: Send + Sync {
    /// What a frame shows from above when such a camera took it.
    ///
    /// # Errors
    /// Why there is none.
    fn ground_view(&self, frame: u64, camera: &Camera) -> Result<Picture, Cause>;
}

/// Where a camera goes that is kept.
pub trait CameraKeeper: Send + Sync {
    /// Keeps a camera in place of the one that was kept before.
    ///
    /// # Errors
    /// Why it could not be kept.
    fn keep(&self, camera: &Camera) -> Result<Kept, Cause>;
}

/// A camera that is kept.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Kept {
    /// Its file.
    pub file: String,
    /// The command line that runs the drive with it.
    pub command: String,
}

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
    /// Where the camera goes.
    pub keeper: Box<dyn CameraKeeper>,
}

/// A camera that is calibrated, so that it has a mount.
#[derive(Debug, Clone)]
struct MountedCamera {
    camera: Camera,
    intrinsics: Intrinsics,
    mount: Mount,
}

/// Height and angles of a mount as the page has them.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
struct PageMount {
    height_m: f64,
    pitch_deg: f64,
    yaw_deg: f64,
    roll_deg: f64,
}

impl PageMount {
    /// The four numbers of a path, with commas between them.
    fn of_path(text: &str) -> Option<Self> {
        let numbers: Vec<f64> = text.split(',').map(str::parse).collect::<Result<_, _>>().ok()?;
        let [height_m, pitch_deg, yaw_deg, roll_deg] = numbers.try_into().ok()?;
        Some(Self { height_m, pitch_deg, yaw_deg, roll_deg })
    }

    fn of(mount: &Mount) -> Self {
        let degrees = |rad: f64| (rad.to_degrees() * 1e6).round() / 1e6;
        Self {
            height_m: mount.height_m,
            pitch_deg: degrees(mount.pitch_rad),
            yaw_deg: degrees(mount.yaw_rad),
            roll_deg: degrees(mount.roll_rad),
        }
    }
}

/// A drive whose camera's mount is set up.
pub struct MountPage {
    frames: DriveFrames,
    area: GroundArea,
    start: MountedCamera,
    sources: DriveSources,
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
        let start = MountedCamera { camera, intrinsics, mount };
        Some(Self { frames, area, start, sources })
    }

    fn drive(&self) -> Answer {
        let MountedCamera { camera, intrinsics, mount } = &self.start;
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
            }),
        )
    }

    /// The camera on a mount of the page, or the answer that says why there is none.
    fn camera(&self, mount: PageMount) -> Result<Camera, Answer> {
        let mount = Mount {
            height_m: mount.height_m,
            pitch_rad: mount.pitch_deg.to_radians(),
            yaw_rad: mount.yaw_deg.to_radians(),
            roll_rad: mount.roll_deg.to_radians(),
            ..self.start.mount
        };
        self.start.camera.with_mount(mount).map_err(|cause| Answer::refused(400, &cause.to_string()))
    }

    fn with_camera(&self, mount: &str, answer: impl Fn(&Camera) -> Answer) -> Answer {
        match PageMount::of_path(mount) {
            None => Answer::refused(400, "a mount is HEIGHT_M,PITCH_DEG,YAW_DEG,ROLL_DEG"),
            Some(mount) => self.camera(mount).map_or_else(|refusal| refusal, |camera| answer(&camera)),
        }
    }

    fn with_frame(&self, frame: &str, picture: impl Fn(u64) -> Result<Picture, Cause>) -> Answer {
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

    fn keep(&self, body: &[u8]) -> Answer {
        let mount: PageMount = match serde_json::from_slice(body) {
            Ok(mount) => mount,
            Err(cause) => return Answer::refused(400, &format!("this is no mount ({cause})")),
        };
        match self.camera(mount).map(|camera| self.sources.keeper.keep(&camera)) {
            Ok(Ok(kept)) => Answer::json(200, &kept),
            Ok(Err(cause)) => Answer::refused(500, &cause.to_string()),
            Err(refusal) => refusal,
        }
    }
}

impl Handler for MountPage {
    fn answer(&self, request: Request<'_>) -> Answer {
        let path: Vec<&str> = request.path.trim_start_matches('/').split('/').collect();
        match (request.method, &path[..]) {
            ("GET", [""]) => Answer::text("text/html; charset=utf-8", include_str!("page/mount.html")),
            ("GET", [name]) if name.contains('.') => page_file(name),
            ("GET", ["api", "drive"]) => self.drive(),
            ("GET", ["api", "frames", frame, "picture"]) => {
                self.with_frame(frame, |frame| self.sources.pictures.picture(frame))
            }
            ("GET", ["api", "mounts", mount, "shapes"]) => {
                self.with_camera(mount, |camera| Answer::json(200, &metre_grid(camera)))
            }
            ("GET", ["api", "mounts", mount, "frames", frame]) => self.with_camera(mount, |camera| {
                self.with_frame(frame, |frame| self.sources.ground_views.ground_view(frame, camera))
            }),
            ("POST", ["api", "camera"]) => self.keep(request.body),
            _ => Answer::refused(404, "there is no such page; open / instead"),
        }
    }
}
