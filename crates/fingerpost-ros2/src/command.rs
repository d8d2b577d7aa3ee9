//! The advice as a command to a vehicle with Ackermann steering.

use std::time::Instant;

use fingerpost::advice::Advice;
use ros2_client::Publisher;

use crate::frames::BASE_LINK;
use crate::messages::{AckermannDrive, AckermannDriveStamped, Header};

/// Sends commands, and the one to stop when no pictures come.
pub(crate) struct Commands {
    to: Publisher<AckermannDriveStamped>,
    last: Option<Last>,
}

/// The last command that came of a picture.
#[derive(Debug, Clone, Copy)]
struct Last {
    stamp_ns: u64,
    steering_angle: f32,
    sent: Instant,
}

impl Commands {
    pub(crate) const fn new(to: Publisher<AckermannDriveStamped>) -> Self {
        Self { to, last: None }
    }

    /// Sends what is advised after the picture with that stamp.
    pub(crate) fn send(&mut self, stamp_ns: u64, advice: &Advice) {
        let command = command(stamp_ns, advice);
        let steering_angle = command.drive.steering_angle;
        self.last = Some(Last { stamp_ns, steering_angle, sent: Instant::now() });
        // Where a reader that confirms nothing leaves no room, the next picture's command is soon there.
        let _ = self.to.publish(command);
    }

    /// Sends the command to stop; none where nothing was commanded before.
    ///
    /// # Errors
    /// What DDS says where a reader that confirms nothing leaves no room for it.
    pub(crate) fn stop(&self) -> Result<(), String> {
        let Some(last) = &self.last else { return Ok(()) };
        self.to.publish(stop(last, Instant::now())).map_err(|cause| cause.to_string())
    }
}

/// The command for a picture: to stand where nothing leads.
fn command(stamp_ns: u64, advice: &Advice) -> AckermannDriveStamped {
    let is_led = advice.stop.is_none() && advice.line.is_some();
    let speed = if is_led { advice.speed_mps as f32 } else { 0.0 };
    of(stamp_ns, advice.steer_rad as f32, speed)
}

/// The command to stop, wheels as they are. Its stamp is in the clock of the pictures, whose time goes on without them: a vehicle that
/// leaves out what is old must not leave it out.
fn stop(last: &Last, now: Instant) -> AckermannDriveStamped {
    let since_ns = now.saturating_duration_since(last.sent).as_nanos();
    let since_ns = u64::try_from(since_ns).unwrap_or(u64::MAX);
    of(last.stamp_ns.saturating_add(since_ns), last.steering_angle, 0.0)
}

fn of(stamp_ns: u64, steering_angle: f32, speed: f32) -> AckermannDriveStamped {
    // The rates are zero, by the message's definition as fast as possible: how hard it brakes is the vehicle's own matter.
    let drive = AckermannDrive { steering_angle, speed, ..AckermannDrive::default() };
    AckermannDriveStamped { header: Header::new(stamp_ns, BASE_LINK), drive }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use fingerpost::advice::{LineKind, Stop};

    use super::*;
    use crate::messages::Time;

    fn advice() -> Advice {
        Advice { steer_rad: 0.25, speed_mps: 6.5, line: Some(LineKind::DrivingLine), ..Advice::default() }
    }

    #[test]
    fn what_is_advised_is_commanded_at_the_pictures_time() {
        let sent = command(7_000_000_003, &advice());
        assert_eq!(sent.header, Header { stamp: Time { sec: 7, nanosec: 3 }, frame_id: "base_link".into() });
        let expected = AckermannDrive { steering_angle: 0.25, speed: 6.5, ..AckermannDrive::default() };
        assert_eq!(sent.drive, expected);
    }

    #[test]
    fn where_nothing_leads_the_vehicle_stands() {
        for advice in [
            Advice { stop: Some(Stop::NoLine), ..advice() },
            Advice { line: None, ..advice() },
            Advice::default(),
        ] {
            assert_eq!(command(1, &advice).drive.speed.to_bits(), 0, "{advice:?}");
        }
    }

    #[test]
    fn a_stop_has_the_time_at_which_it_is_sent_and_leaves_the_wheels() {
        let last = Last { stamp_ns: 5_000_000_000, steering_angle: -0.125, sent: Instant::now() };
        let sent = stop(&last, last.sent + Duration::from_millis(750));
        assert_eq!(sent.header.stamp, Time { sec: 5, nanosec: 750_000_000 });
        assert_eq!(sent.drive, AckermannDrive { steering_angle: -0.125, ..AckermannDrive::default() });
    }
}
