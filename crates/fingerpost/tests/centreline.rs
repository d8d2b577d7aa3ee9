//! The road's middle on painted surfaces, where it is known to the centimetre.

// A helper that fails has failed the test that calls it.
#![allow(clippy::unwrap_used)]

use fingerpost::centreline::{Centreline, CentrelineConfig, CentrelineFinder, NoCentreline, SectionUse};
use fingerpost::ground_view::{GroundView, GroundViewConfig};
use fingerpost::road_surface::RoadSurface;
use fingerpost::vehicle::{Traffic, VehicleConfig};
use fingerpost_geometry::{Camera, Distortion, GroundPixel, Intrinsics, Mount};
use fingerpost_vision::colour::HueSaturationBins;
use fingerpost_vision::picture::{Plane, ValidityMask};

fn view() -> GroundView {
    let intrinsics = Intrinsics { fx: 420.0, fy: 420.0, cx: 319.5, cy: 239.5 };
    let mount = Mount { pitch_rad: 0.14, x_m: 1.5, ..Mount::level(1.5) };
    let camera = Camera::calibrated(640, 480, intrinsics, Distortion::None, mount).unwrap();
    let bins = HueSaturationBins { hue: 32, saturation: 32 };
    GroundView::new(&GroundViewConfig::default(), bins, &camera).unwrap()
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
        assert!((found.steer_rad - (middle_m(8.0) / 8.0).atan()).abs() < 0.05, "{name}");
    }
}

#[test]
fn the_vehicle_is_steered_to_its_side_of_the_road() {
    let view = view();
    let surface = painted(&view, |_, y| road(1.5, 6.0, y));
    let steer = |traffic| find(&surface, traffic).0.unwrap().steer_rad;
    assert!(steer(Traffic::Right).abs() < 0.03, "it is where it ought to be");
    assert!((steer(Traffic::Centre) - (1.5_f64 / 8.0).atan()).abs() < 0.03);
    assert!((steer(Traffic::Left) - (3.0_f64 / 8.0).atan()).abs() < 0.03);
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
