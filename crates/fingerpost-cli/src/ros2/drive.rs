//! Picture after picture of a node, each with what was measured before it.

use std::path::Path;
use std::thread;
use std::time::{Duration, Instant};

use anyhow::Result;
use fingerpost::Sensors;
use fingerpost::vehicle_signals::VehicleSamples;
use fingerpost_io::bag::Picture;
use fingerpost_io::decode_picture;
use fingerpost_map::LatLon;
use fingerpost_record::FrameTime;
use fingerpost_ros2::{Arrival, RosNode};
use fingerpost_vision::picture::RgbImage;

use super::GLANCE;
use crate::driver::{Driver, FrameResult, pass_over};
use crate::interrupt::Interrupt;
use crate::output;
use crate::stage_clock::FrameClock;
use crate::watchdog::Watchdog;

/// What the last command has until the node ends: DDS sends from a thread of its own, which ends with it.
const FAREWELL: Duration = Duration::from_millis(100);

/// A drive whose pictures come as they are taken.
pub(super) struct RosDrive {
    driver: Driver,
    node: RosNode,
    /// Whether the vehicle's speed and yaw rate are listened to.
    has_twist: bool,
    /// Pictures still wanted.
    left: u64,
    watchdog: Watchdog,
    interrupt: Interrupt,
    /// Stamp of the first picture that could be used, nanoseconds.
    first_ns: Option<u64>,
    /// Time of the last one, seconds since the first.
    last_t_s: f64,
}

impl RosDrive {
    pub(super) fn new(
        driver: Driver,
        node: RosNode,
        has_twist: bool,
        most: Option<u64>,
        watchdog: Watchdog,
        interrupt: Interrupt,
    ) -> Self {
        let left = most.unwrap_or(u64::MAX);
        Self { driver, node, has_twist, left, watchdog, interrupt, first_ns: None, last_t_s: 0.0 }
    }

    /// Pictures that made room for later ones.
    pub(super) fn dropped(&self) -> u64 {
        self.node.dropped()
    }

    /// Says how many they are.
    pub(super) fn say_what_was_dropped(&self) {
        let dropped = self.dropped();
        if dropped > 0 {
            output::message(&format!(
                "{dropped} pictures came faster than they could be used, or before the calibration, and were passed over for later ones; \
                 send fewer or smaller ones, or let more wait (--queue)"
            ));
        }
    }

    /// Commands the vehicle to stop, because no more pictures will be used.
    pub(super) fn stop_vehicle(&self) {
        if let Err(cause) = self.node.stop() {
            output::message(&cause.to_string());
        }
        thread::sleep(FAREWELL);
    }

    /// Commands it because none could be used for long, once a silence.
    pub(super) fn watch(&mut self) {
        let Some(silence) = self.watchdog.silence(Instant::now()) else { return };
        // Where it cannot be sent it is tried again.
        if self.node.stop().is_ok() {
            self.watchdog.rest();
            output::message(&format!(
                "no new picture has come for {:.1} s: the vehicle is commanded to stop until one does",
                silence.as_secs_f64()
            ));
        }
    }

    /// The next picture; none when the user wants no more.
    fn wait(&mut self) -> Option<Arrival> {
        loop {
            if self.interrupt.wanted() {
                return None;
            }
            self.watch();
            let arrival = self.node.next(GLANCE);
            self.node.look_after().iter().for_each(|text| output::message(text));
            if arrival.is_some() {
                return arrival;
            }
        }
    }

    /// Runs the method on a picture and sends what it says.
    fn result(&mut self, arrival: Arrival) -> Result<FrameResult> {
        let Arrival { number, picture, gps, twist, came } = arrival;
        let mut clock = FrameClock::start();
        let decoded = picture.and_then(|(stamp_ns, picture)| {
            let picture = decoded(number, picture);
            let picture = picture.and_then(|picture| self.fitting(picture));
            // What did not even arrive as a picture is counted already.
            picture.inspect_err(|cause| self.node.refuse(cause)).map(|picture| (stamp_ns, picture))
        });
        clock.finished("decode");
        let (stamp_ns, picture) = match decoded {
            Ok(decoded) => decoded,
            Err(cause) => {
                let time = FrameTime { frame: number, t_s: self.last_t_s };
                return Ok(pass_over(time, cause.as_str()));
            }
        };
        let first_ns = *self.first_ns.get_or_insert(stamp_ns);
        let time = FrameTime { frame: number, t_s: stamp_ns.saturating_sub(first_ns) as f64 * 1e-9 };
        self.last_t_s = time.t_s;
        let signals = twist
            .and_then(|twist| VehicleSamples::of_now(Some(twist.speed_mps), Some(twist.yaw_rate_rps)))
            .or_else(|| self.has_twist.then(VehicleSamples::default));
        let gps = gps.and_then(|at| LatLon::new(at.lat_deg, at.lon_deg).ok());
        let sensors = Sensors { gps, signals, ..Sensors::default() };
        let node = &mut self.node;
        let mut result =
            self.driver.step_showing(time, &picture, sensors, &mut |scene| node.send(stamp_ns, scene))?;
        match &result.outcome {
            Ok(seen) => {
                node.note(&seen.record, came);
                self.watchdog.restart(came, time.t_s, Instant::now());
            }
            Err(cause) => node.refuse(cause),
        }
        result.stage_ms.extend(clock.stage_ms);
        Ok(result)
    }

    /// A picture of the calibration's size.
    fn fitting(&self, picture: RgbImage) -> Result<RgbImage, String> {
        if picture.size() == self.driver.input_px() {
            Ok(picture)
        } else {
            Err(self.driver.wrong_size(&picture).to_string())
        }
    }
}

/// The results of picture after picture.
impl Iterator for RosDrive {
    type Item = Result<FrameResult>;

    fn next(&mut self) -> Option<Self::Item> {
        let arrival = self.left.checked_sub(1).and_then(|left| {
            self.left = left;
            self.wait()
        });
        let result = arrival.map(|arrival| self.result(arrival));
        // Before the results that still wait are written, which may take long.
        if !matches!(result, Some(Ok(_))) {
            self.stop_vehicle();
        }
        result
    }
}

fn decoded(number: u64, picture: Picture) -> Result<RgbImage, String> {
    match picture {
        Picture::Raw(pixels) => Ok(pixels),
        Picture::Jpeg(bytes) | Picture::Png(bytes) => {
            let name = format!("picture {number}");
            decode_picture(&bytes, Path::new(&name)).map_err(|cause| cause.to_string())
        }
    }
}
