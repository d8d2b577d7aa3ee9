//! Candidate poses a second of the bracketing search, on one thread: a T-junction of four masks (three arms and the
//! driving line) on a ground view of 512 x 512 pixels, of which the camera sees what lies between two slanted lines.
//!
//! `cargo run --release -p fingerpost --example candidate_rate` prints a line a case: the vehicle's own lattice and one
//! of every pixel; a junction where it is believed, one that is not there, and a plane that is all road, on which no
//! candidate falls behind another and so none can be left early.
#![allow(clippy::print_stdout, reason = "the program's output")]

use std::error::Error;
use std::time::Instant;

use fingerpost::driving_line::{DrivingLine, DrivingLineConfig};
use fingerpost::feature_masks::{FeatureMaskConfig, MaskCache};
use fingerpost::feature_model::{ArmModel, FeatureModel};
use fingerpost::matching::{MatchConfig, Matcher};
use fingerpost::road_surface::RoadSurface;
use fingerpost::track::{CandidateSearch, TrackConfig};
use fingerpost::vehicle::VehicleConfig;
use fingerpost_geometry::{GroundGrid, GroundPixel, Polyline};
use fingerpost_map::{ArmRole, FeatureKind};
use fingerpost_vision::picture::{Plane, ValidityMask};
use nalgebra::{Isometry2, Point2, Vector2};

const WIDTH_M: f64 = 5.5;
/// Where the junction is believed: straight ahead in the middle of the view.
const AHEAD_M: f64 = 16.0;
/// The best of so many measurements of so many searches counts: the others were disturbed.
const MEASUREMENTS: usize = 15;
const SEARCHES: usize = 8;

fn main() -> Result<(), Box<dyn Error>> {
    // 25.6 m by 25.6 m at 0.05 m a pixel.
    let grid = GroundGrid::new(4.0, 29.6, 12.8, 0.05)?;
    let (junction, vehicle) = (t_junction()?, VehicleConfig::default());
    let line = DrivingLine::new(&DrivingLineConfig::default(), &vehicle, &junction)?;
    let config = FeatureMaskConfig::default();
    let mut masks = MaskCache::new(&config, &vehicle, &grid, &junction, line.as_ref());
    let own = TrackConfig::default();
    let every_pixel = TrackConfig {
        search_forward_step_m: 2.0 * grid.metres_per_pixel(),
        search_left_step_m: 2.0 * grid.metres_per_pixel(),
        ..own.clone()
    };
    let at = |forward_m: f64| Some(Isometry2::new(Vector2::new(forward_m, 0.3), 0.02));
    for (scene, truth) in
        [("junction there", at(AHEAD_M)), ("junction elsewhere", at(23.0)), ("all road", None)]
    {
        for (lattice, config) in [("own lattice", &own), ("every pixel", &every_pixel)] {
            let surface = surface(&grid, &junction, truth.as_ref())?;
            let rate = candidates_a_second(config, &grid, &surface, &mut masks)?;
            println!("{scene:<20} {lattice:<12} {:6.2} million candidates a second", 1e-6 * rate);
        }
    }
    Ok(())
}

fn candidates_a_second(
    config: &TrackConfig,
    grid: &GroundGrid,
    (surface, validity): &(RoadSurface, ValidityMask),
    masks: &mut MaskCache,
) -> Result<f64, Box<dyn Error>> {
    let predicted = Isometry2::new(Vector2::new(AHEAD_M, 0.0), 0.0);
    let mut matcher = Matcher::new(&MatchConfig::default(), grid);
    let laid = matcher.laid(surface, validity)?;
    let mut search = CandidateSearch::default();
    let mut best = 0.0_f64;
    for _ in 0..MEASUREMENTS {
        let (start, mut tried) = (Instant::now(), 0);
        for _ in 0..SEARCHES {
            tried += search.about(config, &laid, masks, config.confirm_threshold, &predicted)?.count;
        }
        best = best.max(tried as f64 / start.elapsed().as_secs_f64());
    }
    Ok(best)
}

/// A T-junction that is left to the right.
fn t_junction() -> Result<FeatureModel, Box<dyn Error>> {
    let mut arms = Vec::new();
    for (role, label, forward, left) in [
        (ArmRole::Approach, "approach", -60.0, 0.0),
        (ArmRole::Exit, "exit", 0.0, -60.0),
        (ArmRole::Side, "side_1", 0.0, 60.0),
    ] {
        let course = Polyline::new([Point2::origin(), Point2::new(forward, left)])?;
        arms.push(ArmModel { role, label: label.into(), course, width_m: WIDTH_M, mouth_m: 0.5 * WIDTH_M });
    }
    let (id, name, kind) = (7, "A x B".to_owned(), FeatureKind::Junction);
    Ok(FeatureModel { id, name, kind, route_m: 60.0, arms, map_from_feature: Isometry2::identity() })
}

/// Roads of the junction at `vehicle_from_feature`, or nothing but road, under a little noise.
fn surface(
    grid: &GroundGrid,
    junction: &FeatureModel,
    vehicle_from_feature: Option<&Isometry2<f64>>,
) -> Result<(RoadSurface, ValidityMask), Box<dyn Error>> {
    let (columns, rows) = (grid.columns(), grid.rows());
    let mut surface = RoadSurface { probability: Plane::new(columns, rows, 0), ..RoadSurface::default() };
    let mut seen = Plane::new(columns, rows, 0);
    let mut noise = 1_u32;
    for row in 0..rows {
        for column in 0..columns {
            let p = grid.vehicle_from_ground(GroundPixel { column: column as f64, row: row as f64 });
            let is_road = vehicle_from_feature.is_none_or(|vehicle_from_feature| {
                let p_in_feature = vehicle_from_feature.inverse() * p;
                let mut courses = junction.arms.iter().map(|arm| arm.course.nearest(p_in_feature));
                courses.any(|foot| foot.left_m.abs() < 0.5 * WIDTH_M)
            });
            noise = noise.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            surface.probability.row_mut(row)[column] = if is_road { 230 } else { 20 } + (noise >> 28) as u8;
            seen.row_mut(row)[column] = u8::from(p.y.abs() < 0.7 * p.x);
        }
    }
    let validity = ValidityMask::from_plane(seen);
    surface.sums.rebuild(surface.probability.view(), &validity)?;
    Ok((surface, validity))
}
