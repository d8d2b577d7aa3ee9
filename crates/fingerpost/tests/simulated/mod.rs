//! Ground views of simulated drives, where every step is known, and how far off a motion estimator is there.
#![allow(unreachable_pub, dead_code, reason = "shared by several test programs, each of which uses a part")]
#![allow(clippy::unwrap_used, reason = "a failed expectation is a failed test")]

use fingerpost::attitude::{AttitudeObservation, AttitudeWatch};
use fingerpost::ground_view::{GroundPicture, GroundView, GroundViewConfig};
use fingerpost::motion::{Motion, MotionEstimator};
use fingerpost_geometry::{Camera, Distortion, Intrinsics, Mount, wrap_angle};
use fingerpost_map::{OsmData, RoadGraph, read_route};
use fingerpost_sim::{Conditions, SimConfig, Simulator};
use fingerpost_vision::colour::HueSaturationBins;
use nalgebra::{Isometry2, Vector2, Vector3};

pub const BINS: HueSaturationBins = HueSaturationBins { hue: 32, saturation: 32 };

pub fn camera() -> Camera {
    let intrinsics = Intrinsics { fx: 262.5, fy: 262.5, cx: 199.5, cy: 149.5 };
    let mount = Mount { pitch_rad: 8_f64.to_radians(), x_m: 1.5, ..Mount::level(1.5) };
    Camera::calibrated(400, 300, intrinsics, Distortion::None, mount).unwrap()
}

pub fn view() -> GroundView {
    GroundView::new(&GroundViewConfig::default(), BINS, &camera()).unwrap()
}

pub fn simulator(config: &SimConfig) -> Simulator {
    let town = include_bytes!("../../../fingerpost-sim/assets/town.osm");
    let graph = RoadGraph::from_osm(&OsmData::from_bytes(town).unwrap()).unwrap();
    let route = read_route(include_str!("../../../fingerpost-sim/assets/town_route.geojson")).unwrap();
    Simulator::new(&graph, &route, &camera(), config).unwrap()
}

/// A part of a drive with its ground views, and the true step to each from the one before.
pub struct Drive {
    pub name: &'static str,
    pub pictures: Vec<GroundPicture>,
    /// What each picture shows of how the camera is turned.
    pub attitudes: Vec<AttitudeObservation>,
    pub steps: Vec<Isometry2<f64>>,
}

pub fn drive(name: &'static str, config: &SimConfig, frames: usize) -> Drive {
    recorded(name, &simulator(config), frames)
}

pub fn recorded(name: &'static str, simulator: &Simulator, frames: usize) -> Drive {
    let view = view();
    let (camera, mut watch) = (camera(), AttitudeWatch::new(&camera()));
    let (pictures, attitudes) = (0..frames)
        .map(|index| {
            let mut picture = GroundPicture::new(view.grid().columns(), view.grid().rows(), BINS);
            let frame = simulator.frame(index).picture;
            view.render(&frame, &mut picture).unwrap();
            (picture, watch.look_at(&camera, &frame).unwrap().unwrap_or_default())
        })
        .unzip();
    let pose = |index: usize| {
        let truth = simulator.truth(index);
        Isometry2::new(Vector2::new(truth.x_m, truth.y_m), truth.heading_rad)
    };
    let steps = (1..frames).map(|index| pose(index - 1).inverse() * pose(index)).collect();
    Drive { name, pictures, attitudes, steps }
}

/// Motions of the drive's steps.
pub fn motions(drive: &Drive, estimator: &mut dyn MotionEstimator) -> Vec<Motion> {
    let view = view();
    let mut found =
        drive.pictures.iter().zip(&drive.attitudes).map(|(picture, attitude)| {
            estimator.estimate(&view, picture, attitude).unwrap().map(|m| m.0.motion)
        });
    assert!(found.next().unwrap().is_none(), "one frame is no motion");
    found.map(|motion| motion.unwrap()).collect()
}

/// Error of a step: metres forward and left, radians.
pub fn error(found: &Motion, step: &Isometry2<f64>) -> Vector3<f64> {
    let shift = found.previous_from_current.translation.vector - step.translation.vector;
    let turn = wrap_angle(found.previous_from_current.rotation.angle() - step.rotation.angle());
    Vector3::new(shift.x, shift.y, turn)
}

/// Root mean squares of the errors.
pub fn rms(drive: &Drive, found: &[Motion]) -> Vector3<f64> {
    let squares = found.iter().zip(&drive.steps).map(|(found, step)| error(found, step).map(|e| e * e));
    (squares.sum::<Vector3<f64>>() / found.len() as f64).map(f64::sqrt)
}

/// Five days, each on a turn of the town with some road before and behind it.
pub fn turns() -> impl Iterator<Item = Drive> {
    let days = [
        ("clear", Conditions::CLEAR),
        ("unmarked", Conditions::UNMARKED),
        ("shadows", Conditions::SHADOWS),
        ("rough", Conditions::ROUGH),
        ("ideal", Conditions::IDEAL),
    ];
    (11..).zip(days).map(|(seed, (name, conditions))| {
        let config = SimConfig { seed, conditions, start_m: 249.0, ..SimConfig::default() };
        let drive = drive(name, &config, 45);
        let turned: f64 = drive.steps.iter().map(|step| step.rotation.angle().abs()).sum();
        assert!(turned > 0.5, "{name}: a turn of {turned} rad");
        drive
    })
}

/// Whether an estimator that is shown two ground views of one camera in turn measures, by frame: two of a fine one, two of a
/// coarse one.
pub fn is_measured_in_other_views(estimator: &mut dyn MotionEstimator) -> [bool; 4] {
    let config = GroundViewConfig { metres_per_pixel: 0.1, ..GroundViewConfig::default() };
    let (fine, coarse) = (view(), GroundView::new(&config, BINS, &camera()).unwrap());
    [&fine, &fine, &coarse, &coarse].map(|view| {
        let mut picture = GroundPicture::new(view.grid().columns(), view.grid().rows(), BINS);
        for (index, value) in picture.grey.as_mut_slice().iter_mut().enumerate() {
            *value = (index * index % 251) as u8;
        }
        estimator.estimate(view, &picture, &AttitudeObservation::default()).unwrap().is_some()
    })
}
