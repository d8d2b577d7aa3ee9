//! What the road network sees in a frame of a run: asked when it is to be shown, as no run records it.

use std::path::PathBuf;
use std::sync::{Mutex, PoisonError};

use anyhow::{Context, Result, anyhow};
use fingerpost::Sensors;
use fingerpost_geometry::Camera;
use fingerpost_io::decode_picture;
use fingerpost_look::{NetworkClasses, SeenClass};
use fingerpost_record::FrameTime;
use fingerpost_report::{NETWORK_CLASSES, network_picture};
use fingerpost_server::{Cause, Picture, Pictures};
use fingerpost_vision::jpeg::{ChromaSampling, jpeg_file};

use super::method::Method;
use super::run_files::RunFiles;
use crate::driver::{Driver, RunSetting, Sequence};
use crate::parts;
use crate::recorder::Wishes;

/// JPEG quality of the pictures.
const QUALITY: u8 = 85;

/// The classes in the run's pictures, or why they cannot be shown.
pub(super) fn open(
    run: &RunFiles,
    camera: Option<&Camera>,
    pictures: Option<Box<dyn Pictures>>,
) -> Result<Result<NetworkClasses, String>> {
    let lacking = |what: &str| Ok(Err(format!("To see what the network sees, {what}.")));
    let method = match Method::of(run, camera) {
        Ok(method) => method,
        Err(what) => return lacking(what),
    };
    let Some(pictures) = pictures else {
        return lacking("say where the pictures are with --input");
    };
    let road = &method.config.road_surface;
    // A network that a user brings tells no classes but road.
    if road.needs_onnx() || parts::road_detector(road)?.network().is_none() {
        let cause = "The run's road detector asks no network that tells classes.";
        return Ok(Err(cause.to_owned()));
    }
    let legend = NETWORK_CLASSES.iter().map(|class| SeenClass::new(class.name, class.colour)).collect();
    let asked = AskedNetwork { method, pictures, asking: Mutex::new(()) };
    Ok(Ok(NetworkClasses { legend, pictures: Box::new(asked) }))
}

/// A network that is asked about one frame at a time: what it sees in one does not depend on those before.
struct AskedNetwork {
    method: Method,
    pictures: Box<dyn Pictures>,
    /// One frame at a time, so that a slider that is dragged leaves the other answers a core.
    asking: Mutex<()>,
}

impl Pictures for AskedNetwork {
    fn picture(&self, frame: u64) -> Result<Picture, Cause> {
        let file = self.pictures.picture(frame)?;
        let _asking = self.asking.lock().unwrap_or_else(PoisonError::into_inner);
        Ok(self.seen(frame, &file.bytes)?)
    }
}

impl AskedNetwork {
    fn seen(&self, frame: u64, file: &[u8]) -> Result<Picture> {
        let picture = decode_picture(file, &PathBuf::from(format!("frame {frame}")))?;
        let scaling = self.method.scaling()?;
        let camera = self.method.scaled_camera(scaling.as_ref());
        // Pictures of a recording have the size at which the method got them.
        let scaling = scaling.filter(|scaling| picture.size() == scaling.input_px());
        let setting = RunSetting {
            config: &self.method.config,
            camera: &camera,
            route: None,
            start_m: None,
            sequence: Sequence::Drive,
        };
        let mut driver =
            Driver::new(setting, &Wishes::records_alone(), None)?.without_key_frames().scaling_with(scaling);
        let mut drawn = None;
        let time = FrameTime { frame, t_s: 0.0 };
        let result = driver.step_showing(time, &picture, Sensors::default(), &mut |scene| {
            drawn = network_picture(scene);
        })?;
        result.outcome.map_err(|cause| anyhow!("frame {frame} cannot be used: {cause}"))?;
        let drawn = drawn.with_context(|| {
            format!("the network was not asked about frame {frame}, in which the camera shows no road")
        })?;
        let bytes = jpeg_file(&drawn, QUALITY, ChromaSampling::Halved)?;
        Ok(Picture { content_type: "image/jpeg", bytes })
    }
}
