//! The road's middle on painted surfaces, where it is known to the centimetre.

// A helper that fails has failed the test that calls it.
#![allow(clippy::unwrap_used)]

use fingerpost::centreline::{Centreline, CentrelineConfig, CentrelineFinder, NoCentreline, SectionUse};
use fingerpost::ground_view::{GroundView, GroundViewConfig};
use fingerpost::motion::Motion;
use fingerpost::road_surface::RoadSurface;
use fingerpost::vehicle::{Traffic, VehicleConfig};
use fingerpost::{Config, Pipeline, Sensors};
use fingerpost_geometry::{Camera, Distortion, GroundPixel, Intrinsics, Mount};
use fingerpost_sim::{Conditions, CoursePiece, RoadCourse, SimConfig, Simulator};
use fingerpost_vision::colour::HueSaturationBins;
use fingerpost_vision::picture::{Plane, ValidityMask};
use nalgebra::{Isometry2, Matrix3, Point2, Vector2};

fn camera() -> Camera {
    let intrinsics = Intrinsics { fx: 420.0, fy: 420.0, cx: 319.5, cy: 239.5 };
    let mount = Mount { pitch_rad: 0.14, x_m: 1.5, ..Mount::level(1.5) };
    Camera::calibrated(640, 480, intrinsics, Distortion::None, mount).unwrap()
}

fn view() -> GroundView {
    let bins = HueSaturationBins { hue: 32, saturation: 32 };
    GroundView::new(&GroundViewConfig::default(), bins, &camera()).unwrap()
}

/// A surface with the probability of road at each place, `[forward, left]` metres; none where nothing is known.
fn painted(view: &GroundView, road: impl Fn(f64, f64) -> Option<f64>) -> RoadSurface {
    let grid = view.grid();
    let mut surface =
        RoadSurface { probability: Plane::new(grid.columns(), grid.rows(), 0), ..RoadSurface::default() };
    let mut known = Plane::new(grid.columns(), grid.rows(), 0);
    for row in 0..grid.rows() {
        for column in 0..grid.columns() {
            let at = grid.vehicle_from_ground(GroundPixel { column: column as f64, row: row as f64 });
            if let Some(p) = road(at.x, at.y) {
                // Grain that a detector leaves.
                let grain = ((row * 31 + column * 17 + row * column) % 23) as f64 - 11.0;
                surface.probability.row_mut(row)[column] = (255.0 * p + grain).clamp(0.0, 255.0) as u8;
                known.row_mut(row)[column] = 1;
            }
        }
    }
    surface.sums.rebuild(surface.probability.view(), &ValidityMask::from_plane(known)).unwrap();
    surface
}

/// Road within half a width of its middle, where grass begins within a few decimetres.
fn road(middle_m: f64, width_m: f64, left_m: f64) -> Option<f64> {
    let inside_m = 0.5 * width_m - (left_m - middle_m).abs();
    Some(0.1 + 0.8 * (0.5 + inside_m / 0.3).clamp(0.0, 1.0))
}

fn find(
    surface: &RoadSurface,
    traffic: Traffic,
) -> (Option<Centreline>, Option<NoCentreline>, Vec<SectionUse>) {
    let vehicle = VehicleConfig { traffic, ..VehicleConfig::default() };
    let mut finder = CentrelineFinder::new(&CentrelineConfig::default(), &vehicle, &view()).unwrap();
    let (found, evidence) = finder.find(surface, None).unwrap();
    (found, evidence.none_because, evidence.sections.iter().map(|section| section.section_use).collect())
}

#[test]
fn straight_and_bent_roads_pass_the_vehicle_where_they_do() {
    let view = view();
    for (offset_m, slope, curvature) in
        [(0.0, 0.0, 0.0), (1.4, 0.0, 0.0), (-0.8, 0.08, 0.0), (0.6, -0.1, 0.01), (0.3, 0.0, -0.025)]
    {
        let middle_m = |x: f64| offset_m + slope * x + 0.5 * curvature * x * x;
        let surface = painted(&view, |x, y| road(middle_m(x), 6.0, y));
        let found = find(&surface, Traffic::Centre).0.unwrap();
        let name = format!("{offset_m} {slope} {curvature}: {found:?}");
        // The road is seen from 4 m on: of a bend, one frame alone knows less where it passes the rear axle.
        let tolerance_m = 0.15 + 5.0 * curvature.abs();
        assert!((found.offset_m - offset_m).abs() < tolerance_m, "{name}");
        assert!((found.left_m(10.0) - middle_m(10.0)).abs() < 0.2, "{name}");
        assert!((found.width_m - 6.0).abs() < 0.4, "{name}");
        // A fifth of the way to the middle is made good up to the look-ahead.
        let aim_m = middle_m(8.0) - 0.8 * offset_m;
        assert!((found.steer.unwrap().direction_rad - libm::atan(aim_m / 8.0)).abs() < 0.05, "{name}");
    }
}

#[test]
fn the_vehicle_is_steered_to_its_side_of_the_road() {
    let view = view();
    let surface = painted(&view, |_, y| road(1.5, 6.0, y));
    let steer = |traffic| find(&surface, traffic).0.unwrap().steer.unwrap().direction_rad;
    assert!(steer(Traffic::Right).abs() < 0.03, "it is where it ought to be");
    // Moving over takes 40 m: at the look-ahead a fifth of 1.5 and of 3 m is made good.
    assert!((steer(Traffic::Centre) - libm::atan(0.3 / 8.0)).abs() < 0.015);
    assert!((steer(Traffic::Left) - libm::atan(0.6 / 8.0)).abs() < 0.015);
}

#[test]
fn a_side_road_is_passed_over() {
    let view = view();
    let junction =
        |x: f64, y: f64| if (8.0..13.0).contains(&x) && y < 0.0 { Some(0.9) } else { road(0.5, 6.0, y) };
    let (found, _, sections) = find(&painted(&view, junction), Traffic::Centre);
    assert!((found.unwrap().offset_m - 0.5).abs() < 0.15, "{found:?}");
    assert!(sections.iter().any(|section| *section != SectionUse::BothEdges), "{sections:?}");
}

#[test]
fn without_sound_edges_there_is_none_and_the_reason() {
    let view = view();
    let none = |road: &dyn Fn(f64, f64) -> Option<f64>| {
        let (found, why, _) = find(&painted(&view, road), Traffic::Centre);
        assert_eq!(found, None);
        why.unwrap()
    };
    assert_eq!(none(&|_, _| Some(0.9)), NoCentreline::NoEdges, "a yard");
    assert_eq!(none(&|_, _| Some(0.0)), NoCentreline::NoEdges, "a meadow");
    assert_eq!(none(&|_, _| None), NoCentreline::NoEdges, "darkness");
    assert_eq!(
        none(&|_, y| (y.abs() < 3.0).then_some(0.9)),
        NoCentreline::NoEdges,
        "the end of what is known"
    );
    assert_eq!(none(&|_, y| Some(if y < 1.0 { 0.9 } else { 0.1 })), NoCentreline::NoEdges, "one edge");
}

/// Width of the painted roads that are driven, metres, and the step between frames.
const WIDTH_M: f64 = 6.5;
const STEP_M: f64 = 1.1;

/// What is wrong with a stretch of a painted road.
#[derive(Clone, Copy)]
enum Flaw {
    /// Nothing.
    None,
    /// A side road as wide as it is long leaves to the right every 40 m.
    Mouths,
    /// To the left nothing is known for 15 m in 40 m.
    OneEdge,
}

/// How far out of its line a verge grows at a place along the road, metres.
fn ragged_m(along_m: f64, seed: f64) -> f64 {
    let wave = |length_m: f64, phase: f64| libm::sin(along_m / length_m + phase);
    0.10 * wave(0.9, seed) + 0.08 * wave(2.3, 2.0 * seed) + 0.06 * wave(0.3, 3.0 * seed)
}

/// Offset errors over a drive along a painted road that is straight for 30 m, bends for 50 m and is straight again, metres;
/// none where no centreline was given.
fn drive_errors_m(radius_m: f64, seed: f64, flaw: Flaw) -> Vec<Option<f64>> {
    // Places of the middle and its direction, every decimetre.
    let mut middle = vec![(Point2::origin(), 0.0_f64)];
    for i in 1..1300 {
        let (place, heading_rad): (Point2<f64>, f64) = middle[i - 1];
        let bent = (300..800).contains(&i);
        let next_rad = heading_rad + if bent { 0.1 / radius_m } else { 0.0 };
        middle.push((place + 0.1 * Vector2::new(libm::cos(heading_rad), libm::sin(heading_rad)), next_rad));
    }
    let view = view();
    let mut finder =
        CentrelineFinder::new(&CentrelineConfig::default(), &VehicleConfig::default(), &view).unwrap();
    let mut before: Option<Isometry2<f64>> = None;
    let mut errors_m = Vec::new();
    for frame in 0..85 {
        let along_m = f64::from(frame) * STEP_M;
        let (place, road_rad) = middle[(10.0 * along_m).round() as usize];
        let right_m = 1.5 + 0.3 * libm::sin(0.1 * along_m + seed);
        let across = Vector2::new(-libm::sin(road_rad), libm::cos(road_rad));
        let map_from_vehicle = Isometry2::new(place.coords - right_m * across, road_rad);
        let ahead: Vec<(f64, Point2<f64>, f64)> = middle
            .iter()
            .enumerate()
            .map(|(i, (place, heading_rad))| {
                let p = map_from_vehicle.inverse_transform_point(place);
                (0.1 * i as f64, p, heading_rad - road_rad)
            })
            .filter(|(at_m, p, _)| p.x > 0.0 && (at_m - along_m).abs() < 25.0)
            .collect();
        let surface = painted(&view, |x, y| {
            let here = Point2::new(x, y);
            let at = ahead.partition_point(|(_, p, turn_rad)| {
                (here - p).dot(&Vector2::new(libm::cos(*turn_rad), libm::sin(*turn_rad))) > 0.0
            });
            let (at_m, p, turn_rad) = ahead.get(at)?;
            let left_m = (here - p).dot(&Vector2::new(-libm::sin(*turn_rad), libm::cos(*turn_rad)));
            let of_40_m = at_m.rem_euclid(40.0);
            match flaw {
                Flaw::Mouths if of_40_m < WIDTH_M && left_m < 0.0 => return Some(0.9),
                Flaw::OneEdge if of_40_m < 15.0 && left_m > 1.0 => return None,
                _ => {}
            }
            road(0.0, WIDTH_M, left_m + ragged_m(*at_m, seed + left_m.signum()))
        });
        let motion = before.map(|before| Motion {
            previous_from_current: before.inverse() * map_from_vehicle,
            covariance: 1e-4 * Matrix3::identity(),
            quality: 0.9,
        });
        before = Some(map_from_vehicle);
        let found = finder.find(&surface, motion.as_ref()).unwrap().0;
        errors_m.push(found.map(|found| found.offset_m - right_m));
    }
    errors_m
}

/// The 95th percentile of the errors' sizes.
fn p95_m(mut errors_m: Vec<f64>) -> f64 {
    errors_m.iter_mut().for_each(|error_m| *error_m = error_m.abs());
    errors_m.sort_by(f64::total_cmp);
    errors_m[errors_m.len() * 95 / 100]
}

#[test]
fn drives_along_straight_and_bent_roads_keep_the_offset() {
    for (radius_m, seed) in [(1e9, 1.0), (-40.0, 2.0), (25.0, 3.0)] {
        for flaw in [Flaw::None, Flaw::Mouths, Flaw::OneEdge] {
            let errors_m = drive_errors_m(radius_m, seed, flaw);
            let found: Vec<f64> = errors_m.iter().flatten().copied().collect();
            let name = format!("radius {radius_m}, flaw {}", flaw as u8);
            assert!(found.len() * 10 >= errors_m.len() * 8, "{name}: {} of {}", found.len(), errors_m.len());
            let p95_m = p95_m(found);
            assert!(p95_m < 0.25, "{name}: {p95_m}");
        }
    }
}

/// Offset errors of the whole method on a simulated road without markings, metres, and how many frames it drove.
fn simulated_errors_m(course: &RoadCourse, seed: u64) -> (Vec<f64>, usize) {
    let (graph, route) = course.roads().unwrap();
    let config = SimConfig {
        seed,
        conditions: Conditions::UNMARKED,
        cruise_speed_mps: 11.0,
        end_gap_m: 40.0,
        ..SimConfig::default()
    };
    let simulator = Simulator::new(&graph, &route, &camera(), &config).unwrap();
    let mut pipeline = Pipeline::new(&Config::default(), &camera(), None, None).unwrap();
    let mut errors_m = Vec::new();
    for index in 0..simulator.frames() {
        let picture = simulator.frame(index).picture;
        let sensors = Sensors { dt_s: (index > 0).then_some(1.0 / config.fps), ..Sensors::default() };
        let (output, _) = pipeline.step(&picture, sensors, &mut |_| ()).unwrap();
        let place = simulator.road_place(index).unwrap();
        let true_m = -place.left_m / libm::cos(place.heading_rad);
        errors_m.extend(output.centreline.map(|found| found.offset_m - true_m));
    }
    (errors_m, simulator.frames())
}

#[test]
fn simulated_roads_without_markings_keep_the_offset() {
    let road = |pieces: Vec<CoursePiece>| RoadCourse { pieces, width_m: 6.5, two_way: true };
    let straight = CoursePiece::Straight { length_m: 60.0 };
    let bend = |radius_m: f64, turn_rad: f64| CoursePiece::Bend { radius_m, turn_rad };
    let courses = [
        (road(vec![straight; 3]), 71),
        (road(vec![straight, bend(60.0, 0.9), bend(45.0, -1.2), straight]), 72),
    ];
    for (course, seed) in courses {
        let (errors_m, frames) = simulated_errors_m(&course, seed);
        assert!(errors_m.len() * 10 >= frames * 9, "seed {seed}: {} of {frames}", errors_m.len());
        let p95_m = p95_m(errors_m);
        assert!(p95_m < 0.25, "seed {seed}: {p95_m}");
    }
}
