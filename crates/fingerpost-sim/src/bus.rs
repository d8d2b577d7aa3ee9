//! What the vehicle's own bus says on a drive: a CAN log with the database and the settings that read it.
//!
//! Speed and yaw rate come together in one frame, fifty times a second, in steps as production vehicles have them; the turn
//! signal in another, ten times a second. The times are seconds since the drive's first frame.
//!
//! Limits: values are rounded, without noise, bias and delay; a lane change is signalled, a turn at a junction is not.

use std::fmt::Write;

use fingerpost_format::Side;

use crate::drive::{Drive, VehicleState};
use crate::driving::PlannedDriving;

/// The bus's database, a DBC file.
pub const BUS_DATABASE: &str = include_str!("bus/car.dbc");
/// Settings that name its signals, TOML: the table `can` of a configuration.
pub const BUS_SETTINGS: &str = include_str!("bus/can.toml");

/// Frames a second with speed and yaw rate.
const MOTIONS_PER_S: usize = 50;
/// So many of them come between two with the turn signal.
const MOTIONS_A_LEVER: usize = 5;
/// Identifiers of the two messages.
const MOTION_ID: u16 = 0x1A1;
const LEVERS_ID: u16 = 0x316;
/// Steps of speed, km/h, and of the yaw rate, degrees a second.
const SPEED_STEP_KMH: f64 = 0.01;
const YAW_RATE_STEP_DEG: f64 = 0.1;

/// The log of a drive for so many seconds, as `candump -L` writes it.
pub(crate) fn log(drive: &Drive, planned: Option<&PlannedDriving>, for_s: f64) -> String {
    let mut text = String::new();
    for i in 0..=(for_s * MOTIONS_PER_S as f64).floor() as usize {
        let t_s = i as f64 / MOTIONS_PER_S as f64;
        let state = drive.at(t_s);
        add_frame(&mut text, t_s, MOTION_ID, &motion(&state));
        if i.is_multiple_of(MOTIONS_A_LEVER) {
            let signalled = planned.and_then(|planned| planned.turn_signal(state.route_m));
            add_frame(&mut text, t_s, LEVERS_ID, &[lever(signalled)]);
        }
    }
    text
}

/// Speed and yaw rate, both with their lowest byte first.
fn motion(state: &VehicleState) -> [u8; 4] {
    // Numbers beyond the bytes' range become the last one within.
    let speed = (3.6 * state.speed_mps / SPEED_STEP_KMH).round() as u16;
    let yaw_rate = (state.yaw_rate_rps.to_degrees() / YAW_RATE_STEP_DEG).round() as i16;
    let ([a, b], [c, d]) = (speed.to_le_bytes(), yaw_rate.to_le_bytes());
    [a, b, c, d]
}

const fn lever(signalled: Option<Side>) -> u8 {
    match signalled {
        None => 0,
        Some(Side::Left) => 1,
        Some(Side::Right) => 2,
    }
}

fn add_frame(text: &mut String, t_s: f64, id: u16, data: &[u8]) {
    // Writing to a text cannot fail.
    let _ = write!(text, "({t_s:.6}) can0 {id:03X}#");
    for byte in data {
        let _ = write!(text, "{byte:02X}");
    }
    text.push('\n');
}

#[cfg(test)]
mod tests {
    use nalgebra::Point2;

    use super::*;

    fn state(speed_mps: f64, yaw_rate_rps: f64) -> VehicleState {
        VehicleState {
            p_in_map: Point2::origin(),
            heading_rad: 0.0,
            speed_mps,
            yaw_rate_rps,
            route_m: 0.0,
            pitch_rad: 0.0,
            roll_rad: 0.0,
        }
    }

    #[test]
    fn values_are_steps_with_their_lowest_byte_first() {
        // 72 km/h are 7200 = 0x1C20 steps, 6 degrees a second 60 = 0x3C of them, to the right 0xFFC4.
        assert_eq!(motion(&state(20.0, 6_f64.to_radians())), [0x20, 0x1C, 0x3C, 0x00]);
        assert_eq!(motion(&state(20.0, -(6_f64.to_radians()))), [0x20, 0x1C, 0xC4, 0xFF]);
        // 0.014 km/h and 0.06 degrees a second are nearest to one step.
        assert_eq!(motion(&state(0.014 / 3.6, 0.06_f64.to_radians())), [1, 0, 1, 0]);
        assert_eq!(motion(&state(1e3, -1e3)), [0xFF, 0xFF, 0x00, 0x80]);
        assert_eq!([None, Some(Side::Left), Some(Side::Right)].map(lever), [0, 1, 2]);
    }

    #[test]
    fn a_line_is_one_of_candumps() {
        let mut text = String::new();
        add_frame(&mut text, 12.02, LEVERS_ID, &[2]);
        add_frame(&mut text, 0.0, MOTION_ID, &[0x20, 0x1C, 0xC4, 0xFF]);
        assert_eq!(text, "(12.020000) can0 316#02\n(0.000000) can0 1A1#201CC4FF\n");
    }

    #[test]
    fn the_database_has_the_messages_of_the_log() {
        for (id, name) in [(MOTION_ID, "MOTION"), (LEVERS_ID, "LEVERS")] {
            assert!(BUS_DATABASE.contains(&format!("BO_ {id} {name}: ")), "{name}");
        }
        for signal in ["MOTION.SPEED", "MOTION.YAW_RATE", "LEVERS.TURN_SIGNAL"] {
            assert!(BUS_SETTINGS.contains(signal), "{signal}");
        }
    }
}
