//! The belief on painted drives past three side roads, each with something that goes wrong: the start, the pictures' times and
//! order, the camera's calibration, GPS, the map. Nothing false is claimed, and what can be found again is.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a failed expectation is a failed test")]

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};

use crate::painted::{Place, World, camera, camera_calibrated_wrong, route_past};
use fingerpost::vehicle_signals::{Sample, VehicleSamples};
use fingerpost::{Pipeline, Sensors};
use fingerpost_map::{LatLon, TangentPlane};
use fingerpost_vision::picture::RgbImage;
use nalgebra::{Isometry2, Point2, Vector2};

const WIDTH_M: f64 = 5.5;
/// Metres north of the nodes, and where the side roads lead.
const SIDES: [(f64, Place); 3] = [(30.0, (-60.0, 0.0)), (75.0, (60.0, 0.0)), (112.0, (-60.0, 10.0))];
/// The route's ends, metres north. The longer a route, the less a start that is wrong explains a receiver that is off.
const ENDS: [f64; 2] = [-20.0, 1000.0];
const SPEED_MPS: f64 = 8.0;
/// The vehicle drives so far to the right of the road's middle, metres.
const RIGHT_M: f64 = 0.3;
/// A feature that is said to be there and is this far off is false, metres.
const FALSE_M: f64 = 3.0;
/// The origin of the painted map.
const ORIGIN: LatLon = LatLon { lat_deg: 47.1, lon_deg: 9.5 };

/// What happens to the pictures on the way.
#[derive(Clone, Copy)]
enum Pictures {
    /// From so far north on, there are none for so many seconds.
    Pause { north_m: f64, for_s: f64 },
    /// From so far north on, the same one comes for so many seconds.
    Frozen { north_m: f64, for_s: f64 },
    /// From so far north on, every two change places for so many seconds.
    Reordered { north_m: f64, for_s: f64 },
}

/// A receiver, by the place that it gives at a time and at the places of the vehicle then and before.
#[derive(Clone, Copy)]
enum Gps {
    /// It gives where the vehicle was so many seconds ago.
    Late(f64),
    /// It stays where it was after so many seconds.
    Frozen(f64),
    /// It is so many metres off towards the north.
    Biased(f64),
    /// Every second fix is so many metres off towards the north.
    Jumping(f64),
}

impl Gps {
    /// Metres north that the receiver gives `t_s` seconds into the drive.
    fn north_m(self, t_s: f64) -> f64 {
        let at = |t_s: f64| SPEED_MPS * t_s;
        match self {
            Self::Late(by_s) => at(t_s - by_s),
            Self::Frozen(from_s) => at(t_s.min(from_s)),
            Self::Biased(by_m) => at(t_s) + by_m,
            Self::Jumping(by_m) => at(t_s) + if t_s.floor() % 2.0 > 0.0 { by_m } else { 0.0 },
        }
    }
}

/// What a drive is like.
#[derive(Clone, Copy)]
struct Drive {
    /// Seconds from picture to picture.
    dt_s: f64,
    /// How far the start is given too far along, metres.
    start_off_m: f64,
    pictures: Option<Pictures>,
    /// Speed that the vehicle's bus says.
    bus_mps: Option<f64>,
    gps: Option<Gps>,
    /// How far the calibration's pitch is off, radians, and the factor of its focal length.
    calibration_off: (f64, f64),
    /// How far the map has the side road of this index too far north, metres.
    moved_on_map: Option<(usize, f64)>,
    /// Side road of the map that does not exist.
    missing: Option<usize>,
}

const PLAIN: Drive = Drive {
    dt_s: 0.1,
    start_off_m: 0.0,
    pictures: None,
    bus_mps: None,
    gps: None,
    calibration_off: (0.0, 1.0),
    moved_on_map: None,
    missing: None,
};

/// What came of a drive.
#[derive(Debug)]
struct Outcome {
    /// How far off the best claim of each side road was, metres.
    found: BTreeMap<usize, f64>,
    /// How far off each claim was, metres, in the order of the pictures.
    off_m: Vec<f64>,
    /// How far off the last progress along the route was, metres.
    route_off_m: f64,
}

impl Outcome {
    /// Asserts that the last side road was found.
    fn assert_ends_found(&self, within_m: f64, what: &str) {
        let last_off_m = self.found.get(&2);
        assert!(last_off_m.is_some_and(|off_m| *off_m < within_m), "{what}: {self:?}");
    }
}

impl Drive {
    fn world(&self) -> World {
        let roads: Vec<[Place; 2]> = SIDES
            .iter()
            .enumerate()
            .filter(|(index, _)| self.missing != Some(*index))
            .map(|(_, &(north, (x, y)))| [(0.0, north), (x, north + y)])
            .collect();
        let mut painted: Vec<(&[Place], f64)> = vec![(&[(0.0, -60.0), (0.0, 200.0)], WIDTH_M)];
        painted.extend(roads.iter().map(|road| (road.as_slice(), WIDTH_M)));
        World::new(&painted)
    }

    /// When the pictures come and when each was taken, seconds.
    fn times(&self) -> Vec<(f64, f64)> {
        let end_s = (SIDES[2].0 + 2.0) / SPEED_MPS;
        let frames = (end_s / self.dt_s).ceil() as usize;
        let mut times: Vec<(f64, f64)> = (0..frames).map(|i| i as f64 * self.dt_s).map(|t| (t, t)).collect();
        let within = |t_s: f64, north_m: f64, for_s: f64| {
            let from_s = north_m / SPEED_MPS;
            (from_s..from_s + for_s).contains(&t_s)
        };
        match self.pictures {
            None => {}
            Some(Pictures::Pause { north_m, for_s }) => {
                times.retain(|(t_s, _)| !within(*t_s, north_m, for_s))
            }
            Some(Pictures::Frozen { north_m, for_s }) => times
                .iter_mut()
                .filter(|(t_s, _)| within(*t_s, north_m, for_s))
                .for_each(|(_, taken_s)| *taken_s = north_m / SPEED_MPS),
            Some(Pictures::Reordered { north_m, for_s }) => {
                for pair in times.chunks_exact_mut(2).filter(|pair| within(pair[0].0, north_m, for_s)) {
                    (pair[0].1, pair[1].1) = (pair[1].1, pair[0].1);
                }
            }
        }
        times
    }

    /// What the camera shows from a place, which is that of a moment. Drives on all roads at the plain rate pass the same places:
    /// what they show is painted once for all of them.
    fn picture(&self, world: &World, taken_s: f64, map_from_vehicle: &Isometry2<f64>) -> Arc<RgbImage> {
        static PAINTED: Mutex<BTreeMap<u64, Arc<RgbImage>>> = Mutex::new(BTreeMap::new());
        let paint = || Arc::new(world.picture(&camera(), map_from_vehicle));
        if self.missing.is_some() || self.dt_s.total_cmp(&PLAIN.dt_s).is_ne() {
            return paint();
        }
        // A test that fails while another paints spoils no picture.
        let mut painted = PAINTED.lock().unwrap_or_else(PoisonError::into_inner);
        Arc::clone(painted.entry(taken_s.to_bits()).or_insert_with(paint))
    }

    /// Drives past all side roads; fails where something false is claimed.
    fn run(&self) -> Outcome {
        let mut on_map = SIDES;
        if let Some((index, by_m)) = self.moved_on_map {
            on_map[index].0 += by_m;
        }
        let (world, route) = (self.world(), route_past(&on_map, ENDS, WIDTH_M));
        let plane = TangentPlane::new(ORIGIN);
        let start_m = self.start_off_m - ENDS[0];
        let believed = camera_calibrated_wrong(self.calibration_off.0, self.calibration_off.1);
        let mut pipeline =
            Pipeline::new(&crate::painted::config(), &believed, Some(&route), Some(start_m)).unwrap();
        let mut outcome = Outcome { found: BTreeMap::new(), off_m: Vec::new(), route_off_m: f64::INFINITY };
        let mut last: Option<(f64, f64, Arc<RgbImage>)> = None;
        for (t_s, taken_s) in self.times() {
            let north = SPEED_MPS * taken_s;
            let map_from_vehicle = Isometry2::new(Vector2::new(RIGHT_M, north), std::f64::consts::FRAC_PI_2);
            let dt_s = last.as_ref().map(|(last_s, ..)| t_s - last_s);
            let frame = match last.take() {
                Some((_, last_taken_s, frame)) if last_taken_s.total_cmp(&taken_s).is_eq() => frame,
                _ => self.picture(&world, taken_s, &map_from_vehicle),
            };
            let signals = self.bus_mps.map(|speed_mps| VehicleSamples {
                speed_mps: Some(Sample { value: speed_mps, age_s: 0.0 }),
                ..VehicleSamples::default()
            });
            // A receiver of one fix a second.
            let is_fix = dt_s.is_none_or(|dt_s| t_s.floor() > (t_s - dt_s).floor());
            let at = |gps: Gps| plane.wgs84_from_map(Point2::new(RIGHT_M, gps.north_m(t_s)));
            let sensors = Sensors { dt_s, signals, gps: self.gps.filter(|_| is_fix).map(at) };
            let (output, _) = pipeline.step(&frame, sensors, &mut |_| {}).unwrap();
            last = Some((t_s, taken_s, frame));
            outcome.route_off_m =
                output.track.route_m.map_or(f64::INFINITY, |m| (m - (north - ENDS[0])).abs());
            let Some(followed) = &output.track.followed else { continue };
            let node = map_from_vehicle.inverse() * Point2::new(0.0, SIDES[followed.index].0);
            let off_m = (followed.vehicle_from_feature.translation.vector - node.coords).norm();
            let is_there = off_m < FALSE_M && self.missing != Some(followed.index);
            let present = followed.present;
            assert!(is_there || present < 0.5, "{north}: {off_m} m off at {present}: {}", output.why);
            let nearest = outcome.found.entry(followed.index).or_insert(f64::INFINITY);
            *nearest = off_m.min(*nearest);
            outcome.off_m.push(off_m);
        }
        outcome.off_m.sort_by(f64::total_cmp);
        outcome
    }
}

#[test]
fn features_are_found_from_a_start_that_is_right() {
    let outcome = PLAIN.run();
    assert_eq!(outcome.found.len(), 3, "{outcome:?}");
    assert!(outcome.found.values().all(|off_m| *off_m < 0.5), "{outcome:?}");
}

#[test]
fn the_rate_of_the_pictures_changes_neither_what_is_found_nor_where() {
    let p95_m = |dt_s: f64| {
        let outcome = Drive { dt_s, ..PLAIN }.run();
        assert_eq!(outcome.found.len(), 3, "{dt_s}: {outcome:?}");
        outcome.off_m[outcome.off_m.len() * 95 / 100]
    };
    let at_10_hz_m = p95_m(0.1);
    for rate_hz in [5.0, 15.0, 30.0] {
        let ratio = p95_m(1.0 / rate_hz) / at_10_hz_m;
        assert!((0.8..1.2).contains(&ratio), "{rate_hz}: {ratio} of {at_10_hz_m} m");
    }
}

#[test]
fn pictures_too_far_apart_for_their_motion_claim_nothing_false() {
    // What is false fails in the drive. Without a motion nothing can be placed for a driving line.
    let outcome = Drive { dt_s: 0.4, ..PLAIN }.run();
    assert!(outcome.route_off_m.is_finite(), "{outcome:?}");
}

#[test]
fn a_start_that_is_off_is_mended_or_claims_nothing_false() {
    // What is false fails in the drive.
    for (start_off_m, is_mended) in [(-8.0, true), (8.0, true), (-30.0, false), (30.0, false)] {
        let outcome = Drive { start_off_m, ..PLAIN }.run();
        assert!(!is_mended || outcome.route_off_m < 1.5, "{start_off_m}: {outcome:?}");
    }
}

#[test]
fn a_pause_in_the_pictures_claims_nothing_and_is_mended() {
    for (for_s, bus_mps) in [(1.2, None), (2.5, None), (5.0, None), (5.0, Some(SPEED_MPS))] {
        let pictures = Some(Pictures::Pause { north_m: 12.0, for_s });
        let outcome = Drive { pictures, bus_mps, ..PLAIN }.run();
        outcome.assert_ends_found(0.5, &format!("{for_s} s, bus {bus_mps:?}"));
    }
}

#[test]
fn pictures_that_freeze_or_change_places_claim_nothing_and_are_mended() {
    for (what, pictures) in [
        ("frozen for 1 s", Pictures::Frozen { north_m: 12.0, for_s: 1.0 }),
        ("frozen for 2 s", Pictures::Frozen { north_m: 12.0, for_s: 2.0 }),
        ("reordered for 1 s", Pictures::Reordered { north_m: 12.0, for_s: 1.0 }),
        ("reordered for 3 s", Pictures::Reordered { north_m: 12.0, for_s: 3.0 }),
    ] {
        Drive { pictures: Some(pictures), ..PLAIN }.run().assert_ends_found(0.8, what);
    }
}

const ERRING_RECEIVERS: [(&str, Gps); 6] = [
    ("late by 1 s", Gps::Late(1.0)),
    ("late by 3 s", Gps::Late(3.0)),
    ("frozen", Gps::Frozen(2.0)),
    ("biased by 15 m", Gps::Biased(15.0)),
    ("biased by 36 m", Gps::Biased(36.0)),
    ("jumping by 36 m", Gps::Jumping(36.0)),
];

#[test]
fn gps_that_errs_takes_nothing_away_that_is_found_without_it() {
    for (what, gps) in ERRING_RECEIVERS {
        let outcome = Drive { gps: Some(gps), ..PLAIN }.run();
        outcome.assert_ends_found(0.8, what);
    }
}

#[test]
fn a_calibration_that_errs_claims_nothing_false() {
    let third_rad = (1.0_f64 / 3.0).to_radians();
    for calibration_off in [(third_rad, 1.0), (-third_rad, 1.0), (0.0, 1.05), (0.0, 0.95)] {
        let outcome = Drive { calibration_off, ..PLAIN }.run();
        outcome.assert_ends_found(1.5, &format!("{calibration_off:?}"));
    }
}

#[test]
fn a_map_that_errs_is_believed_no_more_than_the_ground() {
    for by_m in [-5.0, 5.0] {
        let outcome = Drive { moved_on_map: Some((1, by_m)), ..PLAIN }.run();
        outcome.assert_ends_found(0.8, &format!("the second node {by_m} m off"));
    }
    for missing in [0, 1] {
        let outcome = Drive { missing: Some(missing), ..PLAIN }.run();
        outcome.assert_ends_found(0.8, &format!("without side road {missing}"));
    }
}
