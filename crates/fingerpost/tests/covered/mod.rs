//! A followed junction whose camera is covered on the way.
#![allow(unreachable_pub, reason = "shared by several test programs")]
#![allow(clippy::unwrap_used, reason = "a failed expectation is a failed test")]

use super::painted::{Junction, Place, World, camera_of_width, route};
use fingerpost::pipeline::Parts;
use fingerpost::road_surface::RoadMethod;
use fingerpost::track::{Decision, State};
use fingerpost::vehicle::Traffic;
use fingerpost::{Config, Pipeline, Sensors};
use fingerpost_map::FeatureKind;
use fingerpost_vision::picture::RgbImage;
use nalgebra::{Isometry2, Vector2};

const WIDTH_M: f64 = 5.5;
const SOUTH: &[Place] = &[(0.0, 0.0), (0.0, -60.0)];
const EAST: &[Place] = &[(0.0, 0.0), (60.0, 0.0)];
const WEST: &[Place] = &[(0.0, 0.0), (-60.0, 0.0)];

/// What comes in place of the camera's pictures, of a frame's number and the picture's size.
type Cover = fn(usize, (usize, usize)) -> RgbImage;

/// A picture whose levels follow from row and column as shares.
fn painted_with(size: (usize, usize), level: impl Fn(f64, f64) -> u8) -> RgbImage {
    let (width, height) = size;
    let mut picture = RgbImage::new(width, height);
    for row in 0..height {
        for (column, pixel) in picture.row_mut(row).chunks_exact_mut(3).enumerate() {
            pixel.fill(level(row as f64 / height as f64, column as f64 / width as f64));
        }
    }
    picture
}

const COVERS: [(&str, Cover); 3] = [
    ("a cap", |frame, size| {
        painted_with(size, |y, x| {
            (70.0 - 60.0 * ((x - 0.5).powi(2) + (y - 0.5).powi(2))) as u8 + frame as u8 % 2
        })
    }),
    ("even grey", |frame, size| painted_with(size, |_, _| 110 + frame as u8 % 2)),
    ("grey below an even sky", |frame, size| {
        painted_with(size, |y, _| if y < 0.4 { 200 } else { 110 + frame as u8 % 2 })
    }),
];

/// Follows a junction by these detectors, and covers the lens: nothing is claimed then.
pub fn no_junction_is_confirmed(detectors: &[RoadMethod], parts: impl Fn(&Config) -> Parts) {
    let (camera, world) =
        (camera_of_width(320), World::new(&[(SOUTH, WIDTH_M), (EAST, WIDTH_M), (WEST, WIDTH_M)]));
    let kind = FeatureKind::Junction;
    let (route, _) = route(&Junction { kind, approach: SOUTH, exit: EAST, sides: &[WEST], width_m: WIDTH_M });
    let picture = |i: usize| {
        let place = Vector2::new(0.0, -24.0 + 0.6 * i as f64);
        world.picture(&camera, &Isometry2::new(place, std::f64::consts::FRAC_PI_2))
    };
    let seen: Vec<RgbImage> = (0..22).map(picture).collect();
    for &detector in detectors {
        for (name, cover) in COVERS {
            let mut config = super::painted::config();
            config.track.kerb_radius_m = 0.0;
            config.vehicle.traffic = Traffic::Centre;
            config.road_surface.detector = detector;
            let mut pipeline =
                Pipeline::with_parts(&config, &camera, Some(&route), Some(36.0), parts(&config)).unwrap();
            let mut was_followed = false;
            for picture in &seen {
                let (output, _) = pipeline.step(picture, Sensors::default(), &mut |_| {}).unwrap();
                was_followed |= output.track.state == State::Tracking;
            }
            assert!(was_followed, "{detector:?}: the junction is followed before");
            for frame in 0..15 {
                let covered = cover(frame, seen[0].size());
                let (output, evidence) = pipeline.step(&covered, Sensors::default(), &mut |_| {}).unwrap();
                let decision = &evidence.track.decision;
                let is_claimed =
                    matches!(decision, Decision::Confirmed | Decision::Detected | Decision::Arrived);
                assert!(!is_claimed, "{detector:?}, {name}, frame {frame}: {}", output.why);
                if name != COVERS[2].0 {
                    assert!(output.track.followed.is_none(), "{detector:?}, {name}: {}", output.why);
                }
            }
        }
    }
}
