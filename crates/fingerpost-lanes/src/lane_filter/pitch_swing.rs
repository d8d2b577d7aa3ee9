//! What becomes of the camera's pitch from one frame to the next.

use fingerpost_geometry::ObservedAngle;

/// How much the suspension swings the pitch in a second, radians.
const PITCH_WALK_RAD: f64 = 0.0045;
/// How much in a second the slope of the road ahead changes against a camera whose turning is seen, radians.
const SLOPE_WALK_RAD: f64 = 0.003;
/// Time in which the pitch swings back to its mean, seconds.
const PITCH_RETURN_S: f64 = 0.6;

/// What becomes of the pitch over a frame.
pub(super) struct PitchSwing {
    /// Share of the way back to its mean.
    pub(super) returned: f64,
    /// What is added to it.
    pub(super) seen_rad: f64,
    pub(super) variance_rad2: f64,
}

impl PitchSwing {
    /// The suspension's swing and the change that the picture shows, each as far as it is the surer one.
    pub(super) fn over(dt_s: f64, seen: Option<ObservedAngle>) -> Self {
        let swing_rad2 = PITCH_WALK_RAD * PITCH_WALK_RAD * dt_s;
        let (angle_rad, share) = seen.map_or((0.0, 0.0), |seen| {
            let seen_rad2 = seen.variance_rad2 + SLOPE_WALK_RAD * SLOPE_WALK_RAD * dt_s;
            (seen.angle_rad, swing_rad2 / (swing_rad2 + seen_rad2))
        });
        Self {
            returned: (1.0 - share) * (1.0 - libm::exp(-dt_s / PITCH_RETURN_S)),
            seen_rad: share * angle_rad,
            variance_rad2: (1.0 - share) * swing_rad2,
        }
    }
}
