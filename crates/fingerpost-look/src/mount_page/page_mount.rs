//! A mount as the page has it.

use fingerpost_geometry::Mount;
use serde::{Deserialize, Serialize};

/// Height and angles of a mount as the page has them.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub(super) struct PageMount {
    height_m: f64,
    pitch_deg: f64,
    yaw_deg: f64,
    roll_deg: f64,
}

impl PageMount {
    /// The four numbers of a path, with commas between them.
    pub(super) fn of_path(text: &str) -> Option<Self> {
        let numbers: Vec<f64> = text.split(',').map(str::parse).collect::<Result<_, _>>().ok()?;
        let [height_m, pitch_deg, yaw_deg, roll_deg] = numbers.try_into().ok()?;
        Some(Self { height_m, pitch_deg, yaw_deg, roll_deg })
    }

    pub(super) fn of(mount: &Mount) -> Self {
        let degrees = |rad: f64| (rad.to_degrees() * 1e6).round() / 1e6;
        Self {
            height_m: mount.height_m,
            pitch_deg: degrees(mount.pitch_rad),
            yaw_deg: degrees(mount.yaw_rad),
            roll_deg: degrees(mount.roll_rad),
        }
    }

    /// A mount with these numbers in place of its own.
    pub(super) fn in_place_of(self, mount: Mount) -> Mount {
        Mount {
            height_m: self.height_m,
            pitch_rad: self.pitch_deg.to_radians(),
            yaw_rad: self.yaw_deg.to_radians(),
            roll_rad: self.roll_deg.to_radians(),
            ..mount
        }
    }
}
