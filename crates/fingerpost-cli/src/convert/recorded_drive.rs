//! What of a recording goes into the drive: pictures with their times, and what was measured meanwhile.

use std::path::{Path, PathBuf};

use anyhow::{Result, bail};
use fingerpost_format::{MotionLogRow, camera_to_toml};
use fingerpost_geometry::Camera;
use fingerpost_io::bag::{
    Choice, Frames, GpsPosition, Inertial, Picture, Role, StaticTransform, Twist, VehicleMotion,
};
use fingerpost_io::{ConvertedDrive, ConvertedLogs, PictureEnding, PictureFileError, decode_picture};
use fingerpost_map::LatLon;
use serde::Serialize;

use super::measured::{Measured, Timed, seconds_after};
use super::passed_over::PassedOver;
use super::recorded_motion::{self, RecordedMotion};
use crate::{camera_size, output};

/// What was converted, on standard output.
#[derive(Debug, Serialize)]
pub(super) struct Converted {
    pub(super) frames: u64,
    /// Messages and lines that could not be used.
    pub(super) passed_over: u64,
    /// From the first picture to the last, seconds.
    pub(super) length_s: f64,
    pub(super) gps_positions: usize,
    pub(super) motion_rows: usize,
    pub(super) poses: usize,
}

/// A drive that grows message by message. Its folder is made with its first picture.
#[derive(Debug)]
pub(super) struct RecordedDrive {
    out: PathBuf,
    camera: Camera,
    /// Whence the camera is.
    camera_source: String,
    folder: Option<ConvertedDrive>,
    first_ns: u64,
    last_ns: u64,
    gps: Measured<GpsPosition>,
    twists: Measured<Twist>,
    inertial: Measured<Inertial>,
    frames: Frames,
    passed_over: PassedOver,
}

impl RecordedDrive {
    pub(super) fn new(out: &Path, camera: Camera, camera_source: String, choice: &Choice) -> Self {
        Self {
            out: out.to_owned(),
            camera,
            camera_source,
            folder: None,
            first_ns: 0,
            last_ns: 0,
            gps: Measured::of(choice.topic(Role::Gps), "GPS positions"),
            twists: Measured::of(choice.topic(Role::Twist), "twists"),
            inertial: Measured::of(choice.topic(Role::Imu), "inertial measurements"),
            frames: Frames::default(),
            passed_over: PassedOver::default(),
        }
    }

    /// Adds a picture. One that is no later than the one before is passed over: a folder's pictures stand in the order of time.
    pub(super) fn add_picture(&mut self, at_ns: u64, picture: &Picture) -> Result<()> {
        if self.folder.is_some() && at_ns <= self.last_ns {
            self.pass_over(|| format!("a picture at {at_ns} ns is no later than the one before it"));
            return Ok(());
        }
        let folder = match &mut self.folder {
            Some(folder) => folder,
            None => {
                match size(picture) {
                    Ok(size) => {
                        self.camera =
                            camera_size::of_pictures(self.camera.clone(), size, &self.camera_source)?;
                    }
                    Err(cause) => {
                        self.pass_over(|| cause.to_string());
                        return Ok(());
                    }
                }
                self.first_ns = at_ns;
                self.folder.insert(ConvertedDrive::create(&self.out, &camera_to_toml(&self.camera)?)?)
            }
        };
        let t_s = seconds_after(at_ns, self.first_ns);
        match picture {
            Picture::Jpeg(bytes) => folder.add_packed(t_s, PictureEnding::Jpeg, bytes)?,
            Picture::Png(bytes) => folder.add_packed(t_s, PictureEnding::Png, bytes)?,
            Picture::Raw(pixels) => folder.add_pixels(t_s, pixels)?,
        }
        self.last_ns = at_ns;
        Ok(())
    }

    pub(super) fn add_gps(&mut self, at_ns: u64, position: GpsPosition) {
        match LatLon::new(position.lat_deg, position.lon_deg) {
            Ok(_) => self.gps.add(at_ns, position),
            Err(cause) => self.pass_over(|| cause.to_string()),
        }
    }

    pub(super) fn add_twist(&mut self, at_ns: u64, twist: Twist) {
        match self.frames.shared_name(&twist.frame_id) {
            Ok(frame_id) => self.twists.add(at_ns, Twist { frame_id, ..twist }),
            Err(cause) => self.pass_over(|| cause.to_string()),
        }
    }

    pub(super) fn add_inertial(&mut self, at_ns: u64, inertial: Inertial) {
        if !inertial.angular_rps.iter().all(|rate| rate.is_finite()) {
            self.pass_over(|| "a turn is no number".to_owned());
            return;
        }
        match self.frames.shared_name(&inertial.frame_id) {
            Ok(frame_id) => self.inertial.add(at_ns, Inertial { frame_id, ..inertial }),
            Err(cause) => self.pass_over(|| cause.to_string()),
        }
    }

    pub(super) fn add_transforms(&mut self, transforms: Vec<StaticTransform>) {
        if let Err(cause) = self.frames.add(transforms) {
            self.pass_over(|| cause.to_string());
        }
    }

    pub(super) fn pass_over(&mut self, reason: impl FnOnce() -> String) {
        self.passed_over.add(reason);
    }

    /// Writes the rest and says what came of it.
    pub(super) fn finish(mut self, input: &Path) -> Result<Converted> {
        let Some(folder) = self.folder.take() else {
            let why = self.passed_over.first_reason.map_or(String::new(), |reason| format!(" ({reason})"));
            bail!("none of the pictures of {} can be used{why}; nothing was written", input.display());
        };
        let logs = self.logs();
        let converted = Converted {
            frames: folder.frames(),
            passed_over: self.passed_over.count,
            length_s: seconds_after(self.last_ns, self.first_ns),
            gps_positions: logs.gps.len(),
            motion_rows: logs.motion.len(),
            poses: 0,
        };
        folder.finish(&logs)?;
        if !self.twists.is_empty() && logs.motion.is_empty() {
            output::message(
                "no speed was recorded between the first picture and the last; there is no motion.csv",
            );
        }
        if let PassedOver { count, first_reason: Some(reason) } = self.passed_over {
            output::message(&format!(
                "{count} messages of {} are passed over; the first: {reason}",
                input.display()
            ));
        }
        Ok(converted)
    }

    /// What was measured from the first picture to the last, in the order of time.
    fn logs(&mut self) -> ConvertedLogs {
        let (first_ns, last_ns) = (self.first_ns, self.last_ns);
        let (Timed { values: gps, .. }, gps_outside) = self.gps.during(first_ns, last_ns);
        let (twists, twists_outside) = self.twists.during(first_ns, last_ns);
        let (inertial, inertial_outside) = self.inertial.during(first_ns, last_ns);
        for outside in [gps_outside, twists_outside, inertial_outside].into_iter().flatten() {
            output::message(&outside.to_string());
        }
        let RecordedMotion { rows, said, passed_over } =
            recorded_motion::motion(twists, inertial, &self.frames);
        said.iter().for_each(|text| output::message(text));
        self.passed_over.extend(passed_over);
        let seconds = |at_ns: u64| seconds_after(at_ns, first_ns);
        let gps = gps.iter().map(|(at_ns, at)| (seconds(*at_ns), [at.lat_deg, at.lon_deg]));
        let motion = rows.into_iter().map(|(at_ns, VehicleMotion { speed_mps, yaw_rate_rps })| {
            MotionLogRow { t_s: seconds(at_ns), speed_mps, yaw_rate_rps }
        });
        ConvertedLogs { gps: gps.collect(), motion: motion.collect(), poses: Vec::new() }
    }
}

/// Width and height of a picture, pixels.
fn size(picture: &Picture) -> Result<(usize, usize), PictureFileError> {
    match picture {
        Picture::Raw(pixels) => Ok(pixels.size()),
        Picture::Jpeg(bytes) | Picture::Png(bytes) => {
            Ok(decode_picture(bytes, Path::new("the first picture"))?.size())
        }
    }
}
