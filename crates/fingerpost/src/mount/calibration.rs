//! The mount from a drive: pitch and yaw from where the vehicle drives to, roll from the road, height from a known length.
//!
//! Every frame in which the vehicle moves shows its direction of travel in the picture, the focus of expansion; on average
//! over a drive that direction is parallel to the road, because what the suspension and waves of the road add comes and goes.
//! The road's own motion gives its plane, less precisely, and the way in heights of the camera: a known way then gives the
//! height.
//!
//! Limits: a drive that only accelerates, only climbs onto a ramp or is only a turn is biased or refused; a crowned road
//! looks rolled, so that a roll is only taken over when it is clearly one.

use fingerpost_geometry::{Camera, GeometryError, Mount, View};
use fingerpost_vision::error::PictureError;
use fingerpost_vision::picture::RgbImage;
use nalgebra::Vector3;
use thiserror::Error;

use super::road_plane::{PlaneFit, RoadPlane};
use super::sighting::{Sighting, Sightings, angles_of_normal, angles_of_travel};
use super::sparse::{BackCheck, SparseSetting};

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
    /// The resulting mount cannot be right.
    #[error("the drive gives a mount that cannot be right: {0}")]
    Mount(#[from] GeometryError),
    /// A frame has another size than the calibration says.
    #[error(transparent)]
    Frame(#[from] PictureError),
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
/// Frames that share what a wave of the road or a push of the brakes does to them.
const BLOCK: usize = 10;
/// Standard deviation that no number of frames takes away: how far a vehicle's mean direction of travel is from the road's
/// plane and from its own axis (load, tyres, a side slope).
const TRAVEL_FLOOR_RAD: f64 = 0.1 * DEGREE;
/// The same of the road's plane: a street is crowned by 2.5 %, of which a lane shows a part, and its slope changes ahead.
const ROAD_PITCH_FLOOR_RAD: f64 = 0.3 * DEGREE;
const ROAD_ROLL_FLOOR_RAD: f64 = 0.7 * DEGREE;
/// A roll that differs from the configured one by more standard deviations is taken over.
const ROLL_SIGMAS: f64 = 2.0;
/// Place of the camera ahead of the rear axle, metres, where the calibration has none, and how far off it may be: in a bend
/// the camera moves towards the outside by this over the radius.
const USUAL_X_M: f64 = 1.5;
const X_SIGMA_M: f64 = 1.0;
/// Share of a measured length that texture and waves of the road leave uncertain.
const LENGTH_FLOOR: f64 = 0.01;
/// Median absolute deviation to standard deviation of a Gaussian.
const MAD_TO_SIGMA: f64 = 1.4826;
/// Frames further from the mean count as being there.
const OUTLIER_SIGMAS: f64 = 3.0;
const ITERATIONS: usize = 5;
const DEGREE: f64 = std::f64::consts::PI / 180.0;

/// One frame's contribution.
#[derive(Debug, Clone, Copy)]
struct Look {
    t_s: f64,
    sighting: Option<Sighting>,
    plane: Option<RoadPlane>,
}

/// Calibrates a mount, frame by frame.
#[derive(Debug)]
pub struct MountCalibrator {
    camera: Camera,
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
            None => Look { t_s, sighting: None, plane: None },
            Some((sighting, pairs)) => {
                if sighting.moves {
                    self.travel += sighting.motion.travel.into_inner();
                }
                let normal = self.travel.try_normalize(1e-9).map(|travel| {
                    let travel = nalgebra::Unit::new_unchecked(travel);
                    let (pitch_rad, yaw_rad) = angles_of_travel(&travel, self.mount.roll_rad);
                    road_normal(&Mount { pitch_rad, yaw_rad, ..self.mount })
                });
                let plane = normal
                    .filter(|_| sighting.moves)
                    .and_then(|normal| self.planes.fit(pairs, &sighting.motion, normal, self.mount.height_m));
                Look { t_s, sighting: Some(sighting), plane }
            }
        };
        self.looks.push(look);
        Ok(())
    }

    /// The mount that the drive shows.
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
        let away_deg = (mount.pitch_rad.cos() * mount.yaw_rad.cos()).acos() / DEGREE;
        if away_deg > MOST_AWAY_DEG {
            return Err(CalibrationError::NotForward { away_deg });
        }
        let way = self.way(&road_normal(&mount));
        let height = match known {
            KnownScale::Nothing => None,
            _ if way.is_none() => {
                return Err(CalibrationError::NoRoad { found: roads.len(), needed: LEAST_ROAD });
            }
            KnownScale::SpeedMps(speed_mps) => way.map(|way| way.height(speed_mps * self.duration_s())),
            KnownScale::DistanceM(distance_m) => way.map(|way| way.height(distance_m)),
        };
        if let Some(height) = height {
            mount.height_m = height.value;
        }
        mount.check()?;
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
        })
    }

    /// Time from the first frame to the last, seconds.
    fn duration_s(&self) -> f64 {
        let times = self.looks.first().zip(self.looks.last());
        times.map_or(0.0, |(first, last)| last.t_s - first.t_s)
    }

    /// The way of the whole drive in heights of the camera, when the road's normal is `normal`: as each frame shows it, and
    /// where one does not, as its neighbours do.
    fn way(&self, normal: &Vector3<f64>) -> Option<Way> {
        let seen: Vec<Option<f64>> = self
            .looks
            .iter()
            .map(|look| match (&look.plane, &look.sighting) {
                (Some(plane), _) => Some(plane.way_with_normal(normal)),
                // A vehicle that stands makes no way.
                (None, Some(sighting)) if !sighting.moves => Some(0.0),
                _ => None,
            })
            .collect();
        let count = seen.iter().flatten().filter(|way| **way > 0.0).count();
        if count < LEAST_ROAD {
            return None;
        }
        let steps: Vec<f64> = (1..seen.len()).map(|frame| middle_of_neighbours(&seen, frame)).collect();
        let heights: f64 = steps.iter().sum();
        // Differences of neighbours show the noise of a frame.
        let noise: f64 = seen
            .iter()
            .skip(1)
            .zip(&steps)
            .filter_map(|(seen, step)| Some((*seen)? - step))
            .map(|d| d * d)
            .sum();
        let sigma = (noise.sqrt() / heights).hypot(LENGTH_FLOOR);
        Some(Way { heights, sigma_share: sigma })
    }
}

/// A way in heights of the camera.
#[derive(Debug, Clone, Copy)]
struct Way {
    heights: f64,
    sigma_share: f64,
}

impl Way {
    fn height(&self, way_m: f64) -> Estimated {
        let value = way_m / self.heights;
        Estimated { value, sigma: value * self.sigma_share }
    }
}

/// Median of what a frame and its two neighbours to either side show; of the nearest that show something where they do not.
fn middle_of_neighbours(seen: &[Option<f64>], frame: usize) -> f64 {
    for reach in 2..seen.len().max(3) {
        let near = &seen[frame.saturating_sub(reach)..(frame + reach + 1).min(seen.len())];
        let mut values: Vec<f64> = near.iter().flatten().copied().collect();
        if !values.is_empty() {
            values.sort_unstable_by(f64::total_cmp);
            return values[values.len() / 2];
        }
    }
    0.0
}

/// The road's normal in the camera frame, towards the road.
fn road_normal(mount: &Mount) -> Vector3<f64> {
    mount.vehicle_from_camera().rotation.inverse() * -Vector3::z()
}

/// Way of a frame in heights of the camera, the median.
fn typical_way(roads: &[RoadPlane], normal: &Vector3<f64>) -> Option<f64> {
    let mut ways: Vec<f64> = roads.iter().map(|plane| plane.way_with_normal(normal)).collect();
    ways.sort_unstable_by(f64::total_cmp);
    ways.get(ways.len() / 2).copied()
}

/// Pitch from the directions of travel.
fn pitch_of_travel(moving: &[&Sighting], roll_rad: f64) -> Estimated {
    let seen: Vec<Estimated> = moving
        .iter()
        .map(|sighting| Estimated {
            value: angles_of_travel(&sighting.motion.travel, roll_rad).0,
            sigma: sighting.motion.travel_sigma_rad[0],
        })
        .collect();
    mean_of_drive(&seen, TRAVEL_FLOOR_RAD)
}

/// Yaw from the directions of travel: where the road bends, the camera, ahead of the rear axle, moves towards the outside.
fn yaw_of_travel(straight: &[&Sighting], mount: &Mount, way_m: f64) -> Estimated {
    let yaw = |sighting: &&Sighting| angles_of_travel(&sighting.motion.travel, mount.roll_rad).1;
    let middle = straight.iter().map(yaw).sum::<f64>() / straight.len() as f64;
    let x_m = if mount.x_m > 0.0 { mount.x_m } else { USUAL_X_M };
    // A line through yaw over curvature, its slope known roughly.
    let curvature = |sighting: &&Sighting| sighting.turn_rad / way_m;
    let mean = straight.iter().map(curvature).sum::<f64>() / straight.len() as f64;
    let (mut information, mut product) = ((TRAVEL_FLOOR_RAD / X_SIGMA_M).powi(2), 0.0);
    for sighting in straight {
        let from_mean = curvature(sighting) - mean;
        information += from_mean * from_mean;
        product += from_mean * (yaw(sighting) - middle + x_m * from_mean);
    }
    let lever_m = product / information - x_m;
    let seen: Vec<Estimated> = straight
        .iter()
        .map(|sighting| Estimated {
            value: yaw(sighting) - lever_m * curvature(sighting),
            sigma: sighting.motion.travel_sigma_rad[1],
        })
        .collect();
    mean_of_drive(&seen, TRAVEL_FLOOR_RAD)
}

/// Pitch and roll of the road's planes; none where too few frames show one.
fn road_angles(roads: &[RoadPlane]) -> Option<(Estimated, Estimated)> {
    if roads.len() < LEAST_ROAD {
        return None;
    }
    let angle = |of: fn((f64, f64)) -> f64, floor: f64| {
        let seen: Vec<Estimated> = roads
            .iter()
            .map(|plane| {
                let spread = plane.information.try_inverse().map_or(f64::INFINITY, |c| c.diagonal().max());
                Estimated { value: of(angles_of_normal(&plane.way)), sigma: spread.sqrt() / plane.way.norm() }
            })
            .collect();
        mean_of_drive(&seen, floor)
    };
    Some((
        angle(|(pitch_rad, _)| pitch_rad, ROAD_PITCH_FLOOR_RAD),
        angle(|(_, roll_rad)| roll_rad, ROAD_ROLL_FLOOR_RAD),
    ))
}

/// Mean over a drive, with outliers weighed down, and its standard deviation: that of the means of blocks of frames, because
/// neighbouring frames share their errors.
fn mean_of_drive(seen: &[Estimated], floor: f64) -> Estimated {
    let mut values: Vec<f64> = seen.iter().map(|frame| frame.value).collect();
    values.sort_unstable_by(f64::total_cmp);
    let median = values[values.len() / 2];
    values.iter_mut().for_each(|value| *value = (*value - median).abs());
    values.sort_unstable_by(f64::total_cmp);
    let scatter = (MAD_TO_SIGMA * values[values.len() / 2]).max(1e-4);
    let mut mean = median;
    let weight = |frame: &Estimated, mean: f64| {
        let away = (frame.value - mean).abs() / (OUTLIER_SIGMAS * scatter);
        let robust = if away > 1.0 { 1.0 / away } else { 1.0 };
        robust / (scatter * scatter + frame.sigma * frame.sigma)
    };
    let mean_about = |frames: &[Estimated], about: f64| {
        let total: f64 = frames.iter().map(|frame| weight(frame, about)).sum();
        (frames.iter().map(|frame| weight(frame, about) * frame.value).sum::<f64>() / total, total)
    };
    for _ in 0..ITERATIONS {
        mean = mean_about(seen, mean).0;
    }
    let blocks: Vec<(f64, f64)> = seen.chunks(BLOCK).map(|block| mean_about(block, mean)).collect();
    let total: f64 = blocks.iter().map(|(_, weight)| weight).sum();
    let squares: f64 = blocks.iter().map(|(block, weight)| (weight * (block - mean)).powi(2)).sum();
    let count = blocks.len() as f64;
    let of_mean = if count > 1.0 { (squares * count / (count - 1.0)).sqrt() / total } else { scatter };
    Estimated { value: mean, sigma: of_mean.hypot(floor) }
}

/// Two estimates of the same angle as one.
fn joined(a: Estimated, b: Estimated) -> Estimated {
    let (of_a, of_b) = (a.sigma.powi(-2), b.sigma.powi(-2));
    Estimated {
        value: (of_a * a.value + of_b * b.value) / (of_a + of_b),
        sigma: (of_a + of_b).sqrt().recip(),
    }
}
