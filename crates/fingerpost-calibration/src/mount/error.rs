//! Why a drive does not show the mount.

use std::fmt::{self, Display, Formatter};

use fingerpost_geometry::GeometryError;
use fingerpost_vision::error::PictureError;
use thiserror::Error;

use super::{Estimated, KnownScale};

/// Frames that do not follow each other in one rhythm, by the way from each to the next.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct CadenceDoubt {
    /// Frames looked at.
    pub frames: usize,
    /// Frames that repeat the one before while the vehicle moves.
    pub repeated: usize,
    /// Frames that are missing between others, if the ways are read rightly.
    pub missing: usize,
}

impl Display for CadenceDoubt {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let Self { frames, repeated, missing } = self;
        if *repeated + *missing == 0 {
            return write!(f, "whether the vehicle stood in some of the {frames} frames cannot be seen");
        }
        if *repeated > 0 {
            write!(f, "{repeated} of {frames} frames repeat the one before")?;
        }
        if *repeated > 0 && *missing > 0 {
            f.write_str(", and ")?;
        }
        if *missing > 0 {
            write!(
                f,
                "the way between some of the {frames} frames is as long as if {missing} were missing; whether they are, or the road's motion \
                 is misread there, is not known"
            )?;
        }
        Ok(())
    }
}

/// What gives the height in place of what was given.
const fn in_place_of(given: KnownScale) -> &'static str {
    match given {
        KnownScale::DistanceM(_) => {
            "the width of the lane in place of the distance, or a drive on a road with more texture, or, if frames were lost or filled in, \
             the recording as the camera made it"
        }
        KnownScale::SpeedMps(_) | KnownScale::Nothing => {
            "the width of the lane or the distance driven in place of the speed, or a drive on a road with more texture, or, if frames were \
             lost or filled in, the recording as the camera made it, with the time of each frame"
        }
    }
}

/// The name of what was given.
const fn name_of(given: KnownScale) -> &'static str {
    match given {
        KnownScale::DistanceM(_) => "distance",
        KnownScale::SpeedMps(_) | KnownScale::Nothing => "speed",
    }
}

/// A drive that does not show the mount.
#[derive(Debug, Error)]
pub enum CalibrationError {
    /// A camera known by points has no mount.
    #[error(
        "a camera known by four points has no mount to calibrate; give a calibration with [intrinsics] and [mount]"
    )]
    NoIntrinsics,
    /// Too few frames show a straight drive.
    #[error(
        "{straight} of {frames} frames show the vehicle driving straight ahead ({moving} show it moving at all) and {needed} \
         are needed; give a longer drive on a straight road, at more than walking speed, in daylight"
    )]
    TooLittleStraight {
        /// Frames looked at.
        frames: usize,
        /// Frames with enough motion.
        moving: usize,
        /// Straight ones of them.
        straight: usize,
        /// Straight frames needed.
        needed: usize,
    },
    /// The frames contradict each other.
    #[error(
        "the {angle} is only known to {sigma_deg:.2} degrees and {most_deg} are needed; give a longer drive on a straight, \
         even road with steady speed"
    )]
    Uncertain {
        /// Which angle.
        angle: &'static str,
        /// Its standard deviation, degrees.
        sigma_deg: f64,
        /// The largest that is trusted, degrees.
        most_deg: f64,
    },
    /// The direction of travel does not point ahead.
    #[error(
        "the camera would look {away_deg:.0} degrees away from the direction of driving; check that the drive is of a camera \
         that looks forward and that the intrinsics are its own"
    )]
    NotForward {
        /// Angle between the camera's axis and the direction of travel, degrees.
        away_deg: f64,
    },
    /// The road was not seen well enough for the height.
    #[error(
        "the road's own motion is seen in {found} frames and {needed} are needed for the height; give a drive on a road with \
         texture, or leave the known length out"
    )]
    NoRoad {
        /// Frames with the road's plane.
        found: usize,
        /// Frames needed.
        needed: usize,
    },
    /// Frames repeat others or may be missing, so that nobody knows how long the drive took, or how far it went.
    #[error(
        "{doubt}; that leaves {:.0} % of the height open, and {:.0} % are trusted at the most; give {}",
        100.0 * .open, 100.0 * .most, in_place_of(*.given)
    )]
    UnevenFrames {
        /// What is known of the frames.
        doubt: CadenceDoubt,
        /// Share of the height that is open.
        open: f64,
        /// The largest that is trusted.
        most: f64,
        /// What the height was to come from.
        given: KnownScale,
    },
    /// The same frames show another way through the camera that comes of it.
    #[error(
        "with the camera {height_m:.3} m above the road the same frames show a way of {:.1} m ± {:.1} m, and {given_m:.1} m were given; \
         the road's motion is misread in one of two ways; give the width of the lane in place of the {}, or a drive on a road with more \
         texture, or measure the height by hand",
        .seen.value, .seen.sigma, name_of(*.given)
    )]
    AnotherWay {
        /// The height found, metres.
        height_m: f64,
        /// The way of the drive as given, metres.
        given_m: f64,
        /// The way that the camera shows.
        seen: Estimated,
        /// What the height was to come from.
        given: KnownScale,
    },
    /// No camera is so high or low.
    #[error(
        "the drive gives a camera {height_m:.3} m above the road, and {expected} is possible; either the road's motion is misread, as on \
         smooth asphalt, which a compressed video keeps where it was (take a drive on a road with more texture, or measure the height by \
         hand), or the camera's lens is another, or what was given is wrong: check the speed or distance that was given, and how long the \
         drive took: the number of its frames, their rate or their times"
    )]
    NoHeight {
        /// The height found, metres.
        height_m: f64,
        /// What would be accepted.
        expected: &'static str,
    },
    /// The angles found are none that a camera is mounted at.
    #[error(
        "the drive gives no mount that can be ({0}); give a longer drive of this camera, straight ahead on an even road"
    )]
    Mount(GeometryError),
    /// A frame has another size than the calibration says.
    #[error(transparent)]
    Frame(#[from] PictureError),
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refusal(given: KnownScale, repeated: usize, missing: usize) -> String {
        let doubt = CadenceDoubt { frames: 100, repeated, missing };
        CalibrationError::UnevenFrames { doubt, open: 0.2, most: 0.09, given }.to_string()
    }

    #[test]
    fn a_refused_height_asks_for_what_was_not_given() {
        let by_speed = refusal(KnownScale::SpeedMps(10.0), 20, 0);
        assert!(
            by_speed.starts_with("20 of 100 frames repeat the one before; that leaves 20 %"),
            "{by_speed}"
        );
        assert!(by_speed.contains("or the distance driven in place of the speed"), "{by_speed}");
        let at_rest = refusal(KnownScale::SpeedMps(10.0), 0, 0);
        assert!(at_rest.starts_with("whether the vehicle stood in some of the 100 frames"), "{at_rest}");
        let by_distance = refusal(KnownScale::DistanceM(90.0), 20, 0);
        assert!(by_distance.contains("the width of the lane in place of the distance"), "{by_distance}");
        assert!(!by_distance.contains("distance driven") && !by_distance.contains("speed"), "{by_distance}");
    }

    #[test]
    fn a_height_that_cannot_be_may_be_the_road_s_fault_and_not_what_was_given() {
        for height_m in [192.161, 20.1, 0.01] {
            let said = CalibrationError::NoHeight { height_m, expected: "0.05 to 20 metres above the road" }
                .to_string();
            let [road, given] =
                ["smooth asphalt", "check the speed or distance"].map(|cause| said.find(cause));
            assert!(road.is_some() && road < given, "the likelier cause comes first: {said}");
            assert!(said.contains("measure the height by hand"), "{said}");
        }
    }

    #[test]
    fn frames_that_only_seem_to_be_missing_are_not_said_to_be() {
        for (repeated, said) in
            [(0, "the way between"), (5, "5 of 100 frames repeat the one before, and the")]
        {
            let doubt = CadenceDoubt { frames: 100, repeated, missing: 41 }.to_string();
            assert!(doubt.starts_with(said) && doubt.contains("as long as if 41 were missing"), "{doubt}");
            assert!(doubt.ends_with("or the road's motion is misread there, is not known"), "{doubt}");
        }
    }
}
