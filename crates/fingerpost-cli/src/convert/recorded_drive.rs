//! What of a recording goes into the drive: pictures with their times, and what was measured meanwhile.

use std::path::{Path, PathBuf};

use anyhow::{Result, bail};
use fingerpost_format::{MotionLogRow, camera_to_toml};
use fingerpost_geometry::Camera;
use fingerpost_io::bag::{Frames, GpsPosition, Inertial, Picture, StaticTransform, Twist, VehicleMotion};
use fingerpost_io::{ConvertedDrive, ConvertedLogs, PictureEnding, PictureFileError, decode_picture};
use fingerpost_map::LatLon;
use serde::Serialize;

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
    gps: Vec<(u64, GpsPosition)>,
    twists: Vec<(u64, Twist)>,
    inertial: Vec<(u64, Inertial)>,
    frames: Frames,
    /// What could not be used, and the first reason.
    passed_over: u64,
    first_reason: Option<String>,
}

impl RecordedDrive {
    pub(super) fn new(out: &Path, camera: Camera, camera_source: String) -> Self {
        Self {
            out: out.to_owned(),
            camera,
            camera_source,
            folder: None,
            first_ns: 0,
            last_ns: 0,
            gps: Vec::new(),
            twists: Vec::new(),
            inertial: Vec::new(),
            frames: Frames::default(),
            passed_over: 0,
            first_reason: None,
        }
    }

    /// Adds a picture. One that is no later than the one before is passed over: a folder's pictures stand in the order of time.
    pub(super) fn add_picture(&mut self, at_ns: u64, picture: &Picture) -> Result<()> {
        if self.folder.is_some() && at_ns <= self.last_ns {
            self.pass_over(format!("a picture at {at_ns} ns is no later than the one before it"));
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
                        self.pass_over(cause.to_string());
                        return Ok(());
                    }
                }
                self.first_ns = at_ns;
                self.folder.insert(ConvertedDrive::create(&self.out, &camera_to_toml(&self.camera)?)?)
            }
        };
        let t_s = seconds(at_ns, self.first_ns);
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
            Ok(_) => self.gps.push((at_ns, position)),
            Err(cause) => self.pass_over(cause.to_string()),
        }
    }

    pub(super) fn add_twist(&mut self, at_ns: u64, twist: Twist) {
        self.twists.push((at_ns, twist));
    }

    pub(super) fn add_inertial(&mut self, at_ns: u64, inertial: Inertial) {
        if inertial.angular_rps.iter().all(|rate| rate.is_finite()) {
            self.inertial.push((at_ns, inertial));
        } else {
            self.pass_over("a turn is no number".to_owned());
        }
    }

    pub(super) fn add_transforms(&mut self, transforms: Vec<StaticTransform>) {
        self.frames.add(transforms);
    }

    pub(super) fn pass_over(&mut self, reason: String) {
        self.passed_over += 1;
        self.first_reason.get_or_insert(reason);
    }

    /// Writes the rest and says what came of it.
    pub(super) fn finish(mut self, input: &Path) -> Result<Converted> {
        let Some(folder) = self.folder.take() else {
            let why = self.first_reason.map_or(String::new(), |reason| format!(" ({reason})"));
            bail!("none of the pictures of {} can be used{why}; nothing was written", input.display());
        };
        let logs = self.logs();
        let converted = Converted {
            frames: folder.frames(),
            passed_over: self.passed_over,
            length_s: seconds(self.last_ns, self.first_ns),
            gps_positions: logs.gps.len(),
            motion_rows: logs.motion.len(),
            poses: 0,
        };
        folder.finish(&logs)?;
        if let (true, Some((first, _)), Some((last, _))) =
            (logs.gps.is_empty(), self.gps.first(), self.gps.last())
        {
            output::message(&format!(
                "none of the {} GPS positions is used: they are stamped {:.1} to {:.1} s after the first picture, and the last picture is \
                 {:.1} s after it; their clock is another one",
                self.gps.len(),
                signed_seconds(*first, self.first_ns),
                signed_seconds(*last, self.first_ns),
                converted.length_s
            ));
        }
        if !self.twists.is_empty() && logs.motion.is_empty() {
            output::message(
                "no speed was recorded between the first picture and the last; there is no motion.csv",
            );
        }
        if let Some(reason) = self.first_reason {
            output::message(&format!(
                "{} of {} messages are passed over; the first: {reason}",
                input.display(),
                self.passed_over
            ));
        }
        Ok(converted)
    }

    /// What was measured from the first picture to the last, in the order of time.
    fn logs(&mut self) -> ConvertedLogs {
        let (first_ns, last_ns) = (self.first_ns, self.last_ns);
        let during = move |at_ns: u64| (first_ns..=last_ns).contains(&at_ns);
        self.gps.sort_by_key(|(at_ns, _)| *at_ns);
        let gps = self.gps.iter().filter(|(at_ns, _)| during(*at_ns));
        let gps = gps.map(|(at_ns, at)| (seconds(*at_ns, first_ns), [at.lat_deg, at.lon_deg])).collect();
        let RecordedMotion { rows, said, passed_over } =
            recorded_motion::motion(&mut self.twists, &mut self.inertial, &self.frames);
        said.iter().for_each(|text| output::message(text));
        for reason in passed_over {
            self.pass_over(reason);
        }
        let rows = rows.into_iter().filter(|(at_ns, _)| during(*at_ns));
        let motion = rows.map(|(at_ns, VehicleMotion { speed_mps, yaw_rate_rps })| MotionLogRow {
            t_s: seconds(at_ns, first_ns),
            speed_mps,
            yaw_rate_rps,
        });
        ConvertedLogs { gps, motion: motion.collect(), poses: Vec::new() }
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

/// Negative before.
fn signed_seconds(at_ns: u64, since_ns: u64) -> f64 {
    (i128::from(at_ns) - i128::from(since_ns)) as f64 * 1e-9
}

fn seconds(at_ns: u64, since_ns: u64) -> f64 {
    at_ns.saturating_sub(since_ns) as f64 * 1e-9
}
