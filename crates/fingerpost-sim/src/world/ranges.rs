//! What a world is drawn from: every range, spread and share, in one place.
//!
//! Where nothing is cited the range is an assumption: wide enough that drives of others' vehicles, cameras and streets lie
//! within it, and no wider than what a road vehicle can have.

use crate::{Conditions, TrafficSide};

/// A vehicle that carries a camera. Lengths in metres.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Carrier {
    pub(super) wheelbase_m: [f64; 2],
    pub(super) width_m: [f64; 2],
    /// Of the rear axle's middle: half of the kerb-to-kerb turning circle on the data sheet, less half of the width and what
    /// the front wheels run outside of the rear ones.
    pub(super) turning_radius_m: [f64; 2],
    /// The camera's height above the road.
    pub(super) camera_height_m: [f64; 2],
    /// The camera's place forward of the rear axle.
    pub(super) camera_x_m: [f64; 2],
}

/// Cars from the smallest to large ones: wheelbases 2.4 to 2.9 m, turning circles 9.5 to 12 m.
pub(super) const CAR: Carrier = Carrier {
    wheelbase_m: [2.4, 2.9],
    width_m: [1.65, 1.95],
    turning_radius_m: [3.8, 5.2],
    camera_height_m: [1.0, 1.6],
    camera_x_m: [1.2, 2.2],
};
/// Vans: wheelbases 3.0 to 3.7 m, turning circles 11.5 to 14 m.
pub(super) const VAN: Carrier = Carrier {
    wheelbase_m: [3.0, 3.7],
    width_m: [1.9, 2.1],
    turning_radius_m: [4.8, 6.0],
    camera_height_m: [1.5, 2.2],
    camera_x_m: [2.0, 3.2],
};
/// Light lorries and small buses: wheelbases 3.6 to 4.2 m, turning circles 14 to 16 m.
const LORRY: Carrier = Carrier {
    wheelbase_m: [3.6, 4.2],
    width_m: [2.1, 2.4],
    turning_radius_m: [5.8, 6.8],
    camera_height_m: [2.0, 2.8],
    camera_x_m: [3.2, 4.6],
};
/// Vehicles by their share.
pub(super) const VEHICLES: [(f64, Carrier); 3] = [(0.5, CAR), (0.3, VAN), (0.2, LORRY)];

/// Speed on a straight street, m/s: 16 to 50 km/h, the usual limit in towns.
pub(super) const SPEED_MPS: [f64; 2] = [4.5, 13.9];
/// Standard deviation of a driver's place beside the lane's middle, metres: naturalistic studies of lane keeping find 0.2 to
/// 0.3 m.
pub(super) const ASIDE_SIGMA_M: f64 = 0.25;
/// Amplitude of the wander about that, metres.
pub(super) const WANDER_M: [f64; 2] = [0.03, 0.2];
/// How much wider than the road turns across the other lane are driven, share of the radius.
pub(super) const CORNER_CUTTING: [f64; 2] = [0.0, 0.35];
/// Sides of the road by their share: about a third of mankind lives where traffic keeps left.
pub(super) const TRAFFIC_SIDES: [(f64, TrafficSide); 2] =
    [(0.65, TrafficSide::Right), (0.35, TrafficSide::Left)];

/// Sizes of pictures, pixels: 4:3 and 16:9 at what cameras of vehicles are reduced to.
pub(super) const SIZES_PX: [(f64, [usize; 2]); 6] = [
    (1.0, [480, 270]),
    (1.0, [480, 360]),
    (1.0, [640, 360]),
    (1.0, [640, 480]),
    (1.0, [800, 450]),
    (1.0, [960, 540]),
];
/// Frames a second: from time-lapse dashcams to what video has.
pub(super) const FPS: [(f64, f64); 7] =
    [(1.0, 5.0), (1.0, 7.5), (1.0, 10.0), (1.0, 12.5), (1.0, 15.0), (1.0, 20.0), (1.0, 30.0)];
/// How cameras are aimed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct CameraRanges {
    /// Angle that the picture's width spans, degrees.
    pub(super) field_of_view_deg: [f64; 2],
    /// Pitch, degrees, nose down.
    pub(super) pitch_deg: [f64; 2],
    /// The picture's middle column shows the road from this far ahead of the camera or nearer, and to [`SHOWS_TO_M`] or farther,
    /// metres: a camera is aimed so that it shows a street, wherever it sits.
    pub(super) shows_from_m: f64,
}

/// Cameras of drives.
pub(super) const CAMERA: CameraRanges =
    CameraRanges { field_of_view_deg: [50.0, 110.0], pitch_deg: [2.0, 20.0], shows_from_m: 7.0 };
pub(super) const SHOWS_TO_M: f64 = 30.0;
/// Standard deviations of the direction that it is aimed in, degrees: yaw, and roll.
pub(super) const AIM_SIGMA_DEG: [f64; 2] = [1.0, 0.5];
/// How far left of the vehicle's middle it sits, metres: beside the mirror.
pub(super) const CAMERA_Y_M: [f64; 2] = [-0.35, 0.35];
/// Standard deviation of the principal point from the picture's middle, share of its width and height.
pub(super) const PRINCIPAL_POINT_SIGMA: f64 = 0.01;

/// Lenses.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum LensKind {
    /// None: a picture that was rectified, or a narrow lens.
    Pinhole,
    /// Brown-Conrady, a dashcam's barrel distortion.
    Barrel,
    /// Kannala-Brandt, about equidistant: a fisheye.
    Fisheye,
}
/// Lenses by their share.
pub(super) const LENSES: [(f64, LensKind); 3] =
    [(0.4, LensKind::Pinhole), (0.35, LensKind::Barrel), (0.25, LensKind::Fisheye)];
/// By how much a barrel lens draws in the middle of the picture's side edge, share. With more, the corners would lie beyond the
/// place at which a lens of one coefficient folds back.
pub(super) const BARREL: [f64; 2] = [0.01, 0.12];
/// First coefficient of a fisheye lens; the others are zero.
pub(super) const FISHEYE_K1: [f64; 2] = [-0.05, 0.03];

/// Standard deviation of the calibration's error in pitch, yaw and roll, degrees, and of its height, share: those of a mount
/// that was measured with a tape and a spirit level.
pub(super) const MOUNT_ERROR_DEG: f64 = 0.5;
pub(super) const HEIGHT_ERROR: f64 = 0.03;
/// Standard deviation of where the first frame is believed to be, metres along the route: a phone's GPS.
pub(super) const START_SIGMA_M: f64 = 5.0;
/// Where it is, metres along the route: three standard deviations of that.
pub(super) const START_M: f64 = 15.0;

/// Standard deviation of the logarithm of a street's width against the map's: 16 %, so that one in twenty is a third wider or a
/// quarter narrower. Few streets have a tagged width; the others have that of their class.
pub(super) const WIDTH_LOG_SIGMA: f64 = 0.16;
/// Largest shift of a whole neighbourhood of the map, metres, drawn from nought up: the imagery that maps are drawn from is off by
/// this much where it is not aligned.
pub(super) const SHIFT_M: f64 = 2.0;
/// Distance over which the shift changes, metres.
pub(super) const SHIFT_LENGTH_M: f64 = 180.0;
/// Standard deviation of a node's own error to the east and to the north, metres: a mapper's hand.
pub(super) const NODE_SIGMA_M: f64 = 0.25;
/// Share of the map's ways that nobody has mapped.
pub(super) const MISSING_WAYS: f64 = 0.05;
/// Share of the nodes inside a way at which the map has a side road that is not there: a path, a drive behind a gate, a road
/// that was planned.
pub(super) const INVENTED_ARMS: f64 = 0.02;
/// Length of such a road, metres, and its angle to the road that it leaves, degrees.
pub(super) const INVENTED_M: [f64; 2] = [20.0, 60.0];
pub(super) const INVENTED_DEG: [f64; 2] = [50.0, 130.0];

/// Length of a route and distance of its first feature from its start, metres: as in the drives of one world, and as much more as
/// the drive begins later.
pub(super) const ROUTE_M: [f64; 2] = [110.0, 270.0];
pub(super) const FIRST_FEATURE_M: [f64; 2] = [45.0, 90.0];

/// Days by their share.
pub(super) const DAYS: [(f64, Conditions); 7] = [
    (2.0, Conditions::CLEAR),
    (1.0, Conditions::UNMARKED),
    (1.5, Conditions::SHADOWS),
    (1.0, Conditions::WET),
    (1.0, Conditions::MIXED),
    (1.0, Conditions::DUSK),
    (0.5, Conditions::DUST),
];
/// Numbers of [`Conditions`] that are drawn in place of the day's. From those of `clear` or less to those of the day that has the
/// most.
pub(super) const UNDULATION_M: [f64; 2] = [0.0, 0.15];
pub(super) const SUSPENSION_RMS_RAD: [f64; 2] = [0.001, 0.005];
pub(super) const SUSPENSION_RAD_PER_MPS2: [f64; 2] = [0.001, 0.003];
pub(super) const NOISE_LEVELS: [f64; 2] = [0.5, 4.0];
pub(super) const VIGNETTE: [f64; 2] = [0.0, 0.35];
pub(super) const TREES_PER_100_M: [f64; 2] = [0.0, 14.0];
pub(super) const HOUSES_PER_100_M: [f64; 2] = [0.0, 4.0];
pub(super) const PAVEMENTS: [f64; 2] = [0.0, 0.8];
pub(super) const PARKED_PER_100_M: [f64; 2] = [0.0, 1.5];
/// Share of the paint that is gone.
pub(super) const WORN: [f64; 2] = [0.0, 0.6];
