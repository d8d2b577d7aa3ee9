//! Ground views of textured ground with a pavement beside it, drawn as a camera would show them.

use fingerpost_geometry::{Camera, Distortion, GroundPixel, Intrinsics, Mount};
use nalgebra::{Isometry2, Matrix3, Point2, Vector2};

use super::*;
use crate::ground_view::GroundViewConfig;

/// Beyond them the ground is raised, metres to the left and to the right of the vehicle's way, and by how much.
const KERB_LEFT_M: f64 = 2.0;
const KERB_RIGHT_M: f64 = 2.7;
const KERB_M: f64 = 0.12;

fn view() -> GroundView {
    let intrinsics = Intrinsics { fx: 420.0, fy: 420.0, cx: 319.5, cy: 239.5 };
    let mount = Mount { x_m: 1.5, pitch_rad: 0.14, ..Mount::level(1.5) };
    let camera = Camera::calibrated(640, 480, intrinsics, Distortion::None, mount).unwrap();
    let bins = crate::Config::default().road_surface.backprojection.bins();
    GroundView::new(&GroundViewConfig::default(), bins, &camera).unwrap()
}

/// Smooth noise with structures of some decimetres.
fn texture(p: Point2<f64>) -> f64 {
    let corner = |x: f64, y: f64| {
        let mixed = (x as i64).wrapping_mul(0x9E37_79B1) ^ (y as i64).wrapping_mul(0x85EB_CA77);
        f64::from((mixed.wrapping_mul(0x2545_F491_4F6C_DD1D) >> 40) as u8)
    };
    let (x, y) = (p.x / 0.2, p.y / 0.2);
    let (i, j) = (x.floor(), y.floor());
    let (dx, dy) = (x - i, y - j);
    let along = |j: f64| (1.0 - dx) * corner(i, j) + dx * corner(i + 1.0, j);
    60.0 + 0.5 * ((1.0 - dy) * along(j) + dy * along(j + 1.0))
}

/// The ground view of a vehicle that has driven so far, whose camera is turned by `turn`.
fn shown(view: &GroundView, driven_m: f64, turn: CameraTurn) -> Plane<u8> {
    let grid = view.grid();
    let (foot, height_m) = (view.camera_foot(), view.camera_height_m());
    let road_from_shown = turn.road_from_shown(view.viewpoint());
    let mut plane = Plane::new(grid.columns(), grid.rows(), 0);
    for row in 0..grid.rows() {
        for (column, value) in plane.row_mut(row).iter_mut().enumerate() {
            let shown = grid.vehicle_from_ground(GroundPixel { column: column as f64, row: row as f64 });
            let at = road_from_shown * shown.to_homogeneous();
            let at = Point2::new(at.x / at.z, at.y / at.z);
            // What is raised is seen first, then the kerb's face, which stands upright.
            let raised = foot + (at - foot) * (1.0 - KERB_M / height_m);
            let kerb_m = if at.y > 0.0 { KERB_LEFT_M } else { -KERB_RIGHT_M };
            let face_share = (kerb_m - foot.y) / (at.y - foot.y);
            let at = if raised.y / kerb_m > 1.0 {
                raised
            } else if at.y / kerb_m > 1.0 {
                let up_m = (1.0 - face_share) * height_m;
                Point2::new(foot.x + (at.x - foot.x) * face_share, 10.0 * kerb_m + up_m)
            } else {
                at
            };
            *value = texture(Point2::new(at.x + driven_m, at.y)) as u8;
        }
    }
    plane
}

fn drive(turn: CameraTurn, believed: CameraTurn, steps_m: &[f64]) -> (GroundView, HeightStage) {
    let view = view();
    let mut stage = HeightStage::new(&HeightConfig { used: HeightUse::Shown, ..HeightConfig::default() });
    let mut driven_m = 0.0;
    stage.step(&view, &shown(&view, 0.0, turn), None, believed);
    for step_m in steps_m {
        driven_m += step_m;
        let motion = Motion {
            previous_from_current: Isometry2::new(Vector2::new(*step_m, 0.0), 0.0),
            covariance: Matrix3::identity() * 1e-6,
            quality: 1.0,
        };
        stage.step(&view, &shown(&view, driven_m, turn), Some(&motion), believed);
    }
    (view, stage)
}

/// Log-odds that a place is raised.
fn at(view: &GroundView, stage: &HeightStage, x: f64, y: f64) -> f64 {
    let pixel = view.grid().ground_from_vehicle(Point2::new(x, y));
    stage.height.log_odds(pixel.column.round() as usize, pixel.row.round() as usize)
}

fn is_told(view: &GroundView, stage: &HeightStage) {
    for x in [6.0, 7.0, 8.0] {
        for y in [-1.5, -0.5, 0.5, 1.5] {
            assert!(at(view, stage, x, y) < -1.0, "road at {x}, {y}: {}", at(view, stage, x, y));
        }
        let beside: Vec<f64> = (0..8).map(|i| at(view, stage, x, 2.4 + 0.1 * f64::from(i))).collect();
        let raised = beside.iter().filter(|&&log_odds| log_odds > 1.0).count();
        assert!(raised >= 6, "pavement at {x}: {beside:?}");
    }
}

#[test]
fn a_pavement_is_raised_and_the_road_is_level() {
    let (view, stage) = drive(CameraTurn::default(), CameraTurn::default(), &[0.5; 16]);
    is_told(&view, &stage);
}

#[test]
fn a_pitch_and_a_roll_that_nobody_knows_of_are_the_plane_s() {
    let turn = CameraTurn { pitch_rad: 0.005, roll_rad: 0.006, yaw_rad: 0.0 };
    let (view, stage) = drive(turn, CameraTurn::default(), &[0.5; 16]);
    is_told(&view, &stage);
}

#[test]
fn kerbs_are_found_where_they_are_on_either_side() {
    let (view, stage) = drive(CameraTurn::default(), CameraTurn::default(), &[0.5; 16]);
    for (side, kerb_m) in [(1.0, KERB_LEFT_M), (-1.0, KERB_RIGHT_M)] {
        let mut found_m: Vec<f64> = (0..12)
            .map(|i| {
                let x = 6.0 + 0.25 * f64::from(i);
                let mut aside = (0..80).map(|j| 1.0 + 0.05 * f64::from(j));
                aside.find(|aside_m| at(&view, &stage, x, side * aside_m) > 0.0).unwrap()
            })
            .collect();
        found_m.sort_by(f64::total_cmp);
        assert!((found_m[6] - kerb_m).abs() < 0.2, "{side}: {found_m:?}");
    }
}

#[test]
fn a_standing_vehicle_learns_nothing_more() {
    let (_, driven) = drive(CameraTurn::default(), CameraTurn::default(), &[0.5; 12]);
    let mut steps = vec![0.5; 12];
    steps.extend([0.0; 30]);
    let (_, stood) = drive(CameraTurn::default(), CameraTurn::default(), &steps);
    assert_eq!(driven.height.raised, stood.height.raised);
}

#[test]
fn a_drive_on_allocates_nothing_once_every_view_has_been_kept() {
    let (view, mut stage) = drive(CameraTurn::default(), CameraTurn::default(), &[0.5; 24]);
    let motion = Motion {
        previous_from_current: Isometry2::new(Vector2::new(0.5, 0.0), 0.0),
        covariance: Matrix3::identity() * 1e-6,
        quality: 1.0,
    };
    for further in 1..=6 {
        let grey = shown(&view, 12.0 + 0.5 * f64::from(further), CameraTurn::default());
        let counted = allocation_counter::measure(|| {
            let (_, evidence) = stage.step(&view, &grey, Some(&motion), CameraTurn::default());
            assert!(evidence.pair.is_some());
        });
        assert_eq!(counted.count_total, 0, "{} bytes", counted.bytes_total);
    }
}
