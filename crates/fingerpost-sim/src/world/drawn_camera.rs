//! The camera of a world, and what its calibration says of it.

use fingerpost_geometry::{Camera, Distortion, GeometryError, Intrinsics, Mount};
use nalgebra::Vector3;

use super::log_between;
use super::ranges::{self, CameraRanges, Carrier, LensKind};
use crate::SimError;
use crate::noise::Stream;

/// The camera that looks, and the one that is known.
#[derive(Debug, Clone)]
pub(super) struct DrawnCamera {
    pub(super) camera: Camera,
    pub(super) calibration: Camera,
}

/// Draws until the picture shows enough of the road; about one in three does.
const ATTEMPTS: usize = 1000;

impl DrawnCamera {
    /// A camera on a vehicle, aimed as `aims` say, of a size if one is given.
    pub(super) fn draw(
        stream: &mut Stream,
        carrier: &Carrier,
        aims: &CameraRanges,
        size_px: Option<[usize; 2]>,
    ) -> Result<Self, SimError> {
        let drawn_px = stream.choose(&ranges::SIZES_PX).unwrap_or([640, 480]);
        let size_px = size_px.unwrap_or(drawn_px);
        for _ in 0..ATTEMPTS {
            let mount = mount(stream, carrier, aims);
            let lens = stream.choose(&ranges::LENSES).unwrap_or(LensKind::Pinhole);
            let (intrinsics, distortion) = lens_of(stream, lens, aims, size_px)?;
            let calibrated =
                |mount: Mount| Camera::calibrated(size_px[0], size_px[1], intrinsics, distortion, mount);
            let calibration = calibrated(mount)?;
            let camera = calibrated(true_mount(stream, &mount))?;
            if shows_a_street(&calibration, &mount, aims) {
                return Ok(Self { camera, calibration });
            }
        }
        Err(SimError::NoDrawnCamera { width: size_px[0], height: size_px[1] })
    }
}

fn mount(stream: &mut Stream, carrier: &Carrier, aims: &CameraRanges) -> Mount {
    let [yaw_sigma_deg, roll_sigma_deg] = ranges::AIM_SIGMA_DEG;
    let mut within = |range: [f64; 2]| stream.between(range[0], range[1]);
    let (height_m, x_m) = (within(carrier.camera_height_m), within(carrier.camera_x_m));
    let (y_m, pitch_deg) = (within(ranges::CAMERA_Y_M), within(aims.pitch_deg));
    Mount {
        height_m,
        pitch_rad: pitch_deg.to_radians(),
        yaw_rad: stream.normal(yaw_sigma_deg).to_radians(),
        roll_rad: stream.normal(roll_sigma_deg).to_radians(),
        x_m,
        y_m,
    }
}

/// The mount of which `known` is the calibration.
fn true_mount(stream: &mut Stream, known: &Mount) -> Mount {
    let mut off_rad = || stream.normal(ranges::MOUNT_ERROR_DEG).to_radians();
    let [pitch_rad, yaw_rad, roll_rad] = [off_rad(), off_rad(), off_rad()];
    Mount {
        height_m: known.height_m * (1.0 + stream.normal(ranges::HEIGHT_ERROR)),
        pitch_rad: known.pitch_rad + pitch_rad,
        yaw_rad: known.yaw_rad + yaw_rad,
        roll_rad: known.roll_rad + roll_rad,
        ..*known
    }
}

/// A lens whose picture's width spans a drawn angle.
fn lens_of(
    stream: &mut Stream,
    lens: LensKind,
    aims: &CameraRanges,
    [width, height]: [usize; 2],
) -> Result<(Intrinsics, Distortion), GeometryError> {
    let field_rad = log_between(stream, aims.field_of_view_deg).to_radians();
    let edge = libm::tan(0.5 * field_rad);
    let distortion = match lens {
        LensKind::Pinhole => Distortion::None,
        LensKind::Barrel => {
            let drawn_in = stream.between(ranges::BARREL[0], ranges::BARREL[1]);
            Distortion::brown_conrady(&[-drawn_in / (edge * edge), 0.0, 0.0, 0.0])?
        }
        LensKind::Fisheye => {
            let k1 = stream.between(ranges::FISHEYE_K1[0], ranges::FISHEYE_K1[1]);
            Distortion::kannala_brandt(&[k1, 0.0, 0.0, 0.0])?
        }
    };
    // Every direction within the field of view is one that the lens sees.
    let shown = distortion.distort(Vector3::new(edge, 0.0, 1.0)).map_or(edge, |p| p.x);
    let (w, h) = (width as f64, height as f64);
    let focal_px = 0.5 * w / shown;
    let mut middle = |side: f64| 0.5 * (side - 1.0) + stream.normal(ranges::PRINCIPAL_POINT_SIGMA) * side;
    Ok((Intrinsics { fx: focal_px, fy: focal_px, cx: middle(w), cy: middle(h) }, distortion))
}

/// Whether the picture's middle column shows the road from near enough to far enough.
fn shows_a_street(camera: &Camera, mount: &Mount, aims: &CameraRanges) -> bool {
    let shown = |ahead_m: f64| {
        let on_road =
            nalgebra::Point2::new(mount.x_m + ahead_m, mount.y_m + ahead_m * libm::tan(mount.yaw_rad));
        camera.pixel_of_ground(on_road).is_some_and(|pixel| camera.contains(pixel))
    };
    shown(aims.shows_from_m) && shown(ranges::SHOWS_TO_M)
}
