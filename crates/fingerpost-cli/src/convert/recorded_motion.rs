//! The vehicle's motion out of a recording's twists and inertial unit, each along the axes of its frame.

use std::collections::BTreeMap;
use std::sync::Arc;

use fingerpost::vehicle_signals::CanConfig;
use fingerpost_io::bag::{AxesSource, Frames, Inertial, KnownAxes, Twist, VehicleMotion};

use super::frames_of_topic::{FramesOfTopic, frame_in_words, others_in_words};
use super::measured::{Timed, seconds_after};
use super::passed_over::PassedOver;

/// Half of what gravity makes a unit at rest show, m/s²: less is an accelerometer that has gravity taken out, or none.
const LEAST_GRAVITY_MPS2: f64 = 9.806_65 / 2.0;

/// What a recording says of the vehicle's motion.
#[derive(Debug, Default)]
pub(super) struct RecordedMotion {
    /// By time, nanoseconds; of two at once the first.
    pub(super) rows: Vec<(u64, VehicleMotion)>,
    /// Which source gives what, and by which axes.
    pub(super) said: Vec<String>,
    /// Messages that could not be used.
    pub(super) passed_over: PassedOver,
}

/// The motion that twists and an inertial unit say.
pub(super) fn motion(
    twists: Timed<'_, Twist>,
    inertial: Timed<'_, Inertial>,
    frames: &Frames,
) -> RecordedMotion {
    let (mut recorded, mut known) = (RecordedMotion::default(), KnownAxes::of(frames));
    let mut twist_frames = FramesOfTopic::default();
    for (at_ns, twist) in twists.values {
        let axes = known.axes(&twist.frame_id);
        match twist.of_vehicle(&axes) {
            Ok(motion) => {
                twist_frames.count(&twist.frame_id, axes);
                // A log's times grow.
                if recorded.rows.last().is_none_or(|(last_ns, _)| last_ns != at_ns) {
                    recorded.rows.push((*at_ns, motion));
                }
            }
            Err(cause) => recorded.passed_over.add(|| format!("{}: {cause}", twists.topic)),
        }
    }
    if recorded.rows.is_empty() {
        if !inertial.values.is_empty() {
            let cause = "an inertial unit without a speed gives no motion.csv; record the vehicle's twist or odometry too";
            recorded.said.push(cause.to_owned());
        }
        return recorded;
    }
    let said = twist_frames.said("speed", twists.topic);
    recorded.said.extend(said.filter(|(source, _)| *source != AxesSource::Vehicle).map(|(_, said)| said));
    if !inertial.values.is_empty() {
        take_yaw_rates(&mut recorded, inertial, &mut known);
    }
    recorded
}

/// Puts the yaw rate of an inertial unit in place of the twist's: it measures the turn itself, where a twist may come from wheels.
fn take_yaw_rates(recorded: &mut RecordedMotion, inertial: Timed<'_, Inertial>, known: &mut KnownAxes<'_>) {
    let tilted = contradictions(inertial.values, known);
    if let Some((frame_id, [forward, left, up])) = tilted.first_key_value() {
        let frame = frame_in_words(frame_id, &known.axes(frame_id));
        recorded.said.push(format!(
            "{}: the inertial unit in {frame}{}, is pushed by gravity along [{forward:.1}, {left:.1}, {up:.1}] (forward, left, up), which \
             is not up, so that its axes are others and its yaw rate is not used; record /tf_static with base_link, or name its frame by \
             REP 103",
            inertial.topic,
            others_in_words(tilted.len() - 1)
        ));
    }
    // As old as a yaw rate of the vehicle's bus may be.
    let max_age_s = CanConfig::default().max_age_s;
    let mut unit_frames = FramesOfTopic::default();
    let (mut upcoming, mut newest) = (inertial.values.iter().peekable(), None);
    let (mut taken, rows) = (0, recorded.rows.len());
    for (at_ns, motion) in &mut recorded.rows {
        while let Some((unit_ns, unit)) = upcoming.next_if(|(unit_ns, _)| unit_ns <= at_ns) {
            if !tilted.contains_key(&unit.frame_id) {
                let axes = known.axes(&unit.frame_id);
                unit_frames.count(&unit.frame_id, axes);
                newest = Some((*unit_ns, axes.in_vehicle(unit.angular_rps)));
            }
        }
        if let Some((unit_ns, [.., yaw_rate_rps])) = newest
            && seconds_after(*at_ns, unit_ns) <= max_age_s
        {
            motion.yaw_rate_rps = yaw_rate_rps;
            taken += 1;
        }
    }
    if taken == 0 {
        recorded.said.push("the yaw rate is that of the twist".to_owned());
        return;
    }
    recorded.said.extend(unit_frames.said("yaw rate", inertial.topic).map(|(_, said)| said));
    if taken < rows {
        recorded.said.push(format!(
            "in {} of {rows} rows of motion the yaw rate is that of the twist: no measurement of {} that can be used came in the {max_age_s:.1} \
             s before",
            rows - taken,
            inertial.topic
        ));
    }
}

/// Frames whose axes gravity contradicts, with the mean acceleration in each along forward, left and up: on the mean it pushes a vehicle
/// up.
fn contradictions(inertial: &[(u64, Inertial)], known: &mut KnownAxes<'_>) -> BTreeMap<Arc<str>, [f64; 3]> {
    let mut sums: BTreeMap<Arc<str>, ([f64; 3], f64)> = BTreeMap::new();
    for (_, unit) in inertial {
        let Some(in_sensor) = unit.acceleration_mps2.filter(is_finite) else { continue };
        let acceleration = known.axes(&unit.frame_id).in_vehicle(in_sensor);
        let (sum, count) = sums.entry(Arc::clone(&unit.frame_id)).or_default();
        *sum = [0, 1, 2].map(|axis| sum[axis] + acceleration[axis]);
        *count += 1.0;
    }
    let means = sums.into_iter().map(|(frame_id, (sum, count))| (frame_id, sum.map(|sum| sum / count)));
    // More to the side than up: turned by more than 45 degrees, which no road does.
    let is_tilted = |[forward, left, up]: [f64; 3]| {
        let across = libm::hypot(forward, left);
        libm::hypot(across, up) > LEAST_GRAVITY_MPS2 && up < across
    };
    means.filter(|(_, mean)| is_tilted(*mean)).collect()
}

fn is_finite(vector: &[f64; 3]) -> bool {
    vector.iter().all(|part| part.is_finite())
}

#[cfg(test)]
mod tests {
    use fingerpost_io::bag::StaticTransform;

    use super::*;

    const MS: u64 = 1_000_000;

    fn twist(frame_id: &str, linear_mps: [f64; 3], angular_rps: [f64; 3]) -> Twist {
        Twist { frame_id: frame_id.into(), linear_mps, angular_rps }
    }

    fn unit(frame_id: &str, angular_rps: [f64; 3], acceleration_mps2: Option<[f64; 3]>) -> Inertial {
        Inertial { frame_id: frame_id.into(), angular_rps, acceleration_mps2 }
    }

    /// Speeds and yaw rates of the rows, and all that is said.
    fn moved(
        twists: &[(u64, Twist)],
        units: &[(u64, Inertial)],
        frames: &Frames,
    ) -> (Vec<(f64, f64)>, String) {
        let twists = Timed { topic: "/twist", values: twists };
        let found = motion(twists, Timed { topic: "/imu", values: units }, frames);
        let rows = found.rows.iter().map(|(_, motion)| (motion.speed_mps, motion.yaw_rate_rps));
        let said: Vec<String> = found.said.into_iter().chain(found.passed_over.first_reason).collect();
        (rows.collect(), said.join("; "))
    }

    #[test]
    fn each_source_is_read_along_its_own_axes() {
        let body = twist("base_link", [8.0, 0.1, 0.0], [0.0, 0.0, 0.3]);
        let up = Some([0.0, -9.8, 0.1]);
        for (twist, unit, expected, word) in [
            (&body, None, (8.0, 0.3), ""),
            (&body, Some(unit("cam_imu_optical_frame", [0.01, -0.289, 0.01], None)), (8.0, 0.289), "optical"),
            (&body, Some(unit("imu_optical", [0.01, -0.289, 0.01], up)), (8.0, 0.289), "minus y"),
            (
                &body,
                Some(unit("imu_link", [0.0, 0.0, 0.289], Some([0.3, 0.0, 9.8]))),
                (8.0, 0.289),
                "up is z",
            ),
            // Gravity along minus y in a frame that is said to be a body's.
            (&body, Some(unit("imu_link", [0.01, -0.289, 0.01], up)), (8.0, 0.3), "not up"),
            (&twist("camera_optical", [0.1, 0.0, 8.0], [0.0, -0.3, 0.0]), None, (8.0, 0.3), "speed"),
        ] {
            let units: Vec<_> = unit.map(|unit| (5, unit)).into_iter().collect();
            let twists = [(7, twist.clone()), (7, twist.clone())];
            let (rows, said) = moved(&twists, &units, &Frames::default());
            assert_eq!(rows, [expected], "of two at once the first: {said}");
            assert!(said.contains(word), "{said}");
        }
    }

    #[test]
    fn a_twist_along_axes_on_the_ground_is_passed_over() {
        let (rows, said) =
            moved(&[(7, twist("map", [8.0, 0.0, 0.0], [0.0, 0.0, 0.3]))], &[], &Frames::default());
        assert_eq!(rows, []);
        assert!(said.contains("\"map\"") && said.contains("base_link"), "{said}");
    }

    #[test]
    fn frames_that_are_guessed_are_said_once_with_topic_name_and_count() {
        let mut frames = Frames::default();
        let on = |parent: &str, child: &str| StaticTransform {
            parent: parent.into(),
            child: child.into(),
            parent_from_child: [0.0, 0.0, 0.0, 1.0],
        };
        let described = [on("base_link", "mast"), on("ring_1", "ring_2"), on("ring_2", "ring_1")];
        frames.add(described).expect("few names");
        let of_frames = |names: &[&str]| -> Vec<(u64, Twist)> {
            let values = (1..).zip(names);
            values.map(|(at, name)| (at * MS, twist(name, [8.0, 0.0, 0.0], [0.0; 3]))).collect()
        };
        for (names, words) in [
            (vec!["base_link", "/base_footprint"], vec![]),
            (vec!["mast", "base_link"], vec!["1 messages of /twist in frame \"mast\"", "/tf_static"]),
            (
                vec!["gps", "gps", "base_link"],
                vec!["2 messages of /twist in frame \"gps\"", "taken for the vehicle's"],
            ),
            (
                vec!["", "antenna", "base_link"],
                vec!["2 messages of /twist in a frame without", "and in 1 more", "taken for the vehicle's"],
            ),
            (vec!["", ""], vec!["2 messages of /twist in a frame without a name"]),
            (vec!["ring_1"], vec!["taken for the vehicle's", "in a circle"]),
        ] {
            let (rows, said) = moved(&of_frames(&names), &[], &frames);
            assert_eq!(rows.len(), names.len());
            assert!(words.iter().all(|word| said.contains(word)), "{names:?}: {said}");
            assert_eq!(said.is_empty(), words.is_empty(), "{said}");
            assert!(said.matches("speed:").count() <= 1, "{said}");
        }
    }

    #[test]
    fn gravity_contradicts_each_frame_by_itself() {
        let twists: Vec<_> =
            (1..=6).map(|i| (10 * i * MS, twist("base_link", [8.0, 0.0, 0.0], [0.0, 0.0, 0.3]))).collect();
        // Three frames in turn; only together do they seem to stand upright.
        let units: Vec<_> = (1..=6)
            .map(|i| {
                let (frame_id, up) = match i % 3 {
                    1 => ("on_its_side", [0.0, 9.8, 0.0]),
                    2 => ("upright", [0.3, 0.0, 9.8]),
                    _ => ("on_the_other", [0.0, -9.8, 0.0]),
                };
                (10 * i * MS - 1, unit(frame_id, [0.0, 0.0, 0.1 * i as f64], Some(up)))
            })
            .collect();
        let (rows, said) = moved(&twists, &units, &Frames::default());
        let rates: Vec<f64> = rows.iter().map(|(_, rate)| *rate).collect();
        assert_eq!(rates, [0.3, 0.2, 0.2, 0.2, 0.5, 0.5], "{said}");
        assert!(said.contains("\"on_its_side\"") && said.contains("and in 1 more"), "{said}");
        assert!(
            said.contains("2 messages of /imu in frame \"upright\"") && said.contains("1 of 6 rows"),
            "{said}"
        );
    }

    #[test]
    fn an_inertial_unit_that_stops_is_believed_for_no_longer_than_a_bus() {
        let every = |count: u64| 1..=count;
        let twists: Vec<_> =
            every(40).map(|i| (100 * i * MS, twist("base_link", [8.0, 0.0, 0.0], [0.0, 0.0, 0.3]))).collect();
        // It stops after a second.
        let units: Vec<_> = every(10).map(|i| (100 * i * MS, unit("imu", [0.0, 0.0, -0.1], None))).collect();
        let (rows, said) = moved(&twists, &units, &Frames::default());
        let taken = rows.iter().filter(|(_, rate)| *rate < 0.0).count();
        assert_eq!(taken, 15, "half a second more: {said}");
        assert!(said.contains("25 of 40 rows") && said.contains("/imu"), "{said}");
        // One that begins late gives nothing before.
        let late: Vec<_> = units.iter().map(|(at, unit)| (at + 3050 * MS, unit.clone())).collect();
        let (rows, said) = moved(&twists, &late, &Frames::default());
        assert_eq!(rows.iter().filter(|(_, rate)| *rate < 0.0).count(), 9, "{said}");
        let far = vec![(100_000 * MS, unit("imu", [0.0, 0.0, -0.1], None))];
        let (rows, said) = moved(&twists, &far, &Frames::default());
        assert!(rows.iter().all(|(_, rate)| *rate > 0.0) && said.contains("that of the twist"), "{said}");
    }
}
