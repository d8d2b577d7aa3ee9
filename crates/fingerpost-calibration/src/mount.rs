//! The mount from a drive: pitch and yaw from where the vehicle drives to, roll from the road, height from a known length.
//!
//! Every frame in which the vehicle moves shows its direction of travel in the picture, the focus of expansion; on average
//! over a drive that direction is parallel to the road, because what the suspension and waves of the road add comes and goes.
//! The road's own motion gives its plane, less precisely, and the way in heights of the camera: a known way then gives the
//! height.
//!
//! Limits: a drive that only accelerates, only climbs onto a ramp or is only a turn is biased or refused; a crowned road
//! looks rolled, so that a roll is only taken over when it is clearly one.

mod angles;
mod cadence;
mod error;
mod frame_intervals;
mod road_plane;
mod way;

use fingerpost::attitude::{BackCheck, RayPair, Sighting, Sightings, SparseSetting, angles_of_travel};
use fingerpost_geometry::{Camera, GeometryError, Mount, View};
use fingerpost_vision::picture::RgbImage;
use nalgebra::Vector3;

use self::angles::{joined, pitch_of_travel, road_angles, yaw_of_travel};
use self::road_plane::{AHEAD_M, PlaneFit, RoadPlane};
use self::way::{Way, typical_way, way};

pub use self::error::{CadenceDoubt, CalibrationError};

/// What is known of the drive, for the camera's height.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum KnownScale {
    /// Nothing: the height stays as configured.
    Nothing,
    /// The vehicle's mean speed over the drive, metres a second.
    SpeedMps(f64),
    /// Distance driven from the first frame to the last, metres.
    DistanceM(f64),
}

/// An angle or height with its standard deviation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimated {
    /// Radians or metres.
    pub value: f64,
    /// Standard deviation, in the same unit; never zero.
    pub sigma: f64,
}

/// A mount as a drive shows it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MountCalibration {
    /// The whole mount: what could not be measured is as configured.
    pub mount: Mount,
    /// Pitch, radians, positive nose down.
    pub pitch: Estimated,
    /// Yaw, radians, positive left.
    pub yaw: Estimated,
    /// Roll as the road showed it, radians, positive left side up; none where too little road was seen. The mount has it
    /// only where [`MountCalibration::roll_taken_over`] says so.
    pub roll: Option<Estimated>,
    /// Whether the roll differs from the configured one by more than a crowned road explains.
    pub roll_taken_over: bool,
    /// Height, metres; none where no length is known and the mount has the configured one.
    pub height: Option<Estimated>,
    /// Pitch as the direction of travel alone shows it, radians.
    pub travel_pitch: Estimated,
    /// Pitch as the road's plane alone shows it, radians, for comparison; none where too little road was seen.
    pub road_pitch: Option<Estimated>,
    /// Distance driven, metres, with the mount's height; none where too little road was seen.
    pub distance_m: Option<f64>,
    /// Frames looked at.
    pub frames: usize,
    /// Frames in which the vehicle moved far enough for a direction, and of those the straight ones.
    pub frames_moving: usize,
    /// Straight ones of them.
    pub frames_straight: usize,
    /// Frames in which the road's plane was seen.
    pub frames_with_road: usize,
    /// Frames that repeat the one before while the vehicle moves.
    pub frames_repeated: usize,
    /// Frames that are missing between others, if the ways from frame to frame are read rightly.
    pub frames_missing: usize,
}

impl MountCalibration {
    /// The camera on the mount that was found.
    ///
    /// # Errors
    /// [`CalibrationError::NoHeight`] or [`CalibrationError::Mount`] when no camera is mounted so.
    pub fn camera_on_mount(&self, camera: &Camera) -> Result<Camera, CalibrationError> {
        camera.with_mount(self.mount).map_err(|cause| match (self.height, cause) {
            (Some(height), GeometryError::OutOfRange { name: "mount.height_m", expected, .. }) => {
                CalibrationError::NoHeight { height_m: height.value, expected }
            }
            (_, cause) => CalibrationError::Mount(cause),
        })
    }

    /// What is not known of the frames' rhythm; none where every frame comes once and none is missing.
    #[must_use]
    pub fn cadence_doubt(&self) -> Option<CadenceDoubt> {
        let (repeated, missing) = (self.frames_repeated, self.frames_missing);
        (repeated + missing > 0).then_some(CadenceDoubt { frames: self.frames, repeated, missing })
    }

    /// Holds the mount against the way that the same frames show through a camera on it, `seen` by
    /// [`DrivenWay`](crate::DrivenWay): the one that was given, where the height comes of that.
    ///
    /// # Errors
    /// [`CalibrationError::AnotherWay`] where the two are farther apart than both leave open.
    pub fn held_against(&self, seen: Estimated, known: KnownScale) -> Result<(), CalibrationError> {
        let (Some(height), Some(given_m)) = (self.height, self.distance_m) else { return Ok(()) };
        // At the strip's middle a pitch that is off lengthens the way by twice its share of the angle to there.
        let by_pitch = 2.0 * STRIP_M / height.value * self.pitch.sigma;
        let share = libm::hypot(height.sigma / height.value, by_pitch);
        let sigma_m = libm::hypot(seen.sigma, share * given_m);
        if (seen.value - given_m).abs() <= WAY_SIGMAS * sigma_m {
            return Ok(());
        }
        Err(CalibrationError::AnotherWay { height_m: height.value, given_m, seen, given: known })
    }

    /// The same with the height at which a lane that is `lane_width_m` wide looks as wide as it was `seen`, metres, by
    /// [`LaneWidth`](crate::LaneWidth) through a camera on [`MountCalibration::mount`].
    #[must_use]
    pub fn with_lane_width(self, seen: Estimated, lane_width_m: f64) -> Self {
        let value = self.mount.height_m * lane_width_m / seen.value;
        let height = Estimated { value, sigma: value * seen.sigma / seen.value };
        let share = height.value / self.mount.height_m;
        Self {
            mount: Mount { height_m: height.value, ..self.mount },
            height: Some(height),
            distance_m: self.distance_m.map(|distance_m| distance_m * share),
            ..self
        }
    }
}

/// Full size and all corners checked: precision counts here, time does not.
const PRECISE: SparseSetting =
    SparseSetting { find_level: 0, cell_px: 20, follow_level: 0, iterations: 10, check: BackCheck::All };
/// Straight frames that are needed: two seconds at ten frames a second.
const LEAST_STRAIGHT: usize = 20;
/// Frames with the road's plane that roll and height need.
const LEAST_ROAD: usize = 10;
/// Largest standard deviations of pitch and yaw that are trusted, degrees: at 0.3 a place 10 m ahead is 3 % off.
const MOST_SIGMA_DEG: f64 = 0.3;
/// Farthest that the direction of travel may be from the camera's axis, degrees.
const MOST_AWAY_DEG: f64 = 60.0;
/// A thing that moved by less stayed where it was, radians: a few hundredths of a pixel, as far as corners are followed.
const STILL_RAD: f64 = 1e-4;
/// Standard deviations by which the way that was given and the one that the camera shows may be apart.
const WAY_SIGMAS: f64 = 3.0;
/// About how far from the camera the middle of the road lies that shows the way, metres.
const STRIP_M: f64 = 7.0;
/// A roll that differs from the configured one by more standard deviations is taken over.
const ROLL_SIGMAS: f64 = 2.0;
const DEGREE: f64 = std::f64::consts::PI / 180.0;

/// One frame's contribution.
#[derive(Debug, Clone, Copy)]
struct Look {
    t_s: f64,
    sighting: Option<Sighting>,
    plane: Option<RoadPlane>,
    /// Whether the picture is the one before.
    is_still: bool,
}

/// Calibrates a mount, frame by frame.
#[derive(Debug)]
pub struct MountCalibrator {
    /// On the mount that the directions of travel so far show.
    camera: Camera,
    /// The mount at the start.
    mount: Mount,
    sightings: Sightings,
    planes: PlaneFit,
    looks: Vec<Look>,
    /// Sum of the directions of travel so far, for where the road is looked for.
    travel: Vector3<f64>,
}

impl MountCalibrator {
    /// A calibrator for the camera's lens; its mount is where the search begins.
    ///
    /// # Errors
    /// [`CalibrationError::NoIntrinsics`] for a camera known by points.
    pub fn new(camera: &Camera) -> Result<Self, CalibrationError> {
        let View::Calibrated { mount, .. } = camera.view() else {
            return Err(CalibrationError::NoIntrinsics);
        };
        Ok(Self {
            mount: *mount,
            camera: camera.clone(),
            sightings: Sightings::new(PRECISE),
            planes: PlaneFit::default(),
            looks: Vec::new(),
            travel: Vector3::zeros(),
        })
    }

    /// Takes in the next frame, `t_s` seconds after the first.
    ///
    /// # Errors
    /// [`CalibrationError::Frame`] when the frame has not the camera's size.
    pub fn add(&mut self, frame: &RgbImage, t_s: f64) -> Result<(), CalibrationError> {
        let look = match self.sightings.look_at(&self.camera, frame)? {
            None => Look { t_s, sighting: None, plane: None, is_still: false },
            Some((sighting, pairs)) => {
                let is_still = is_still(pairs);
                if sighting.moves {
                    self.travel += sighting.motion.travel.into_inner();
                }
                let seen_mount = self.travel.try_normalize(1e-9).map(|travel| {
                    let travel = nalgebra::Unit::new_unchecked(travel);
                    let (pitch_rad, yaw_rad) = angles_of_travel(&travel, self.mount.roll_rad);
                    Mount { pitch_rad, yaw_rad, ..self.mount }
                });
                let plane = seen_mount.filter(|_| sighting.moves).and_then(|mount| {
                    self.planes.fit(pairs, &sighting.motion, road_normal(&mount), self.mount.height_m)
                });
                // The next direction is looked for about those that were seen: about one that is far off it is not found, or only halfway.
                if let Some(Ok(camera)) = seen_mount.map(|mount| self.camera.with_mount(mount)) {
                    self.camera = camera;
                }
                Look { t_s, sighting: Some(sighting), plane, is_still }
            }
        };
        self.looks.push(look);
        Ok(())
    }

    /// The mount that the drive shows; whether a camera can sit so, [`MountCalibration::camera_on_mount`] says.
    ///
    /// # Errors
    /// [`CalibrationError`] when the drive does not show it well enough to be trusted.
    pub fn finish(&self, known: KnownScale) -> Result<MountCalibration, CalibrationError> {
        let moving: Vec<&Sighting> =
            self.looks.iter().filter_map(|look| look.sighting.as_ref()).filter(|s| s.moves).collect();
        let straight: Vec<&Sighting> = moving.iter().copied().filter(|s| s.is_straight()).collect();
        if straight.len() < LEAST_STRAIGHT {
            return Err(CalibrationError::TooLittleStraight {
                frames: self.looks.len(),
                moving: moving.len(),
                straight: straight.len(),
                needed: LEAST_STRAIGHT,
            });
        }
        let roads: Vec<RoadPlane> = self.looks.iter().filter_map(|look| look.plane).collect();
        let (road_pitch, roll) = road_angles(&roads).unzip();
        let mut mount = self.mount;
        let roll_taken_over =
            roll.is_some_and(|roll| (roll.value - mount.roll_rad).abs() > ROLL_SIGMAS * roll.sigma);
        if let Some(roll) = roll.filter(|_| roll_taken_over) {
            mount.roll_rad = roll.value;
        }
        let way_heights = typical_way(&roads, &road_normal(&self.mount)).unwrap_or(1.0 / mount.height_m);
        let travel_pitch = pitch_of_travel(&moving, mount.roll_rad);
        let yaw = yaw_of_travel(&straight, &mount, way_heights * mount.height_m);
        let pitch = road_pitch.map_or(travel_pitch, |road| joined(travel_pitch, road));
        (mount.pitch_rad, mount.yaw_rad) = (pitch.value, yaw.value);
        for (angle, estimated) in [("pitch", pitch), ("yaw", yaw)] {
            let sigma_deg = estimated.sigma / DEGREE;
            if sigma_deg > MOST_SIGMA_DEG {
                return Err(CalibrationError::Uncertain { angle, sigma_deg, most_deg: MOST_SIGMA_DEG });
            }
        }
        let away_deg = libm::acos(libm::cos(mount.pitch_rad) * libm::cos(mount.yaw_rad)) / DEGREE;
        if away_deg > MOST_AWAY_DEG {
            return Err(CalibrationError::NotForward { away_deg });
        }
        let way = way(&self.looks, &road_normal(&mount), self.mount.height_m);
        let height = self.height(way, known)?;
        if let Some(height) = height {
            mount.height_m = height.value;
        }
        Ok(MountCalibration {
            mount,
            pitch,
            yaw,
            roll,
            roll_taken_over,
            height,
            travel_pitch,
            road_pitch,
            distance_m: way.map(|way| way.heights * mount.height_m),
            frames: self.looks.len(),
            frames_moving: moving.len(),
            frames_straight: straight.len(),
            frames_with_road: roads.len(),
            frames_repeated: way.map_or(0, |way| way.repeated),
            frames_missing: way.map_or(0, |way| way.missing),
        })
    }

    /// The height at which the way is as long as is known, where the frames leave little of it open; none where nothing is known.
    fn height(&self, way: Option<Way>, known: KnownScale) -> Result<Option<Estimated>, CalibrationError> {
        let (way_m, open_by): (f64, fn(&Way) -> f64) = match known {
            KnownScale::Nothing => return Ok(None),
            KnownScale::SpeedMps(speed_mps) => (speed_mps * self.duration_s(), Way::open_by_speed),
            KnownScale::DistanceM(distance_m) => (distance_m, Way::open_by_distance),
        };
        let found = self.looks.iter().filter(|look| look.plane.is_some()).count();
        let way = way.ok_or(CalibrationError::NoRoad { found, needed: LEAST_ROAD })?;
        let (open, most) = (open_by(&way), self.most_open());
        if open > most {
            let doubt =
                CadenceDoubt { frames: self.looks.len(), repeated: way.repeated, missing: way.missing };
            return Err(CalibrationError::UnevenFrames { doubt, open, most, given: known });
        }
        Ok(Some(way.height(way_m, open)))
    }

    /// Largest share of the height that repeated and missing frames may leave open: a height that is off moves what is seen on the road by
    /// as much as the largest error of the pitch that is trusted moves the farthest road that is looked at.
    fn most_open(&self) -> f64 {
        MOST_SIGMA_DEG * DEGREE * AHEAD_M[1] / self.mount.height_m
    }

    /// Time from the first frame to the last, seconds.
    fn duration_s(&self) -> f64 {
        let times = self.looks.first().zip(self.looks.last());
        times.map_or(0.0, |(first, last)| last.t_s - first.t_s)
    }
}

/// Whether a picture shows nothing in another place than the one before: three in four things may not have moved, as those that other
/// vehicles carry do. Noise alone moves them by more in most pictures.
fn is_still(pairs: &[RayPair]) -> bool {
    let still = pairs.iter().filter(|pair| (pair.current - pair.previous).norm() < STILL_RAD).count();
    !pairs.is_empty() && 4 * still >= 3 * pairs.len()
}

/// The road's normal in the camera frame, towards the road.
fn road_normal(mount: &Mount) -> Vector3<f64> {
    mount.vehicle_from_camera().rotation.inverse() * -Vector3::z()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_height_whose_camera_shows_another_way_than_was_given_is_refused() {
        let of = |value: f64, sigma: f64| Estimated { value, sigma };
        let mut found = MountCalibration {
            mount: Mount::level(1.6),
            pitch: of(0.0, 0.1 * DEGREE),
            yaw: of(0.0, 0.1 * DEGREE),
            roll: None,
            roll_taken_over: false,
            height: Some(of(1.6, 0.064)),
            travel_pitch: of(0.0, 0.1 * DEGREE),
            road_pitch: None,
            distance_m: Some(69.6),
            frames: 61,
            frames_moving: 60,
            frames_straight: 60,
            frames_with_road: 60,
            frames_repeated: 0,
            frames_missing: 0,
        };
        for (seen_m, sigma_m, is_held) in [
            (69.6, 1.0, true),
            (75.0, 1.0, true),
            (64.0, 1.0, true),
            (95.4, 1.5, false),
            (40.0, 1.0, false),
            // A way of which frames show nothing says nothing.
            (0.0, 300.0, true),
            (95.4, 20.0, true),
        ] {
            for known in [KnownScale::SpeedMps(29.0), KnownScale::DistanceM(69.6)] {
                let held = found.held_against(of(seen_m, sigma_m), known);
                assert_eq!(held.is_ok(), is_held, "{seen_m}");
                let Err(refused) = held.map_err(|error| error.to_string()) else { continue };
                let given = if known == KnownScale::DistanceM(69.6) { "distance" } else { "speed" };
                assert!(refused.contains(&format!("{seen_m:.1} m ± {sigma_m:.1} m")), "{refused}");
                assert!(refused.contains(&format!("width of the lane in place of the {given}")), "{refused}");
            }
        }
        found.height = None;
        assert!(found.held_against(of(95.4, 1.5), KnownScale::Nothing).is_ok());
    }
}
