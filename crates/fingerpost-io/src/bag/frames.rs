//! In which axes a sensor measures, by the name of its frame and the static transforms of the recording.
//!
//! Sources: ROS REP 103 (bodies: x forward, y left, z up; frames named `..._optical`: x right, y down, z forward) and REP 105
//! (`base_link` on the vehicle; `odom`, `map` and `earth` on the ground).
//!
//! Limits: a frame that neither transforms nor its name describe is taken for one of REP 103's bodies, which is a guess and said to be
//! one; a camera that an optical frame belongs to is taken to look straight ahead: at a pitch of p the yaw rate comes out smaller by
//! 1 - cos p.

use std::collections::BTreeMap;
use std::sync::Arc;

use nalgebra::{Matrix3, Quaternion, Rotation3, UnitQuaternion, Vector3};

use super::frame_names::{FrameNameError, FrameNames};

/// How one frame sits on another, for good.
#[derive(Debug, Clone, PartialEq)]
pub struct StaticTransform {
    /// Name of the frame it sits on.
    pub parent: Arc<str>,
    /// Name of the frame.
    pub child: Arc<str>,
    /// Rotation from the child's axes to the parent's, a quaternion x, y, z, w.
    pub parent_from_child: [f64; 4],
}

/// By what the axes of a frame are known.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum AxesSource {
    /// It is the vehicle's own frame.
    Vehicle,
    /// Static transforms lead to the vehicle's frame.
    FromTree,
    /// Its name says that it is an optical one.
    OpticalName,
    /// Nothing: it is taken for a body's that looks ahead as the vehicle does.
    Guessed,
}

impl AxesSource {
    /// In words.
    pub const fn words(self) -> &'static str {
        match self {
            Self::Vehicle => "the vehicle's own",
            Self::FromTree => "turned into the vehicle's by /tf_static",
            Self::OpticalName => "an optical one by its name: up is minus y, forward is z",
            Self::Guessed => {
                "which nothing joins to base_link and is taken for the vehicle's: forward is x, up is z"
            }
        }
    }
}

/// The axes of a sensor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Axes {
    vehicle_from_sensor: UnitQuaternion<f64>,
    source: AxesSource,
    is_chain_cut: bool,
}

impl Axes {
    /// By what they are known.
    pub const fn source(&self) -> AxesSource {
        self.source
    }

    /// Whether transforms carry its frame, but on more than 64 others or in a circle, so that they are not followed to their end.
    pub const fn is_chain_cut(&self) -> bool {
        self.is_chain_cut
    }

    /// What a sensor measured along its axes, along those of the vehicle.
    pub fn in_vehicle(&self, in_sensor: [f64; 3]) -> [f64; 3] {
        (self.vehicle_from_sensor * Vector3::from(in_sensor)).into()
    }
}

/// Frames that a recording names and describes.
#[derive(Debug, Clone, Default)]
pub struct Frames {
    names: FrameNames,
    /// By their names: the frame each sits on, and how it is turned on it.
    parents: BTreeMap<Arc<str>, (Arc<str>, UnitQuaternion<f64>)>,
}

/// Names of the vehicle's own frame.
const VEHICLE: [&str; 2] = ["base_link", "base_footprint"];
/// Names of frames on the ground.
const GROUND: [&str; 4] = ["odom", "map", "earth", "world"];
/// Frames that one may sit on, each on the next: a sensor on a vehicle has fewer than ten, and ROS's tf2 gives up at 1000.
const MOST_DEPTH: usize = 64;

/// The frame that carries one at last, and how that one is turned on it.
type OnRoot<'a> = (&'a str, UnitQuaternion<f64>);

impl Frames {
    /// The one copy of a frame's name, for measurements that are kept.
    ///
    /// # Errors
    /// [`FrameNameError`] when the name has more than 255 bytes, or is one more than the 65,536 that are kept.
    pub fn shared_name(&mut self, frame_id: &str) -> Result<Arc<str>, FrameNameError> {
        self.names.shared(frame_id)
    }

    /// Takes in transforms; of a frame that was described before the latest holds. A quaternion that is no rotation says nothing.
    ///
    /// # Errors
    /// [`FrameNameError`] as [`Self::shared_name`]; the transforms before that name are taken in.
    pub fn add(
        &mut self,
        transforms: impl IntoIterator<Item = StaticTransform>,
    ) -> Result<(), FrameNameError> {
        for StaticTransform { parent, child, parent_from_child: [x, y, z, w] } in transforms {
            let quaternion = Quaternion::new(w, x, y, z);
            if let Some(turn) = UnitQuaternion::try_new(quaternion, f64::EPSILON) {
                let (parent, child) = (self.names.shared(plain(&parent))?, self.names.shared(plain(&child))?);
                self.parents.insert(child, (parent, turn));
            }
        }
        Ok(())
    }

    /// The axes of the frame of such a name. They are worked out anew; [`KnownAxes`] keeps them.
    pub fn axes(&self, frame_id: &str) -> Axes {
        let frame = plain(frame_id);
        let identity = UnitQuaternion::identity();
        let axes = |vehicle_from_sensor, source| Axes { vehicle_from_sensor, source, is_chain_cut: false };
        if VEHICLE.contains(&frame) {
            return axes(identity, AxesSource::Vehicle);
        }
        let on_root = self.on_root(frame);
        let by_transforms = on_root.and_then(|(root, root_from_frame)| {
            VEHICLE.iter().find_map(|vehicle| {
                let (vehicle_root, root_from_vehicle) = self.on_root(vehicle)?;
                (root == vehicle_root).then(|| root_from_vehicle.inverse() * root_from_frame)
            })
        });
        if let Some(vehicle_from_sensor) = by_transforms {
            return axes(vehicle_from_sensor, AxesSource::FromTree);
        }
        let is_chain_cut = on_root.is_none();
        if frame.split(['_', '/', '-']).any(|part| part.eq_ignore_ascii_case("optical")) {
            // Rows: forward is z, left is minus x, up is minus y.
            let turn = Matrix3::new(0.0, 0.0, 1.0, -1.0, 0.0, 0.0, 0.0, -1.0, 0.0);
            let vehicle_from_sensor =
                UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(turn));
            return Axes { is_chain_cut, ..axes(vehicle_from_sensor, AxesSource::OpticalName) };
        }
        Axes { is_chain_cut, ..axes(identity, AxesSource::Guessed) }
    }

    /// None where the chain is longer than any, as transforms in a circle are.
    fn on_root<'a>(&'a self, frame: &'a str) -> Option<OnRoot<'a>> {
        let (mut at, mut turn) = (frame, UnitQuaternion::identity());
        for _ in 0..=MOST_DEPTH {
            let Some((parent, parent_from_child)) = self.parents.get(at) else { return Some((at, turn)) };
            (at, turn) = (parent, parent_from_child * turn);
        }
        None
    }
}

/// The axes of frames, each worked out once.
#[derive(Debug)]
pub struct KnownAxes<'a> {
    frames: &'a Frames,
    known: BTreeMap<Arc<str>, Axes>,
}

impl<'a> KnownAxes<'a> {
    /// Those of frames that a recording described to its end.
    pub const fn of(frames: &'a Frames) -> Self {
        Self { frames, known: BTreeMap::new() }
    }

    /// The axes of a frame.
    pub fn axes(&mut self, frame_id: &Arc<str>) -> Axes {
        match self.known.get(frame_id) {
            Some(known) => *known,
            None => *self.known.entry(Arc::clone(frame_id)).or_insert_with(|| self.frames.axes(frame_id)),
        }
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
        StaticTransform { parent: parent.into(), child: child.into(), parent_from_child: [x, y, z, w] }
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
        for (name, source) in [
            ("base_link", AxesSource::Vehicle),
            ("/base_footprint", AxesSource::Vehicle),
            ("imu_link", AxesSource::Guessed),
            ("", AxesSource::Guessed),
            ("opticals", AxesSource::Guessed),
        ] {
            assert_eq!(turned(&frames, name, [7.0, 0.1, 0.289]), billionths([7.0, 0.1, 0.289]), "{name}");
            assert_eq!(frames.axes(name).source(), source, "{name}");
        }
    }

    #[test]
    fn transforms_to_the_vehicle_go_before_names() {
        use std::f64::consts::{FRAC_PI_2, PI};
        let mut frames = Frames::default();
        // On its head, on a mast that looks left; and a frame whose name is wrong.
        let all = [
            transform("base_link", "mast", Vector3::z() * FRAC_PI_2),
            transform("mast", "imu", Vector3::x() * PI),
            transform("base_footprint", "base_link", Vector3::zeros()),
            transform("base_link", "not_optical", Vector3::zeros()),
            transform("other_root", "far_optical", Vector3::zeros()),
        ];
        frames.add(all).expect("few names");
        assert_eq!(turned(&frames, "/imu", [1.0, 0.0, -0.3]), billionths([0.0, 1.0, 0.3]));
        assert_eq!(frames.axes("imu").source(), AxesSource::FromTree);
        assert_eq!(turned(&frames, "not_optical", [7.0, 0.1, 0.3]), billionths([7.0, 0.1, 0.3]));
        assert_eq!(frames.axes("far_optical").source(), AxesSource::OpticalName);
        let mut known = KnownAxes::of(&frames);
        for name in ["imu", "far_optical", "imu", "nobody"] {
            assert_eq!(known.axes(&name.into()), frames.axes(name), "{name}");
        }
    }

    #[test]
    fn chains_without_end_and_broken_quaternions_are_not_followed() {
        let mut frames = Frames::default();
        let circle =
            [transform("a", "b_optical", Vector3::zeros()), transform("b_optical", "a", Vector3::zeros())];
        frames.add(circle).expect("few names");
        let no_turn = [StaticTransform {
            parent_from_child: [0.0; 4],
            ..transform("base_link", "c", Vector3::zeros())
        }];
        frames.add(no_turn).expect("few names");
        for (name, source, is_chain_cut) in [
            ("a", AxesSource::Guessed, true),
            ("b_optical", AxesSource::OpticalName, true),
            ("c", AxesSource::Guessed, false),
        ] {
            let axes = frames.axes(name);
            assert_eq!((axes.source(), axes.is_chain_cut()), (source, is_chain_cut), "{name}");
        }
        // Each frame on the one before it, the first on the vehicle.
        let name = |i: usize| if i == 0 { "base_link".to_owned() } else { format!("link_{i}") };
        let chain = (1..1000).map(|i| transform(&name(i - 1), &name(i), Vector3::z() * 0.01));
        frames.add(chain).expect("few names");
        for (depth, is_followed) in [(1, true), (MOST_DEPTH, true), (MOST_DEPTH + 1, false), (999, false)] {
            let axes = frames.axes(&name(depth));
            assert_eq!(axes.source() == AxesSource::FromTree, is_followed, "{depth}");
            assert_eq!(axes.is_chain_cut(), !is_followed, "{depth}");
        }
    }

    #[test]
    fn names_are_kept_once_and_in_bounds() {
        let mut frames = Frames::default();
        let first = frames.shared_name("imu").expect("a name");
        assert!(Arc::ptr_eq(&first, &frames.shared_name("imu").expect("a name")));
        let long = "x".repeat(256);
        assert_eq!(frames.shared_name(&long), Err(FrameNameError::Long { bytes: 256 }));
        let many = (0..70_000).map(|i| transform("base_link", &i.to_string(), Vector3::zeros()));
        assert_eq!(frames.add(many), Err(FrameNameError::Many));
        assert_eq!(frames.shared_name("one more"), Err(FrameNameError::Many));
        assert!(frames.shared_name("imu").is_ok() && frames.axes("7").source() == AxesSource::FromTree);
    }

    #[test]
    fn frames_on_the_ground_are_known() {
        assert!(["map", "/odom", "earth"].into_iter().all(is_on_ground));
        assert!(!is_on_ground("base_link"));
    }
}
