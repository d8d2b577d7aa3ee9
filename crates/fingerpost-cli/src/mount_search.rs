//! A camera's mount from a drive: every frame handed on, what comes of it, and what there is to say of that.

use std::sync::atomic::{AtomicBool, Ordering};

use anyhow::{Context, Result, bail};
use fingerpost_calibration::{
    DrivenWay, DrivenWayError, Estimated, KnownScale, LaneWidth, MountCalibration, MountCalibrator,
};
use fingerpost_geometry::Camera;
use fingerpost_io::{FrameClock, FrameError, FrameSource, SourceOptions, StampFaults};
use fingerpost_vision::picture::RgbImage;
use indicatif::ProgressBar;

use crate::{camera_size, inputs, output};

/// What is said before the reason where a drive does not show the mount.
const NOTHING_WRITTEN: &str = "the mount cannot be trusted and nothing was written";

/// A search for the mount of a camera in a drive.
pub(crate) struct MountSearch<'a> {
    /// The drive.
    pub(crate) input: &'a str,
    /// How to read it.
    pub(crate) options: SourceOptions,
    /// The frames that are looked at; none for all.
    pub(crate) frames: Option<u64>,
    /// What is known of the drive, for the height.
    pub(crate) known: KnownScale,
    /// Width of the lane, metres, where the height is to come from it.
    pub(crate) lane_width_m: Option<f64>,
    /// Set where the search is to end.
    pub(crate) stop: &'a AtomicBool,
    /// Gives what shows how far a pass through the frames is, by their number.
    pub(crate) bar: &'a dyn Fn(Option<u64>) -> ProgressBar,
}

/// What a drive shows of a mount.
pub(crate) struct FoundMount {
    pub(crate) calibration: MountCalibration,
    /// The camera on it.
    pub(crate) camera: Camera,
}

impl MountSearch<'_> {
    /// Searches about the mount of a camera, whose calibration is that of `camera_source`.
    pub(crate) fn find(&self, camera: Camera, camera_source: &str) -> Result<FoundMount> {
        let mut source = inputs::frames(self.input, &self.options)?;
        if source.clock() == FrameClock::Guessed && matches!(self.known, KnownScale::SpeedMps(_)) {
            bail!(
                "the height from --speed-mps is as wrong as the frame rate is, and that of {} is a guess; give the rate (--fps), or \
                 --distance-m in place of the speed; nothing was written",
                self.input
            );
        }
        let camera = match source.picture_size() {
            Some(size) => camera_size::of_pictures(camera, size, camera_source)?,
            None => camera,
        };
        let is_live = source.is_live();
        let mut calibrator = MountCalibrator::new(&camera)?;
        let faults = self.for_each_frame(source, |picture, t_s| Ok(calibrator.add(picture, t_s)?))?;
        inputs::say_stamp_faults(self.input, faults);
        let mut calibration = calibrator.finish(self.known).context(NOTHING_WRITTEN)?;
        if let Some(lane_width_m) = self.lane_width_m {
            let seen = self.width_of_lane(&calibration.camera_on_mount(&camera).context(NOTHING_WRITTEN)?)?;
            calibration = calibration.with_lane_width(seen, lane_width_m);
        }
        let calibrated = calibration.camera_on_mount(&camera).context(NOTHING_WRITTEN)?;
        if self.known != KnownScale::Nothing && !is_live {
            let seen = self.driven_way(&calibrated)?;
            seen.map_or(Ok(()), |seen| calibration.held_against(seen, self.known))
                .context(NOTHING_WRITTEN)?;
        }
        Ok(FoundMount { calibration, camera: calibrated })
    }

    /// Hands every picture of the input on, and says what was wrong with their stamps; broken pictures are passed over.
    fn for_each_frame(
        &self,
        mut source: FrameSource,
        mut take: impl FnMut(&RgbImage, f64) -> Result<()>,
    ) -> Result<StampFaults> {
        let most = self.frames.unwrap_or(u64::MAX);
        let bar = (self.bar)(source.length().map(|length| length.min(most)).or(self.frames));
        let mut left = most;
        while let Some(frame) = source.next().filter(|_| left > 0) {
            self.go_on()?;
            left -= 1;
            match frame.picture {
                Ok(picture) => {
                    take(&picture, frame.t_s).with_context(|| format!("frame {}", frame.index))?;
                    source.recycle(picture);
                }
                Err(cause @ FrameError::Picture(_)) => output::message(&format!("passed over: {cause}")),
                Err(cause @ FrameError::Video(_)) => return Err(cause.into()),
            }
            bar.inc(1);
        }
        bar.finish_and_clear();
        self.go_on()?;
        Ok(source.stamp_faults())
    }

    fn go_on(&self) -> Result<()> {
        if self.stop.load(Ordering::SeqCst) {
            bail!("interrupted; nothing was written");
        }
        Ok(())
    }

    /// The way of the drive through the camera; none where it does not show the road just ahead, which is said.
    fn driven_way(&self, camera: &Camera) -> Result<Option<Estimated>> {
        let mut way = DrivenWay::new(camera).map_err(DrivenWayError::from);
        if way.is_ok() {
            // What there is to say of the input has been said.
            let source = FrameSource::open(self.input, &self.options)?;
            self.for_each_frame(source, |picture, _| {
                if let Err(error) = way.as_mut().map_or(Ok(()), |way| way.add(picture)) {
                    way = Err(error);
                }
                Ok(())
            })?;
        }
        match way {
            Ok(way) => Ok(Some(way.way())),
            Err(error) => {
                output::message(&format!(
                    "the height is not held against the way that the frames show through its camera: {error}"
                ));
                Ok(None)
            }
        }
    }

    /// How wide the lane looks through a camera of that height.
    fn width_of_lane(&self, camera: &Camera) -> Result<Estimated> {
        let mut lane = LaneWidth::new(camera)?;
        // What there is to say of the input has been said.
        let source = FrameSource::open(self.input, &self.options)?;
        self.for_each_frame(source, |picture, _| Ok(lane.add(picture)?))?;
        lane.width().context(
            "the drive shows no lane with markings on both sides for long enough, so that its width does not give the height; give \
             --speed-mps or --distance-m instead; nothing was written",
        )
    }
}

impl FoundMount {
    /// What there is to say of it, a line each.
    pub(crate) fn lines(&self) -> Vec<String> {
        let MountCalibration { mount, pitch, yaw, roll, height, .. } = &self.calibration;
        let degrees = |what: &str, of: &Estimated| {
            format!("{what}: {:.2}° ± {:.2}°", of.value.to_degrees(), of.sigma.to_degrees())
        };
        let roll_kept = mount.roll_rad.to_degrees();
        let roll = match roll {
            Some(roll) if self.calibration.roll_taken_over => degrees("roll (positive left side up)", roll),
            Some(roll) => format!(
                "roll kept at {roll_kept:.2}°: the road shows {:.2}° ± {:.2}°, which a crowned road may do",
                roll.value.to_degrees(),
                roll.sigma.to_degrees()
            ),
            None => format!("roll kept at {roll_kept:.2}°: too little of the road's surface was seen"),
        };
        let height = match height {
            Some(height) => format!("height: {:.3} m ± {:.3} m", height.value, height.sigma),
            None => format!(
                "height kept at {:.3} m; `calibrate mount` measures it with --speed-mps, --distance-m or --lane-width-m",
                mount.height_m
            ),
        };
        let doubt = self.calibration.cadence_doubt().map(|doubt| doubt.to_string());
        let pitch = degrees("pitch (positive nose down)", pitch);
        [pitch, degrees("yaw (positive left)", yaw), roll, height].into_iter().chain(doubt).collect()
    }

    /// How many frames it is from.
    pub(crate) fn frames_line(&self) -> String {
        let MountCalibration { frames, frames_moving, frames_straight, frames_with_road, .. } =
            self.calibration;
        format!(
            "{frames} frames: {frames_moving} moving, {frames_straight} of them straight, {frames_with_road} with the road's surface"
        )
    }
}
