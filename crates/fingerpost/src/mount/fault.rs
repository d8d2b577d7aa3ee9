//! Watching for a camera that has been turned.

use super::{MountAngle, MountFault};

/// Observations of an angle that are looked at together, about two seconds of driving: more than half of them must be
/// beyond what a mount does by itself.
const WATCHED: usize = 16;

/// Looks whether the last observations of one angle all differ from what was known.
#[derive(Debug, Clone)]
pub(super) struct AngleWatch {
    angle: MountAngle,
    moved_rad: f64,
    last: [f64; WATCHED],
    seen: usize,
}

impl AngleWatch {
    pub(super) fn new(angle: MountAngle, moved_rad: f64) -> Self {
        Self { angle, moved_rad, last: [0.0; WATCHED], seen: 0 }
    }

    /// Takes in an observation's difference from the slow angle, radians; the fault if the camera has been turned.
    pub(super) fn add(&mut self, difference_rad: f64) -> Option<MountFault> {
        self.last[self.seen % WATCHED] = difference_rad;
        self.seen += 1;
        if self.seen < WATCHED {
            return None;
        }
        let mut sorted = self.last;
        sorted.sort_unstable_by(f64::total_cmp);
        let median = 0.5 * (sorted[WATCHED / 2 - 1] + sorted[WATCHED / 2]);
        let beyond = self.last.iter().filter(|&&last| last * median.signum() > self.moved_rad).count();
        (median.abs() > self.moved_rad).then_some(MountFault {
            angle: self.angle,
            by_rad: median,
            frames_since: beyond,
        })
    }
}

/// Frames that a jump of the roll must last.
const JUMP_FRAMES: usize = 10;
/// Share of the summed roll that is left after a frame: a body that leans for seconds is not a camera that was turned.
const JUMP_KEPT: f64 = 0.99;

/// Sums the changes of the roll, which no frame shows as such: a camera that was turned stays turned.
#[derive(Debug, Clone)]
pub(super) struct RollJump {
    moved_rad: f64,
    sum_rad: f64,
    frames: usize,
}

impl RollJump {
    pub(super) fn new(moved_rad: f64) -> Self {
        Self { moved_rad, sum_rad: 0.0, frames: 0 }
    }

    /// Takes in a change of the roll, radians; the fault if the camera has been turned. A vehicle that turns leans, and its
    /// turn is easily taken for some roll, so nothing counts meanwhile: a camera that is turned just then is not noticed.
    pub(super) fn add(&mut self, change_rad: f64, is_turning: bool) -> Option<MountFault> {
        if is_turning {
            return None;
        }
        self.sum_rad = JUMP_KEPT * self.sum_rad + change_rad;
        if self.sum_rad.abs() <= self.moved_rad {
            self.frames = 0;
        } else {
            self.frames += 1;
        }
        (self.frames >= JUMP_FRAMES).then_some(MountFault {
            angle: MountAngle::Roll,
            by_rad: self.sum_rad,
            frames_since: self.frames,
        })
    }
}
