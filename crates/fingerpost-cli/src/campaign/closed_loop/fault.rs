//! What goes wrong on a closed-loop drive besides what its conditions bring.

use clap::ValueEnum;
use clap::builder::PossibleValue;
use fingerpost_map::LatLon;
use fingerpost_sim::{CameraFault, MapFault};
use nalgebra::Vector2;
use serde::{Serialize, Serializer};

/// A fault of a drive.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Fault {
    /// Of the camera or its line.
    Camera(CameraFault),
    /// Of the map.
    Map(MapFault),
    /// GPS that jumps.
    GpsJumps,
}

/// All of them with their names.
const FAULTS: [(Fault, &str, &str); 10] = [
    (Fault::Camera(CameraFault::Dropped), "dropped", "one picture in five does not arrive"),
    (Fault::Camera(CameraFault::Frozen), "frozen", "the same picture for a second, every eight"),
    (Fault::Camera(CameraFault::Black), "black", "black pictures for a second, every eight"),
    (Fault::Camera(CameraFault::Blind), "blind", "black pictures from the tenth second on"),
    (Fault::Camera(CameraFault::Late), "late", "every picture two frames late"),
    (Fault::Camera(CameraFault::Reordered), "reordered", "one picture in five passed by the next"),
    (Fault::GpsJumps, "gps_jumps", "GPS, 60 m off for three seconds, every ten"),
    (Fault::Map(MapFault::RoadMissing), "road_missing", "one road in four not on the map"),
    (Fault::Map(MapFault::NodeMoved), "node_moved", "one junction in three 5 m off on the map"),
    (Fault::Map(MapFault::WrongWidth), "wrong_width", "widths a third off on the map"),
];

impl Fault {
    /// Its name on the command line and in files.
    fn entry(self) -> &'static (Self, &'static str, &'static str) {
        FAULTS.iter().find(|(fault, ..)| *fault == self).unwrap_or(&FAULTS[0])
    }

    /// What is wrong with the camera.
    pub(super) fn of_camera(fault: Option<Self>) -> Option<CameraFault> {
        match fault {
            Some(Self::Camera(fault)) => Some(fault),
            _ => None,
        }
    }
}

impl ValueEnum for Fault {
    fn value_variants<'a>() -> &'a [Self] {
        const ALL: [Fault; FAULTS.len()] = {
            let mut all = [Fault::GpsJumps; FAULTS.len()];
            let mut i = 0;
            while i < FAULTS.len() {
                all[i] = FAULTS[i].0;
                i += 1;
            }
            all
        };
        &ALL
    }

    fn to_possible_value(&self) -> Option<PossibleValue> {
        let (_, name, help) = self.entry();
        Some(PossibleValue::new(*name).help(*help))
    }
}

impl Serialize for Fault {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.entry().1)
    }
}

/// How often GPS jumps, for how long, seconds, and how far, metres.
const EVERY_S: f64 = 10.0;
const LASTS_S: f64 = 3.0;
const JUMP_M: f64 = 60.0;

/// What a receiver says at a time of a vehicle that is really there; with this fault it jumps to the north-east.
pub(super) fn gps(t_s: f64, truth: LatLon, plane: &fingerpost_map::TangentPlane) -> LatLon {
    let jumped = t_s >= EVERY_S && t_s % EVERY_S < LASTS_S;
    let offset_m = if jumped { JUMP_M * std::f64::consts::FRAC_1_SQRT_2 } else { 0.0 };
    plane.wgs84_from_map(plane.map_from_wgs84(truth) + Vector2::repeat(offset_m))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_lead_to_their_faults() {
        for (fault, name, _) in FAULTS {
            assert_eq!(Fault::from_str(name, false), Ok(fault));
        }
    }

    #[test]
    fn gps_is_true_and_then_60_m_off() {
        let place = LatLon::new(49.0, 8.4).unwrap();
        let plane = fingerpost_map::TangentPlane::new(place);
        let off_m = |t_s: f64| plane.map_from_wgs84(gps(t_s, place, &plane)).coords.norm();
        assert!(off_m(9.9) < 1e-6 && (off_m(10.1) - 60.0).abs() < 1e-3 && off_m(13.1) < 1e-6);
    }
}
