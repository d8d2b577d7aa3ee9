//! The kerbs beside the vehicle's way as the truth has them.

use fingerpost_geometry::Camera;
use nalgebra::{Isometry3, Point2, Point3};

use crate::render::{FrameView, Renderer};

/// How far ahead of the vehicle kerbs are given, from, to and how often, metres.
const AHEAD_M: [f64; 2] = [4.0, 14.0];
const EVERY_M: f64 = 0.5;
/// How far aside they are looked for, metres, and in which steps: half of the narrowest island's width at the most.
const ASIDE_M: f64 = 9.0;
const STEP_M: f64 = 0.1;
/// Lower kerbs are flush, metres.
const LEAST_KERB_M: f32 = 0.01;

/// The nearest kerb to the left and to the right that the `camera`, as it is mounted then, sees: forward and left in the vehicle frame, and its height, metres.
/// Height of the ground is `height_m` of a place of the map.
pub(crate) fn kerbs_ahead(
    renderer: &Renderer,
    view: &FrameView,
    camera: &Camera,
    height_m: impl Fn(Point2<f64>) -> f64,
) -> [Vec<[f64; 3]>; 2] {
    let steps = ((AHEAD_M[1] - AHEAD_M[0]) / EVERY_M) as usize;
    [1.0, -1.0].map(|side| {
        let ahead = (0..=steps).map(|i| AHEAD_M[0] + EVERY_M * i as f64);
        let kerbs = ahead.filter_map(|forward_m| kerb_at(renderer, &view.map_from_vehicle, forward_m, side));
        let seen = kerbs.filter(|kerb| {
            let p = view.map_from_vehicle * Point3::new(kerb[0], kerb[1], 0.0);
            let p = Point3::new(p.x, p.y, height_m(p.xy()));
            let pixel = camera.project(view.map_from_vehicle.inverse_transform_point(&p));
            pixel.is_some_and(|pixel| camera.contains(pixel)) && renderer.is_open(view, p)
        });
        seen.collect()
    })
}

/// The first kerb on a side (1 left, -1 right), so far ahead.
fn kerb_at(
    renderer: &Renderer,
    map_from_vehicle: &Isometry3<f64>,
    forward_m: f64,
    side: f64,
) -> Option<[f64; 3]> {
    let street = |aside_m: f64| {
        let p = map_from_vehicle * Point3::new(forward_m, side * aside_m, 0.0);
        renderer.street_at(p.x as f32, p.y as f32)
    };
    // From the road alone: what lies ahead of the vehicle may be a pavement already.
    let mut before_m = f64::from(street(0.0).filter(|at| at.ground.edge_m < 0.0)?.behind_kerb_m);
    for i in 1..=(ASIDE_M / STEP_M) as usize {
        let aside_m = STEP_M * i as f64;
        let at = street(aside_m)?;
        let behind_m = f64::from(at.behind_kerb_m);
        if behind_m >= 0.0 && at.kerb_m >= LEAST_KERB_M {
            let kerb_m = aside_m - STEP_M * behind_m / (behind_m - before_m).max(1e-6);
            return Some([forward_m, side * kerb_m, f64::from(at.kerb_m)]);
        }
        before_m = behind_m;
    }
    None
}
