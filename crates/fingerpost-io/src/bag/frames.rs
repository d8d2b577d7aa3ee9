//! In which axes a sensor measures, by the name of its frame and the static transforms of the recording.
//!
//! Sources: ROS REP 103 (bodies: x forward, y left, z up; frames named `..._optical`: x right, y down, z forward) and REP 105
//! (`base_link` on the vehicle; `odom`, `map` and `earth` on the ground).
//!
//! Limits: a frame that neither transforms nor its name describe is taken for one of REP 103's bodies, and a camera that an optical
//! frame belongs to for one that looks straight ahead: at a pitch of p the yaw rate comes out smaller by 1 - cos p.

use std::collections::BTreeMap;

use nalgebra::{Matrix3, Quaternion, Rotation3, UnitQuaternion, Vector3};

/// How one frame sits on another, for good.
#[derive(Debug, Clone, PartialEq)]
pub struct StaticTransform {
    /// Name of the frame it sits on.
    pub parent: String,
    /// Name of the frame.
    pub child: String,
    /// Rotation from the child's axes to the parent's, a quaternion x, y, z, w.
    pub parent_from_child: [f64; 4],
}

/// By what the axes of a frame are known.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum AxesSource {
    /// Static transforms lead to the vehicle's frame.
    Transforms,
    /// Its name says that it is an optical one.
    OpticalName,
    /// Nothing: it is taken for a body's.
    Body,
}

impl AxesSource {
    /// In words.
    pub const fn words(self) -> &'static str {
        match self {
            Self::Transforms => "turned into the vehicle's by /tf_static",
            Self::OpticalName => "an optical one by its name: up is minus y, forward is z",
            Self::Body => "taken for a body's: forward is x, up is z",
        }
    }
}

/// The axes of a sensor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Axes {
    vehicle_from_sensor: UnitQuaternion<f64>,
    source: AxesSource,
}

impl Axes {
    /// By what they are known.
    pub const fn source(&self) -> AxesSource {
        self.source
    }

    /// What a sensor measured along its axes, along those of the vehicle.
    pub fn in_vehicle(&self, in_sensor: [f64; 3]) -> [f64; 3] {
        (self.vehicle_from_sensor * Vector3::from(in_sensor)).into()
    }
}

/// Frames that a recording describes.
#[derive(Debug, Clone, Default)]
pub struct Frames {
    /// By their names: the frame each sits on, and how it is turned on it.
    parents: BTreeMap<String, (String, UnitQuaternion<f64>)>,
}

/// Names of the vehicle's own frame.
const VEHICLE: [&str; 2] = ["base_link", "base_footprint"];
/// Names of frames on the ground.
const GROUND: [&str; 4] = ["odom", "map", "earth", "world"];

impl Frames {
    /// Takes in transforms; of a frame that was described before the latest holds. A quaternion that is no rotation says nothing.
    pub fn add(&mut self, transforms: impl IntoIterator<Item = StaticTransform>) {
        for StaticTransform { parent, child, parent_from_child: [x, y, z, w] } in transforms {
            let quaternion = Quaternion::new(w, x, y, z);
            if let Some(turn) = UnitQuaternion::try_new(quaternion, f64::EPSILON) {
                self.parents.insert(plain(&child).to_owned(), (plain(&parent).to_owned(), turn));
            }
        }
    }

    /// The axes of the frame of such a name.
    pub fn axes(&self, frame_id: &str) -> Axes {
        let frame = plain(frame_id);
        if VEHICLE.contains(&frame) {
            return Axes { vehicle_from_sensor: UnitQuaternion::identity(), source: AxesSource::Body };
        }
        let by_transforms = VEHICLE.iter().find_map(|vehicle| {
            let ((root, from_frame), (vehicle_root, from_vehicle)) =
                (self.on_root(frame), self.on_root(vehicle));
            (root == vehicle_root).then(|| from_vehicle.inverse() * from_frame)
        });
        if let Some(vehicle_from_sensor) = by_transforms {
            return Axes { vehicle_from_sensor, source: AxesSource::Transforms };
        }
        if frame.split(['_', '/', '-']).any(|part| part.eq_ignore_ascii_case("optical")) {
            // Rows: forward is z, left is minus x, up is minus y.
            let turn = Matrix3::new(0.0, 0.0, 1.0, -1.0, 0.0, 0.0, 0.0, -1.0, 0.0);
            let vehicle_from_sensor =
                UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(turn));
            return Axes { vehicle_from_sensor, source: AxesSource::OpticalName };
        }
        Axes { vehicle_from_sensor: UnitQuaternion::identity(), source: AxesSource::Body }
    }

    /// The frame that carries one at last, and how that one is turned on it. Transforms in a circle carry nothing: the walk ends where
    /// it has been as often as there are frames.
    fn on_root<'a>(&'a self, frame: &'a str) -> (&'a str, UnitQuaternion<f64>) {
        let (mut at, mut turn) = (frame, UnitQuaternion::identity());
        for _ in 0..self.parents.len() {
            let Some((parent, parent_from_child)) = self.parents.get(at) else { break };
            (at, turn) = (parent, parent_from_child * turn);
        }
        (at, turn)
    }
}

/// Whether a frame is on the ground, so that the vehicle's speed is along none of its axes.
pub(super) fn is_on_ground(frame_id: &str) -> bool {
    GROUND.contains(&plain(frame_id))
}

/// A name without the slash that ROS 1 wrote before it.
fn plain(frame_id: &str) -> &str {
    frame_id.trim_start_matches('/')
}

#[cfg(test)]
mod tests {
    use super::*;

    fn transform(parent: &str, child: &str, axis: Vector3<f64>) -> StaticTransform {
        let turn = UnitQuaternion::new(axis);
        let [x, y, z, w]: [f64; 4] = turn.coords.into();
        StaticTransform {
            parent: parent.to_owned(),
            child: child.to_owned(),
            parent_from_child: [x, y, z, w],
        }
    }

    /// Along the vehicle's axes, in billionths.
    fn turned(frames: &Frames, frame_id: &str, in_sensor: [f64; 3]) -> [i64; 3] {
        billionths(frames.axes(frame_id).in_vehicle(in_sensor))
    }

    fn billionths(vector: [f64; 3]) -> [i64; 3] {
        vector.map(|part| (part * 1e9).round() as i64)
    }

    #[test]
    fn optical_frames_are_told_by_their_names() {
        let frames = Frames::default();
        for name in ["camera_imu_optical_frame", "front_optical", "/camera/optical", "Imu_Optical_Frame"] {
            assert_eq!(turned(&frames, name, [0.1, -0.289, 7.0]), billionths([7.0, -0.1, 0.289]), "{name}");
            assert_eq!(frames.axes(name).source(), AxesSource::OpticalName);
        }
        for name in ["imu_link", "base_link", "", "opticals"] {
            assert_eq!(turned(&frames, name, [7.0, 0.1, 0.289]), billionths([7.0, 0.1, 0.289]), "{name}");
        }
    }

    #[test]
    fn transforms_to_the_vehicle_go_before_names() {
        use std::f64::consts::{FRAC_PI_2, PI};
        let mut frames = Frames::default();
        // On its head, on a mast that looks left; and a frame whose name is wrong.
        frames.add([
            transform("base_link", "mast", Vector3::z() * FRAC_PI_2),
            transform("mast", "imu", Vector3::x() * PI),
            transform("base_footprint", "base_link", Vector3::zeros()),
            transform("base_link", "not_optical", Vector3::zeros()),
            transform("other_root", "far_optical", Vector3::zeros()),
        ]);
        assert_eq!(turned(&frames, "/imu", [1.0, 0.0, -0.3]), billionths([0.0, 1.0, 0.3]));
        assert_eq!(frames.axes("imu").source(), AxesSource::Transforms);
        assert_eq!(turned(&frames, "not_optical", [7.0, 0.1, 0.3]), billionths([7.0, 0.1, 0.3]));
        assert_eq!(frames.axes("far_optical").source(), AxesSource::OpticalName);
    }

    #[test]
    fn circles_and_broken_quaternions_end_nothing() {
        let mut frames = Frames::default();
        frames.add([transform("a", "b", Vector3::zeros()), transform("b", "a", Vector3::zeros())]);
        frames.add([StaticTransform {
            parent_from_child: [0.0; 4],
            ..transform("base_link", "c", Vector3::zeros())
        }]);
        for name in ["a", "b", "c"] {
            assert_eq!(frames.axes(name).source(), AxesSource::Body, "{name}");
        }
    }

    #[test]
    fn frames_on_the_ground_are_known() {
        assert!(["map", "/odom", "earth"].into_iter().all(is_on_ground));
        assert!(!is_on_ground("base_link"));
    }
}
